"""What rows of the campaign say: counts as data, a table of them, and the failures."""

import json
from collections import Counter
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL

SLACK = 1e-9  # rounding of the truth and of the comparison
KINDS = ("area", "gap", "pressure")


def read(path):
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def counts(row):
    """Tell whether a row is a converged solve that can be judged."""
    return row.get("status") == "converged" and row["kkt"] < DOUBTFUL


def less_accurate(row):
    """List the kinds of error above the accuracy that was asked for."""
    if not counts(row):
        return []
    return [k for k, true in zip(KINDS, row["true"]) if not true <= row["accuracy"] + SLACK]


def above_estimate(row):
    """List the kinds of error above their own estimate, though within what was asked for."""
    if not counts(row):
        return []
    errors = zip(KINDS, row["true"], row["claimed"])
    worse = less_accurate(row)
    return [k for k, true, claimed in errors if k not in worse and not true <= claimed + SLACK]


def count(rows):
    """Count what came of some rows."""
    outcomes = Counter(
        "no truth" if row.get("status") == "converged" and not counts(row) else row.get("status")
        for row in rows
    )
    pairs = [row["fft_pairs"] for row in rows if row.get("status") == "converged"]
    found = {"solves": len(rows), "converged": outcomes.pop("converged", 0), "others": outcomes}
    for judge in (less_accurate, above_estimate):
        kinds = [judge(row) for row in rows]
        found[judge.__name__] = [
            sum(map(bool, kinds)),
            *(sum(k in f for f in kinds) for k in KINDS),
        ]
    return found | {"mean_pairs": round(float(np.mean(pairs)), 2) if pairs else None}


def grouped(rows, by="family"):
    """Count by the values of a key, and all: {value: counts, "all": counts}."""
    names = sorted({str(row.get(by)) for row in rows})
    found = {name: count([row for row in rows if str(row.get(by)) == name]) for name in names}
    return found | {"all": count(rows)}


def markdown(groups, by="family"):
    """Write counts as a table; those less accurate than asked, and else above the estimate, in all,
    of area, of mean gap and of pressure."""
    lines = [
        f"| {by} | solves | converged | less accurate than asked (area / gap / pressure)"
        " | else above own estimate | other outcomes | mean pairs |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, found in groups.items():
        failures = [
            f"{n} ({' / '.join(map(str, kinds))})" if n else "0"
            for n, *kinds in (found["less_accurate"], found["above_estimate"])
        ]
        others = ", ".join(f"{n} {status}" for status, n in found["others"].items())
        cells = [name, found["solves"], found["converged"], *failures, others or "-"]
        lines.append(f"| {' | '.join(map(str, cells))} | {found['mean_pairs'] or '-'} |")
    return "\n".join(lines)


def failures(rows):
    """List the rows that are less accurate than asked or above their estimate, the worst first."""

    def badness(row):
        asked, claimed = less_accurate(row), above_estimate(row)
        of = zip(KINDS, row["true"], row["claimed"])
        ratios = [true / (row["accuracy"] if k in asked else max(c, SLACK)) for k, true, c in of]
        kinds = asked or claimed
        return bool(asked), max(r for k, r in zip(KINDS, ratios) if k in kinds)

    bad = [row for row in rows if less_accurate(row) or above_estimate(row)]
    return sorted(bad, key=badness, reverse=True)


def worst_of_each(bad):
    """Choose of failures in order the first of every wall and kind of failure."""
    first = {}
    for row in bad:
        first.setdefault((row["family"], row["seed"], row["index"], bool(less_accurate(row))), row)
    return list(first.values())


def line(row):
    """Write one failure, and what reproduces it."""
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
    """Write everything as text."""
    keys = ("family", "solver", "precision", "accuracy", "low_memory")
    parts = [markdown(grouped(rows, by), by) for by in keys]
    for what, warm in (("cold or first", False), ("warm", True)):
        some = [row for row in rows if (row.get("load", 0) > 0) == warm]
        parts.append(f"Loads that are {what}:\n\n{markdown(grouped(some, 'precision'))}")
    bad = failures(rows)
    parts.append(f"{len(bad)} failures, the worst of each wall:")
    parts += [f"* {line(row)}" for row in worst_of_each(bad)[:worst]]
    broken = [row for row in rows if "error" in row]
    parts.append(f"{len(broken)} raised, refused or too slow:")
    for row in broken[:worst]:
        where = [row.get(k) for k in ("family", "seed", "index", "solver", "precision", "accuracy")]
        parts.append(f"* {' '.join(map(str, where))}: {row['status']} {row['error'][:150]}")
    return "\n\n".join(parts)
