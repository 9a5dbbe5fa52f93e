"""What can be read of an ensemble of free rods beside what every ensemble offers."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.rods.ensemble import Reading
from warp_rods.rods.free.arrays import Arrays
from warp_rods.rods.free.launches import FreeLaunches


class FreeReadings:
    """Readings of the present state, brought up to date when they are asked for."""

    _arrays: Arrays
    _run: FreeLaunches

    def _apply_external(self) -> None:
        """Make the external force that of this moment."""

    def _balance(self) -> None:
        self._apply_external()
        self._run.measure()

    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""
        a, m = self._arrays, self._arrays.measures

        def of(update: Any, array: wp.array) -> Reading:
            return Reading(update, partial(to_host, array))

        # The balance comes first: an external force is a function of the frames before they are made anew.
        balance, frames = self._balance, self._run.materialise
        return {
            "tension": of(balance, a.flow.tension),
            "energy_density": of(balance, m.energy_density),
            "energy": of(balance, m.energy),
            "dissipation": of(balance, m.dissipation),
            "power": of(balance, m.power),
            "position": of(frames, a.position),
            "strain": of(frames, a.strain),
            "orientation": of(frames, a.orientation),
            "rotation": of(frames, a.rotation),
            "status": of(_up_to_date, a.rods.status),
            "activity": of(_up_to_date, a.now.activity),
        }

    @property
    def rotation(self) -> np.ndarray:
        """Directors of the Bishop frame as columns, tangent first [rod, node, 3, 3]."""
        return self.reading("rotation")  # type: ignore[attr-defined]

    @property
    def activity(self) -> np.ndarray:
        """The flagellar field f [rod, node]."""
        return self.reading("activity")  # type: ignore[attr-defined]

    def rates(self) -> dict[str, np.ndarray]:
        """The present shape and what the semi-discrete equations make of it, Bishop frame.

        At nodes [rod, node]: ``bending`` k = Ω[1] + iΩ[2], complex, ``twist``, ``activity``, each with its time
        derivative ``…_rate``; ``tension``; ``transverse`` u⊥, complex. At half nodes: ``axial`` u0, ``spin`` ω⊥.
        """
        a = self._arrays
        with exclusive:
            self._balance()
            return {
                "bending": _complex(a.now.bending),
                "twist": to_host(a.now.twist),
                "activity": to_host(a.now.activity),
                "bending_rate": _complex(a.measures.bending_rate),
                "twist_rate": to_host(a.measures.twist_rate),
                "activity_rate": to_host(a.measures.activity_rate),
                "tension": to_host(a.flow.tension),
                "transverse": _complex(a.flow.transverse),
                "axial": to_host(a.flow.axial)[:, :-1],
                "spin": _complex(a.flow.spin)[:, :-1],
            }


def _up_to_date() -> None:
    """Arrays of the state are present at any moment."""


def _complex(pairs: wp.array) -> np.ndarray:
    values = pairs.numpy()
    return values[..., 0] + 1j * values[..., 1]
