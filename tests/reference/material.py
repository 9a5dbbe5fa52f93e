"""An independent solver for the active rod: material frame, polynomial Galerkin method, adaptive implicit time steps.

It shares only the equations of motion with the scheme of the ensemble: twist terms as in (4.19)–(4.24), no staggered
grid, boundary conditions in the basis, and a matrix differential equation for the frame of the midpoint.
"""

import numpy as np
from numpy.polynomial import chebyshev, legendre
from scipy.integrate import solve_ivp

BUBBLE = np.array([0.5, 0.0, -0.5])
"""1 − x² in Chebyshev polynomials."""


class Basis:
    """Orthonormal polynomials in x = 2s that span ``rows``: values and derivatives in s at quadrature points."""

    def __init__(self, rows, x, weights):
        self.weights = weights
        self.rows = np.array([np.pad(row, (0, len(rows) + 4 - len(row))) for row in rows])
        triangle = np.linalg.qr(np.sqrt(weights)[:, None] * self.at(x), mode="r")
        self.rows = np.linalg.solve(triangle.T, self.rows)
        self.derivative = [self.at(x, order) for order in range(4)]

    def at(self, x, order=0):
        """[point, function]: derivatives of ``order`` in s."""
        return np.array([chebyshev.chebval(x, chebyshev.chebder(row, order)) for row in self.rows]).T * 2.0**order

    def weak(self, order):
        """[function, point]: the matrix from values g to ∫ v^(order) g ds for every function v."""
        return self.derivative[order].T * self.weights


class MaterialRod:
    """One rod with ``size`` functions per field; ``p``: parameters with the names of ``reference.free``."""

    def __init__(self, p, size: int):
        self.p, self.size = p, size
        x, weights = legendre.leggauss(2 * size + 1)
        self.s, weights, self.middle = x / 2, weights / 2, size
        pinned = [chebyshev.chebmul(BUBBLE, row) for row in np.eye(size)]
        flat, m = np.eye(size + 2)[:size], np.arange(size)
        flat[m, m + 2] = -(m**2) / (m + 2) ** 2
        self.clamped = Basis([chebyshev.chebmul(BUBBLE, row) for row in pinned], x, weights)
        self.pinned, self.flat = Basis(pinned, x, weights), Basis(list(flat), x, weights)

    def rate(self, _t, state):
        """d/dt of the coefficients of (Re k, Im k, τ, f), and of (R, r) of the midpoint."""
        p, n = self.p, self.size
        b, c, eta = p.bend, p.twist, p.drag_ratio
        k, k1, k2, k3 = (d @ (state[:n] + 1j * state[n : 2 * n]) for d in self.clamped.derivative)
        tau, tau1, tau2 = (d @ state[2 * n : 3 * n] for d in self.pinned.derivative[:3])
        f, f1 = (d @ state[3 * n : 4 * n] for d in self.flat.derivative[:2])

        shear = 1j * b * k1 + (c - b) * tau * k
        shear1 = 1j * b * k2 + (c - b) * (tau1 * k + tau * k1)
        shear2 = 1j * b * k3 + (c - b) * (tau2 * k + 2 * tau1 * k1 + tau * k2)
        loose = (shear1 + 1j * tau * shear) / eta
        loose1 = (shear2 + 1j * (tau1 * shear + tau * shear1)) / eta
        square = np.abs(k) ** 2
        push = b * (k.conj() * k1).real + f

        # ∫ v' λ' + v |k|²λ/η = ∫ −v' push + v Im(k̄ loose), from (∂s u + Ω×u)·e0 = 0.
        values, slopes = self.pinned.derivative[:2]
        matrix = self.pinned.weak(1) @ slopes + self.pinned.weak(0) @ (values * (square / eta)[:, None])
        right = self.pinned.weak(0) @ (k.conj() * loose).imag - self.pinned.weak(1) @ push
        coefficients = np.linalg.solve(matrix, right)
        tension, tension1 = values @ coefficients, slopes @ coefficients

        axial = tension1 + push
        across = loose - 1j * tension * k / eta
        bent = axial * k - tau * across
        spin = 1j * (loose1 - 1j * (tension1 * k + tension * k1) / eta) + bent
        roll = (c * tau1 + p.moment * f) / p.rotational_drag
        roll1 = (c * tau2 + p.moment * f1) / p.rotational_drag

        clamped, pinned, flat = self.clamped, self.pinned, self.flat
        k_t = 1j * clamped.weak(2) @ across - clamped.weak(1) @ bent + 1j * clamped.weak(0) @ (tau * spin - roll * k)
        tau_t = pinned.weak(0) @ (roll1 + (k.conj() * spin).imag)
        f_t = flat.weak(0) @ ((1 - f**2) * axial) - p.diffusion * flat.weak(1) @ f1
        m = self.middle
        R = state[4 * n : 4 * n + 9].reshape(3, 3)
        w, u = np.array([roll[m], spin[m].real, spin[m].imag]), np.array([axial[m], across[m].real, across[m].imag])
        R_t = R @ np.cross(np.eye(3), w)
        return np.concatenate([k_t.real, k_t.imag, tau_t, f_t / p.relaxation, R_t.ravel(), R @ u])

    def run(self, start, end, s):
        """k, τ, f at arc lengths ``s`` and R, r of the midpoint at the time ``end``; R = 1, r = 0 at t = 0."""
        n, bases = self.size, (self.clamped, self.pinned, self.flat)
        k, tau, f = (basis.weak(0) @ values for basis, values in zip(bases, start(self.s), strict=True))
        state = np.concatenate([k.real, k.imag, tau, f, np.eye(3).ravel(), np.zeros(3)])
        state = solve_ivp(self.rate, (0, end), state, method="Radau", rtol=1e-7, atol=1e-8).y[:, -1]
        fields = state[:n] + 1j * state[n : 2 * n], state[2 * n : 3 * n], state[3 * n : 4 * n]
        there = (basis.at(2 * s) @ field for basis, field in zip(bases, fields, strict=True))
        return (*there, state[4 * n : 4 * n + 9].reshape(3, 3), state[4 * n + 9 :])
