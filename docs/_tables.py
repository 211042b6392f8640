"""Fill the tables of the pages with measured rows: `python docs/_tables.py`.

A table stands in its page between `<!-- rows: NAME -->` and `<!-- end -->`. The rows are those of
`scripts/bench` in docs/bench (with a folder for each further machine) and of `scripts/campaign` in
docs/campaign.jsonl.
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
TIME_AND_MEMORY = "{cpu_seconds_min:.3g} s, {peak_mib:.0f} MiB"


def filled(text):
    """Return the text of a page with its tables filled."""
    return PLACE.sub(lambda place: f"{place[1]}\n{TABLES[place[2]]()}\n\n{place[3]}", text)


def rows(name, folder=DOCS / "bench"):
    """Return the rows in all files NAME.jsonl of a folder; NAME may have wildcards."""
    files = sorted(folder.rglob(f"{name}.jsonl"))
    return [json.loads(line) for path in files for line in path.read_text("utf-8").splitlines()]


def table(columns, rows, note=""):
    """Return rows as a Markdown table, and below it the machines and commits of the measurement.

    Parameters
    ----------
    columns : dict of str
        {title: template of the cells}.
    rows : list of dict
        Its rows.
    note : str
        Sentence below the table.
    """
    if not rows:
        return "There are no rows of this release yet."
    cells = [columns, ["---"] * len(columns)]
    cells += [[cell.format_map(row) for cell in columns.values()] for row in rows]
    text = "\n".join(f"| {' | '.join(line)} |" for line in cells)
    provenances = [row["provenance"] for row in rows if "provenance" in row]
    machines = [
        f"{cpu} (cores: {cores}), commit {', '.join(dict.fromkeys(p['commit'] for p in members))}"
        for (cpu, cores), members in grouped(provenances, "cpu", "cores")
    ]
    measured = f"Measured on {'; '.join(machines)}." if machines else ""
    return "\n\n".join(filter(None, [text, " ".join(filter(None, [note, measured]))]))


def grouped(rows, *keys):
    """Return [(values of the keys, rows that share them)], in the order of the values."""

    def values_of(row):
        return tuple(row[key] for key in keys)

    ordered = sorted(rows, key=values_of)
    return [(values, list(members)) for values, members in groupby(ordered, values_of)]


def span(values, form):
    """Return the range of values as text, such as 6.2 to 145."""
    low = f"{min(values):{form}}"
    high = f"{max(values):{form}}"
    return low if low == high else f"{low} to {high}"


def pairs():
    """Return FFT pairs by accuracy and grid: the mean over surfaces and loads, and the maximum."""
    pair_rows = rows("pairs")
    sizes = sorted({row["n"] for row in pair_rows})
    lines = [
        dict.fromkeys((f"n{n}" for n in sizes), "")
        | {f"n{row['n']}": f"{row['fft_pairs']:.2f} ({row['largest']:.1f})" for row in part}
        | {"accuracy": accuracy, "provenance": part[0]["provenance"]}
        for (accuracy,), part in grouped(pair_rows, "accuracy")
    ]
    columns = {"accuracy": "{accuracy:g}"} | {f"n = {n}": f"{{n{n}}}" for n in sizes}
    return table(columns, lines)


def process():
    """Return the times of one process: the first solve, the following ones, threads, memory."""
    lines = []
    for _, part in grouped(rows("process"), "n", "precision"):
        serial, *_, threaded = sorted(part, key=lambda row: row["threads"])
        lines.append(serial | {f"all_{key}": value for key, value in threaded.items()})
    threads = max((line["all_threads"] for line in lines), default=2)
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
    return table(columns, lines)


def scaling():
    """Return the scaling with ranks and threads of one machine."""
    columns = {
        "machine and grid": "{provenance[cores]} cores, n = {n}, {precision}",
        "ranks x threads": "{ranks} x {threads}",
        "time": "{seconds_min:.3g} s",
        "efficiency": "{efficiency:.2f}",
    }
    return table(columns, rows("scaling"))


def gpu():
    """Return the milliseconds of an iteration on a GPU and of its parts, by grid."""
    parts = ("search", "update and restriction", "levels", "iteration")
    lines = []
    for (n,), part in grouped([row for row in rows("gpu") if "n" in row and "ms" in row], "n"):
        fastest = min(row["ms"] for row in part if row["item"] == "pair")
        line = {"n": n, "pair": fastest} | dict.fromkeys(parts, "")
        for row in part:
            if row["item"] in parts and (row["kernels"] == "cuda" or row["item"] == "levels"):
                line[row["item"]] = f"{row['ms']:.3g}"
            if row["item"] == "iteration" and row["kernels"] == "cuda":
                line |= {"share": row["share_of_copy"], "memory": row["GiB_in_use"]}
        lines.append(line)
    columns = {
        "n": "{n}",
        "FFT pair": "{pair:.3g} ms",
        "search": "{search} ms",
        "update, restriction": "{update and restriction} ms",
        "coarse levels": "{levels} ms",
        "iteration": "{iteration} ms",
        "59 bytes a point over the speed of a copy": "{share:.2f}",
        "memory": "{memory:.1f} GiB",
    }
    return table(columns, lines)


def storage():
    """Return the speed of the result file and of raw writes."""
    columns = {
        "n": "{n}",
        "ranks": "{provenance[ranks]}",
        "what": "{way}",
        "GB/s": "{gb_per_s:.2f}",
        "time over raw": "{times raw:.2f}",
    }
    return table(columns, rows("storage"))


def releases():
    """Return time, pairs and memory of five standard contacts by release."""
    columns = {
        "release, commit": "{release}",
        "contact": "{scene}, n = {n}",
        "time": "{seconds_min:.3g} s",
        "pairs": "{fft_pairs:.1f}",
        "memory": "{peak_mib:.0f} MiB",
    }
    return table(columns, rows("releases"))


def billion():
    """Return the loads of the stored result of a billion points, and the time of the whole run."""
    steps = json.loads((DOCS / "billion/result.json").read_text())["steps"]
    columns = {
        "p\\*": "{p_star:.3g}",
        "time": "{wall_seconds:.0f} s",
        "pairs": "{fft_pairs:.1f}",
        "contact area": "{a_r:.4f}",
        "its error": "{a_r_error:.1g}",
    }
    return table(columns, steps, f"Both loads, surface and result file: {wall_time()}.")


def wall_time():
    """Return the wall time of the stored run of a billion points as text."""
    log = (DOCS / "billion/run.log").read_text()
    minutes, seconds = re.search(r"real\s+(\d+)m([\d.]+)s", log).groups()
    return f"{minutes} min {float(seconds):.0f} s"


def contests():
    """Return [(our fastest row, {peer: its fastest row or None})] of all compared contacts."""
    peer_rows = rows("peers*")
    for row in peer_rows:
        row["kind"] = "hardness" if row.get("hardness") else row["boundary"]
        if row.get("L_over_lam_l", 2) != 2:
            row["kind"] += f" with {row['L_over_lam_l']:g} waves"
        row["peer"] = PEERS.get(row["code"].partition("-")[0], "ours")
    refuse_unlike(peer_rows)
    pairs_of_rows = []
    for _, part in grouped(peer_rows, "kind", "n", "a_r", "asked"):
        fastest = {}
        for (peer,), attempts in grouped(part, "peer"):
            timed = [row for row in attempts if "cpu_seconds_min" in row]
            fastest[peer] = min(timed, key=lambda row: row["cpu_seconds_min"], default=None)
        if ours := fastest.pop("ours", None):
            pairs_of_rows.append((ours, fastest))
    return pairs_of_rows


def refuse_unlike(peer_rows):
    """Raise ValueError for rows of a tree with changes, and for rows of one code and contact whose
    status or tolerance differ."""
    for row in peer_rows:
        if row["provenance"]["commit"].endswith("+"):
            raise ValueError(f"peers: a row of {row['code']} is of a tree with changes")
    for key, same in grouped(peer_rows, "kind", "n", "a_r", "asked", "code"):
        for name in ("status", "tolerance"):
            found = {row.get(name) for row in same}
            if len(found) > 1:
                raise ValueError(f"peers: {key}: the {name} of its rows differ: {found}")


def peers():
    """Return time and memory at equal true error, with the fastest variant of each program."""
    compared = contests()
    versions = {p: row["version"] for _, others in compared for p, row in others.items() if row}
    cell = f"{TIME_AND_MEMORY}, {{cpu_seconds_over_ours:.3g}} times"
    lines = []
    for ours, others in compared:
        line = ours | {"ours": TIME_AND_MEMORY.format_map(ours)} | dict.fromkeys(versions, "")
        for peer in others.keys() & versions:
            line[peer] = cell.format_map(others[peer]) if others[peer] else "not reached"
        lines.append(line)
    columns = {
        "kind, n, area": "{kind}, {n}, {a_r:.3g}",
        "error": "{asked:g}",
        "hpc-gfmd": "{ours}",
    }
    columns |= {f"{peer} {versions[peer]}": f"{{{peer}}}" for peer in sorted(versions)}
    return table(columns, lines)


def times_by_load(error=1e-3):
    """Return {p*: rows of program, n and time} of the periodic contacts compared at an error."""
    times = {}
    for ours, others in contests():
        if (ours["kind"], ours["asked"]) == ("periodic", error):
            for name, row in ({"hpc-gfmd": ours} | others).items():
                if row:
                    point = {
                        "program": name,
                        "n": str(row["n"]),
                        "cpu_seconds_min": row["cpu_seconds_min"],
                    }
                    times.setdefault(row["p_star"], []).append(point)
    return times


def draw(path):
    """Draw the time of each program against the points along an axis."""
    sys.path.append(str(DOCS.parent / "scripts"))
    from bench.pictures import Panel, picture

    picture(
        path,
        [
            Panel(points, ("program",), "n", "cpu_seconds_min", f"p* = {p_star:g}")
            for p_star, points in sorted(times_by_load().items())
        ],
    )


def campaign():
    """Return the counts of the campaign's records."""
    records = rows("campaign", DOCS)
    for row in records:
        row["number"] = len(row["families"]) - 1
        row.setdefault("commit", "")
        row["other"] = ", ".join(f"{n} {outcome}" for outcome, n in row["others"].items())
    columns = {
        "families": "{number}",
        "loads converged": "{converged}",
        "less accurate than asked": "{less_accurate[0]}",
        "above own estimate": "{above_estimate[0]}",
        "other outcomes": "{other}",
        "commit": "{commit}",
    }
    return table(columns, records)


