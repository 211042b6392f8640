"""Made-up runs that obey a given law, in the form in which scripts/paper stores them."""

import numpy as np

LAW = {"limit": 2.0, "C_t": 0.05, "C_f": 2.0, "alpha_f": 0.7, "C_c": 0.8, "alpha_c": 1.1}
EDGE = {"limit": 2.0, "C_t": 0.05, "C_f": 1.0, "alpha_f": 0.7, "C_c": -0.1, "alpha_c": 1.0}
GAP = {"limit": 0.0, "C_t": -0.05, "C_f": 2.5, "alpha_f": 0.2, "C_c": -0.03, "alpha_c": 3.0}


def value(law, case):
    """The observable of a case by eq. tfc: limit + sum over i of C_i eps_i^alpha_i."""
    return law["limit"] + sum(
        law[f"C_{i}"] * case.eps[f"eps_{i}"] ** law.get(f"alpha_{i}", 1.0) for i in "tfc"
    )


def runs_of(cases, scatter=0.02, noise=0.0, laws=(LAW, EDGE, GAP), kappa=None, seed=0):
    """Runs of all loads of the cases.

    Parameters
    ----------
    cases
        Cases of scripts/paper.
    scatter
        Relative scatter of realisations over eps_t; the same on all grids of a surface, and for
        kappa and kappa_edge.
    noise
        Relative scatter over eps_t eps_c, independent on every grid.
    laws
        Coefficients of kappa, kappa_edge and the gap.
    kappa
        Function of (case, eps_t, eps_f, eps_c) that replaces the laws of kappa and kappa_edge.
    seed
        Of both kinds of scatter.
    """
    rng = np.random.default_rng(seed)
    surface_scatter = {}
    runs = []
    for case in cases:
        for p_star in case.p_star:
            eps_t, eps_f, eps_c = case.eps.values()
            key = (case.hurst, case.seed, eps_t, eps_f, p_star)
            shift = (
                1
                + surface_scatter.setdefault(key, rng.normal()) * scatter * eps_t
                + noise * eps_t * eps_c * rng.normal()
            )
            raw, edge, gap = (value(law, case) * shift for law in laws)
            if kappa is not None:
                raw, edge = (x * shift for x in kappa(case, eps_t, eps_f, eps_c))
            fall = 1 / (1 + p_star)  # the area must stay below 1
            runs.append(
                case.surface
                | case.eps
                | {
                    "n": case.n,
                    "p_star": p_star,
                    "h_rms": 1.0,
                    "g_rms": 1.0,
                    "lam_s": 0.01,
                    "a_r": raw * min(p_star, 0.4 * fall),
                    "a_r_edge": edge * min(p_star, 0.4 * fall),
                    "kappa": raw,
                    "kappa_edge": edge,
                    "gap_over_h_rms": gap * fall,
                    "gap_over_g_rms_lam_s": gap * fall * eps_f**-case.hurst,
                    "contact_points": 1,
                    "a_r_error": 1e-5,
                    "gap_error": 1e-5,
                    "pressure_error": 1e-5,
                    "status": "converged",
                    "iterations": 1,
                    "fft_pairs": 1.0,
                    "wall_seconds": 1.0,
                    "precision": "float64",
                    "ranks": 1,
                    "version": "0",
                }
            )
    return runs
