"""Regularised Yukawa repulsion summed over all pairs in NumPy (docs/model.md §6.1; D.6)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

REACH = 8.0


@dataclass(frozen=True)
class Rods:
    """One ensemble: positions [rod, node, 3] and lengths [rod]."""

    position: np.ndarray
    length: np.ndarray

    @property
    def spacing(self) -> np.ndarray:
        return self.length / (self.position.shape[1] - 1)


@dataclass(frozen=True)
class Pairs:
    """All nodes of all ensembles in one list, and the potential between them: strength g0, range a, core ε.

    period [3] of the box along each axis, 0 where there is none: pairs interact through nearest images.
    """

    ensembles: list[Rods]
    strength: float
    range: float
    core: float
    period: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def _joined(self, per_ensemble) -> np.ndarray:
        return np.concatenate([per_ensemble(e).reshape(-1) for e in self.ensembles])

    @cached_property
    def points(self) -> np.ndarray:
        return np.concatenate([e.position.reshape(-1, 3) for e in self.ensembles])

    @cached_property
    def weights(self) -> np.ndarray:
        """Trapezoid weights."""

        def of(e: Rods) -> np.ndarray:
            w = np.repeat(e.spacing[:, None], e.position.shape[1], axis=1)
            w[:, [0, -1]] /= 2
            return w

        return self._joined(of)

    @cached_property
    def allowed(self) -> np.ndarray:
        """Pairs that interact within reach: all but those of one rod closer than max(2ε, 4Δs) along it."""
        sizes = [e.position.shape[1] for e in self.ensembles for _ in e.length]
        rod = np.repeat(np.arange(len(sizes)), sizes)
        node = np.concatenate([np.arange(n) for n in sizes])
        spacing = np.repeat(np.concatenate([e.spacing for e in self.ensembles]), sizes)
        along = np.abs(node[:, None] - node) * spacing
        # Pairs exactly at the bound count, whatever the rounding of node times spacing.
        near = along < np.maximum(2 * self.core, 4 * spacing)[:, None] * (1 - 1e-9)
        return ~((rod[:, None] == rod) & near)

    def _separations(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """r_i − r_j, ρ, and whether pairs count; points may be complex, for differentiation by complex steps."""
        d = points[:, None] - points
        for axis, period in enumerate(self.period):
            if period:
                d[..., axis] -= period * np.round(d[..., axis].real / period)
        square = np.sum(d * d, axis=-1)
        return d, np.sqrt(square + self.core**2), self.allowed & (square.real < (REACH * self.range) ** 2)

    def energies(self, points: np.ndarray | None = None) -> np.ndarray:
        """Half of the energy w_i w_j G of the pairs of each node."""
        _, rho, counts = self._separations(self.points if points is None else points)
        end = np.hypot(REACH * self.range, self.core)
        G = self._yukawa(rho) - self._yukawa(end) + self._pull(end) * (rho - end)
        return 0.5 * self.weights * np.sum(np.where(counts, G, 0) * self.weights, axis=1)

    def _yukawa(self, rho):
        """G(ρ)."""
        return self.strength * np.exp(-rho / self.range) / (4 * np.pi * rho)

    def _pull(self, rho):
        """−G'(ρ); its value at the end of the reach is subtracted, so that forces and energies are zero there."""
        return (1 / rho + 1 / self.range) * self._yukawa(rho)

    def forces(self) -> np.ndarray:
        """Force per length on each node [point, 3] (5.39)."""
        return self.force_of(self.points)

    def force_of(self, points: np.ndarray) -> np.ndarray:
        """Force per length for points at these positions [point, 3], which may be complex."""
        d, rho, counts = self._separations(points)
        push = (self._pull(rho) - self._pull(np.hypot(REACH * self.range, self.core))) / rho
        return np.einsum("ij,ijk,j->ik", np.where(counts, push, 0), d, self.weights)

    def mobility_jacobian(self, drag: np.ndarray) -> np.ndarray:
        """∂(f_i/ζ_i)/∂r_j [3 point, 3 point] by complex steps, for nodes that move independently; 1/time."""
        step, size = 1e-30, self.points.size
        found = np.empty((size, size))
        for column in range(size):
            moved = self.points.astype(complex)
            moved.flat[column] += 1j * step
            found[:, column] = (self.force_of(moved).imag / step / drag[:, None]).ravel()
        return found
