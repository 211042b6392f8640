"""Time, FFT pairs and memory of five standard contacts.

Every release appends its rows to the file, so that a regression shows.
"""

from hpc_gfmd import __version__

from .pictures import Panel, picture
from .report import Report
from .timing import run_workers, summary

SCENES = {  # p*, and arguments of hpc_gfmd.solve
    "light": {"p_star": 0.007},
    "dense": {"p_star": 0.353},
    "tight": {"p_star": 0.05, "accuracy": 1e-6},
    "layer": {"p_star": 0.05, "thickness": 0.05, "nu": 0.45},
    "free edges": {"p_star": 0.05, "boundary": "free"},
}


def run(args):
    """Append the rows of this release and draw those of all releases."""
    report = Report("releases", args.out, append=True)
    release = f"{__version__} {report.head['commit']}"
    for n in args.n:
        jobs = {name: (1, {"n": n} | settings) for name, settings in SCENES.items()}
        for name, rows in run_workers("process", jobs, args.repeats).items():
            report.add(release=release, scene=name, n=n, **SCENES[name], **summary(rows))
    report.finish()
    if report.path:
        panels = [
            Panel(report.rows, ("scene", "n"), "release", column)
            for column in ("seconds_min", "fft_pairs", "peak_mib")
        ]
        picture(report.path.with_suffix(".png"), panels)
