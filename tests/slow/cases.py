"""Contact problems of every kind, made from a seed: random rough surfaces to measure errors on, and odd ones to break solvers with."""

import numpy as np

from hpc_gfmd.scene import Scene


def rough_scene(rng, n=(64, 512), p_star=(1e-4, 2.0)):
    """A random self-affine scene: n_x and n_y anything in the range, H, cutoffs and p* spread over what the paper covers."""
    n_x = int(np.exp(rng.uniform(np.log(n[0]), np.log(n[1] + 1))))
    if rng.random() < 0.3:
        n_x = 2 ** round(np.log2(n_x))
    n_y = n_x if rng.random() < 0.5 else min(max(int(n_x * rng.uniform(0.5, 2)), n[0]), n[1])
    L_over_lam_l = rng.uniform(1, 4)
    lam_s_over_a = rng.uniform(2, 8)
    surface = {"kind": "self-affine", "hurst": round(rng.uniform(0, 1), 2), "L_over_lam_l": L_over_lam_l,
               "lam_l_over_lam_s": n_x / (L_over_lam_l * lam_s_over_a), "lam_s_over_a": lam_s_over_a,
               "seed": int(rng.integers(2**31)), "physical_sizes": [1.0, n_y / n_x]}
    return Scene.from_dict({"surface": surface,
                            "load": {"p_star": float(np.exp(rng.uniform(*np.log(p_star))))}})


def rough_scenes(count, seed):
    """`count` random rough scenes."""
    rng = np.random.default_rng(seed)
    return [rough_scene(rng) for _ in range(count)]
