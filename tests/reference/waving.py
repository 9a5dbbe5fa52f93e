"""The stiffness at which the planar U starts to wave, from the Galerkin method in the material frame (material.py).

The U of a boundary value problem (steady_u.py) is the start of Newton steps; eigenvalues are those of a Jacobian by
central differences, within the plane and the symmetry.
"""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from reference import free, steady_u
from reference.material import MaterialRod


class PlanarRod:
    """Coefficients of an even κ = Im k and an odd f [2 size / 2] of a rod without twist and moment."""

    def __init__(self, bend: float, size: int):
        p = free.Parameters(bend=bend, twist=1e-3, moment=0.0)
        self.rod, self.size = MaterialRod(p, size), size
        even, odd = self._parities(self.rod.clamped, 1), self._parities(self.rod.flat, -1)
        self.lift = np.zeros((4 * size + 12, even.shape[1] + odd.shape[1]))
        self.lift[size : 2 * size, : even.shape[1]] = even
        self.lift[3 * size : 4 * size, even.shape[1] :] = odd

    def _parities(self, basis, sign: int) -> np.ndarray:
        """An orthonormal basis [function, one of them] of the functions with this parity."""
        values = basis.derivative[0]
        mirrored = basis.weak(0) @ values[::-1]
        weights, vectors = np.linalg.eigh((mirrored + mirrored.T) / 2)
        return vectors[:, weights * sign > 0.5]

    def rate(self, state: np.ndarray) -> np.ndarray:
        full = self.lift @ state
        full[4 * self.size : 4 * self.size + 9] = np.eye(3).ravel()
        return self.lift.T @ self.rod.rate(0.0, full)

    def jacobian(self, state: np.ndarray) -> np.ndarray:
        steps = 1e-6 * np.eye(len(state))
        return np.array([(self.rate(state + h) - self.rate(state - h)) / 2e-6 for h in steps]).T

    def steady(self) -> np.ndarray:
        found = steady_u.followed(self.rod.p.bend)
        s = self.rod.s
        k, f = found.sol(abs(s))[0], np.sign(s) * found.sol(abs(s))[5]
        full = np.zeros(len(self.lift))
        full[self.size : 2 * self.size] = self.rod.clamped.weak(0) @ k
        full[3 * self.size : 4 * self.size] = self.rod.flat.weak(0) @ f
        state = self.lift.T @ full
        for _ in range(4):
            state = state - np.linalg.solve(self.jacobian(state), self.rate(state))
        assert abs(self.rate(state)).max() < 1e-6
        return state


def growth(bend: float, size: int) -> float:
    """Growth rate of the leading oscillation about the U."""
    rod = PlanarRod(bend, size)
    spectrum = np.linalg.eigvals(rod.jacobian(rod.steady()))
    return float(spectrum[abs(spectrum.imag) > 1].real.max())


@cache
def hopf(size: int = 48) -> float:
    """The stiffness at which it is zero."""
    return brentq(growth, 1.45e-4, 1.465e-4, args=(size,), xtol=1e-10)
