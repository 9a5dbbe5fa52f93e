"""What can be read of an ensemble of free rods at any moment, as NumPy arrays of its own."""

from __future__ import annotations

import numpy as np
import warp as wp

from warp_rods.kernels.layout import to_host
from warp_rods.rods.free.arrays import Arrays
from warp_rods.rods.free.launches import FreeLaunches


class FreeReadings:
    """Readings of the present state. Each is worked out when asked for; ``variables`` takes them all at once."""

    _arrays: Arrays
    _run: FreeLaunches

    def _ask(self) -> None:
        """Make the external force that of this moment."""

    def _read(self, array: wp.array) -> np.ndarray:
        self._run.materialise()
        return to_host(array)

    def _measured(self, array: wp.array) -> np.ndarray:
        self._ask()
        self._run.measure()
        return to_host(array)

    @property
    def position(self) -> np.ndarray:
        """Centre line [rod, node, 3]."""
        return self._read(self._arrays.position)

    @property
    def rotation(self) -> np.ndarray:
        """Directors of the Bishop frame as columns, tangent first [rod, node, 3, 3]."""
        return self._read(self._arrays.rotation)

    @property
    def orientation(self) -> np.ndarray:
        """Directors of the material as quaternions x, y, z, w [rod, node, 4]."""
        return self._read(self._arrays.orientation)

    @property
    def strain(self) -> np.ndarray:
        """Twist and both bendings of the material frame [rod, node, 3]."""
        return self._read(self._arrays.strain)

    @property
    def activity(self) -> np.ndarray:
        """The flagellar field f [rod, node]."""
        return to_host(self._arrays.now.activity)

    @property
    def tension(self) -> np.ndarray:
        """λ [rod, node] (4.24)."""
        return self._measured(self._arrays.flow.tension)

    @property
    def energy(self) -> np.ndarray:
        """½ ∫ β⊥|k|² + β∥τ² ds [rod]."""
        return self._measured(self._arrays.measures.energy)

    @property
    def dissipation(self) -> np.ndarray:
        """Power lost to drag, ∫ u0² + η|u⊥|² + ηr ω0² ds [rod]."""
        return self._measured(self._arrays.measures.dissipation)

    @property
    def power(self) -> np.ndarray:
        """Power of flagella and external force, ∫ f u0 + M f ω0 + f_ext·u ds [rod]; dE/dt is it less dissipation."""
        return self._measured(self._arrays.measures.power)

    @property
    def status(self) -> np.ndarray:
        """0 while a rod is well [rod]; else a key of ``STATUS``, and it is frozen at its last sound state."""
        return to_host(self._arrays.rods.status)

    def variables(self) -> dict[str, np.ndarray]:
        """The present state as the trajectory keeps it: names and shapes of ``variables.SWIMMER_VARIABLES``."""
        a = self._arrays
        self._ask()
        self._run.measure()
        self._run.materialise()
        return {
            "position": to_host(a.position),
            "strain": to_host(a.strain),
            "orientation": to_host(a.orientation),
            "tension": to_host(a.flow.tension),
            "energy_density": to_host(a.measures.energy_density),
            "energy": to_host(a.measures.energy),
            "dissipation": to_host(a.measures.dissipation),
            "power": to_host(a.measures.power),
            "status": self.status,
            "activity": self.activity,
        }

    def rates(self) -> dict[str, np.ndarray]:
        """The present shape and what the semi-discrete equations make of it, Bishop frame.

        At nodes [rod, node]: ``bending`` k = Ω[1] + iΩ[2], complex, ``twist``, ``activity``, each with its time
        derivative ``…_rate``; ``tension``; ``transverse`` u⊥, complex. At half nodes: ``axial`` u0, ``spin`` ω⊥.
        """
        a = self._arrays
        self._ask()
        self._run.measure()
        return {
            "bending": _complex(a.now.bending),
            "twist": to_host(a.now.twist),
            "activity": self.activity,
            "bending_rate": _complex(a.measures.bending_rate),
            "twist_rate": to_host(a.measures.twist_rate),
            "activity_rate": to_host(a.measures.activity_rate),
            "tension": to_host(a.flow.tension),
            "transverse": _complex(a.flow.transverse),
            "axial": to_host(a.flow.axial)[:, :-1],
            "spin": _complex(a.flow.spin)[:, :-1],
        }


def _complex(pairs: wp.array) -> np.ndarray:
    values = pairs.numpy()
    return values[..., 0] + 1j * values[..., 1]
