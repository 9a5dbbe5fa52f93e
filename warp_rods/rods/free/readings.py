"""Readings of an ensemble of free rods, in addition to those of every ensemble."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.free.state import CARRIED_APART, NOT_CARRIED
from warp_rods.kernels.layout import to_host
from warp_rods.rods.free.arrays import Arrays
from warp_rods.rods.free.behaviour import Behaviours
from warp_rods.rods.free.launches import FreeLaunches
from warp_rods.rods.readings import Reading, Readings
from warp_rods.rods.tiles import Tiled, is_tiled


class FreeReadings(Readings):
    """Readings of the present state, computed when they are read."""

    _arrays: Arrays
    _launches: FreeLaunches
    _behaviours: Behaviours | None

    def _apply_external(self) -> None:
        """Evaluate the external force at the present time."""

    def _find_output(self) -> None:
        self._apply_external()
        self._launches.find_output()

    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""
        a, output = self._arrays, self._arrays.output

        def of(update: Any, array: wp.array) -> Reading:
            return Reading(update, partial(self._on_host, array))

        # Output comes first: an external force is evaluated with the frames as they were after the last step.
        find_output, find_frames = self._find_output, self._launches.find_material_frame
        events = {} if self._behaviours is None else {"events": of(_no_update, self._behaviours.count_array)}
        return {
            **events,
            "tension": of(find_output, a.balance.tension),
            "energy_density": of(find_output, output.energy_density),
            "energy": of(find_output, output.energy),
            "dissipation": of(find_output, output.dissipation),
            "power": of(find_output, output.power),
            "flow_power": of(find_output, output.flow_power),
            "position": of(find_frames, a.position),
            "strain": of(find_frames, a.strain),
            "orientation": of(find_frames, a.orientation),
            "rotation": of(find_frames, a.rotation),
            "status": of(_no_update, a.rods.status),
            "activity": of(find_frames, a.shown.activity),
        }

    @property
    def rotation(self) -> np.ndarray:
        """Directors of the Bishop frame as columns, tangent first [rod, node, 3, 3]."""
        return self.reading("rotation")

    @property
    def flow_power(self) -> np.ndarray:
        """The part of ``power`` that a flow gives [rod]: ∫ ζ(u∞ − u)·u∞ ds, u∞ relative to that at the middle node."""
        return self.reading("flow_power")

    @property
    def activity(self) -> np.ndarray:
        """The flagellar field f [rod, node]."""
        return self.reading("activity")

    def rates(self) -> dict[str, np.ndarray]:
        """The present shape, its rates of change and its velocities, in the Bishop frame.

        At nodes [rod, node]: ``bending`` k = Ω[1] + iΩ[2] (complex), ``twist`` and ``activity``, each with its time
        derivative ``…_rate``; ``tension`` λ; ``transverse`` velocity u⊥ (complex). At half nodes [rod, node − 1]:
        ``axial`` velocity u0, transverse ``angular_velocity`` ω⊥ (complex).
        """
        a = self._arrays
        with exclusive:
            self._find_output()
            along, across = self._carried()
            return {
                "bending": self._complex(a.shown.bending),
                "twist": self._on_host(a.shown.twist),
                "activity": self._on_host(a.shown.activity),
                "bending_rate": self._complex(a.output.bending_rate),
                "twist_rate": self._on_host(a.output.twist_rate),
                "activity_rate": self._on_host(a.output.activity_rate),
                "tension": self._on_host(a.balance.tension),
                "transverse": self._complex(a.balance.transverse_velocity) + across,
                "axial": self._on_host(a.balance.axial_velocity)[:, :-1] + along,
                "angular_velocity": self._complex(a.balance.angular_velocity)[:, :-1],
            }

    def _carried(self) -> tuple[Any, Any]:
        """The velocity with which a flow carries the rods as a whole: along at half nodes, across at nodes."""
        a, carrier = self._arrays, self._arrays.midpoint.carrier
        if carrier.kind == NOT_CARRIED:
            return 0.0, 0.0
        velocity = np.broadcast_to(np.array(carrier.uniform), (len(to_host(a.failed_at)), 3))
        if carrier.kind == CARRIED_APART:
            velocity = to_host(carrier.stream)[:, a.rods.tracked]
        self._launches.find_frames()
        here = np.einsum("rnij,ri->rnj", to_host(a.rotation), velocity)
        return (here[:, 1:, 0] + here[:, :-1, 0]) / 2, here[..., 1] + 1j * here[..., 2]

    def _on_host(self, array: wp.array) -> np.ndarray:
        """A copy [rod, …] of an array [rod, …] or [tile, …]."""
        return Tiled(array, self._arrays.failed_at.shape[0]).numpy() if is_tiled(array) else to_host(array)

    def _complex(self, pairs: wp.array) -> np.ndarray:
        values = self._on_host(pairs)
        return values[..., 0] + 1j * values[..., 1]


def _no_update() -> None:
    """Arrays of the state are always up to date."""
