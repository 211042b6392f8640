"""What rows of the campaign say, as a table."""

import json
from collections import defaultdict
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL

SLACK = 1e-9  # rounding of the truth and of the comparison
KINDS = ("area", "gap", "pressure")


def read(path):
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def counts(row):
    """Whether a row is a converged solve that can be judged."""
    return row.get("status") == "converged" and row["kkt"] < DOUBTFUL


def less_accurate(row):
    """The kinds of error above the accuracy that was asked for."""
    return (
        [k for k, true in zip(KINDS, row["true"]) if not true <= row["accuracy"] + SLACK]
        if counts(row)
        else []
    )


def above_estimate(row):
    """The kinds of error above their own estimate, though within what was asked for."""
    if not counts(row):
        return []
    worse = less_accurate(row)
    return [
        k
        for k, true, claimed in zip(KINDS, row["true"], row["claimed"])
        if k not in worse and not true <= claimed + SLACK
    ]


def _count(rows, judge):
    found = [judge(row) for row in rows]
    if not any(found):
        return "0"
    return f"{sum(map(bool, found))} ({' / '.join(str(sum(k in f for f in found)) for k in KINDS)})"


def markdown(rows, by="family"):
    """Rows by family (or solver, precision, accuracy): solves, converged, less accurate than asked,
    else above the estimate."""
    groups = defaultdict(list)
    for row in rows:
        groups[row.get(by)].append(row)
    lines = [
        (
            f"| {by} | solves | converged | less accurate than asked (area / gap / pressure) | else"
            " above own estimate (area / gap / pressure) | other outcomes | mean pairs |"
        ),
        "|---|---|---|---|---|---|---|",
    ]
    for name, group in [*sorted(groups.items(), key=lambda item: str(item[0])), ("all", rows)]:
        good = [row for row in group if row.get("status") == "converged"]
        others = defaultdict(int)
        for row in group:
            if row.get("status") != "converged":
                others[row.get("status")] += 1
            elif row["kkt"] >= DOUBTFUL:
                others["no truth"] += 1
        pairs = f"{np.mean([row['fft_pairs'] for row in good]):.1f}" if good else "-"
        lines.append(
            f"| {name} | {len(group)} | {len(good)} | {_count(group, less_accurate)} |"
            f" {_count(group, above_estimate)} |"
            f" {', '.join(f'{v} {k}' for k, v in others.items()) or '-'} | {pairs} |"
        )
    return "\n".join(lines)


def failures(rows):
    """Rows that are less accurate than asked or above their estimate, the worst first, with what
    went wrong."""

    def badness(row):
        asked = max(
            (t / row["accuracy"] for k, t in zip(KINDS, row["true"]) if k in less_accurate(row)),
            default=0,
        )
        claimed = max(
            (
                t / max(c, SLACK)
                for k, t, c in zip(KINDS, row["true"], row["claimed"])
                if k in above_estimate(row)
            ),
            default=0,
        )
        return (bool(asked), asked or claimed)

    return sorted(
        (row for row in rows if less_accurate(row) or above_estimate(row)),
        key=badness,
        reverse=True,
    )


def worst_of_each(bad):
    """Of failures in order the first of every wall and kind of failure."""
    seen, first = set(), []
    for row in bad:
        key = row["family"], row["seed"], row["index"], bool(less_accurate(row))
        if key not in seen:
            seen.add(key)
            first.append(row)
    return first


def line(row):
    """One failure, and what reproduces it."""
    kinds = [f"{k} above asked" for k in less_accurate(row)] + [
        f"{k} above estimate" for k in above_estimate(row)
    ]
    true, claimed = (" ".join(f"{x:.2g}" for x in row[key]) for key in ("true", "claimed"))
    return (
        f"{', '.join(kinds)}: --family {row['family']} --seed {row['seed']} --index {row['index']}"
        f" --solvers {row['solver']} --precision {row['precision']} --accuracy"
        f" {row['accuracy']:g}{' --low-memory only' if row['low_memory'] else ''}, n {row['n']},"
        f" load {row['load']} p* {row['p_star']:.6g}, {row['contact']} points; true {true}, claimed"
        f" {claimed}, {row['iterations']} iterations"
    )


def report(rows, worst=40):
    bad = failures(rows)
    parts = [
        markdown(rows),
        *(markdown(rows, by) for by in ("solver", "precision", "accuracy", "low_memory")),
    ]
    first = [row for row in rows if row.get("load") == 0]
    later = [row for row in rows if row.get("load", 0) > 0]
    parts.append("Cold loads (and first loads of sweeps):\n\n" + markdown(first, "precision"))
    if later:
        parts.append("Warm loads:\n\n" + markdown(later, "precision"))
    broken = [row for row in rows if row.get("status") in ("raised", "too slow", "no wall")]
    first = [f"* {line(row)}" for row in worst_of_each(bad)[:worst]]
    parts.append("\n".join([f"{len(bad)} failures, the worst of each wall:\n", *first]))
    if broken:
        lines = [
            f"* {row['family']} seed {row['seed']} index {row['index']} {row.get('solver')}"
            f" {row.get('precision')} {row.get('accuracy')}: {row['status']} {row['error'][:150]}"
            for row in broken[:worst]
        ]
        parts.append("\n".join([f"{len(broken)} raised or too slow:\n", *lines]))
    return "\n\n".join(parts)
