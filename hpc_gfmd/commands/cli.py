"""The command line: arguments in, exit code out; an error is one line, for all ranks together."""

import difflib
import errno
import importlib
import io
import os
import sys
import traceback
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NoReturn

from ..util.errors import GfmdError, SceneError, how_to_install, one_line, reason
from ..util.file_names import require_decoded
from ..util.streams import discard, occupy_standard_descriptors
from ..util.versions import versions

COMMANDS = (  # files of this folder, in the order in which --help lists them
    "init",
    "help",
    "run",
    "restart",
    "plan",
    "law",
    "show",
    "plot",
    "export",
    "persson",
    "tfc",
    "info",
)
SHELLS = ("bash", "zsh", "tcsh")
WRITE_FILES = (["run"], ["restart"])  # what they print only tells of their result
ON_ALL_RANKS = ("run", "restart", "law", "info")  # the others work on rank 0 alone
GRACE_SECONDS = 1.0  # before a rank that failed alone aborts the job
DESCRIPTION = (
    "Elastic contact of rough surfaces. Start with: hpc-gfmd init; hpc-gfmd run scene.toml;"
    " hpc-gfmd plot contact.h5. With a measured map: hpc-gfmd init scan.x3p. Every key of a scene:"
    " hpc-gfmd help scene."
)


class Parser(ArgumentParser):
    """An ArgumentParser that raises SceneError, so that under MPI an error is printed once."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse arguments as argparse does, but refuse unknown ones here, where `prog` is known."""
        namespace, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return namespace, unknown

    def error(self, message: str) -> NoReturn:
        """Raise SceneError with the message and a hint at the --help of this command."""
        raise SceneError(f"{one_line(message, 400)} (see {self.prog} --help)")


class PrintCompletion(Action):
    """Option that prints a script for a shell, which completes commands and files, and exits."""

    def __call__(self, parser: ArgumentParser, namespace: Any, values: Any, *_: Any) -> None:
        """Print the script for the shell `values` and exit the process."""
        import shtab

        print(shtab.complete(parser, values))
        parser.exit()


def build_parser() -> ArgumentParser:
    """Make the parser with all commands; parsed arguments have `main`, that of the command."""
    parser = Parser(prog="hpc-gfmd", description=DESCRIPTION)
    version = versions().get("hpc_gfmd", "that is not installed")
    parser.add_argument("--version", action="version", version=f"hpc-gfmd {version}")
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print the script that completes this command line in a shell: {', '.join(SHELLS)}",
    )
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for name in COMMANDS:
        command = importlib.import_module(f".{name}", __package__)
        subparser = subparsers.add_parser(name, help=command.HELP, description=command.DESCRIPTION)
        command.add_arguments(subparser)
        subparser.set_defaults(main=command.main)
    return parser


def main(
    argv: Sequence[str] | None = None, script: Callable[[], ArgumentParser] | None = None
) -> int:
    """Run one command and return its exit code; errors are printed and do not raise. Collective.

    script makes another program's Parser, whose commands have a default `main`. Exit code: 0
    success, 1 failed or output not writable, 2 wrong input, 130 interrupted, or the command's.
    """
    occupy_standard_descriptors()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    arguments = list(sys.argv[1:] if argv is None else argv)
    exit_code = _run(arguments, script)
    unwritten = _flush_error()
    if exit_code or unwritten is None or arguments[:1] in WRITE_FILES:
        return exit_code
    if not isinstance(unwritten, BrokenPipeError):
        _print_error(f"standard output: {reason(unwritten)}")
    return 1


def _flush_error() -> OSError | None:
    """Flush standard output; redirect a broken one to the null device and return the error."""
    if sys.stdout is None:
        return OSError(errno.EBADF, os.strerror(errno.EBADF))
    try:
        sys.stdout.flush()
    except OSError as error:
        discard(sys.stdout)
        return error
    return None


def _run(arguments: Sequence[str], script: Callable[[], ArgumentParser] | None) -> int:
    """Run one command and return its exit code; after an error ranks wait. Collective."""
    command = arguments[0] if arguments else ""
    try:
        return _parsed(arguments, script)
    except BrokenPipeError:  # the reader of a pipe, such as `head`, has read enough
        discard(sys.stdout)
        return 1
    except (GfmdError, ImportError) as error:
        if isinstance(error, ImportError):
            error = GfmdError(_missing(command, error))
        _leave_together(error.exit_code, str(error))
        return error.exit_code
    except KeyboardInterrupt:  # the other ranks may not have been interrupted
        _leave_together(130, seconds=GRACE_SECONDS)
        return 130
    except Exception as error:
        exit_code, message = _of_exception(command, error)
        details = traceback.format_exc() if message.startswith("internal error") else ""
        _leave_together(exit_code, message, details, GRACE_SECONDS)
        return exit_code