def failures():
    """Return the families of walls with failures in all records together, by the kind of error."""
    columns = {
        "family": "`{name}`",
        "loads converged": "{converged}",
        "less accurate than asked": "{wrong}",
        "above own estimate": "{above}",
    }
    counts_of_families = [
        counts | {"name": name}
        for row in rows("campaign", DOCS)
        for name, counts in row["families"].items()
        if name != "all"
    ]
    lines = []
    for (name,), part in grouped(counts_of_families, "name"):
        wrong, above = (
            [sum(numbers) for numbers in zip(*(counts[kind] for counts in part), strict=True)]
            for kind in ("less_accurate", "above_estimate")
        )
        if wrong[0] or above[0]:
            converged = sum(counts["converged"] for counts in part)
            line = {"name": name, "converged": converged}
            lines.append(line | {"wrong": _kinds(wrong), "above": _kinds(above)})
    return table(columns, lines) if lines else "No family has any."


def _kinds(counts):
    """Return the counts of the kinds of error as text; counts: of all, area, gap, pressure."""
    kinds = zip(("area", "gap", "pressure"), counts[1:], strict=True)
    return ", ".join(f"{n} {kind}" for kind, n in kinds if n) or "none"


def model():
    """Return the predictions for a large grid on one node and on 64, by the link of a node."""
    large = [row for row in rows("scaling-model") if row["n"] == 2**17]
    lines = []
    for _, part in grouped(large, "link_gb_per_s"):
        by_nodes = {row["nodes"]: row for row in part}
        lines.append(by_nodes[64] | {"memory": by_nodes[1]["of_bandwidth"]})
    columns = {
        "link": "{link_gb_per_s:g} GB/s",
        "one node: share of the memory's bandwidth": "{memory:.2f}",
        "64 nodes: efficiency against one": "{of_one_node:.2f}",
        "of it in transposes": "{share_transpose:.0%}",
    }
    return table(columns, lines)


