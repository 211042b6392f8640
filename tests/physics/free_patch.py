"""A rough patch with free edges and its pressure by two other codes, which free_patch.npz stores.

This makes the file with a Python in which these codes are installed:

    scripts/bench-peers-setup
    .venv-peers/bin/python tests/physics/free_patch.py

The heights follow from a formula, so that only the points in contact and their pressure are stored.
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
    """Return heights (N, N), peaks up, on a square of side 1.

    Waves in all directions (H = 0.8, rms slope 1) lie on a crown that keeps the edges out of
    contact. At edges the pressure is singular, and details of the size of a grid point differ
    between discretisations.
    """
    x = np.arange(N) / N
    k_x, k_y = (
        k.ravel()
        for k in np.meshgrid(np.arange(-WAVES, WAVES + 1), np.arange(WAVES + 1), indexing="ij")
    )
    k = np.hypot(k_x, k_y)
    inside = (k >= 2) & (k <= WAVES) & ((k_y > 0) | (k_x > 0))
    z = np.zeros((N, N))
    square_slope = 0.0
    for number, (a, b, c) in enumerate(zip(k_x[inside], k_y[inside], k[inside])):
        amplitude = c**-1.8
        z += amplitude * np.cos(2 * np.pi * (a * x[:, None] + b * x + 0.618034 * number**2))
        square_slope += (2 * np.pi * c * amplitude) ** 2 / 2
    return z / np.sqrt(square_slope) - 0.5 * ((x[:, None] - 0.5) ** 2 + (x - 0.5) ** 2)


def pressure(data, load):
    """Return the stored pressure (N, N) at one of LOADS; data is the opened free_patch.npz."""
    number = LOADS.index(load)
    is_contact = np.unpackbits(data[f"contact{number}"], count=N * N).astype(bool)
    p = np.zeros((N, N))
    p[is_contact.reshape(N, N)] = data[f"pressure{number}"]
    return p * (load / p.mean())


def main():
    """Solve with both codes, compare them and write the file."""
    sys.path.insert(0, str(HERE.parents[1] / "scripts" / "bench"))
    from peer_worker import Aspher, ContactMechanicsPK

    data = {}
    z = heights()
    for number, load in enumerate(LOADS):
        fields = []
        for peer in (Aspher(z, load, backend="fft"), ContactMechanicsPK(z, load, free=True)):
            result, iterations, status = peer.solve(1e-9)
            fields.append(np.array(peer.pressure(result)))
            print(load, type(peer).__name__, iterations, status, np.mean(fields[-1] > 0))
        aspher, contact_mechanics = (p * (load / p.mean()) for p in fields)
        difference = np.linalg.norm(aspher - contact_mechanics) / np.linalg.norm(aspher)
        print(load, "difference of the codes", difference)
        assert difference < 1e-4
        data |= {
            f"contact{number}": np.packbits(aspher > 0),
            f"pressure{number}": (aspher[aspher > 0] / aspher.max()).astype(np.float16),
        }
    codes = [f"aspher {version('aspher')}", f"ContactMechanics {version('ContactMechanics')}"]
    np.savez_compressed(HERE / "free_patch.npz", codes=codes, numpy=np.__version__, **data)


if __name__ == "__main__":
    main()
