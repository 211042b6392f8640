"""Summaries of the rows of the campaign: counts, tables and failures."""

import json
from collections import Counter
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL

SLACK = 1e-9  # rounding of the truth and of the comparison
KINDS = ("area", "gap", "pressure")


def read(path):
    """Return the rows of a file."""
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def counts(row):
    """Return whether a row is a converged solve with a reliable truth."""
    return row.get("status") == "converged" and row["kkt"] < DOUBTFUL


def less_accurate(row):
    """Return the kinds of error above the requested accuracy."""
    if not counts(row):
        return []
    return [k for k, true in zip(KINDS, row["true"]) if not true <= row["accuracy"] + SLACK]


def above_estimate(row):
    """Return the kinds of error above their estimate but within the requested accuracy.

    An estimate is relative to the value found, which may be larger than the true one by as much.
    """
    if not counts(row):
        return []
    errors = zip(KINDS, row["true"], row["claimed"])
    worse = less_accurate(row)
    return [
        k
        for k, true, claimed in errors
        if k not in worse and claimed < 1 and not true <= claimed / (1 - claimed) + SLACK
    ]


def count(rows):
    """Return the counts of the outcomes of rows, and their mean FFT pairs."""
    outcomes = Counter(
        "no truth" if row.get("status") == "converged" and not counts(row) else row.get("status")
        for row in rows
    )
    pairs = [row["fft_pairs"] for row in rows if row.get("status") == "converged"]
    counted = {"solves": len(rows), "converged": outcomes.pop("converged", 0), "others": outcomes}
    for judge in (less_accurate, above_estimate):
        kinds_of_rows = [judge(row) for row in rows]
        of_kinds = [sum(kind in kinds for kinds in kinds_of_rows) for kind in KINDS]
        counted[judge.__name__] = [sum(map(bool, kinds_of_rows)), *of_kinds]
    return counted | {"mean_pairs": round(float(np.mean(pairs)), 2) if pairs else None}


def grouped(rows, by="family"):
    """Return {value of a key: counts}, with "all" for the counts of all rows."""
    names = sorted({str(row.get(by)) for row in rows})
    counted = {name: count([row for row in rows if str(row.get(by)) == name]) for name in names}
    return counted | {"all": count(rows)}


def markdown(groups, by="family"):
    """Return counts {name: counts}, as `grouped` returns them, as a Markdown table; `by` is the
    heading of the names."""
    lines = [
        f"| {by} | solves | converged | less accurate than asked (area / gap / pressure)"
        " | else above own estimate | other outcomes | mean pairs |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, counted in groups.items():
        failures = [
            f"{n} ({' / '.join(map(str, kinds))})" if n else "0"
            for n, *kinds in (counted["less_accurate"], counted["above_estimate"])
        ]
        outcomes = ", ".join(f"{n} {status}" for status, n in counted["others"].items())
        cells = [name, counted["solves"], counted["converged"], *failures, outcomes or "-"]
        lines.append(f"| {' | '.join(map(str, cells))} | {counted['mean_pairs'] or '-'} |")
    return "\n".join(lines)


def failures(rows):
    """Return the rows that missed their accuracy or exceeded their estimate, the worst first."""

    def badness(row):
        inaccurate = less_accurate(row)
        kinds = inaccurate or above_estimate(row)
        ratios = [
            true / (row["accuracy"] if kind in inaccurate else max(claimed, SLACK))
            for kind, true, claimed in zip(KINDS, row["true"], row["claimed"])
            if kind in kinds
        ]
        return bool(inaccurate), max(ratios)

    bad = [row for row in rows if less_accurate(row) or above_estimate(row)]
    return sorted(bad, key=badness, reverse=True)


def worst_of_each(bad):
    """Return the first failure of every wall and kind of failure."""
    worst = {}
    for row in bad:
        worst.setdefault((row["family"], row["seed"], row["index"], bool(less_accurate(row))), row)
    return list(worst.values())


def line(row):
    """Return a failure as text, with the arguments that reproduce it."""
    kinds = [f"{k} above asked" for k in less_accurate(row)]
    kinds += [f"{k} above estimate" for k in above_estimate(row)]
    true, claimed = (" ".join(f"{x:.2g}" for x in row[key]) for key in ("true", "claimed"))
    return (
        f"{', '.join(kinds)}: --family {row['family']} --seed {row['seed']} --index {row['index']}"
        f" --solvers {row['solver']} --precision {row['precision']} --accuracy"
        f" {row['accuracy']:g}{' --low-memory only' if row['low_memory'] else ''}, n {row['n']},"
        f" load {row['load']} p* {row['p_star']:.6g}, {row['contact']} points; true {true}, claimed"
        f" {claimed}, {row['iterations']} iterations"
    )


def report(rows, worst=40):
    """Return the tables of all groups and at most `worst` failures as text."""
    keys = ("family", "solver", "precision", "accuracy", "low_memory")
    parts = [markdown(grouped(rows, by), by) for by in keys]
    for start, is_warm in (("cold or first", False), ("warm", True)):
        chosen = [row for row in rows if (row.get("load", 0) > 0) == is_warm]
        parts.append(f"Loads that are {start}:\n\n{markdown(grouped(chosen, 'precision'))}")
    bad = failures(rows)
    parts.append(f"{len(bad)} failures, the worst of each wall:")
    parts += [f"* {line(row)}" for row in worst_of_each(bad)[:worst]]
    broken = [row for row in rows if "error" in row]
    parts.append(f"{len(broken)} raised, refused or too slow:")
    for row in broken[:worst]:
        where = [row.get(k) for k in ("family", "seed", "index", "solver", "precision", "accuracy")]
        parts.append(f"* {' '.join(map(str, where))}: {row['status']} {row['error'][:150]}")
    return "\n\n".join(parts)