def numbers():
    """Return the numbers of the README about speed and accuracy."""
    numbers_by_claim = {}
    if cost := [row["fft_pairs"] for row in rows("pairs") if row["accuracy"] == 1e-3]:
        numbers_by_claim["Cost of an accuracy of 1e-3 in area, mean gap and pressure"] = (
            f"{span(cost, '.1f')} [FFT pairs](docs/performance.md) (a transform of the grid"
            " and back), for any size"
        )
    if contested := [list(filter(None, others.values())) for _, others in contests()]:
        fastest = [min(part, key=_over_ours) for part in contested if part]
        best = min(fastest, key=_over_ours)
        where = "{kind}, n = {n}, area {a_r:.2g}, error {asked:g}".format_map(best)
        numbers_by_claim["Time of the fastest other program at equal true error"] = (
            f"{_over_ours(best):.2g} ({best['peer']}; {where}) to"
            f" {max(map(_over_ours, fastest)):.3g} times ours"
        )
    numbers_by_claim["Time for a billion points and two loads on two cores"] = wall_time()
    records = rows("campaign", DOCS)
    loads = sum(row["converged"] for row in records)
    wrong = sum(row["less_accurate"][0] for row in records)
    numbers_by_claim[f"Of {loads:,} loads with status converged"] = (
        f"{wrong or 'none'} missed the requested accuracy"
    )
    if plain := [row for row in rows("user") if row["what"] == "solve(z)"]:
        points = [row["n"] for row in plain]
        over_core = [row["over_core"] for row in plain]
        numbers_by_claim[
            "Time of `solve(array)` over that of its loads alone,"
            f" {min(points)} to {max(points)} points a side"
        ] = f"{span(over_core, '.1f')} ([rows](docs/bench/user.txt))"
    if texts := [row for row in rows("user") if row["what"] == "run of text"]:
        largest = max(texts, key=lambda row: row["n"])
        numbers_by_claim[
            "What a text map of {n} x {n} points takes beyond a .npy file".format_map(largest)
        ] = f"{largest['over_loadtxt']:.2g} times `numpy.loadtxt`"
    parts = [row for row in rows("light") if row["n"] == 1024 and row["solved"] == "part"]
    where = "of that on the whole grid ([rows](docs/performance.md#light-contacts))"
    for name, of_kind in (
        ("a light contact of a rough ball", [row for row in parts if row["roughness"]]),
        ("a contact of few points, up to 0.1 % of a rough wall", _few_points(parts)),
    ):
        ratios = [row["over_whole"] for row in of_kind]
        numbers_by_claim[f"Time of {name}, 1024 x 1024 points"] = f"{span(ratios, '.2f')} {where}"
    large = [row for row in rows("scaling") if row["n"] == 4096]
    widest = max(large, key=lambda row: (row["ranks"], row["precision"] == "single"))
    numbers_by_claim[f"{widest['ranks']} cores instead of one, 4096 x 4096 points"] = (
        f"{widest['efficiency'] * widest['ranks']:.1f} times faster"
    )
    lines = [{"claim": claim, "number": number} for claim, number in numbers_by_claim.items()]
    return table({" ": "{claim}", "  ": "{number}"}, lines)


