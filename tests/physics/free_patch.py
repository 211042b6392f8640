"""A rough patch with free edges, and its pressure by two other codes: makes free_patch.npz, with
the Python that has them.

    scripts/bench-peers-setup
    .venv-peers/bin/python tests/physics/free_patch.py

The heights are a formula, so that only the answer has to be kept: where there is contact, and its
pressure.
"""

import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
N = 128
WAVES = N // 16  # the shortest is 16 points long
LOADS = (0.01, 0.1)  # over E* g_rms, nearly


def heights():
    """(N, N) heights, peaks up, on 1 x 1: waves of all directions, H = 0.8, rms slope 1 of all of
    them, on a crown that keeps the edges out of contact: there the pressure is singular, and what
    is a grid point wide is different in every discretisation."""
    x = np.arange(N) / N
    k_x, k_y = (
        k.ravel()
        for k in np.meshgrid(np.arange(-WAVES, WAVES + 1), np.arange(WAVES + 1), indexing="ij")
    )
    k = np.hypot(k_x, k_y)
    inside = (k >= 2) & (k <= WAVES) & ((k_y > 0) | (k_x > 0))
    z, slope = np.zeros((N, N)), 0.0
    for number, (a, b, c) in enumerate(zip(k_x[inside], k_y[inside], k[inside])):
        amplitude = c**-1.8
        z += amplitude * np.cos(2 * np.pi * (a * x[:, None] + b * x + 0.618034 * number**2))
        slope += (2 * np.pi * c * amplitude) ** 2 / 2
    return z / np.sqrt(slope) - 0.5 * ((x[:, None] - 0.5) ** 2 + (x - 0.5) ** 2)


def pressure(kept, load):
    """The field (N, N) that free_patch.npz keeps for one of LOADS; kept: the opened file."""
    number = LOADS.index(load)
    p = np.zeros((N, N))
    p[np.unpackbits(kept[f"contact{number}"], count=N * N).astype(bool).reshape(N, N)] = kept[
        f"pressure{number}"
    ]
    return p * (load / p.mean())


def main():
    """Solve, compare the codes, and write."""
    sys.path.insert(0, str(HERE.parents[1] / "scripts" / "bench"))
    from peer_worker import Aspher, ContactMechanicsPK

    kept, z = {}, heights()
    for number, load in enumerate(LOADS):
        fields = []
        for peer in (Aspher(z, load, backend="fft"), ContactMechanicsPK(z, load, free=True)):
            result, iterations, status = peer.solve(1e-9)
            fields.append(np.array(peer.pressure(result)))
            print(load, type(peer).__name__, iterations, status, np.mean(fields[-1] > 0))
        one, other = (p * (load / p.mean()) for p in fields)
        difference = np.linalg.norm(one - other) / np.linalg.norm(one)
        print(load, "difference of the codes", difference)
        assert difference < 1e-4
        kept |= {
            f"contact{number}": np.packbits(one > 0),
            f"pressure{number}": (one[one > 0] / one.max()).astype(np.float16),
        }
    codes = [f"aspher {version('aspher')}", f"ContactMechanics {version('ContactMechanics')}"]
    np.savez_compressed(HERE / "free_patch.npz", codes=codes, numpy=np.__version__, **kept)


if __name__ == "__main__":
    main()
