"""`hpc-gfmd plot`: the pictures of a result file."""

from argparse import Namespace

from ..output.read import read_result
from ..output.summary import converged
from ..util.errors import SceneError


def main(args: Namespace) -> int:
    """Draw the pictures and print their names; raises SceneError if the file, the folder or what is
    asked for is unusable."""
    from ..plotting import chosen_steps, plot_result

    result = read_result(args.file)
    if args.dpi is not None and not 20 <= args.dpi <= 2400:
        raise SceneError(f"--dpi: found {args.dpi}, allowed: 20 to 2400")
    paths = plot_result(
        result,
        args.output,
        args.what,
        step=args.step,
        window=args.window,
        dpi=args.dpi,
        dimensionless=args.dimensionless,
    )
    said, several = [], {*(args.what or ["maps"])} - {"heights"}
    places = min((chosen_steps(result, name, args.step) for name in several), key=len, default=[])
    shown = [result.indices[k] for k in places]
    left = [index for index in result.indices if index not in shown]
    if left and shown:
        said.append(f"shown: step {_list(shown)}; left out: {_list(left)} (--step chooses)")
    steps = result.numbered
    if doubtful := [index for index, step in steps.items() if not converged(step)]:
        said.append(f"! not converged: step {_list(doubtful)} (marked in the pictures)")
    said += [f"step {index}: {step['note']}" for index, step in steps.items() if step.get("note")]
    print(*paths, *said, *result.remarks, sep="\n")
    return 0


def _list(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))
