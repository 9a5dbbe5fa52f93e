"""Natural strains of free rods, in their material frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.rods.along import Along, at_nodes


class Natural:
    """Natural bending about the third director, or about the second and third, and natural twist, along rods and in t.

    bend: what ``Along`` takes, for Ω[2]; or a pair {"second": …, "third": …} for Ω[1] and Ω[2]. twist: for Ω[0]. named:
    parameters of the formulas [rod].
    """

    def __init__(self, bend: Any, twist: Any, count: int, nodes: int, named: Mapping[str, np.ndarray] | None = None):
        second, third = (bend.get("second", 0.0), bend.get("third", 0.0)) if isinstance(bend, dict) else (0.0, bend)
        self._nodes = nodes
        parts = {"natural_bend.second": second, "natural_bend": third, "natural_twist": twist}
        self._parts = [
            Along(name, part, count, nodes, arguments.ANY, in_time=True, named=named) for name, part in parts.items()
        ]
        self.varies = any(part.varies for part in self._parts)
        """Whether it changes in time."""
        second_values, third_values, self.twist = (at_nodes(part.values, nodes) for part in self._parts)
        self.bending = np.stack([second_values, third_values], axis=-1)

    @property
    def parts(self) -> list[Along]:
        """Those that change in time."""
        return [part for part in self._parts if part.varies]

    @property
    def any(self) -> bool:
        """Whether there is any natural strain."""
        return self.varies or bool(self.bending.any() or self.twist.any())

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Bending [rod, node, 2] and twist [rod, node] at a time."""
        found = [part.at(time) if part.varies else at_nodes(part.values, self._nodes) for part in self._parts]
        return np.stack(found[:2], axis=-1), found[2]
