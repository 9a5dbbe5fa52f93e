"""Stiffnesses at which a straight active rod buckles, by shooting.

Where (4.36) has the eigenvalue 0, b k'' = λ k − A − B s with the tension of the straight rod, λ' = −f, and k = k' = 0
at both ends. For odd f modes are even (B = 0, k' = 0 at s = 0) or odd (A = 0, k = 0 at s = 0).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reference.exact import beam_roots

TENSIONS = {
    "piecewise": lambda s: np.abs(s) - 0.5,
    "tanh": lambda s: (np.log(np.cosh(10 * s)) - np.log(np.cosh(5.0))) / 10,
}
"""λ(s) for f = 1 − 2H(s) and f = −tanh 10s; s ≥ 0 only."""


def mismatch(bend: float, activity: str, odd: bool) -> float:
    """k'(0) of an even mode, k(0) of an odd one, from k = k' = 0 at s = 1/2."""
    tension = TENSIONS[activity]

    def slopes(s, y):
        return [y[1], (tension(s) * y[0] - (s if odd else 1.0)) / bend]

    end = solve_ivp(slopes, (0.5, 0.0), [0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return bend * float(end[0 if odd else 1])


def critical_stiffnesses(count: int, activity: str) -> np.ndarray:
    """The largest ``count`` stiffnesses, even and odd modes together."""
    found = []
    lengths = np.linspace(3.0, 6.2 * count**0.45, 20 * count)  # of a rod of stiffness 1
    for odd in (False, True):
        values = np.array([mismatch(length**-3, activity, odd) for length in lengths])
        for i in np.flatnonzero(values[1:] * values[:-1] < 0):
            bends = lengths[i] ** -3, lengths[i + 1] ** -3
            found.append(brentq(mismatch, *bends, args=(activity, odd), rtol=1e-12))
    return np.sort(found)[::-1][:count]


def beam_mode_stiffness(activity: str) -> float:
    """The stiffness at which beam mode 0 neither grows nor decays: b x₀⁴ = ∫ φ₀ (λφ₀)'' ds = ∫ φ₀'' λφ₀ ds."""
    root = beam_roots(1)[0]
    nodes, weights = np.polynomial.legendre.leggauss(80)
    s = (nodes + 1) / 4  # half of the rod; the integrals over it have the same ratio
    cos, cosh = np.cos(root * s) / np.cos(root / 2), np.cosh(root * s) / np.cosh(root / 2)
    mode, second = cos - cosh, -(root**2) * (cos + cosh)
    return float(weights @ (second * TENSIONS[activity](s) * mode) / (weights @ mode**2) / root**4)
