"""Heights that are not Gaussian, with a given spectrum.

Heights of the same rank in the distribution and amplitudes of the spectrum are put in, in turn
(Perez-Rafols & Almqvist 2019). The spectrum comes last: it holds exactly, the distribution to an
error that is stated.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line

ENOUGH = 1e-3  # rms difference of quantiles, over h_rms, at which the iteration ends
LEAST_GAIN = 1e-2  # relative, in PATIENCE iterations, below which it ends, too
PATIENCE = 10
MAX_ITERATIONS = 1000

Quantiles = Callable[[np.ndarray], np.ndarray]


def with_distribution(z: np.ndarray, spec: Any) -> tuple[np.ndarray, str]:
    """Return heights with the waves of z (periodic) and a given distribution, and a line on it."""
    import scipy.fft

    h_rms = float(np.std(z))
    shares = (np.arange(z.size) + 0.5) / z.size
    wanted = _standardised(_quantiles_of(spec)(shares))
    x = (z - z.mean()) / h_rms
    amplitudes = np.abs(scipy.fft.rfft2(x))
    errors: list[float] = []
    best = x
    while True:
        order = np.argsort(x, axis=None)
        errors.append(float(np.sqrt(np.mean((x.ravel()[order] - wanted) ** 2))))
        if errors[-1] == min(errors):
            best = x
        if _is_done(errors):
            break
        ranked = np.empty(z.size)
        ranked[order] = wanted
        waves = scipy.fft.rfft2(ranked.reshape(z.shape))
        size = np.abs(waves)
        waves *= np.divide(amplitudes, size, out=np.zeros_like(size), where=size > 0)
        x = scipy.fft.irfft2(waves, z.shape)
    skewness, kurtosis = _moments(best)
    line = (
        f"heights ranked to a distribution of skewness {_moments(wanted)[0]:.4g} and kurtosis"
        f" {_moments(wanted)[1]:.4g}: reached {skewness:.4g} and {kurtosis:.4g}, quantiles to"
        f" {100 * min(errors):.2g} % of h_rms, in {len(errors) - 1} iterations; the spectrum holds"
    )
    return h_rms * best, line


def _is_done(errors: list[float]) -> bool:
    """Whether the iteration has reached its goal or gains nothing any more."""
    if min(errors) <= ENOUGH or len(errors) > MAX_ITERATIONS:
        return True
    before = errors[:-PATIENCE]
    return bool(before) and min(errors) > (1 - LEAST_GAIN) * min(before)


def _standardised(x: np.ndarray) -> np.ndarray:
    return (x - x.mean()) / x.std()


def _moments(x: np.ndarray) -> tuple[float, float]:
    x = _standardised(x)
    return float(np.mean(x**3)), float(np.mean(x**4))


def _quantiles_of(spec: Any) -> Quantiles:
    """Return the quantile function of the distribution that a scene's [surface] asks for."""
    if spec.heights is not None:
        heights = _sample(spec.heights)
        return lambda shares: np.quantile(heights, shares)
    return _johnson(spec.skewness or 0.0, 3.0 if spec.kurtosis is None else spec.kurtosis)


def _sample(path: str) -> np.ndarray:
    """Return the heights in a file, an array of any shape or a text, as one sorted array."""
    try:
        array = np.load(path) if path.endswith(".npy") else np.loadtxt(path)
        heights = np.sort(np.asarray(array, float), axis=None)
    except (OSError, ValueError) as error:
        raise SceneError(
            f"surface.heights: cannot read {path}: {one_line(str(error))}, allowed: a .npy or a"
            " text of numbers"
        ) from None
    if len(heights) < 2 or not np.isfinite(heights).all() or heights[0] == heights[-1]:
        raise SceneError(
            f"surface.heights: found {len(heights)} heights in {path}, allowed: at least two"
            " different ones, all finite"
        )
    return heights


def _johnson(skewness: float, kurtosis: float) -> Quantiles:
    """Return quantiles of Johnson's distribution with these moments: sinh((t - a)/b) of a normal t
    or, below the log-normal line, 1/(1 + exp((a - t)/b)).
    """
    from scipy.optimize import least_squares
    from scipy.special import expit, ndtri

    if (skewness, kurtosis) == (0.0, 3.0):
        return ndtri
    t = np.linspace(-9, 9, 4001)
    weight = np.exp(-(t**2) / 2)
    weight /= weight.sum()

    def errors(parameters: np.ndarray, form: Any) -> np.ndarray:
        a, log_b = parameters
        x = form((t - a) / np.exp(log_b))
        x = x - weight @ x
        variance = weight @ x**2
        return np.array(
            [
                weight @ x**3 / variance**1.5 - skewness,
                np.sqrt(weight @ x**4 / variance**2) - np.sqrt(kurtosis),
            ]
        )

    for form in (np.sinh, expit):
        for log_b in (0.5, 0.0, -0.7, 1.2, 2.5, 3.5):
            start = (-np.sign(skewness) if form is np.sinh else np.sign(skewness), log_b)
            with np.errstate(all="ignore"):
                fit = least_squares(
                    errors, start, args=(form,), bounds=([-30, -2.5], [30, 6]), xtol=1e-14
                )
            if np.abs(fit.fun).max() < 1e-8:
                a = fit.x[0]
                b = np.exp(fit.x[1])
                return lambda shares: form((ndtri(shares) - a) / b)
    raise SceneError(
        f"surface.kurtosis: found {kurtosis:g} with skewness = {skewness:g}, of which no"
        " distribution of Johnson's system is known, allowed: more than 1 + skewness^2, and not at"
        " the edge"
    )
