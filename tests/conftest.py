"""Markers and fixtures of all tests. Tests marked `mpi` take one of the fixtures

comm:    the test runs inside mpirun, on every rank at once (see mpi_harness.py)
mpirun:  a function that runs a command on several ranks: its exit code, stdout and stderr
"""

import json
import os
import shlex
import shutil
import signal
import tempfile
from collections import defaultdict
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import mpi_harness
import pytest
from hypothesis import settings

from hpc_gfmd.commands.cli import main
from hpc_gfmd.parallel.grid import _kept
from hpc_gfmd.util.caches import cache_folder

# the same examples in every run; HYPOTHESIS_PROFILE=default tries random ones
settings.register_profile("repeatable", derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

_results = {}  # ranks: {child's node id: (outcome, text)}


def pytest_configure(config):
    # Processes in the background of a script and their children ignore SIGINT otherwise.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if mpi_harness.is_child():
        config.pluginmanager.register(mpi_harness.Child())
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


def pytest_generate_tests(metafunc):
    if metafunc.definition.get_closest_marker("mpi") and not mpi_harness.is_child():
        counts = mpi_harness.rank_counts()
        metafunc.fixturenames.append("ranks")
        metafunc.parametrize("ranks", counts, indirect=True, ids=[f"n{k}" for k in counts])


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    _mark_slow_sets(items)
    lacking = mpi_harness.missing()
    marked = [item for item in items if item.get_closest_marker("mpi")]
    if lacking and marked:
        if mpi_harness.must_run():
            raise pytest.UsageError(
                f"tests on several ranks were asked for, but {lacking} is missing"
            )
        for item in marked:
            item.add_marker(
                pytest.mark.skip(reason=f"{lacking} is missing: no tests on several ranks")
            )


def _mark_slow_sets(items):
    """Mark as slow all but at most three sets of parameters of a test function.

    Those marked `quick` are not slow, else the first, the middle and the last one, which differ in
    most parameters. Two ranks take the first and the last of these, three ranks the last one, one
    and four ranks none.
    """
    functions = defaultdict(list)
    for item in items:
        if not item.get_closest_marker("slow"):
            functions[item.nodeid.partition("[")[0], _ranks(item)].append(item)
    for (_, ranks), sets in functions.items():
        chosen = [item for item in sets if item.get_closest_marker("quick")]
        if not chosen:
            chosen = [sets[0], sets[len(sets) // 2], sets[-1]]
        if not os.environ.get(mpi_harness.RANKS):
            ends = [chosen[0], chosen[-1]]
            chosen = {2: ends, 3: ends[-1:], None: chosen}.get(ranks, [])
        for item in sets:
            if item not in chosen:
                item.add_marker(pytest.mark.slow)


def _ranks(item):
    """The number of ranks of a test item, or None."""
    return item.callspec.params.get("ranks") if hasattr(item, "callspec") else None


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    """Report the outcome on the ranks for tests with `comm`, instead of calling them."""
    if mpi_harness.is_child() or not _on_ranks(pyfuncitem):
        return None
    ranks = pyfuncitem.callspec.params["ranks"]
    if ranks not in _results:
        names = [
            _child_id(item)
            for item in pyfuncitem.session.items
            if _on_ranks(item) and item.callspec.params["ranks"] == ranks
        ]
        _results[ranks] = mpi_harness.run(pyfuncitem.config.rootpath, ranks, names)
    outcome, text = _results[ranks][_child_id(pyfuncitem)]
    if outcome == "failed":
        pytest.fail(text, pytrace=False)
    if outcome == "skipped":
        pytest.skip(text)
    return True


def _on_ranks(item):
    return item.get_closest_marker("mpi") is not None and "comm" in getattr(
        item, "fixturenames", ()
    )


def _child_id(item):
    """The node id without the number of ranks, which comes first."""
    ranks = f"n{item.callspec.params['ranks']}"
    head, _, bracket = item.nodeid.partition("[")
    rest = bracket.removesuffix("]").removeprefix(ranks).removeprefix("-")
    return f"{head}[{rest}]" if rest else head


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """An empty cache of FFTW plans and measured speeds. Compiled kernels are those of the user,
    since compilation takes a minute."""
    if mpi_harness.is_child():  # ranks share the cache of their parent
        yield
        return
    kernels = os.environ.get("NUMBA_CACHE_DIR", str(cache_folder() / "kernels"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_CACHE_DIR", kernels)
        patch.setenv("HPC_GFMD_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(autouse=True)
def own_folder(request, monkeypatch):
    """Every test runs in its own folder, which its ranks share, and without kept grids."""
    _kept.tables.cache_clear()
    name = "shared_path" if mpi_harness.is_child() else "tmp_path"
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


@pytest.fixture
def ranks(request):
    """Number of ranks of this test item."""
    return request.param


@pytest.fixture
def mpirun(ranks):
    """mpirun(*args, env=None, cwd=None, timeout=None): `mpirun -n ranks hpc-gfmd args`, see
    mpi_harness.call."""

    def run(*args, **options):
        return mpi_harness.call(ranks, args, **options)

    run.start = partial(mpi_harness.start, ranks)
    return run


@pytest.fixture(scope="session")
def comm():
    """The communicator of all ranks, with compiled kernels; None in the parent process."""
    if not mpi_harness.is_child():
        return None
    from hpc_gfmd.contact import all_observables
    from hpc_gfmd.driver.warmup import compile_once
    from hpc_gfmd.parallel.world import world
    from hpc_gfmd.scene import ArrayScene

    observables = all_observables().values()
    for precision in ("single", "double"):
        scene = ArrayScene.from_dict({"load": {"p_star": 1}, "solver": {"precision": precision}})
        compile_once(world(), scene, lambda contact: [f(contact) for f in observables])
    return world()


@pytest.fixture
def shared_path(comm):
    """A temporary folder that all ranks share, removed after the test."""
    if comm is None:
        yield None
        return
    path = Path(comm.bcast(tempfile.mkdtemp(prefix="hpc-gfmd-") if comm.rank == 0 else None))
    yield path
    comm.barrier()
    if comm.rank == 0:
        shutil.rmtree(path, ignore_errors=True)
