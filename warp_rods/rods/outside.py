"""What acts on the rods of an ensemble from outside: a flow, gravity, forces and couples by formula."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.kernels import outside as kernels
from warp_rods.kernels.layout import constant_zero, per_node
from warp_rods.rods.changes import Sampled, chosen
from warp_rods.rods.per_rod import parameter
from warp_rods.scene.checks import read_table
from warp_rods.scene.flows import FlowTable, Profile
from warp_rods.scene.outside import VARIABLES, ForceTable

__all__ = ["Outside"]


class Outside:
    """Flow, gravity and forces of an ensemble of ``count`` rods.

    flow: a table as in a scene, or None. gravity: a force per length in space, one vector for all rods or one for each
    [rod, 3], or None. forces: tables as in a scene. Raises SceneError naming what is wrong.
    """

    def __init__(self, flow: Any, gravity: Any, forces: Any, count: int):
        if flow is not None and not isinstance(flow, (Mapping, FlowTable)):
            raise arguments.wrong("flow", flow, "a table { kind, … }, or None")
        self.flow = None if flow is None else read_table(FlowTable, flow, "flow")
        self._profile: Profile | tuple | None = None
        if self.flow is not None:
            self._profile = self.flow.formulas
        weight = (0.0, 0.0, 0.0) if gravity is None else gravity
        self._weight = parameter("gravity", weight, count, (arguments.ANY,) * 3)
        self._tables = _tables(forces)

    @property
    def flows(self) -> bool:
        """Whether there is a flow."""
        return self._profile is not None

    @property
    def uniform(self) -> np.ndarray | None:
        """The velocity [3] of a flow that is the same everywhere and at all times; None for others, and for none."""
        flow = self._profile
        if not isinstance(flow, Profile) or flow.gradient.any() or flow.axis.any():
            return None
        return flow.velocity

    @property
    def pushes(self) -> bool:
        """Whether there is gravity, or a force or couple per length."""
        return bool(self._weight.any() or self._tables)

    @property
    def turns(self) -> bool:
        """Whether there may be a couple per length."""
        return bool(self._tables)

    def sampled(self, position: Callable[[], np.ndarray]) -> list[Sampled]:
        """A function of times [time] → values [time, place] of formulas in t, if there are any.

        position: where the rods are [rod, node, 3], at a few places of which the formulas are taken.
        """
        flow = self._profile if isinstance(self._profile, tuple) else ()
        texts = [text for text in (*flow, *(t for table in self._tables for t in table.texts)) if isinstance(text, str)]
        functions = [function_of_arrays(text, VARIABLES) for text in texts]
        functions = [f for f in functions if "t" in f.names]  # type: ignore[attr-defined]
        if not functions:
            return []
        at_start = position()
        places = at_start[chosen(len(at_start))][:, [0, at_start.shape[1] // 2, -1]]
        s = np.array([-0.5, 0.0, 0.5])

        def values(times: np.ndarray) -> Iterator[np.ndarray]:
            for function in functions:
                for place in places:
                    at = dict(zip("xyz", place.T, strict=True))
                    found = function(t=times[:, None], s=s, **at)
                    yield np.broadcast_to(found, (len(times), len(s)))

        return [values]

    def without_flow(self) -> Outside:
        """The same without a flow."""
        other = copy.copy(self)
        other.flow = other._profile = None
        return other

    def arrays(self, nodes: int, device: Any) -> Any:
        """``Outside`` on the device, for rods of this many nodes."""
        made, count = kernels.Outside(), len(self._weight)
        made.flowing, made.pushing, made.turning = int(self.flows), int(self.pushes), int(self.turns)
        made.weight = wp.array(self._weight, dtype=wp.vec3d, device=device)
        present = {"velocity": self.flows, "spin": self.flows, "force": self.pushes, "couple": self.turns}
        for name, is_present in present.items():
            make = per_node if is_present else constant_zero
            setattr(made, name, make(count, nodes, wp.vec3d, device))
        if self.pushes:
            made.force.assign(np.ascontiguousarray(np.broadcast_to(self._weight[:, None], (count, nodes, 3))))
        if isinstance(self._profile, Profile):
            made.profile = self._profile_on_device(self._profile)
        return made

    def _profile_on_device(self, profile: Profile) -> Any:
        made = kernels.Profile()
        centre = self.flow.values.get("centre") if self.flow is not None else None
        made.centre = wp.vec3d(*(centre or (0.0, 0.0, 0.0)))
        made.velocity, made.axis = wp.vec3d(*profile.velocity), wp.vec3d(*profile.axis)
        made.gradient, made.form = wp.mat33d(*profile.gradient.flat), wp.mat33d(*profile.form.flat)
        return made

    def fields(self) -> list[Any]:
        """Kernels that evaluate what changes in space or time; raises SceneError for a formula that cannot be used."""
        from warp_rods.membranes.formula_fields import flow, force

        found = []
        if isinstance(self._profile, Profile):
            found.append(kernels.flow_kernel(kernels.profile_flow))
        try:
            if isinstance(self._profile, tuple):
                found.append(kernels.flow_kernel(flow(self._profile)))
        except FormulaError as error:
            raise SceneError(f"flow.velocity: {error}") from None
        try:
            if self._tables:
                found.append(kernels.force_kernel(force(tuple(table.texts for table in self._tables))))
        except FormulaError as error:
            raise SceneError(f"forces: {error}") from None
        return found


def _tables(forces: Any) -> list[ForceTable]:
    if forces is None:
        return []
    if isinstance(forces, (str, bytes)) or not isinstance(forces, Sequence):
        raise arguments.wrong("forces", forces, "a list of tables { force, couple }")
    return [read_table(ForceTable, table, "forces", i) for i, table in enumerate(forces)]
