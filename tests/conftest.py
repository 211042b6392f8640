"""Markers and fixtures of all tests. Tests marked `mpi` take the fixture `comm`, all ranks of an
mpirun around pytest, and run on every rank at once (see mpi_harness.py)."""

import json
import os
import shlex
import shutil
import signal
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace

import mpi_harness
import pytest
from hypothesis import HealthCheck, settings

from hpc_gfmd.commands.cli import main
from hpc_gfmd.parallel.grid import _kept
from hpc_gfmd.parallel.world import world
from hpc_gfmd.util.caches import cache_folder

# the same examples in every run; HYPOTHESIS_PROFILE=default tries random ones
slow_examples = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
settings.register_profile("default", deadline=None, suppress_health_check=slow_examples)
settings.register_profile("repeatable", settings.get_profile("default"), derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_configure(config):
    # Processes in the background of a script and their children ignore SIGINT otherwise.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if world().size > 1:
        config.pluginmanager.register(mpi_harness.OnRanks())
        if world().rank > 0:
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115 (rank 0 reports)
        return
    # clean-up of tests runs, and with it ends what they have started
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        import mpi4py
    except ImportError:
        return
    mpi4py.rc.initialize = False  # a process that initialised MPI cannot start mpirun


def pytest_make_parametrize_id(val):
    """Ids of lists and tables show their content, those of files their stem."""
    if isinstance(val, tuple | list | dict | Path):
        return str(getattr(val, "stem", val))[:60]
    return None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark as slow all but at most three sets of parameters of a test function.

    Those marked `quick` are not slow, else the first, the middle and the last one, which differ in
    most parameters. Two ranks take the first and the last of these, more ranks the last one, and
    none of those marked `two_ranks`.
    """
    functions = defaultdict(list)
    for item in items:
        if item.get_closest_marker("alone") and not item.get_closest_marker("slow"):
            raise pytest.UsageError(f"{item.nodeid}: marked alone, which only slow tests may be")
        if world().size > 2 and item.get_closest_marker("two_ranks"):
            item.add_marker(pytest.mark.slow)
        elif not item.get_closest_marker("slow"):
            functions[item.nodeid.partition("[")[0]].append(item)
    for sets in functions.values():
        chosen = [item for item in sets if item.get_closest_marker("quick")]
        if not chosen:
            chosen = [sets[0], sets[len(sets) // 2], sets[-1]]
        chosen = {1: chosen, 2: [chosen[0], chosen[-1]]}.get(world().size, chosen[-1:])
        for item in sets:
            if item not in chosen:
                item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """An empty cache of FFTW plans and measured speeds. Compiled kernels are those of the user,
    since compilation takes a minute."""
    kernels = os.environ.get("NUMBA_CACHE_DIR", str(cache_folder() / "kernels"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_CACHE_DIR", kernels)
        folder = tmp_path_factory.mktemp("cache") if world().rank == 0 else None
        patch.setenv("HPC_GFMD_CACHE", str(world().bcast(folder)))
        yield


@pytest.fixture(autouse=True)
def own_folder(request, monkeypatch):
    """Every test runs in its own folder, which its ranks share, and without kept grids."""
    _kept.tables.cache_clear()
    name = "shared_path" if "comm" in request.fixturenames else "tmp_path"
    monkeypatch.chdir(request.getfixturevalue(name))


@pytest.fixture
def folder(request, tmp_path):
    """The current folder with scene.toml, whose content is SCENE of the test's module."""
    (tmp_path / "scene.toml").write_text(request.module.SCENE, encoding="utf-8")
    return tmp_path


@pytest.fixture
def path(tmp_path):
    """Path of a result file."""
    return tmp_path / "out.h5"


@pytest.fixture
def cli(capfd):
    """cli("words of a command", *args) runs a command in this process: `code`, `out` and `err`.

    cli.prints(*args): the output of a command that has to succeed
    cli.data(*args): its output with --json, parsed
    cli.refused(*args, code=2): the error, one line, of a command that has to fail
    cli.script: function that makes the parser of a script, to run this script instead
    """

    def run(words="", *more_words):
        capfd.readouterr()
        code = main([*shlex.split(words), *map(str, more_words)], run.script)
        return SimpleNamespace(code=code, **capfd.readouterr()._asdict())

    def prints(*args):
        completed = run(*args)
        assert completed.code == 0, completed.err
        return completed.out

    def data(*args):
        return json.loads(prints(*args, "--json"))

    def refused(*args, code=2):
        completed = run(*args)
        assert (completed.code, completed.err.count("\n")) == (code, 1), completed.err
        assert completed.err.strip().isprintable()
        return completed.err

    run.prints = prints
    run.data = data
    run.refused = refused
    run.script = None
    return run


@pytest.fixture(scope="session")
def comm():
    """The communicator of all ranks, with compiled kernels."""
    from hpc_gfmd.contact import all_observables
    from hpc_gfmd.driver.warmup import compile_once
    from hpc_gfmd.scene import ArrayScene

    observables = all_observables().values()
    for precision in ("single", "double"):
        scene = ArrayScene.from_dict({"load": {"p_star": 1}, "solver": {"precision": precision}})
        compile_once(world(), scene, lambda contact: [f(contact) for f in observables])
    return world()


@pytest.fixture
def shared_path(comm):
    """A temporary folder that all ranks share, removed after the test."""
    path = Path(comm.bcast(tempfile.mkdtemp(prefix="hpc-gfmd-") if comm.rank == 0 else None))
    yield path
    comm.barrier()
    if comm.rank == 0:
        shutil.rmtree(path, ignore_errors=True)
