"""An ensemble of filaments bound to one surface: parameters, state, step (model §3; thesis chapter 5)."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from scipy.spatial.transform import Rotation

from warp_rods.kernels import bound_frames, bound_load, bound_rod
from warp_rods.kernels.banded import solve_pentadiagonal, solve_tridiagonal
from warp_rods.kernels.layout import per_node, per_rod, to_host
from warp_rods.per_rod import each_rod
from warp_rods.recorded import Recorded
from warp_rods.surfaces import Surface
from warp_rods.variables import FILAMENT_VARIABLES

STATE = ("geodesic", "curvature", "rotation", "position", "status")
HISTORY = ("pace", "clock", "geodesic", "rate", "spin", "velocity", "failed_at")
VECTORS = ("curvature", "position", "force", "moment")
SCALARS = (
    *("geodesic", "shear", "load", "to_left", "to_right", "remainder"),
    *("tension", "along", "across", "rate"),
)
STATUS = {
    bound_frames.WELL: "well",
    bound_frames.NOT_FINITE: "became non-finite",
    bound_frames.OFF_SURFACE: "left its surface",
}


class BoundRods:
    """Filaments on a surface, each with its own parameters. NumPy in, NumPy out; no files.

    surface: from ``surfaces.make``. position, direction [rod, 3]: middle node (or ``at = "start"``, the first)
    and tangent there, projected to the surface and its tangent plane. geodesic_curvature [rod, node] or a number.
    length, stiffness B (twist, normal bending, geodesic bending), intrinsic σ, drag (ζ∥, ζ⊥, ζr): one for all or
    one a rod. Both ends are free: m3 = 0, (D.59)-(D.61). Lengths, forces and times in units of your choice.
    """

    saved = FILAMENT_VARIABLES

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
        device=None,
    ):
        self.surface, self.nodes, self.count = surface, nodes, len(position)
        self.device = wp.get_device(device)
        self.middle = nodes // 2
        self.length = each_rod(length, self.count)
        self.stiffness = each_rod(stiffness, self.count, 3)
        self.intrinsic = each_rod(intrinsic, self.count, 3)
        self.drag = each_rod(drag, self.count, 3)
        self.time = self._dt = 0.0
        self._allocate()
        self._place(position, direction, geodesic_curvature, 0 if at == "start" else self.middle)
        self._evaluate = Recorded(self._launch_evaluate, self.device)
        self._advance = Recorded(self._launch_advance, self.device)
        self._measure = Recorded(self._launch_measure, self.device)

    def _allocate(self) -> None:
        shape, device = (self.count, self.nodes), self.device
        f, past = bound_rod.Filaments(), bound_frames.History()
        f.spacing = wp.array(self.length / (self.nodes - 1), dtype=wp.float64, device=device)
        for name in ("stiffness", "intrinsic", "drag"):
            setattr(f, name, wp.array(getattr(self, name), dtype=wp.vec3d, device=device))
        f.status = per_rod(self.count, wp.int32, device)
        f.rotation = per_node(*shape, wp.mat33d, device)
        for name in VECTORS:
            setattr(f, name, per_node(*shape, wp.vec3d, device))
        for name in SCALARS:
            setattr(f, name, per_node(*shape, wp.float64, device))
        past.pace = per_rod(1, wp.vec2d, device)
        past.clock = per_rod(1, wp.float64, device)
        past.spin, past.velocity = per_rod(self.count, wp.vec3d, device), per_rod(self.count, wp.vec3d, device)
        past.failed_at = per_rod(self.count, wp.float64, device)
        past.geodesic, past.rate, past.increment = (per_node(*shape, wp.float64, device) for _ in range(3))
        self._f, self._past = f, past
        self._bands = [per_node(*shape, wp.float64, device) for _ in range(5)]
        self._right = per_node(*shape, wp.float64, device)
        self._work = per_node(*shape, wp.vec2d, device)
        self._work1 = per_node(*shape, wp.float64, device)
        self._shear3 = per_node(*shape, wp.float64, device)
        self._out = {name: per_rod(self.count, wp.float64, device) for name in ("energy", "dissipation", "gauss")}
        self._out["energy_density"] = per_node(*shape, wp.float64, device)
        self._out["load"] = per_node(*shape, wp.vec3d, device)
        self._out["residuals"] = per_rod(self.count, wp.vec3d, device)
        self._parameters = self.surface.device_parameters(device)
        self._on_surface = bound_frames.on_surface(self.surface.field)

    def _place(self, position, direction, geodesic_curvature, node: int) -> None:
        """The frame at one node from what the user gave, then the others outwards."""
        shape, f = (self.count, self.nodes), self._f
        turn = np.broadcast_to(np.asarray(geodesic_curvature, dtype=float), shape).copy()
        turn[:, [0, -1]] = self.intrinsic[:, 2:3]  # a free end has m3 = 0 (D.59)
        r, R = np.zeros((*shape, 3)), np.zeros((*shape, 3, 3))
        r[:, node] = position
        R[:, node, :, 0] = direction
        f.geodesic.assign(turn)
        f.position.assign(r)
        f.rotation.assign(R)
        self._past.geodesic.assign(turn)
        self._launch(self._on_surface.place, self.count, f, self._parameters, node)
        self._launch(self._on_surface.rebuild, (self.count, 2), f, self._parameters, node)

    def _launch(self, kernel, dim, *inputs) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def _launch_evaluate(self) -> None:
        """Velocities and rates of the present shape under the present forces."""
        f, grid = self._f, (self.count, self.nodes)
        lower, diagonal, upper = self._bands[:3]
        self._launch(bound_rod.moments, grid, f)
        self._launch(bound_rod.transverse_loads, grid, f)
        self._launch(bound_rod.tangential_rows, grid, f)
        self._launch(bound_rod.tension_rows, grid, f, lower, diagonal, upper, self._right)
        self._launch(solve_tridiagonal, self.count, lower, diagonal, upper, self._right, self._work1, f.tension)
        self._launch(bound_rod.velocities_along, grid, f)
        self._launch(bound_rod.velocities_across, grid, f)
        self._launch(bound_rod.rates, grid, f)

    def _launch_advance(self) -> None:
        """One step of what ``evaluate`` left."""
        f, past, grid, surface = self._f, self._past, (self.count, self.nodes), self._on_surface
        self._launch(bound_rod.bending_rows, grid, f, past.pace, *self._bands)
        self._launch(bound_frames.increment_right_hand_side, grid, f, past)
        self._launch(solve_pentadiagonal, self.count, *self._bands, past.increment, self._work, past.increment)
        self._launch(bound_frames.judge, self.count, f, past, self.middle)
        self._launch(surface.advance_middle, self.count, f, past, self._parameters, self.middle)
        self._launch(bound_frames.advance_geodesic, grid, f, past)
        self._launch(surface.rebuild, (self.count, 2), f, self._parameters, self.middle)
        self._launch(bound_frames.tick, 1, past)

    def _launch_measure(self) -> None:
        """What only a saved frame needs, of the state that ``evaluate`` left."""
        f, out, grid = self._f, self._out, (self.count, self.nodes)
        self._launch(
            bound_rod.energies, self.count, f, out["energy_density"], out["energy"], out["dissipation"]
        )
        self._launch(bound_load.normal_shears, grid, f, self._shear3)
        self._launch(bound_load.membrane_loads, grid, f, self._shear3, out["load"])
        self._launch(bound_load.midpoint_gauss, self.count, f, self.middle, out["gauss"])
        self._launch(self._on_surface.residuals, self.count, f, self._parameters, out["residuals"])

    def step(self, dt: float, steps: int = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order (SBDF2, AB2-Magnus).

        A change of ``dt`` keeps the order: the coefficients follow the ratio of the steps.
        """
        self.set_step(dt)
        for _ in range(steps):
            self._evaluate()
            self._advance()
            self.time += dt

    def set_step(self, dt: float) -> None:
        """Make ``dt`` the length of the steps to come."""
        if dt != self._dt:
            self._past.pace.assign([[dt, dt / self._dt if self.time else 0.0]])
            self._dt = dt

    def evaluate(self) -> None:
        """Make tension, velocities and rates those of the present shape and force."""
        self._evaluate()

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
    def force(self) -> np.ndarray:
        """External force per length in space [rod, node, 3], yours to set."""
        return to_host(self._f.force)

    @force.setter
    def force(self, value: np.ndarray) -> None:
        self._f.force.assign(np.ascontiguousarray(np.broadcast_to(value, (self.count, self.nodes, 3)), dtype=float))

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

    @property
    def orientation(self) -> np.ndarray:
        """Directors as quaternions x, y, z, w [rod, node, 4]."""
        return Rotation.from_matrix(self.rotation.reshape(-1, 3, 3)).as_quat().reshape(self.count, self.nodes, 4)

    def variables(self) -> dict[str, np.ndarray]:
        """The present state as the trajectory keeps it: names and shapes of ``saved``, without the steric energy."""
        f, out = self._f, self._out
        self._evaluate()
        self._measure()
        constraint, orthogonality, arc_length = to_host(out["residuals"]).T
        return {
            "position": self.position,
            "strain": self.strain,
            "orientation": self.orientation,
            "tension": to_host(f.tension),
            "energy_density": to_host(out["energy_density"]),
            "energy": to_host(out["energy"]),
            "dissipation": to_host(out["dissipation"]),
            "status": self.status,
            "gauss": to_host(out["gauss"]),
            "load": to_host(out["load"]),
            "constraint": constraint,
            "orthogonality": orthogonality,
            "arc_length": arc_length,
        }

    def static(self) -> dict[str, np.ndarray]:
        """What the trajectory keeps once: names of ``variables.STATIC``."""
        return {"length": self.length}

    def state(self) -> dict[str, np.ndarray]:
        """All that the next step depends on; ``restore`` goes on from it to the same bits."""
        arrays = {name: to_host(getattr(self._f, name)) for name in STATE}
        arrays |= {f"past_{name}": to_host(getattr(self._past, name)) for name in HISTORY}
        return {**arrays, "time": np.array(self.time)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go back to a ``state`` of an ensemble of the same shape and parameters."""
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
        names = ("length", "stiffness", "intrinsic", "drag")
        return {name: getattr(self, name)[rod].tolist() for name in names}
