"""An ensemble of filaments bound to one surface (docs/model.md §3; dissertation, chapter 5)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound import growth as growth_tables
from warp_rods.rods.bound.arrays import ALONG, CONTACT_HISTORY, GEODESIC, allocate, tracked_node
from warp_rods.rods.bound.checks import (
    along_rods,
    check,
    checked_ends,
    geodesic_curvatures,
    lengths,
    rows_of_three,
)
from warp_rods.rods.bound.launches import BoundLaunches
from warp_rods.rods.bound.readings import STATIC_ALONG, BoundReadings
from warp_rods.rods.bound.refinement import refined_state
from warp_rods.rods.changes import Changes, Sampled
from warp_rods.rods.ensemble import Ensemble, Fixed, Parameter
from warp_rods.rods.modes import beam_root
from warp_rods.rods.outside import Outside
from warp_rods.rods.pace import PACE, restart_pace
from warp_rods.rods.per_rod import named_numbers
from warp_rods.rods.tiles import Tiled, is_tiled
from warp_rods.rods.variables import FILAMENT_VARIABLES, along_in_time

HISTORY = (
    *(*GEODESIC, "turn", "rotation", "position", "rotation_before", "position_before"),
    *("angular_velocity", "velocity", "failed_at"),
)
FIRST_STEP = 1e-9
"""The first step that a rod tries, in units of its slowest bending time in the surface, ζ⊥ L⁴/B3."""
HIGHEST_ORDER = 3
NEXT_KNOT = 1e-6
"""A knot that is closer than this part of a step has been reached."""


class BoundRods(BoundReadings, Ensemble):
    """Filaments on a surface, each with its own parameters. NumPy in, NumPy out; no files.

    surface: from ``surfaces.make``. position, direction [rod, 3]: the middle node (with ``at="start"`` the first
    node) and the tangent there at t = 0, projected onto the surface and its tangent plane. geodesic_curvature: a
    number, a formula of s, or values [node] or [rod, node]. length, stiffness B (twist, normal bending, geodesic
    bending), intrinsic σ, drag (ζ∥, ζ⊥, ζr): one for all rods or one for each; numbers of the last three may be lists
    [node], or formulas in s (−½ to ½) and t: ``(0, "2*sin(k*s - t)", 0)``; parameters: of these, numbers by name, one
    for all rods or one for each. ends: "free" or "clamped" (docs/model.md §3.3), of which one on a membrane that
    moves. growth: ``growth.knots``; free tips grow, and nodes keep their shares. flow, gravity (a force per length),
    forces: as in a scene. All units are arbitrary.

    Raises SceneError naming the parameter for impossible values, fewer than 9 nodes, or a direction normal to the
    surface.
    """

    saved = FILAMENT_VARIABLES
    step_tolerance = 5e-4
    _launches: BoundLaunches

    length = Parameter("Length at the start [rod].")
    stiffness = Parameter("Stiffness B of twist, normal and geodesic bending [rod, 3], or [rod, node, 3]; at t = 0.")
    intrinsic = Parameter("Intrinsic strains σ [rod, 3], or [rod, node, 3]; at t = 0.")
    drag = Parameter("Drag ζ∥, ζ⊥, ζr [rod, 3], or [rod, node, 3]; at t = 0.")
    surface = Fixed[Surface]("The membrane.")
    ends = Fixed[tuple[str, str]]("The first and the last end, each free or clamped.")
    growth = Fixed[growth_tables.Knots]("Times and lengths [rod, knot] of a length that is linear between knots.")
    largest_spacing = Fixed[float]("The number of nodes is doubled before Δs exceeds it; length.")

    def __init__(
        self,
        surface: Surface,
        position: Any,
        direction: Any,
        *,
        nodes: int = 33,
        length: Any = 1.0,
        stiffness: Any = (1.0, 1.0, 1.0),
        intrinsic: Any = (0.0, 0.0, 0.0),
        drag: Any = (1.0, 2.0, 0.1),
        geodesic_curvature: Any = 0.0,
        at: str = "middle",
        ends: tuple[str, str] = ("free", "free"),
        parameters: Mapping[str, Any] | None = None,
        growth: Mapping[str, Any] | None = None,
        flow: Any = None,
        gravity: Any = None,
        forces: Any = None,
        device=None,
    ):
        made = "a Surface, which surfaces.make(kind, parameters) returns"
        surface = arguments.instance("surface", surface, Surface, made)
        position = rows_of_three("position", position)
        direction = rows_of_three("direction", direction, len(position))
        count, nodes = len(position), arguments.whole("nodes", nodes)
        values, named = {"length": lengths(length, count)}, named_numbers(parameters, count)
        grown, given = growth_tables.read(growth), {"stiffness": stiffness, "intrinsic": intrinsic, "drag": drag}
        self._along = along_rods(given, count, nodes, grows=growth is not None, named=named)
        values |= {name: components.values for name, components in self._along.items()}
        outside = Outside(flow, gravity, forces, count)
        self._outside = outside if outside.flows or outside.pushes else None
        fixed = {"surface": surface, "ends": checked_ends(ends)}
        fixed |= {"growth": growth_tables.knots(grown, values["length"]), "largest_spacing": grown.largest_spacing}
        super().__init__(count, nodes, values, device, **fixed)
        check(self, position, direction, at, grows=growth is not None)
        self._saved_nodes = self.nodes
        self.saved = FILAMENT_VARIABLES | {
            name: along_in_time(name) for name in STATIC_ALONG if self._along[name].varies
        }
        self._refined = False
        self._shown = np.inf
        geodesic = geodesic_curvatures(geodesic_curvature, self.count, self.nodes, named)
        with exclusive:
            self._allocate()
            self._place(position, direction, geodesic, 0 if at == "start" else self.middle)

    @property
    def clamped(self) -> tuple[bool, bool]:
        """Whether the first and the last end are clamped."""
        return self.ends[0] == "clamped", self.ends[1] == "clamped"

    @property
    def middle(self) -> int:
        """The index of the middle node; after a refinement that of the same point of the rod."""
        return self.stride * (self._saved_nodes // 2)

    @property
    def tracked(self) -> int:
        """The index of the node whose frame is advanced in time; after a refinement that of the same point."""
        return self.stride * tracked_node(self._saved_nodes, self.clamped)

    def _allocate(self) -> None:
        values = {name: part.at(0.0, self.nodes) if part.varies else part.values for name, part in self._along.items()}
        values |= {"length": self.length}
        self._arrays = allocate(
            values, self.nodes, self.clamped, self.tracked, self.growth, self.surface.moving, self.device
        )
        self._along_time = 0.0
        self._f, self._past = self._arrays.f, self._arrays.past
        self._launches = BoundLaunches(self._arrays, self.surface, self._clock, self.middle)
        if self._outside is not None:
            self._launches.enable_outside(self._outside)

    def _place(self, position: np.ndarray, direction: np.ndarray, geodesic: np.ndarray, node: int) -> None:
        """Set the frame of one node to the given position and direction, and the others from it outwards."""
        f = self._f
        free = [end for end, clamped in zip((0, -1), self.clamped, strict=True) if not clamped]
        at_ends = np.broadcast_to(self.intrinsic.reshape(self.count, -1, 3), (self.count, self.nodes, 3))
        geodesic[:, free] = at_ends[:, free, 2]  # a free end has m3 = 0 (D.59)
        r = np.zeros((self.count, self.nodes, 3))
        r[:, node] = position
        f.position.assign(r)
        for field in (f.geodesic, self._past.now):
            self._tiled(field).assign(geodesic)
        self._tiled(f.growth_rate).assign(growth_tables.rate_at(self.growth, 0.0))
        self._launches.place(node, direction)
        f.status.assign(self._arrays.plan.unfit.numpy().astype(np.int32))
        self._keep_tracked_frame()
        pace = self._arrays.pace
        pace.step.assign(FIRST_STEP * self._bending_times)
        pace.highest_order.fill_(HIGHEST_ORDER)

    def _keep_tracked_frame(self) -> None:
        """Take the frame of the tracked node that is shown as that of the newest level."""
        self._past.rotation.assign(self._rotation()[:, self.tracked])
        self._past.position.assign(self._f.position.numpy()[:, self.tracked])

    # --- steps ------------------------------------------------------------------------------------------------------

    def prepare_step(self, dt: float) -> bool:
        """Refine rods whose spacing would become too large in a step."""
        self._shown, before = np.inf, self.nodes
        if self.largest_spacing < np.inf:
            end = self.reached + dt
            while (growth_tables.length_at(self.growth, end) / (self.nodes - 1) > self.largest_spacing).any():
                self.refine()
        return self.nodes != before

    def step_to_event(self, step: float) -> float:
        """A step from the time reached, ended at the next knot of a length against time."""
        step = super().step_to_event(step)
        left = self.growth[0] - self.reached
        ahead = left[(left > NEXT_KNOT * step) & (left < step)]
        return float(ahead.min()) if len(ahead) else step

    def predict_step(self) -> None:
        """Launch what puts the rods at the extrapolated state at the end of the step."""
        self._set_along(self.reached + self._clock.step)
        self._launches.predict(self.reached + self._clock.step)

    @property
    def changes_in_time(self) -> bool:
        """Whether stiffness, intrinsic strains or drag change in time."""
        return any(part.varies for part in self._along.values())

    def _find_changes(self) -> Changes:
        """Parameters, flows and forces that change in time, and formulas of a membrane that moves."""
        formulas: list[Sampled] = [part.sampled for part in self._along.values() if part.varies]
        if self._outside is not None:
            formulas += self._outside.sampled(lambda: self.position)
        if self.surface.moving:
            formulas.append(self.surface.sampled)
        return Changes(formulas)

    def _set_along(self, time: float) -> None:
        """Let parameters that change in time be those of a time."""
        if time == self._along_time or not self.changes_in_time:
            return
        with exclusive:
            for name in ALONG:
                if self._along[name].varies:
                    self._tiled(getattr(self._f, name)).assign(self._along[name].at(time, self.nodes))
        self._along_time = time

    @property
    def _step_error(self) -> wp.array:
        """Error of the step tried [rod]: of L Ω over 1 + L Ω, the angle, and the place over L; infinite: not valid."""
        return self._arrays.plan.error

    def accept_step(self) -> None:
        """Launch what makes the result of the step tried the present state."""
        super().accept_step()
        self._shown = np.inf

    @property
    def has_own_steps(self) -> bool:
        """True for rods on a membrane at rest that are never refined and do not change in time."""
        return self.largest_spacing == np.inf and not self.surface.moving and not self.changes_in_time

    def take_own_steps(self, time: float, allowed: float) -> None:
        """Launch steps of each rod until it reaches ``time``."""
        self._launches.advance_past(time, allowed, time)

    def gather(self) -> None:
        """Begin anew from the present state, with no past."""
        with exclusive:
            self.show()
            wp.copy(self._past.now, self._f.geodesic)
            self._keep_tracked_frame()
            restart_pace(self._arrays.pace, self.time)
            if self._f.in_contact:
                for name in CONTACT_HISTORY:
                    getattr(self._past, name).zero_()

    @property
    def pace_arrays(self) -> Any:
        """``Pace`` on the device."""
        return self._arrays.pace

    def show_at(self, time: float) -> None:
        """Make ``time``, readings and positions those of a time within the last step."""
        super().show_at(time)
        self._shown = time

    @property
    def _bending_times(self) -> np.ndarray:
        drag, stiffness = (values.reshape(self.count, -1, 3) for values in (self.drag, self.stiffness))
        return drag[..., 1].min(axis=1) * self.length**4 / stiffness[..., 2].max(axis=1)

    @property
    def natural_time(self) -> float:
        """The shortest relaxation time of the first bending mode in the surface, L⁴ζ⊥/501 B3."""
        return float(self._bending_times.min()) / beam_root(0) ** 4

    @property
    def first_step(self) -> float:
        """The shortest first step that the rods try."""
        return FIRST_STEP * float(self._bending_times.min())

    @property
    def ends_of_space(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [3] of the box in which φ is given."""
        return ends_of(self.surface)

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._launches.threads

    def refine(self) -> None:
        """Insert a node between any two adjacent nodes; the order of the next steps does not suffer."""
        state = refined_state(self.state(), self.largest_spacing)
        self._refined = True
        self.restore(state)

    # --- contact -----------------------------------------------------------------------------------------

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node]."""
        return self._f.position

    @property
    def force_array(self) -> wp.array:
        """External force per length on the device [rod, node], in space."""
        return self._f.force

    @property
    def contact_stiffness_array(self) -> wp.array:
        """Stiffness of contact per length [rod, node] (3, 3), in space, on the device; allocated by the first call."""
        if not self._f.in_contact:
            with exclusive:
                self._launches.enable_contact()
        return self._f.contact_stiffness

    @property
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]."""
        return self._f.spacing_of_rod

    @property
    def status_array(self) -> wp.array:
        """``Status`` on the device [rod]."""
        return self._f.status

    @property
    def failed_at(self) -> np.ndarray:
        """The time at which each rod was frozen [rod]; meaningless for the others."""
        with exclusive:
            return to_host(self._past.failed_at)

    def static(self) -> dict[str, np.ndarray]:
        """What a trajectory saves once, [rod, 3] or [rod, node, 3]; not the length, because filaments may grow."""
        return {name: self._parameters[name] for name in STATIC_ALONG if not self._along[name].varies}

    # --- state ------------------------------------------------------------------------------------------------------

    def arrays_of_state(self) -> dict[str, wp.array | Tiled]:
        """Every device array that the next step depends on."""
        arrays: dict[str, Any] = {name: getattr(self._past, name) for name in HISTORY}
        arrays |= {f"pace_{name}": getattr(self._arrays.pace, name) for name in PACE}
        if self._f.in_contact:
            arrays |= {name: getattr(self._past, name) for name in CONTACT_HISTORY}
        arrays |= {name: self._tiled(array) for name, array in arrays.items() if is_tiled(array)}
        return arrays | {"status": self._f.status}

    def nodes_of(self, state: Mapping[str, np.ndarray]) -> int:
        """The number of nodes in a state, which refinement may have changed."""
        shape = np.shape(state.get("now", ()))
        nodes = shape[1] if len(shape) == 2 else 0
        may_differ = self.largest_spacing < np.inf or self._refined
        refined = may_differ and nodes > 1 and (nodes - 1) % (self._saved_nodes - 1) == 0
        return nodes if refined else self.nodes

    def _settings(self, rod: int) -> dict[str, Any]:
        time, length = (knots[rod].tolist() for knots in self.growth)
        return {"ends": self.ends, "growth": {"time": time, "length": length} if len(time) > 1 else None}

    def allocate_for(self, state: Mapping[str, np.ndarray]) -> None:
        """Allocate arrays for the number of nodes in the state, which refinement may have changed."""
        nodes = state["now"].shape[1]
        if nodes != self.nodes:
            in_contact = self._f.in_contact
            self._nodes = nodes
            self._allocate()
            if in_contact:
                self._launches.enable_contact()

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state`` of an ensemble with the same parameters."""
        super().restore(state)
        self._shown = self.time if self.time < self.reached else np.inf
        self.show()
