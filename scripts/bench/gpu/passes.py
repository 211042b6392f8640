"""Times of the passes of an iteration, of copies and of launches."""

import time
from functools import partial

import cupy as cp
import numpy as np

from .convolution import Convolution
from .rows import MIB, timed
from .state import STEP, State, random_field

FLOOR = 59  # bytes per point of an iteration if all passes were fused as on the CPU


def measure_copies(rows):
    """Measure copies on the device, and between it and the host."""
    count = 2**30
    source = random_field((count,))
    target = cp.empty_like(source)
    size = source.nbytes

    def copy():
        cp.cuda.runtime.memcpyAsync(target.data.ptr, source.data.ptr, size, 3, 0)

    milliseconds = timed(copy)
    rows.copy_speed = 2 * size / milliseconds * 1e3
    rows.add("copy on the device", ms=milliseconds, GB_per_s=round(rows.copy_speed / 1e9, 1))
    milliseconds = timed(lambda: cp.multiply(source, np.float32(2), out=target))
    rows.add(
        "scale on the device", ms=milliseconds, GB_per_s=round(2 * size / milliseconds / 1e6, 1)
    )
    size = 2**28
    pinned = np.frombuffer(cp.cuda.alloc_pinned_memory(size), np.uint8, size)
    pageable = np.ones(size, np.uint8)
    pinned[...] = 1
    for name, host in (("pinned", pinned), ("pageable", pageable)):
        pointer = host.ctypes.data
        for direction, ends in (
            ("to the device", (target.data.ptr, pointer, size, 1)),
            ("to the host", (pointer, target.data.ptr, size, 2)),
        ):
            milliseconds = timed(lambda ends=ends: cp.cuda.runtime.memcpy(*ends), 0.1, 5)
            speed = round(size / milliseconds / 1e6, 2)
            rows.add(f"copy {direction}, {name}", ms=milliseconds, GB_per_s=speed)


def measure_launch(rows, kernels):
    """Measure how long Python takes to launch a small kernel, in microseconds."""
    block = cp.ones((64, 64), np.complex64)
    ones = cp.ones(64, np.float32)
    for count in (20, 200):
        cp.cuda.Device().synchronize()
        begin = time.perf_counter()
        for _ in range(count):
            kernels.multiply(block, ones, ones, ones, ones, 1.0)
        queued = time.perf_counter() - begin
        cp.cuda.Device().synchronize()
        ended = time.perf_counter() - begin
    rows.add(
        "launch",
        kernels=kernels.name,
        us_to_queue=round(queued / count * 1e6, 1),
        us=round(ended / count * 1e6, 1),
    )


