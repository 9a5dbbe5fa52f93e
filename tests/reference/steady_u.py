"""The steady U of a planar swimmer as a boundary value problem on half a rod, for SciPy's collocation.

The shape does not turn, so that the rod translates: u⊥' = −u0 κ, u0' = κ u⊥. With (4.32)–(4.34), docs/model.md §2.2:

    κ'' = (λκ − η u⊥)/b,    λ' = u0 − b κκ' − f,    D f'' = −(1 − f²) u0

κ, λ, u⊥ are even and u0, f odd in s; κ = κ' = λ = f' = 0 at s = 1/2.
"""

from functools import cache

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import minimize_scalar

from reference.exact import beam_roots

DRAG_RATIO, DIFFUSION = 2.0, 1e-3
TOLERANCE = 1e-7


def slopes(s, y, bend):
    """d/ds of (κ, κ', u⊥, u0, λ, f, f')."""
    k, k1, across, along, tension, f, f1 = y
    push = along - bend * k * k1 - f
    k2, f2 = (tension * k - DRAG_RATIO * across) / bend, -(1 - f**2) * along / DIFFUSION
    return np.stack([k1, k2, -along * k, k * across, push, f1, f2])


def conditions(start, end):
    """Symmetry at the middle, and the free end."""
    return np.array([start[1], start[3], start[5], end[0], end[1], end[4], end[6]])


def guess() -> tuple[np.ndarray, np.ndarray]:
    """A bent rod."""
    s = np.linspace(0, 0.5, 201)
    k = 5 * np.cos(np.pi * s) ** 2
    angle = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * np.diff(s))])
    across, along = -0.5 * np.cos(angle), -0.5 * np.sin(angle)
    f = -np.tanh(10 * s)
    return s, np.stack([k, np.gradient(k, s), across, along, -0.1 * np.cos(np.pi * s), f, np.gradient(f, s)])


def solved(bend: float, start=None):
    """The solution at this stiffness."""
    s, y = guess() if start is None else (start.x, start.y)
    found = solve_bvp(lambda s, y: slopes(s, y, bend), conditions, s, y, tol=TOLERANCE, max_nodes=100_000)
    assert found.success, found.message
    return found


def followed(bend: float):
    """The solution at a smaller stiffness than 1e-3, on the same branch: in small steps."""
    found = solved(1e-3)
    for between in np.geomspace(1e-3, bend, 14)[1:]:
        found = solved(between, found)
    return found


def amplitude_and_speed(bend: float) -> tuple[float, float]:
    """a₀ = ∫ κ φ₀ ds over the whole rod, and |U|."""
    found = solved(bend)
    root = beam_roots(1)[0]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s, weights = (nodes + 1) / 4, weights / 2  # twice the half rod
    mode = np.cos(root * s) / np.cos(root / 2) - np.cosh(root * s) / np.cosh(root / 2)
    mode *= np.sign(mode[0]) / np.sqrt(weights @ mode**2)
    return abs(float(weights @ (found.sol(s)[0] * mode))), abs(float(found.sol(0.0)[2]))


@cache
def fold() -> float:
    """The largest stiffness of a U, where κ(0) is prescribed and the stiffness is unknown."""
    last = solved(8e-3, solved(5e-3))

    def stiffness(curvature: float) -> float:
        def ends(start, end, p):
            return np.append(conditions(start, end), start[0] - np.sign(last.y[0, 0]) * curvature)

        found = solve_bvp(
            lambda s, y, p: slopes(s, y, p[0]), ends, last.x, last.y, p=[8.5e-3], tol=TOLERANCE, max_nodes=100_000
        )
        assert found.success, found.message
        return float(found.p[0])

    k = abs(last.y[0, 0])
    best = minimize_scalar(lambda curvature: -stiffness(curvature), bounds=(0.4 * k, k), method="bounded")
    return -float(best.fun)
