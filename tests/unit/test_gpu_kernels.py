"""Kernels for a GPU against those of the package, under numba's simulator."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import config

SIMULATED = bool(config.ENABLE_CUDASIM)
ROOT = Path(__file__).resolve().parents[2]
in_simulator = pytest.mark.skipif(not SIMULATED, reason="needs numba's CUDA simulator")


@pytest.mark.skipif(SIMULATED, reason="would start itself again")
def test_all_in_the_simulator():
    environment = {**os.environ, "NUMBA_ENABLE_CUDASIM": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", __file__]
    finished = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stdout + finished.stderr
    assert "6 passed" in finished.stdout


@pytest.fixture(autouse=True)
def arrays_of_the_simulator(monkeypatch):
    """Let the simulator take NumPy arrays where they stand, also parts of others."""
    if not SIMULATED:
        return
    from bench.gpu.numba_kernels import launch
    from numba.cuda.simulator.cudadrv.devicearray import FakeCUDAArray

    def view_of(argument):
        return FakeCUDAArray(argument) if isinstance(argument, np.ndarray) else argument

    monkeypatch.setattr(launch, "view_of", view_of)


def transfer_of(n):
    """Return the tables between a periodic grid and one of half the points along both axes."""
    i = np.arange(n)
    f = (i % 2 / 2).astype(np.float32)
    return i // 2 + 1, f, 1, i // 2, f, np.float32(0.25)


def random_state(n):
    """Return gap, pressure, encoded last step and z of level 1 with halo rows."""
    rng = np.random.default_rng(3)
    field = rng.normal(size=(n, n)).astype(np.float32)
    g = np.maximum(field, 0)
    p = np.where(field <= 0, -field, 0.1 * rng.normal(size=(n, n))).astype(np.float32)
    d = (0.1 * rng.normal(size=(n, n))).astype(np.float32)
    d[:, ::5] = -np.inf
    z_1 = rng.normal(size=(n // 2 + 2, n // 2)).astype(np.float32)
    z_1[0] = z_1[-2]
    z_1[-1] = z_1[1]
    return g, p, (d.view(np.uint32) >> 16).astype(np.uint16), z_1


@in_simulator
@pytest.mark.parametrize("coupling", [1.0, 0.0])
def test_search(coupling):
    from bench.gpu.numba_kernels import bpx as on_gpu

    from hpc_gfmd.kernels import bpx

    n = 32
    g, p, d, z_1 = random_state(n)
    transfer = transfer_of(n)
    step = tuple(np.float32(x) for x in (0.7, 0.2, coupling, 0.6))
    d_cpu = d.copy()
    made = np.zeros((n, n), np.float32)
    scratch = tuple(np.zeros((2, n), np.float32))
    rd, _ = bpx.projected_step(g, p, d_cpu, made, 0, n, z_1, transfer, step, None, (n, n), scratch)
    rows = np.full((n, n), np.nan, np.float32)
    sums = []
    for i0, i1 in ((0, 20), (20, n)):
        sums.append(on_gpu.step_on_rows(g, p, d, rows[i0:i1], i0, i1, z_1, step))
    differ = d != d_cpu  # where a step is rounded to its neighbour in 16 bits
    assert differ.mean() < 0.01
    assert np.allclose(rows, made, rtol=1 / 100, atol=1e-6)
    assert np.concatenate(sums).sum() == pytest.approx(rd, rel=1e-3)


@in_simulator
def test_update():
    from bench.gpu.numba_kernels import bpx as on_gpu

    from hpc_gfmd.kernels import bpx

    n = 32
    m = n // 2
    g, p, d, _ = random_state(n)
    Kd = (0.2 * np.random.default_rng(4).normal(size=(n, n))).astype(np.float32)
    transfer = transfer_of(n)
    s = np.float32(0.9)
    g_cpu = g.copy()
    p_cpu = p.copy()
    coarse_cpu = np.zeros((3, m + 2, m), np.float32)
    shared = np.zeros((2, 3, m), np.float32)
    sums_cpu = np.zeros(10)
    gathered = np.zeros((6, n), np.float32)
    bpx.update_state(
        g_cpu, p_cpu, d, Kd, s, 0, n, coarse_cpu, shared, transfer, None, (n, n), gathered, sums_cpu
    )
    coarse_cpu[:, 1], coarse_cpu[:, m + 1] = shared
    sums = []
    coarse = np.full((3, m + 2, m), np.nan, np.float32)
    for i0, i1 in ((0, 20), (20, n)):
        sums.append(on_gpu.change_on_rows(g, p, d[i0:i1], Kd[i0:i1], s, i0, i1))
        on_gpu.restrict_on_rows(g, p, Kd[i0:i1], i0, i1, i0 > 0, coarse)
    assert np.allclose(g, g_cpu, rtol=1e-5, atol=1e-6)
    assert np.allclose(p, p_cpu, rtol=1e-5, atol=1e-6)
    assert np.allclose(np.concatenate(sums).sum(axis=0), sums_cpu, rtol=1e-4, atol=1e-4)
    assert np.allclose(coarse[:, 1:], coarse_cpu[:, 1:], rtol=1e-5, atol=1e-5)


@in_simulator
def test_restriction_of_a_level():
    from bench.gpu.numba_kernels import multilevel as on_gpu

    from hpc_gfmd.kernels import multilevel

    n = 32
    fine = np.random.default_rng(5).normal(size=(3, n + 2, n)).astype(np.float32)
    expected, coarse = np.full((2, 2, n // 2 + 2, n // 2), np.nan, np.float32)
    scratch = tuple(np.zeros((2, n), np.float32))
    multilevel.restrict_level(fine[:2], expected, transfer_of(n), 0, n, scratch)
    for i0, i1 in ((0, 12), (12, n)):
        on_gpu.restrict_on_rows(fine[:2], coarse, i0, i1)
    assert np.allclose(coarse[:, 1:], expected[:, 1:], rtol=1e-5, atol=1e-6)


@in_simulator
@pytest.mark.parametrize("fields", [2, 3])
def test_smoothing_of_a_level(fields):
    from bench.gpu.numba_kernels import multilevel as on_gpu

    from hpc_gfmd.kernels import multilevel

    n = 32
    level = np.random.default_rng(6).normal(size=(fields, n + 2, n)).astype(np.float32)
    level[1] = abs(level[1])
    _, _, _, z_1 = random_state(n)
    ones = np.ones(n, np.float32), np.ones(n, np.float32)
    numbers = np.float32(0.4), np.float32(1.6)
    scratch = tuple(np.zeros((2, n), np.float32))
    expected = level.copy()
    sums_cpu = multilevel.smooth_level(
        expected, z_1, expected[0], *numbers, transfer_of(n), ones, 0, n, scratch
    )
    sums = on_gpu.smooth_on_rows(level, z_1, level[0], *numbers, 0, n).sum(axis=0)
    assert np.allclose(level[0, 1:-1], expected[0, 1:-1], rtol=1e-5, atol=1e-6)
    assert np.allclose(sums, sums_cpu, rtol=1e-4, atol=1e-3)
