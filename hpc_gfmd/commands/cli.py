"""The command line: arguments in, exit code out, errors as one line on stderr, once whatever the
number of ranks. What the commands and their arguments are stands in commands.toml."""

import importlib
import sys
import tomllib
import traceback
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Sequence
from errno import ENOMEM
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from ..util.errors import GfmdError, SceneError, one_line, reason
from ..util.streams import unfailing_output
from ..util.versions import versions
from .common import number

ALONE = 1.0  # seconds that a rank with an error which others may not have waits for them
COMMANDS = tomllib.loads(Path(__file__).with_name("commands.toml").read_text("utf-8"))
TYPES = {"int": int, "number": number}
DESCRIPTION = (
    "Elastic contact of rough surfaces. Start with: hpc-gfmd init; hpc-gfmd run scene.toml;"
    " hpc-gfmd plot contact.h5. With a measured map: hpc-gfmd init scan.x3p. Every key of a scene:"
    " hpc-gfmd help scene."
)


class Parser(ArgumentParser):
    """argparse whose complaints are SceneErrors, so that under MPI they are printed once."""

    def error(self, message: str) -> NoReturn:
        raise SceneError(f"{message} (see {self.prog} --help)")


def build_parser() -> ArgumentParser:
    """Make the parser of all commands."""
    parser = Parser(prog="hpc-gfmd", description=DESCRIPTION)
    own = versions().get("hpc_gfmd", "that is not installed")
    parser.add_argument("--version", action="version", version=f"hpc-gfmd {own}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for name, about in COMMANDS.items():
        command = subparsers.add_parser(
            name, help=about["help"], description=about.get("description")
        )
        command.set_defaults(main=partial(_command, name), **about.get("defaults", {}))
        alternatives = None
        for flags, given in about.get("arguments", {}).items():
            place: Any = command
            options = dict(given)
            if options.pop("one_of", False):
                alternatives = alternatives or command.add_mutually_exclusive_group(required=True)
                place = alternatives
            if "type" in options:
                options["type"] = TYPES[options["type"]]
            if isinstance(options.get("metavar"), list):
                options["metavar"] = tuple(options["metavar"])
            place.add_argument(*flags.split(), **options)
    return parser


def _command(name: str, args: Namespace) -> int:
    """Run the command of a name: main(args) of its file."""
    return importlib.import_module(f".{name}", __package__).main(args)


def main(
    argv: Sequence[str] | None = None, script: Callable[[], ArgumentParser] | None = None
) -> int:
    """Run one command; returns its exit code. What cannot be printed stops no command, but is an
    error where it was the result.

    script: makes the Parser of a script of its own instead, with the default `main`.
    """
    with unfailing_output() as out:
        code, prints = _run(sys.argv[1:] if argv is None else argv, script)
        out.flush()
        if code or not prints or out.lost is None:
            return code
        if not isinstance(out.lost, BrokenPipeError):  # whoever read has stopped to listen
            _complain(f"standard output: {out.lost.strerror or out.lost}")
        return 1


def _run(argv: Sequence[str], script: Callable[[], ArgumentParser] | None) -> tuple[int, bool]:
    """Run one command; returns (exit code, whether the result is what was printed)."""
    from ..parallel.world import collective_exit

    asked = argv[0] if argv else None
    try:
        args = (script or build_parser)().parse_args(argv)
        return args.main(args) or 0, not getattr(args, "saves", False)
    except (GfmdError, ImportError) as error:
        if isinstance(error, ModuleNotFoundError):
            package = (error.name or str(error)).partition(".")[0]
            error = GfmdError(
                f"{asked} needs {package}, which is not installed here: pip install {package}"
            )
        elif isinstance(error, ImportError):
            error = GfmdError(f"{asked}: what it needs cannot be loaded ({one_line(str(error))})")
        collective_exit(error.exit_code, say=partial(_complain, error))
        return error.exit_code, False
    except KeyboardInterrupt:  # the other ranks may not have been interrupted
        collective_exit(130, ALONE)
        return 130, False
    except Exception as error:
        code, before = 1, ""
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == ENOMEM:
            said = f"out of memory{_where()} ({one_line(str(error) or 'no details')})"
            said += ": use more machines, fewer points or single precision"
        elif isinstance(error, PermissionError):
            code, said = 2, f"{error.filename or asked}: {reason(error)}"
        else:  # a mistake in the program: what it was, for those who mend it, and one line
            said, before = (
                f"internal error{_where()}: {type(error).__name__}: {one_line(str(error))}",
                traceback.format_exc(),
            )
        collective_exit(code, ALONE, partial(_complain, said, before))
        return code, False


def _complain(error: object, before: str = "") -> None:
    print(f"{before}hpc-gfmd: {error}", file=sys.stderr, flush=True)


def _where() -> str:
    """Name this rank, where there are several."""
    from ..parallel.launcher import launched, launcher_rank

    return f" on rank {launcher_rank()}" if launched()[0] else ""