def measure_size(rows, n, sets, piece_bytes):
    """Measure everything at one size."""
    free, _ = cp.cuda.runtime.memGetInfo()
    pitch = -(-(n // 2 + 1) // 32) * 32
    needed = int((8 * n * pitch + 10 * n * n + 4.1 * n * n) + 3 * piece_bytes + 1.5e9)
    if needed > free:
        rows.add("skipped", n=n, reason="memory", needed_GB=needed / 1e9, free_GB=free / 1e9)
        return
    R = min(n, max(piece_bytes // (4 * n), 1))
    spectrum = cp.empty((n, pitch), np.complex64)
    real = random_field((R, n), 0.01)
    strided_fits = n * pitch < 2**31
    best = measure_pairs(rows, n, spectrum, real, sets, False)
    if strided_fits:
        also = measure_pairs(rows, n, spectrum, real, sets, True)
        found = [variant for variant in (best, also) if variant]
        best = min(found, key=lambda variant: variant[1], default=None)
    state = State(n)
    real[...] = random_field((R, n), 0.01)
    passes = {}
    for kernels in sets:
        try:
            passes[kernels.name] = measure_passes(rows, n, state, real, kernels)
        except Exception:
            rows.add_error("passes", n=n, kernels=kernels.name)
    levels = float("nan")
    sweep = None
    try:
        with_levels = [kernels for kernels in sets if hasattr(kernels, "smooth")]
        levels, sweep = measure_levels(rows, n, state, with_levels[0])
    except Exception:
        rows.add_error("levels", n=n)
    if best:
        convolution, pair = best
        for kernels in sets:
            if kernels.name not in passes:
                continue
            parts = pair + passes[kernels.name] + levels
            measure_iteration(rows, n, state, convolution, kernels, sweep, parts)
    if not strided_fits:
        measure_pairs(rows, n, spectrum, real, sets, True)


def measure_pairs(rows, n, spectrum, real, sets, strided):
    """Measure FFT pairs of one size; return the fastest Convolution that is right, and its ms."""
    best = None
    n_c = n // 2 + 1
    if strided:
        variants = [(sets[0], False, 256 * MIB), (sets[0], False, 2**40)]
    else:
        compared = sets if n < 2**16 else sets[:1]
        variants = [(kernels, True, size * MIB) for kernels in compared for size in (16, 32, 256)]
    for kernels, transposes, block_bytes in variants:
        if rows.left() < 25:
            rows.add("skipped", n=n, reason="no time left")
            break
        for pitch in (n_c, -(-n_c // 32) * 32) if strided or block_bytes == 32 * MIB else (n_c,):
            flat = spectrum.reshape(-1)[: n * pitch]
            named = {"transposes": transposes, "block_MiB": block_bytes // MIB}
            named |= {"pitch": pitch, "kernels": kernels.name}
            try:
                convolution = Convolution(
                    n, flat.reshape(n, pitch), real, kernels, transposes, block_bytes
                )
                named["columns"] = convolution.blocks[0][1]
                error = convolution.error_of_wave()
                right = bool(error < 1e-4)
                rows.is_wrong |= not right
                forward = timed(partial(convolution.on_pieces, convolution.store))
                columns = timed(convolution.columns)
                backward = timed(partial(convolution.on_pieces, convolution.load))
                total = forward + columns + backward
                traffic = (56 if transposes else 40) * n * n
                rows.add_time(
                    "pair",
                    n,
                    total,
                    traffic,
                    forward_ms=round(forward, 3),
                    columns_ms=round(columns, 3),
                    backward_ms=round(backward, 3),
                    right=right,
                    error=error,
                    **named,
                )
                if right and (best is None or total < best[1]):
                    best = (convolution, total)
                del convolution
            except cp.cuda.memory.OutOfMemoryError:
                rows.add("skipped", n=n, reason="memory", **named)
            except Exception:
                rows.add_error("pair", n=n, **named)
            cp.get_default_memory_pool().free_all_blocks()
    return best


def measure_passes(rows, n, state, real, kernels):
    """Measure the row passes, restriction and smoothing one by one; return the sum in ms."""
    points = n * n
    R = real.shape[0]
    pieces = [(i, i + R) for i in range(0, n, R)]
    z_1 = state.levels[0][0]
    named = {"kernels": kernels.name}

    def search():
        for i0, i1 in pieces:
            kernels.step(state.g, state.p, state.d, real, i0, i1, z_1, STEP)

    def update():
        for i0, i1 in pieces:
            kernels.update(state, real, np.float32(1e-3), i0, i1)

    total = milliseconds = timed(search)
    rows.add_time("search", n, milliseconds, 17 * points, **named)
    milliseconds = timed(update)
    total += milliseconds
    bytes_of_update = 25 if kernels.fused else 37
    rows.add_time("update and restriction", n, milliseconds, bytes_of_update * points, **named)
    if not kernels.fused:

        def change():
            for i0, i1 in pieces:
                kernels.change(state.g, state.p, state.d[i0:i1], real, np.float32(1e-3), i0, i1)

        rows.add_time("update alone", n, timed(change), 22 * points, **named)
    return total


def measure_levels(rows, n, state, kernels):
    """Measure restriction and smoothing of level 1, and the same of all levels; return its ms."""
    points = n * n
    levels = state.levels
    fine = levels[0]
    coarse = levels[1]
    weight = np.float32(0.4)
    damping = np.float32(1.6)

    def restrict(k):
        kernels.restrict_level(levels[k][:2], levels[k + 1], 0, levels[k].shape[2])

    def smooth(k):
        level = levels[k]
        kernels.smooth(level, levels[k + 1][0], level[0], weight, damping, 0, level.shape[2])

    def sweep():
        for k in range(len(levels) - 1):
            restrict(k)
        for k in reversed(range(len(levels) - 1)):
            smooth(k)

    named = {"kernels": kernels.name}
    traffic = 2 * fine[0].nbytes + 2 * coarse[0].nbytes
    rows.add_time("restriction of level 1", n, timed(lambda: restrict(0)), traffic, **named)
    traffic = 4 * fine[0].nbytes + coarse[0].nbytes
    rows.add_time("smoothing of level 1", n, timed(lambda: smooth(0)), traffic, **named)
    milliseconds = timed(sweep)
    rows.add_time("levels", n, milliseconds, 9 * points, levels=len(levels) - 1, **named)
    return milliseconds, sweep


def measure_iteration(rows, n, state, convolution, kernels, sweep, parts):
    """Measure a whole iteration; parts: the sum of its parts in ms."""

    def iteration():
        z_1 = state.levels[0][0]
        sums = []
        for i0, i1 in convolution.pieces():
            part = kernels.step(state.g, state.p, state.d, convolution.real, i0, i1, z_1, STEP)
            sums.append(part.sum())
            convolution.store(i0)
        sums += [part.sum() for part in convolution.columns()]
        for i0, i1 in convolution.pieces():
            convolution.load(i0)
            part = kernels.update(state, convolution.real, np.float32(1e-6), i0, i1)
            sums.append(part.sum())
        if sweep:
            sweep()

    try:
        milliseconds = timed(iteration)
        free, total = cp.cuda.runtime.memGetInfo()
        rows.add_time(
            "iteration",
            n,
            milliseconds,
            FLOOR * n * n,
            kernels=kernels.name,
            sum_of_parts_ms=round(parts, 3),
            floor_ms=round(FLOOR * n * n / rows.copy_speed * 1e3, 3),
            transposes=convolution.transposes,
            columns=convolution.blocks[0][1],
            with_levels=sweep is not None,
            GiB_in_use=round((total - free) / 2**30, 2),
        )
    except Exception:
        rows.add_error("iteration", n=n, kernels=kernels.name)
