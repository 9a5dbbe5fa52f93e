"""An ensemble of filaments bound to one surface: parameters, state, step (model §3; thesis chapter 5)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp
from scipy.interpolate import CubicSpline

from warp_rods.errors import SceneError
from warp_rods.kernels.bound import step as bound_step
from warp_rods.kernels.layout import to_host
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.bound import growth as growing
from warp_rods.rods.bound.arrays import allocate
from warp_rods.rods.bound.checks import check
from warp_rods.rods.bound.launches import BoundLaunches
from warp_rods.rods.per_rod import check_step, each_rod, vectors
from warp_rods.rods.variables import FILAMENT_VARIABLES

STATE = ("geodesic", "curvature", "rotation", "position", "status", "spacing", "growth_rate")
HISTORY = ("pace", "clock", "geodesic", "rate", "spin", "velocity", "failed_at")
PARAMETERS = ("length", "stiffness", "intrinsic", "drag")
MOST_NODES = 100_000
STATUS = {
    bound_step.WELL: "well",
    bound_step.NOT_FINITE: "became non-finite",
    bound_step.OFF_SURFACE: "left its surface",
    bound_step.TOO_BENT: "was about to bend by more than half a turn a cell",
    bound_step.TOO_FAST: "was about to move by more than its length in a step",
}


class BoundRods:
    """Filaments on a surface, each with its own parameters. NumPy in, NumPy out; no files.

    surface: from ``surfaces.make``; on one that moves ends are free. position, direction [rod, 3] at t = 0: middle
    node (or ``at = "start"``, the first) and tangent there, projected to the surface and its tangent plane.
    geodesic_curvature [rod, node] or a number. length, stiffness B (twist, normal bending, geodesic bending),
    intrinsic σ, drag (ζ∥, ζ⊥, ζr): one for all or one a rod. ends: "free" (D.59-D.61) or "clamped" for the first and
    last node. growth: see ``growth.knots``; tips grow, a clamped end stays; nodes stay at fixed shares of the length.
    Lengths, forces, times in units of your choice.
    Raises SceneError for impossible parameters, fewer than 9 nodes, a direction that is normal to the surface.
    """

    saved = FILAMENT_VARIABLES
    recordable = False
    """A step is more than kernels: it may refine the rods, or move the membrane."""

    def __init__(
        self,
        surface: Surface,
        position: np.ndarray,
        direction: np.ndarray,
        *,
        nodes: int = 33,
        length: Any = 1.0,
        stiffness: Any = (1.0, 1.0, 1.0),
        intrinsic: Any = (0.0, 0.0, 0.0),
        drag: Any = (1.0, 2.0, 0.1),
        geodesic_curvature: Any = 0.0,
        at: str = "middle",
        ends: tuple[str, str] = ("free", "free"),
        growth: Mapping[str, Any] | None = None,
        device=None,
    ):
        position, direction = (np.asarray(given, dtype=float) for given in (position, direction))
        self.surface, self.nodes, self.count = surface, nodes, len(position)
        self.device = wp.get_device(device)
        self.middle = nodes // 2
        self.length = each_rod(length, self.count)
        self.stiffness = each_rod(stiffness, self.count, 3)
        self.intrinsic = each_rod(intrinsic, self.count, 3)
        self.drag = each_rod(drag, self.count, 3)
        self.clamped = (ends[0] == "clamped", ends[1] == "clamped")
        self.largest_spacing = np.inf if growth is None else growth.get("spacing") or np.inf
        check(self, position, direction, at, ends)
        self.growth = growing.knots(growth, self.length)
        self.time = self._dt = 0.0
        self._saved_nodes = nodes
        self._allocate()
        self._place(position, direction, geodesic_curvature, 0 if at == "start" else self.middle)

    def _allocate(self) -> None:
        parameters = {name: getattr(self, name) for name in PARAMETERS}
        self._arrays = allocate(parameters, self.nodes, self.clamped, self.growth, self.surface.moving, self.device)
        self._f, self._past = self._arrays.f, self._arrays.past
        self._run = BoundLaunches(self._arrays, self.surface)

    def refine(self) -> None:
        """Put a node between each two: shape and history by cubic splines, so that the next steps keep their order."""
        if 2 * self.nodes > MOST_NODES:
            raise SceneError(f"growth.spacing = {self.largest_spacing:g}: needs more than {MOST_NODES} nodes a rod")
        state, coarse = self.state(), np.linspace(0.0, 1.0, self.nodes)
        self.nodes = 2 * self.nodes - 1
        self.middle = self.nodes // 2
        fine = np.linspace(0.0, 1.0, self.nodes)
        for name in ("geodesic", "past_geodesic", "past_rate"):
            state[name] = CubicSpline(coarse, state[name], axis=1)(fine)
        for name in ("position", "rotation", "curvature"):
            state[name] = np.repeat(state[name], 2, axis=1)[:, :-1]
        state["spacing"] = state["spacing"] / 2
        self._allocate()
        self._assign(state)
        self._run.membrane_at(self.time)
        self._run.place(self._f.anchor)

    def _refine_if_coarse(self, until: float) -> None:
        """Refine before a step to the time ``until`` would leave Δs above what the growth allows."""
        if self.largest_spacing < np.inf:
            while (growing.length_at(self.growth, until) / (self.nodes - 1) > self.largest_spacing).any():
                self.refine()

    def _place(self, position, direction, geodesic_curvature, node: int) -> None:
        """The frame at one node from what the user gave, then the others outwards."""
        shape, f = (self.count, self.nodes), self._f
        turn = np.broadcast_to(np.asarray(geodesic_curvature, dtype=float), shape).copy()
        free = [end for end, clamped in zip((0, -1), self.clamped, strict=True) if not clamped]
        turn[:, free] = self.intrinsic[:, 2:3]  # a free end has m3 = 0 (D.59)
        r, R = np.zeros((*shape, 3)), np.zeros((*shape, 3, 3))
        r[:, node] = position
        R[:, node, :, 0] = direction
        f.geodesic.assign(turn)
        f.position.assign(r)
        f.rotation.assign(R)
        self._past.geodesic.assign(turn)
        f.growth_rate.assign(growing.rate_at(self.growth, 0.0))
        self._run.place(node)

    def step(self, dt: float, steps: int = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order (SBDF2, AB2-Magnus).

        A change of ``dt`` keeps the order: the coefficients follow the ratio of the steps.
        """
        check_step(dt, steps)
        self.set_step(dt)
        for _ in range(steps):
            self._refine_if_coarse(self.time + dt)
            self.evaluate()
            self._run.membrane_at(self.time + dt)
            self._run.advance()
            self.time += dt

    def set_step(self, dt: float) -> None:
        """Make ``dt`` the length of the steps to come."""
        if dt != self._dt:
            self._past.pace.assign([[dt, dt / self._dt if self.time else 0.0]])
            self._dt = dt

    def evaluate(self) -> None:
        """Make tension, velocities and rates those of the present shape, force and membrane."""
        self._run.membrane_at(self.time)
        self._run.evaluate()

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node]."""
        return self._f.position

    @property
    def force_array(self) -> wp.array:
        """External force per length on the device [rod, node]."""
        return self._f.force

    @property
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]."""
        return self._f.spacing

    @property
    def cross_drag(self) -> np.ndarray:
        """ζ⊥ [rod]."""
        return self.drag[:, 1]

    @property
    def force(self) -> np.ndarray:
        """External force per length in space [rod, node, 3], yours to set."""
        return to_host(self._f.force)

    @force.setter
    def force(self, value: np.ndarray) -> None:
        self._f.force.assign(vectors(value, self.count, self.nodes))

    @property
    def position(self) -> np.ndarray:
        """Centre line r [rod, node, 3]."""
        return to_host(self._f.position)

    @property
    def rotation(self) -> np.ndarray:
        """Directors as columns (q, n×q, n) [rod, node, 3, 3]."""
        return to_host(self._f.rotation)

    @property
    def curvature(self) -> np.ndarray:
        """K11, K12, K22 [rod, node, 3] of the surface in the pair (q, n×q)."""
        return to_host(self._f.curvature)

    @property
    def strain(self) -> np.ndarray:
        """Twist, normal and geodesic bending (K12, −K11, Ω) [rod, node, 3] (5.17), (5.18)."""
        K = self.curvature
        return np.stack([K[..., 1], -K[..., 0], to_host(self._f.geodesic)], axis=-1)

    @property
    def status(self) -> np.ndarray:
        """0 while a rod is well [rod]; else a key of ``STATUS``."""
        return to_host(self._f.status)

    def variables(self) -> dict[str, np.ndarray]:
        """The present state as the trajectory keeps it: names and shapes of ``saved``, without the steric energy."""
        f, out = self._f, self._arrays.out
        self.evaluate()
        self._run.measure()
        every = (self.nodes - 1) // (self._saved_nodes - 1)  # a refined ensemble is saved at the nodes it began with
        constraint, orthogonality, arc_length = to_host(out["residuals"]).T
        return {
            "position": self.position[:, ::every],
            "strain": self.strain[:, ::every],
            "orientation": to_host(out["orientation"])[:, ::every],
            "tension": to_host(f.tension)[:, ::every],
            "energy_density": to_host(out["energy_density"])[:, ::every],
            "energy": to_host(out["energy"]),
            "dissipation": to_host(out["dissipation"]),
            "growth_power": to_host(out["growth_power"]),
            "membrane_power": to_host(out["membrane_power"]),
            "length": to_host(f.spacing) * (self.nodes - 1),
            "status": self.status,
            "gauss": to_host(out["gauss"]),
            "load": to_host(out["load"])[:, ::every],
            "load_moment": to_host(out["load_moment"])[:, ::every],
            "constraint": constraint,
            "orthogonality": orthogonality,
            "arc_length": arc_length,
        }

    def static(self) -> dict[str, np.ndarray]:
        """What the trajectory keeps once [rod, 3]: not the length, as filaments may grow."""
        return {"stiffness": self.stiffness, "intrinsic": self.intrinsic}

    def state(self) -> dict[str, np.ndarray]:
        """All that the next step depends on; ``restore`` goes on from it to the same bits."""
        arrays = {name: to_host(getattr(self._f, name)) for name in STATE}
        arrays |= {f"past_{name}": to_host(getattr(self._past, name)) for name in HISTORY}
        return {**arrays, "time": np.array(self.time)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go back to a ``state`` of an ensemble of the same shape and parameters."""
        if self.nodes != state["geodesic"].shape[1]:
            self.nodes = state["geodesic"].shape[1]
            self.middle = self.nodes // 2
            self._allocate()
        self._assign(state)

    def _assign(self, state: dict[str, np.ndarray]) -> None:
        for name in STATE:
            getattr(self._f, name).assign(state[name])
        for name in HISTORY:
            getattr(self._past, name).assign(state[f"past_{name}"])
        self.time, self._dt = float(state["time"]), float(state["past_pace"][0, 0])

    def failures(self) -> list[tuple[int, float, str]]:
        """Frozen rods: number, time and what happened."""
        status, when = self.status, to_host(self._past.failed_at)
        return [(int(rod), float(when[rod]), STATUS[int(status[rod])]) for rod in np.flatnonzero(status)]

    def parameters(self, rod: int) -> dict[str, Any]:
        """What distinguishes one rod, to name it by."""
        return {name: getattr(self, name)[rod].tolist() for name in PARAMETERS}