def _parsed(arguments: Sequence[str], script: Callable[[], ArgumentParser] | None) -> int:
    """Parse the arguments, call `main` of their command and return its exit code, 0 if None."""
    for argument in arguments:
        require_decoded(argument)
    if script is None and arguments and not arguments[0].startswith("-"):
        _require_command(arguments[0])
    args: Namespace = (script or build_parser)().parse_args(arguments)
    work = partial(args.main, args)
    is_of_one = script is None and arguments[0] not in ON_ALL_RANKS
    return (_once(arguments[0], work) if is_of_one else work()) or 0


def _once(command: str, work: Callable[[], int | None]) -> int | None:
    """Call work() on rank 0 of several that a launcher started; return its exit code on all, and
    raise its errors on all. Without a way to communicate every process calls it. Collective.
    """
    from ..parallel.launcher import launched

    _, size = launched()
    if size is None or size == 1:
        return work()
    from ..parallel.guard import on_rank_0
    from ..parallel.world import world

    try:
        comm = world()
    except GfmdError:
        return work()
    return on_rank_0(comm, command, partial(_with_error_lines, command, work))


def _with_error_lines(command: str, work: Callable[[], int | None]) -> int | None:
    """Call work(); what `_run` foresees of files and libraries is raised with its line."""
    try:
        return work()
    except BrokenPipeError:
        discard(sys.stdout)
        return 1
    except ImportError as error:
        raise GfmdError(_missing(command, error)) from error
    except OSError as error:
        exit_code, message = _of_exception(command, error)
        raise (SceneError if exit_code == 2 else GfmdError)(message) from error


def _require_command(name: str) -> None:
    """Raise SceneError, which names a similar command, if hpc-gfmd has no command `name`."""
    if name not in COMMANDS:
        similar = difflib.get_close_matches(name[:80], COMMANDS, n=1)
        hints = [f"nearest: {command}, " for command in similar]
        raise SceneError(
            f"COMMAND: found {one_line(repr(name), 80)}, {''.join(hints)}allowed:"
            f" {', '.join(COMMANDS)} (see hpc-gfmd --help)"
        )


def _missing(command: str, error: ImportError) -> str:
    """Return an error message on what has to be installed for a command."""
    if isinstance(error, ModuleNotFoundError):
        package = (error.name or str(error)).partition(".")[0]
        return f"{command} needs {package}, which is not installed: {how_to_install(package)}"
    return f"{command}: a library cannot be loaded ({one_line(str(error))})"


def _of_exception(command: str, error: Exception) -> tuple[int, str]:
    """Return (exit code, line) for other exceptions: memory, permission, disk, "internal error"."""
    number = getattr(error, "errno", None)
    name = getattr(error, "filename", None) or command
    if isinstance(error, MemoryError) or number == errno.ENOMEM:
        details = one_line(str(error) or "no details")
        return 1, (
            f"out of memory{_on_rank()} ({details}): use more machines, fewer points or single"
            " precision"
        )
    if isinstance(error, PermissionError):
        return 2, f"{name}: {reason(error)}"
    if number in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
        return 1, f"{name}: {reason(error)}"
    kind = type(error).__name__
    return 1, f"internal error{_on_rank()}: {kind}: {one_line(str(error))}"


def _leave_together(
    exit_code: int, message: str = "", details: str = "", seconds: float = 10.0
) -> None:
    """Print an error once and wait for all ranks to leave with one, for `seconds` at most."""
    from ..parallel.world import collective_exit

    collective_exit(
        exit_code, seconds, partial(_print_error, message, details) if message else None
    )


def _print_error(message: str, details: str = "") -> None:
    """Print one line on standard error, after details for developers; errors are ignored."""
    if sys.stderr is None:
        return
    try:
        print(f"{details}hpc-gfmd: {message}", file=sys.stderr, flush=True)
    except OSError:
        discard(sys.stderr)


def _on_rank() -> str:
    """Return " on rank R" if a launcher started several ranks, else ""."""
    from ..parallel.launcher import launched, launcher_rank

    return f" on rank {launcher_rank()}" if launched()[0] else ""
