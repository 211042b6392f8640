"""Time, FFT pairs and memory of five standard contacts: every release adds its rows to the file
that is there, so that a loss is seen."""

from hpc_gfmd import __version__

from .pictures import Panel, picture
from .report import Report
from .timing import measured, summary

SCENES = {  # p*, and arguments of hpc_gfmd.solve
    "light": {"p_star": 0.007},
    "dense": {"p_star": 0.353},
    "tight": {"p_star": 0.05, "accuracy": 1e-6},
    "layer": {"p_star": 0.05, "thickness": 0.05, "nu": 0.45},
    "free edges": {"p_star": 0.05, "boundary": "free"},
}


def run(args):
    """Add the rows of this release; args: of command.py."""
    report = Report("releases", args.out, append=True)
    release = f"{__version__} {report.head['commit']}"
    for n in args.n:
        jobs = {name: (1, {"n": n} | of) for name, of in SCENES.items()}
        for name, rows in measured("process", jobs, args.repeats).items():
            report.add(release=release, scene=name, n=n, **SCENES[name], **summary(rows))
    report.finish()
    if report.path:
        panels = [
            Panel(report.rows, ("scene", "n"), "release", what)
            for what in ("seconds_min", "fft_pairs", "peak_mib")
        ]
        picture(report.path.with_suffix(".png"), panels)
