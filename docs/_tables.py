"""Tables of the pages that are made of measured rows: `python docs/_tables.py` fills them in.

A table stands in its page between `<!-- rows: NAME -->` and `<!-- end -->`. Rows are those of
`scripts/bench` in docs/bench (and folders in it: one for each further machine) and of
`scripts/campaign` in docs/campaign.jsonl.
"""

import json
import re
import sys
from itertools import groupby
from pathlib import Path

DOCS = Path(__file__).parent
PAGES = [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))]
PLACE = re.compile(r"(<!-- rows: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
PEERS = {"aspher": "ASPHER", "tamaas": "Tamaas", "contactmechanics": "ContactMechanics"}
TAKEN = "{seconds_min:.3g} s, {peak_mib:.0f} MiB"


def filled(text):
    """Return a page with its tables made anew."""
    return PLACE.sub(lambda place: f"{place[1]}\n{TABLES[place[2]]()}\n\n{place[3]}", text)


def rows(name, folder=DOCS / "bench"):
    """Read all rows that `scripts/bench NAME` left; NAME may have a wildcard."""
    files = sorted(folder.rglob(f"{name}.jsonl"))
    return [json.loads(line) for path in files for line in path.read_text("utf-8").splitlines()]


def table(columns, found, note=""):
    """Write rows as a Markdown table, and below it the machines and commits of their measurement.

    columns: {title: template of its cells}.
    """
    if not found:
        return "No rows of this release are there yet."
    cells = [columns, ["---"] * len(columns)]
    cells += [[cell.format_map(row) for cell in columns.values()] for row in found]
    text = "\n".join(f"| {' | '.join(line)} |" for line in cells)
    measured = [row["provenance"] for row in found if "provenance" in row]
    places = [
        f"{cpu} (cores: {cores}), commit {', '.join(dict.fromkeys(p['commit'] for p in of))}"
        for (cpu, cores), of in grouped(measured, "cpu", "cores")
    ]
    said = f"Measured on {'; '.join(places)}." if places else ""
    return "\n\n".join(filter(None, [text, " ".join(filter(None, [note, said]))]))


def grouped(found, *keys):
    """Return [(values of keys, the rows that share them)]."""

    def of(row):
        return tuple(row[key] for key in keys)

    return [(key, list(part)) for key, part in groupby(sorted(found, key=of), of)]


def span(values, form):
    """Write the range of values: 6.2 to 145."""
    low, high = (f"{of(values):{form}}" for of in (min, max))
    return low if low == high else f"{low} to {high}"


def pairs():
    """FFT pairs by accuracy and grid, means over surfaces and loads; and the largest."""
    found = rows("pairs")
    sizes = sorted({row["n"] for row in found})
    lines = [
        dict.fromkeys((f"n{n}" for n in sizes), "")
        | {f"n{row['n']}": f"{row['fft_pairs']:.2f} ({row['largest']:.1f})" for row in part}
        | {"asked": asked, "provenance": part[0]["provenance"]}
        for (asked,), part in grouped(found, "accuracy")
    ]
    columns = {"accuracy": "{asked:g}"} | {f"n = {n}": f"{{n{n}}}" for n in sizes}
    return table(columns, lines)


def process():
    """One process: the first solve, those that follow, threads, memory."""
    found = []
    for _, part in grouped(rows("process"), "n", "precision"):
        one, *_, most = sorted(part, key=lambda row: row["threads"])
        found.append(one | {f"all_{key}": value for key, value in most.items()})
    threads = max((row["all_threads"] for row in found), default=2)
    columns = {
        "n": "{n}",
        "precision": "{precision}",
        "first": "{cold_seconds:.3g} s",
        "next": "{seconds_min:.3g} s",
        f"{threads} threads (efficiency)": "{all_seconds_min:.3g} s ({all_efficiency:.2f})",
        "pairs": "{fft_pairs:.1f}",
        "memory": "{peak_mib:.0f} MiB",
        "outside of passes": "{outside_passes:.0%}",
    }
    return table(columns, found)


def scaling():
    """Ranks and threads of one machine."""
    columns = {
        "machine and grid": "{provenance[cores]} cores, n = {n}, {precision}",
        "ranks x threads": "{ranks} x {threads}",
        "time": "{seconds_min:.3g} s",
        "efficiency": "{efficiency:.2f}",
    }
    return table(columns, [row for row in rows("scaling") if row["kind"] != "weak"])


def storage():
    """The result file against raw writes."""
    columns = {
        "n": "{n}",
        "ranks": "{provenance[ranks]}",
        "what": "{way}",
        "GB/s": "{gb_per_s:.2f}",
        "time over raw": "{times raw:.2f}",
    }
    return table(columns, rows("storage"))


def releases():
    """Five standard contacts by release."""
    columns = {
        "release, commit": "{release}",
        "contact": "{scene}, n = {n}",
        "time": "{seconds_min:.3g} s",
        "pairs": "{fft_pairs:.1f}",
        "memory": "{peak_mib:.0f} MiB",
    }
    return table(columns, rows("releases"))


def billion():
    """The loads of the kept result of a billion points, and the whole run by its log."""
    steps = json.loads((DOCS / "billion/result.json").read_text())["steps"]
    columns = {
        "p\\*": "{p_star:.3g}",
        "time": "{wall_seconds:.0f} s",
        "pairs": "{fft_pairs:.1f}",
        "contact area": "{a_r:.4f}",
        "its error": "{a_r_error:.1g}",
    }
    return table(columns, steps, f"Both loads, surface and result file: {whole()}.")


def whole():
    """Write the wall time of the kept run of a billion points."""
    log = (DOCS / "billion/run.log").read_text()
    minutes, seconds = re.search(r"real\s+(\d+)m([\d.]+)s", log).groups()
    return f"{minutes} min {float(seconds):.0f} s"


def contests():
    """Return [(our fastest row, {peer: its fastest row or None})] of all that was compared."""
    every = rows("peers*")
    for row in every:
        row["kind"] = "hardness" if row.get("hardness") else row["boundary"]
        row["peer"] = PEERS.get(row["code"].partition("-")[0], "ours")
    found = []
    for _, part in grouped(every, "kind", "n", "a_r", "asked"):
        best = {}
        for (peer,), tried in grouped(part, "peer"):
            done = [row for row in tried if "seconds_min" in row]
            best[peer] = min(done, key=lambda row: row["seconds_min"], default=None)
        if ours := best.pop("ours", None):
            found.append((ours, best))
    return found


def peers():
    """Time and memory at equal true error, each program at its fastest."""
    found = contests()
    versions = {p: row["version"] for _, best in found for p, row in best.items() if row}
    lines = []
    for ours, best in found:
        line = ours | {"ours": TAKEN.format_map(ours)} | dict.fromkeys(versions, "")
        for peer in best.keys() & versions:
            row = best[peer]
            taken = f"{TAKEN}, {{seconds_over_ours:.3g}} times"
            line[peer] = taken.format_map(row) if row else "not reached"
        lines.append(line)
    columns = {
        "kind, n, area": "{kind}, {n}, {a_r:.3g}",
        "error": "{asked:g}",
        "hpc-gfmd": "{ours}",
    }
    columns |= {f"{peer} {versions[peer]}": f"{{{peer}}}" for peer in sorted(versions)}
    return table(columns, lines)


def duration(error=1e-3):
    """Return {p*: rows of program, n and time} of what was compared at this error, periodic."""
    found = {}
    for ours, best in contests():
        if (ours["kind"], ours["asked"]) == ("periodic", error):
            for name, row in ({"hpc-gfmd": ours} | best).items():
                if row:
                    point = {"program": name, "n": str(row["n"]), "seconds_min": row["seconds_min"]}
                    found.setdefault(row["p_star"], []).append(point)
    return found


def draw(path):
    """Draw the time that each program takes against the points along an axis."""
    sys.path.append(str(DOCS.parent / "scripts"))
    from bench.pictures import Panel, picture

    picture(
        path,
        [
            Panel(points, ("program",), "n", "seconds_min", f"p* = {p_star:g}")
            for p_star, points in sorted(duration().items())
        ],
    )


def campaign():
    """Counts of the campaign's records."""
    found = rows("campaign", DOCS)
    for row in found:
        row["number"] = len(row["families"]) - 1
        row.setdefault("commit", "")
        row["other"] = ", ".join(f"{n} {what}" for what, n in row["others"].items())
    columns = {
        "families": "{number}",
        "loads converged": "{converged}",
        "less accurate than asked": "{less_accurate[0]}",
        "above own estimate": "{above_estimate[0]}",
        "other outcomes": "{other}",
        "commit": "{commit}",
    }
    return table(columns, found)


def failures():
    """Families of walls with failures in all records together, by what was wrong."""
    columns = {
        "family": "`{name}`",
        "loads converged": "{converged}",
        "less accurate than asked": "{wrong}",
        "above own estimate": "{above}",
    }
    every = [
        of | {"name": name}
        for row in rows("campaign", DOCS)
        for name, of in row["families"].items()
        if name != "all"
    ]
    found = []
    for (name,), part in grouped(every, "name"):
        wrong, above = (
            [sum(counts) for counts in zip(*(of[kind] for of in part), strict=True)]
            for kind in ("less_accurate", "above_estimate")
        )
        if wrong[0] or above[0]:
            converged = sum(of["converged"] for of in part)
            of = {"name": name, "converged": converged}
            found.append(of | {"wrong": _kinds(wrong), "above": _kinds(above)})
    return table(columns, found) if found else "No family has one."


def _kinds(counts):
    kinds = zip(("area", "gap", "pressure"), counts[1:], strict=True)
    return ", ".join(f"{n} {kind}" for kind, n in kinds if n) or "none"


def model():
    """A large grid on one node and on 64, by the link of a node."""
    found = []
    for _, part in grouped([r for r in rows("scaling-model") if r["n"] == 2**17], "link_gb_per_s"):
        by = {row["nodes"]: row for row in part}
        found.append(by[64] | {"memory": by[1]["of_bandwidth"]})
    columns = {
        "link": "{link_gb_per_s:g} GB/s",
        "one node: share of the memory's bandwidth": "{memory:.2f}",
        "64 nodes: efficiency against one": "{of_one_node:.2f}",
        "of it in transposes": "{share_transpose:.0%}",
    }
    return table(columns, found)


def numbers():
    """What the README says of speed and accuracy."""
    found = {}
    if cost := [row["fft_pairs"] for row in rows("pairs") if row["accuracy"] == 1e-3]:
        found["An accuracy of 1e-3 in area, mean gap and pressure costs"] = (
            f"{span(cost, '.1f')} [FFT pairs](docs/performance.md) (a transform of the grid"
            " and back), whatever the size"
        )
    ratios = [
        min(row["seconds_over_ours"] for row in best.values() if row)
        for _, best in contests()
        if any(best.values())
    ]
    if ratios:
        found["Beside it the fastest other program, at equal true error, takes"] = (
            f"{span(ratios, '.3g')} times as long"
        )
    found["A billion points, two loads, on two cores"] = whole()
    records = rows("campaign", DOCS)
    loads, wrong = (
        sum(of) for of in zip(*((row["converged"], row["less_accurate"][0]) for row in records))
    )
    found[f"Of {loads:,} loads called converged"] = (
        f"{wrong or 'none'} were less accurate than asked"
    )
    strong = [row for row in rows("scaling") if row["kind"] == "strong" and row["n"] == 4096]
    most = max(strong, key=lambda row: (row["ranks"], row["precision"] == "single"))
    found[f"{most['ranks']} cores over one, 4096 x 4096 points"] = (
        f"{most['efficiency'] * most['ranks']:.1f} times as fast"
    )
    lines = [{"what": what, "number": number} for what, number in found.items()]
    return table({" ": "{what}", "  ": "{number}"}, lines)


TABLES = {
    made.__name__: made
    for made in (
        *(pairs, process, scaling, storage, releases, billion),
        *(peers, campaign, failures, model, numbers),
    )
}

if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
    draw(DOCS / "bench" / "peers.png")