def _over_ours(row):
    return row["cpu_seconds_over_ours"]


def _few_points(parts):
    return [row for row in parts if row["hurst"] and row["fft_pairs"] < 4]


def light():
    """Return the table of light contacts, on few points or in a box and on the whole grid."""
    all_rows = rows("light")
    lines = [
        row
        | {
            "surface": _surface(row),
            "whole_seconds": whole["cpu_seconds_min"],
            "whole_pairs": whole["fft_pairs"],
        }
        for row, whole in zip(all_rows[::2], all_rows[1::2])
    ]
    columns = {
        "surface": "{surface}",
        "n": "{n}",
        "area": "{a_r:.2g}",
        "default": "{cpu_seconds_min:.3g} s, {fft_pairs:.1f} pairs",
        "whole grid": "{whole_seconds:.3g} s, {whole_pairs:.1f} pairs",
        "ratio": "{over_whole:.2f}",
    }
    return table(columns, lines)


def _surface(row):
    if row["hurst"]:
        return f"wall, H = {row['hurst']}"
    if row["roughness"] is None:
        return "rough piece"
    return f"ball, roughness {row['roughness']}" if row["roughness"] else "ball"


TABLES = {
    function.__name__: function
    for function in (
        *(pairs, process, light, scaling, gpu, storage, releases, billion),
        *(peers, campaign, failures, model, numbers),
    )
}

if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
    draw(DOCS / "bench" / "peers.png")
