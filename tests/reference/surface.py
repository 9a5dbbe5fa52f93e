"""Surfaces for comparison: fields by symbolic differentiation, shape operator in NumPy, areas by quadrature."""

from collections.abc import Callable

import numpy as np
import sympy as sp

X, Y, Z = sp.symbols("x y z", real=True)
POINT = (X, Y, Z)


def differentiated(phi: sp.Expr) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """A function for φ, ∇φ and ∇∇φ at points [n, 3], from an expression in x, y, z."""
    gradient = [sp.diff(phi, a) for a in POINT]
    parts = sp.lambdify(POINT, [phi, *gradient, *(sp.diff(g, a) for g in gradient for a in POINT)])

    def evaluate(points: np.ndarray):
        values = [np.broadcast_to(part, len(points)) for part in parts(*points.T)]
        return values[0], np.stack(values[1:4], axis=-1), np.stack(values[4:], axis=-1).reshape(-1, 3, 3)

    return evaluate


def normal_gradient(gradient: np.ndarray, hessian: np.ndarray) -> np.ndarray:
    """(∇n)_ij = ∂_i n_j [n, 3, 3] of n = ∇φ/|∇φ|, by the quotient rule."""
    size = np.linalg.norm(gradient, axis=-1)[:, None, None]
    along = np.einsum("nia,na,nj->nij", hessian, gradient, gradient)
    return hessian / size - along / size**3


def curvatures(gradient: np.ndarray, hessian: np.ndarray, q: np.ndarray) -> np.ndarray:
    """K11, K12, K22 [n, 3] in the pair (q, n×q): −q_i·∇n·q_j (5.16); q [n, 3] unit tangents."""
    n = gradient / np.linalg.norm(gradient, axis=-1, keepdims=True)
    pair = np.stack([q, np.cross(n, q)], axis=1)
    K = -np.einsum("nia,nab,njb->nij", pair, normal_gradient(gradient, hessian), pair)
    return np.stack([K[:, 0, 0], K[:, 0, 1], K[:, 1, 1]], axis=-1)


def area_below(z: np.ndarray, radius_squared: sp.Expr, low: float, high: float) -> np.ndarray:
    """Fraction of the area of a surface of revolution ρ²(z), low < z < high, below each z."""
    slope = sp.diff(radius_squared, Z) / 2  # ρρ', which is finite at a pole
    element = sp.lambdify(Z, sp.sqrt(sp.Max(radius_squared, 0) + slope**2))
    grid = np.linspace(low, high, 20001)
    area = np.broadcast_to(element(grid), grid.shape)
    below = np.concatenate([[0.0], np.cumsum(area[1:] + area[:-1])])
    return np.interp(z, grid, below / below[-1])
