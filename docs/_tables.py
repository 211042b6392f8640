"""Tables of the pages that are made of measured rows: `python docs/_tables.py` fills them in.

A table stands in its page between `<!-- rows: NAME -->` and `<!-- end -->`. Rows are those of
`scripts/bench` in docs/bench (and folders in it: one for each further machine) and of
`scripts/campaign` in docs/campaign.jsonl. A test compares the pages with what the rows give.
"""

import json
import re
from itertools import groupby
from pathlib import Path

import numpy as np

DOCS = Path(__file__).parent
PAGES = [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))]
PLACE = re.compile(r"(<!-- rows: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
PEERS = {"aspher": "ASPHER", "tamaas": "Tamaas", "contactmechanics": "ContactMechanics"}


def filled(text):
    """Return a page with its tables made anew."""
    return PLACE.sub(lambda place: f"{place[1]}\n{TABLES[place[2]]().strip()}\n\n{place[3]}", text)


def rows(name, folder=DOCS / "bench"):
    """Read all rows that `scripts/bench NAME` left; NAME may have a wildcard."""
    files = sorted(folder.rglob(f"{name}.jsonl"))
    return [json.loads(line) for path in files for line in path.read_text("utf-8").splitlines()]


def table(head, lines, found=()):
    """Write a Markdown table, and below it the machines and commits of the rows."""
    if not lines:
        return "No rows of this release are there yet."
    cells = [head, ["---"] * len(head), *lines]
    text = "\n".join(f"| {' | '.join(map(str, line))} |" for line in cells)
    places = dict.fromkeys(_place(row["provenance"]) for row in found)
    return "\n\n".join([text, *[f"Measured on {'; '.join(places)}."] * bool(places)])


def _place(of):
    return f"{of['cores']} cores of {of['cpu']}, commit {of['commit']}"


def grouped(found, *keys):
    """Yield the values of keys, and the rows that share them."""

    def of(row):
        return tuple(row[key] for key in keys)

    return [(key, list(part)) for key, part in groupby(sorted(found, key=of), of)]


def number(x):
    """Write three digits: 0.0406, 1.25, 149."""
    return f"{float(f'{x:.2e}'):.{max(0, 2 - int(f'{x:e}'.rpartition('e')[2]))}f}" if x else "0"


def span(values, write=number):
    """Write the range of values: 6.2 to 145."""
    low, high = write(min(values)), write(max(values))
    return low if low == high else f"{low} to {high}"


# FFT pairs and accuracy


def our_pairs():
    """Rows of the default solver in single precision as a user starts it: {asked: {n: pairs}}."""
    ours = {"solver": "bpx", "start": "nested", "precision": "single", "hurst": 0.8}
    found = [r for r in rows("accuracy") if ours.items() <= r.items()]
    means = {
        asked: {n: np.mean([r["fft_pairs"] for r in part]) for (n,), part in grouped(same, "n")}
        for (asked,), same in reversed(grouped(found, "asked"))
    }
    return found, means


def pairs():
    """FFT pairs by accuracy and grid, means over the loads."""
    found, means = our_pairs()
    sizes = sorted({n for of in means.values() for n in of})
    lines = [
        [f"{asked:g}", *(f"{of[n]:.1f}" if n in of else "" for n in sizes)]
        for asked, of in means.items()
    ]
    loads = ", ".join(f"{p:.3g}" for (p,), _ in grouped(found, "p_star"))
    said = f"Means over p* = {loads}." if found else ""
    return f"{table(['accuracy', *(f'n = {n}' for n in sizes)], lines, found)}\n\n{said}"


def process():
    """One process: the first solve, those that follow, threads, memory."""
    found = rows("process")
    lines = []
    for (n, precision), part in grouped(found, "n", "precision"):
        by = {row["threads"]: row for row in part}
        one, most = by[min(by)], by[max(by)]
        lines.append(
            [
                n,
                precision,
                *(f"{number(s)} s" for s in (one["cold_seconds"], one["seconds_min"])),
                f"{number(most['seconds_min'])} s ({most['efficiency']:.2f})",
                f"{one['fft_pairs']:.1f}",
                f"{one['peak_mib']:.0f} MiB",
                f"{one['outside_passes']:.0%}",
            ]
        )
    threads = f"{max((row['threads'] for row in found), default=2)} threads (efficiency)"
    head = ["n", "precision", "first", "next", threads, "pairs", "memory", "outside of passes"]
    return table(head, lines, found)


def scaling():
    """Ranks and threads of one machine."""
    found = [row for row in rows("scaling") if row["kind"] in ("strong", "threads")]
    lines = [
        [
            f"{row['provenance']['cores']} cores, n = {row['n']}, {row['precision']}",
            f"{row['ranks']} x {row['threads']}",
            f"{number(row['seconds_min'])} s",
            f"{row['efficiency']:.2f}",
        ]
        for row in found
    ]
    return table(["machine and grid", "ranks x threads", "time", "efficiency"], lines, found)


def kernels():
    """One iteration, over a copy and over FFTW's own transform."""
    found = rows("kernels")
    lines = []
    for (n, precision, cores), part in grouped(found, "n", "precision", "cores"):
        by = {row["what"]: row for row in part}
        fftw = by.get("FFTW 2-D", {}).get("iteration_over_this")
        one = by["iteration"]
        rates = (f"{one[k]:.2f}" for k in ("ns_per_point", "gb_per_s", "share_of_copy"))
        lines.append([n, precision, cores, *rates, f"{fftw:.2f}" if fftw else ""])
    head = ["n", "precision", "cores", "ns a point", "GB/s", "over a copy's", "over FFTW's pair"]
    return table(head, lines, found)


def storage():
    """The result file against raw writes."""
    found = rows("storage")
    lines = [
        [
            row["n"],
            row["provenance"]["ranks"],
            row["way"],
            f"{row['gb_per_s']:.2f}",
            f"{row['times raw']:.2f}",
        ]
        for row in found
    ]
    return table(["n", "ranks", "what", "GB/s", "time over raw"], lines, found)


def releases():
    """Five standard contacts by release."""
    found = rows("releases")
    lines = [
        [
            row["release"],
            f"{row['scene']}, n = {row['n']}",
            f"{number(row['seconds_min'])} s",
            f"{row['fft_pairs']:.1f}",
            f"{row['peak_mib']:.0f} MiB",
        ]
        for row in found
    ]
    return table(["release, commit", "contact", "time", "pairs", "memory"], lines, found)


def billion():
    """The loads of the kept result of a billion points, and the whole run by its log."""
    steps = json.loads((DOCS / "billion/result.json").read_text())["steps"]
    lines = [
        [
            f"p* = {step['p_star']:.3g}",
            *(f"{step['wall_seconds']:.0f} s", f"{step['fft_pairs']:.1f}"),
            f"{step['a_r']:.4f} ± {step['a_r'] * step['a_r_error']:.1g}",
        ]
        for step in steps
    ]
    return table(["load", "time", "pairs", "contact area"], [*lines, ["all", whole(), "", ""]])


def whole():
    """Write the wall time of the kept run of a billion points."""
    log = (DOCS / "billion/run.log").read_text()
    minutes, seconds = re.search(r"real\s+(\d+)m([\d.]+)s", log).groups()
    return f"{minutes} min {float(seconds):.0f} s"


# Other programs


def contests():
    """Yield (case, our fastest row, {peer: its fastest row or None}) of all that was compared."""
    every = rows("peers*")
    for row in every:
        row["kind"] = "hardness" if row.get("hardness") else row["boundary"]
    for key, part in grouped(every, "kind", "n", "a_r", "asked"):
        best = {}
        for row in part:
            name = PEERS.get(row["code"].partition("-")[0], "ours")
            best.setdefault(name, None)
            if "seconds_min" in row and (
                best[name] is None or row["seconds_min"] < best[name]["seconds_min"]
            ):
                best[name] = row
        if ours := best.pop("ours", None):
            yield key, ours, best


def peers():
    """Time and memory at equal true error, each program at its fastest."""
    found = list(contests())
    versions = {
        name: row.get("version", "")
        for *_, best in found
        for name, row in best.items()
        if row is not None
    }
    lines = []
    for (kind, n, a_r, asked), ours, best in found:
        cells = [_taken(ours)]
        for name in versions:
            row = best.get(name)
            over = f", {number(row['seconds_over_ours'])} times" if row else ""
            cells.append(_taken(row) + over if row else "not reached" if name in best else "")
        lines.append([f"{kind}, {n}, {a_r:.3g}", f"{asked:g}", *cells])
    named = [f"{name} {version}" for name, version in versions.items()]
    measured = [ours for _, ours, _ in found]
    return table(["kind, n, area", "error", "hpc-gfmd", *named], lines, measured)


def _taken(row):
    return f"{number(row['seconds_min'])} s, {row['peak_mib']:.0f} MiB"


# The campaign


def campaign():
    """Counts of the campaign's records."""
    lines = []
    for row in rows("campaign", DOCS):
        wrong, above = (row[key][0] for key in ("less_accurate", "above_estimate"))
        families = len(row["families"]) - 1
        others = ", ".join(f"{n} {what}" for what, n in row["others"].items())
        lines.append([families, row["converged"], wrong, above, others, row["commit"]])
    head = ["families", "loads converged", "less accurate than asked", "above own estimate"]
    return table([*head, "other outcomes", "commit"], lines)


def failures():
    """Families of walls with failures, by what was wrong."""
    lines = [
        [
            f"`{name}`",
            of["converged"],
            *(_kinds(of[k]) for k in ("less_accurate", "above_estimate")),
        ]
        for row in rows("campaign", DOCS)
        for name, of in row["families"].items()
        if name != "all" and (of["less_accurate"][0] or of["above_estimate"][0])
    ]
    head = ["family", "loads converged", "less accurate than asked", "above own estimate"]
    return table(head, lines)


def _kinds(counts):
    kinds = zip(("area", "gap", "pressure"), counts[1:], strict=True)
    return ", ".join(f"{n} {kind}" for kind, n in kinds if n) or "none"


# The model of a cluster, the README


def model():
    """A large grid on one node and on 64, by the link of a node."""
    found = [row for row in rows("scaling-model") if row["n"] == 2**17]
    lines = []
    for (link,), part in reversed(grouped(found, "link_gb_per_s")):
        by = {row["nodes"]: row for row in part}
        memory, apart = by[1]["of_bandwidth"], by[64]
        lines.append(
            [
                f"{link:g} GB/s",
                f"{memory:.2f}",
                f"{apart['of_one_node']:.2f}",
                f"{apart['share_transpose']:.0%}",
            ]
        )
    head = ["link", "one node: share of the memory's bandwidth"]
    return table([*head, "64 nodes: efficiency against one", "of it in transposes"], lines, found)


def numbers():
    """What the README says of speed and accuracy."""
    lines = []
    if found := our_pairs()[1].get(1e-3):
        said = f"{span(found.values(), '{:.0f}'.format)} [FFT pairs](docs/performance.md)"
        lines.append(
            [
                "An accuracy of 1e-3 in area, mean gap and pressure costs",
                f"{said} (a transform of the grid and back), whatever the size",
            ]
        )
    ratios = [
        min(row["seconds_over_ours"] for row in best.values() if row)
        for _, _, best in contests()
        if any(best.values())
    ]
    if ratios:
        said = f"{span(ratios, '{:.2g}'.format)} times the time of this one"
        lines.append(["The fastest other program takes, at equal true error", said])
    lines.append(["A billion points, two loads, on two cores", whole()])
    record = rows("campaign", DOCS)[-1]
    asked = f"{record['less_accurate'][0]} were less accurate than asked"
    lines.append([f"Of {record['converged']:,} loads called converged", asked])
    strong = [row for row in rows("scaling") if row["kind"] == "strong" and row["n"] == 4096]
    strong = [row for row in strong if row["precision"] == "single"]
    if strong:
        most = max(strong, key=lambda row: row["ranks"])
        where = most["provenance"]["cores"]
        one = next(r for r in strong if r["provenance"]["cores"] == where and r["ranks"] == 1)
        times = one["seconds_min"] / most["seconds_min"]
        what = f"{most['ranks']} cores over one, 4096 x 4096 points"
        lines.append([what, f"{times:.1f} times as fast"])
    return table(["", ""], lines)


TABLES = {
    made.__name__: made
    for made in (
        *(pairs, process, scaling, kernels, storage, releases, billion),
        *(peers, campaign, failures, model, numbers),
    )
}

if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
