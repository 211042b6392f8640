"""The command line: arguments in, exit code out, errors as one line on stderr, once whatever the number of ranks."""

import argparse
import importlib
import importlib.util
import sys

from . import __version__
from .errors import GfmdError, SceneError

COMMANDS = ("run", "plan", "show", "plot", "persson", "tfc", "study", "bench", "info")


class _Parser(argparse.ArgumentParser):
    """argparse whose complaints are SceneErrors, so that under MPI they are printed once."""

    def error(self, message):
        raise SceneError(f"{self.prog}: {message} (see {self.prog} --help)")


def build_parser(commands=COMMANDS):
    """The parser with these commands, as far as they are there."""
    parser = _Parser(prog="hpc-gfmd", description="Elastic contact of rough surfaces. Start with: hpc-gfmd run SCENE.toml")
    parser.add_argument("--version", action="version", version=f"hpc-gfmd {__version__}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)
    for name in commands:
        module = f"{__package__}.commands.{name}"
        if importlib.util.find_spec(module):
            importlib.import_module(module).add_parser(subparsers)
    return parser


def main(argv=None):
    """Run one command; returns its exit code."""
    from .parallel.comm import launcher_rank, leave_together

    speaker = launcher_rank() == 0
    argv = sys.argv[1:] if argv is None else argv
    # The restart command lives with run; what is not asked for is not imported.
    asked = {"restart": "run"}.get(argv[0], argv[0]) if argv else None
    try:
        args = build_parser([asked] if asked in COMMANDS else COMMANDS).parse_args(argv)
        return args.main(args) or 0
    except GfmdError as error:
        if speaker:
            print(f"hpc-gfmd: {error}", file=sys.stderr, flush=True)
        leave_together(error.exit_code)
        return error.exit_code
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 0
