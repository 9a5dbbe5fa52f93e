"""Soft walls that keep swimmers in a slab, a pore or a duct, or inside or outside a surface (docs/model.md §6.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_rods.contact.rooms import Walled
from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.contact import box as box_kernels
from warp_rods.kernels.layout import per_rod, to_host
from warp_rods.kernels.surface.geometry import Numbers, Parameters
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.recorded import Recorded

NO_CAPS = np.array([[-np.inf] * 3, [np.inf] * 3])
"""Lower and upper corner of a box without walls."""
SAMPLES = 33
"""Points along each edge of a face at which the sign of φ is evaluated."""


def caps_of(surface: Surface, outside: bool) -> np.ndarray:
    """Corners [2, 3] of the box whose finite faces close an open container: those on which φ is negative somewhere.

    A plane has none: it is the wall of a half-space. Outside a container there are none.
    """
    if outside or surface.closed or surface.kind == "plane":
        return NO_CAPS
    corners, found = np.array(surface.box), NO_CAPS.copy()
    for axis in range(3):
        for end in (0, 1):
            axes = [np.linspace(low, high, SAMPLES) for low, high in corners.T]
            axes[axis] = corners[end, axis : axis + 1]
            if (surface.phi(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)) < 0).any():
                found[end, axis] = corners[end, axis]
    return found


class Walls:
    """A wall with W = ½ k (d + δ)² per length for d > −δ on every node of ``ensembles``; d is the distance outside it.

    wall: the ``Surface``, a row of ``rooms.py``, or the height of a slab between walls at z = ±height/2. strength: k,
    force per length and depth. range: δ, length. outside: keep rods where φ > 0 instead of inside. Inside an open
    surface the faces of its box through which it passes are walls, too (``caps_of``). ``add_forces`` adds the force per
    length at the present positions to the force of each ensemble.
    """

    def __init__(
        self,
        ensembles: Sequence[Ensemble],
        wall: Surface | Walled | float,
        strength: float,
        range: float,
        outside: bool = False,
        device: Any = None,
    ):
        self.strength, self.range, self.side = strength, range, -1.0 if outside else 1.0
        self._device = device_of(device)
        self._ensembles = list(ensembles)
        with exclusive:
            if isinstance(wall, Surface):
                field, self._parameters = wall.field, wall.device_parameters(self._device)
                caps, known = caps_of(wall, outside), np.array(wall.box) if wall.kind == "grid" else NO_CAPS
            else:
                name, numbers, caps = (
                    (wall.field, wall.numbers, wall.faces) if isinstance(wall, Walled) else ("slab", (wall,), NO_CAPS)
                )
                known, p = NO_CAPS, Parameters()
                p.v = Numbers(*numbers, *[0.0] * (8 - len(numbers)))
                field = getattr(box_kernels, name)
                self._parameters = wp.array([p], dtype=Parameters, device=self._device)
            self._energies = [per_rod(e.count, device=self._device) for e in self._ensembles]
        # Outside its box the field of a file is a mirror image.
        self._boxes = tuple(wp.vec3d(*corner) for corner in (*caps, *known))
        self._kernel = box_kernels.walls_of(field)
        for e in self._ensembles:
            # An ensemble may have to allocate these first, and then compute its frames.
            _ = e.force_array, e.contact_stiffness_array
        self.add_forces = Recorded(self._launch, self._device)

    def _launch(self) -> None:
        for e, energy in zip(self._ensembles, self._energies, strict=True):
            inputs = [
                e.position_array, e.spacing_array, self._parameters, *self._boxes, self.side, self.strength,
                self.range, e.force_array, e.contact_stiffness_array, energy,
            ]  # fmt: skip
            wp.launch(self._kernel, dim=e.count, inputs=inputs, device=self._device)

    def energies(self) -> list[np.ndarray]:
        """Energy ∫ W ds in the wall of each ensemble [rod], at the last ``add_forces``."""
        with exclusive:
            return [to_host(energy) for energy in self._energies]
