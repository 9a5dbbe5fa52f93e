"""Readings of an ensemble of surface-bound filaments, in addition to those of every ensemble."""

from __future__ import annotations

from abc import abstractmethod
from functools import partial

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.rods.bound.along import Components
from warp_rods.rods.bound.arrays import Arrays
from warp_rods.rods.bound.launches import BoundLaunches
from warp_rods.rods.clock import Clock
from warp_rods.rods.readings import Reading, Readings
from warp_rods.rods.tiles import Tiled, is_tiled

COMPUTED = (
    *("orientation", "energy_density", "energy", "dissipation", "gauss"),
    *("growth_power", "membrane_power", "load", "load_moment"),
    *("end_load", "end_moment", "stretch_force", "tension", "geodesic_rate"),
)
"""Variables that are output of the kernels; the others are part of the state or follow from it on the host."""
STATIC_ALONG = ("stiffness", "intrinsic")
"""Parameters that a trajectory saves once, or in each frame where they change in time."""


class BoundReadings(Readings):
    """Readings of the present state, computed when they are read."""

    nodes: int
    _arrays: Arrays
    _clock: Clock
    _launches: BoundLaunches
    _saved_nodes: int
    _shown: float
    _along: dict[str, Components]

    @abstractmethod
    def _set_along(self, time: float) -> None: ...

    def show(self) -> None:
        """Compute frames and strains of the present state."""
        self._set_along(self._present_time)
        with exclusive:
            self._launches.show(self._shown)

    def evaluate(self) -> None:
        """Compute tension, velocities and rates for the present shape, force and membrane, and what follows."""
        self.show()
        self._launches.find_output(self._clock.time)

    @property
    def stride(self) -> int:
        """A refined ensemble is saved at the nodes it started with."""
        return (self.nodes - 1) // (self._saved_nodes - 1)

    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""
        f, output = self._arrays.f, self._arrays.output
        state = {"position": f.position, "curvature": self._tiled(f.curvature), "status": f.status}
        found = {name: Reading(self.show, partial(to_host, array)) for name, array in state.items()}
        found["rotation"] = Reading(self.show, self._rotation)
        for name in COMPUTED:
            array = getattr(output, name)
            found[name] = Reading(self.evaluate, partial(to_host, self._tiled(array) if is_tiled(array) else array))
        found["strain"] = Reading(self.show, self._strain)
        found["length"] = Reading(self.show, lambda: to_host(f.spacing_of_rod) * (self.nodes - 1))
        for name in STATIC_ALONG:
            found[name] = Reading(self.show, partial(self._present, name))
        found["power"] = Reading(self.evaluate, self._power)
        for column, name in enumerate(("constraint", "orthogonality", "arc_length")):
            found[name] = Reading(self.evaluate, partial(self._residual, column))
        return found

    def _residual(self, column: int) -> np.ndarray:
        """The largest |φ|/|∇φ|, |q·n| or relative error of the length of a segment [rod]."""
        return to_host(self._arrays.residuals)[:, column]

    def _strain(self) -> np.ndarray:
        """Twist, normal and geodesic bending (K12, −K11, Ω) (5.17), (5.18)."""
        f = self._arrays.f
        K = self._tiled(f.curvature).numpy()
        return np.stack([K[..., 1], -K[..., 0], self._tiled(f.geodesic).numpy()], axis=-1)

    def _tiled(self, array: wp.array) -> Tiled:
        """An array [tile, node] as one of rods."""
        return Tiled(array, self._arrays.rods)

    def _rotation(self) -> np.ndarray:
        """Directors as columns (q, n×q, n) [rod, node, 3, 3]."""
        f = self._arrays.f
        return np.stack([self._tiled(column).numpy() for column in (f.tangent, f.across, f.normal)], axis=-1)

    def _power(self) -> np.ndarray:
        """Power of growth, of a moving membrane, of the external force, and of stiffness and σ that change in time."""
        output = self._arrays.output
        power = to_host(output.growth_power) + to_host(output.membrane_power) + to_host(output.force_power)
        return power + self._power_of_change()

    def _power_of_change(self) -> np.ndarray | float:
        """∫ ½ ∂tB (strain − σ)² − B (strain − σ) ∂tσ ds, by the trapezoid rule [rod]."""
        changing = [self._along[name] for name in STATIC_ALONG]
        if not any(part.varies for part in changing):
            return 0.0
        B, sigma = map(self._present, STATIC_ALONG)
        B_rate, sigma_rate = (part.rates(self._present_time, self.nodes) for part in changing)
        bent = self._strain() - sigma
        density = np.sum(0.5 * B_rate * bent**2 - B * bent * sigma_rate, axis=-1)
        return np.trapezoid(density, axis=1) * to_host(self._arrays.f.spacing_of_rod)

    @property
    def _present_time(self) -> float:
        return min(self._shown, self._clock.reached)

    def _present(self, name: str) -> np.ndarray:
        """Values of a parameter of ``STATIC_ALONG`` [rod, node, 3] at the time shown."""
        part = self._along[name]
        values = part.at(self._present_time, self.nodes) if part.varies else part.values
        return values if values.ndim == 3 else np.repeat(values[:, None], self.nodes, axis=1)

    @property
    def rotation(self) -> np.ndarray:
        """Directors as columns (q, n×q, n) [rod, node, 3, 3]."""
        return self.reading("rotation")

    @property
    def end_load(self) -> np.ndarray:
        """Force of the first and the last section on the membrane [rod, end, 3]."""
        return self.reading("end_load")

    @property
    def end_moment(self) -> np.ndarray:
        """Moment of the first and the last section on the membrane [rod, end, 3]."""
        return self.reading("end_moment")

    @property
    def stretch_force(self) -> np.ndarray:
        """λ + K12 m1 − K11 m2 [rod, node]: the force that does work where a section slides along the membrane."""
        return self.reading("stretch_force")

    @property
    def curvature(self) -> np.ndarray:
        """K11, K12, K22 [rod, node, 3] of the surface in the pair (q, n×q)."""
        return self.reading("curvature")
