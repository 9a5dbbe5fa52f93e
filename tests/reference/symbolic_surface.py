"""Surfaces by symbolic differentiation, independent of those of the package."""

import numpy as np
import sympy as sp


class SymbolicSurface:
    """φ, ∇φ and ∇n from an expression in x, y, z; points [..., 3]."""

    def __init__(self, phi: sp.Expr):
        x = sp.symbols("x y z", real=True)
        n = sp.derive_by_array(phi, x)
        n = sp.Matrix(n) / sp.sqrt(sum(g**2 for g in n))
        self._phi = sp.lambdify(x, phi)
        self._gradient = [sp.lambdify(x, sp.diff(phi, a), cse=True) for a in x]
        self._normal_gradient = [[sp.lambdify(x, sp.diff(n[j], a), cse=True) for j in range(3)] for a in x]

    def phi(self, points):
        return self._phi(*np.moveaxis(points, -1, 0))

    def gradient(self, points):
        """∇φ [..., 3]."""
        x = np.moveaxis(points, -1, 0)
        return np.stack([np.broadcast_to(g(*x), points.shape[:-1]) for g in self._gradient], -1)

    def normal(self, points):
        """n [..., 3]."""
        g = self.gradient(points)
        return g / np.linalg.norm(g, axis=-1, keepdims=True)

    def normal_gradient(self, points):
        """(∇n)_ij = ∂_i n_j [..., 3, 3]."""
        x = np.moveaxis(points, -1, 0)
        rows = [[np.broadcast_to(f(*x), points.shape[:-1]) for f in row] for row in self._normal_gradient]
        return np.stack([np.stack(row, -1) for row in rows], -2)

    def curvature(self, points, q):
        """K11, K12, K22 [..., 3] of (D.9) in the pair (q, n×q)."""
        second = -self.normal_gradient(points)
        q1 = np.cross(self.normal(points), q)
        pairs = ((q, q), (q, q1), (q1, q1))
        return np.stack([np.einsum("...i,...ij,...j->...", a, second, b) for a, b in pairs], -1)

    def newton(self, x):
        """One Newton step along ∇φ towards φ = 0."""
        g = self.gradient(x)
        return x - (self.phi(x) / np.sum(g * g, -1))[..., None] * g

    def frame(self, x, q):
        """(q, n×q, n) as columns [..., 3, 3], with q projected into the tangent plane first (D.66)."""
        n = self.normal(x)
        q = q - np.sum(q * n, -1, keepdims=True) * n
        q = q / np.linalg.norm(q, axis=-1, keepdims=True)
        return np.stack([q, np.cross(n, q), n], -1)


def torus(major, minor):
    x, y, z = sp.symbols("x y z", real=True)
    return SymbolicSurface((sp.sqrt(x**2 + y**2) - major) ** 2 + z**2 - minor**2)


def cassini(a, b):
    x, y, z = sp.symbols("x y z", real=True)
    return SymbolicSurface((x**2 + y**2 + z**2 + a**2) ** 2 - 4 * a**2 * z**2 - b**4)
