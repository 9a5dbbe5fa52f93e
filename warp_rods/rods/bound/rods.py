"""An ensemble of filaments bound to one surface (docs/model.md §3; thesis chapter 5)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.bound import growth as growing
from warp_rods.rods.bound.arrays import allocate
from warp_rods.rods.bound.checks import check, geodesic_curvatures, parameters_of, rows_of_three
from warp_rods.rods.bound.launches import BoundLaunches
from warp_rods.rods.bound.refinement import refined_state
from warp_rods.rods.ensemble import Ensemble, Parameter, Reading
from warp_rods.rods.variables import FILAMENT_VARIABLES

STATE = ("geodesic", "curvature", "rotation", "position", "status", "spacing", "growth_rate", "force")
HISTORY = ("geodesic", "rate", "spin", "velocity", "failed_at")


class BoundRods(Ensemble):
    """Filaments on a surface, each with its own parameters. NumPy in, NumPy out; no files.

    surface: from ``surfaces.make``; on one that moves ends are free. position, direction [rod, 3] at t = 0: middle
    node (or ``at = "start"``, the first) and tangent there, projected to the surface and its tangent plane.
    geodesic_curvature [rod, node] or a number. length, stiffness B (twist, normal bending, geodesic bending),
    intrinsic σ, drag (ζ∥, ζ⊥, ζr): one for all or one a rod. ends: "free" (D.59-D.61) or "clamped" for the first and
    last node. growth: see ``growth.knots``; tips grow, a clamped end stays; nodes stay at fixed shares of the length.
    Lengths, forces, times in units of your choice.
    Raises SceneError naming the parameter for impossible values, fewer than 9 nodes, a direction that is normal to
    the surface.
    """

    saved = FILAMENT_VARIABLES

    length = Parameter("Length at the start [rod].")
    stiffness = Parameter("B of twist, normal and geodesic bending [rod, 3].")
    intrinsic = Parameter("σ, the strains without elastic energy [rod, 3].")
    drag = Parameter("ζ∥, ζ⊥, ζr [rod, 3].")

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
        growth: Mapping[str, Any] | None = None,
        device=None,
    ):
        position = rows_of_three("position", position)
        direction = rows_of_three("direction", direction, len(position))
        given = {"length": length, "stiffness": stiffness, "intrinsic": intrinsic, "drag": drag}
        super().__init__(len(position), nodes, parameters_of(given, len(position)), device)
        self.surface = surface
        check(self, position, direction, at, ends, growth)
        self.clamped = (ends[0] == "clamped", ends[1] == "clamped")
        self.largest_spacing = np.inf if growth is None else growth.get("spacing") or np.inf
        self.growth = growing.knots(growth, self.length)
        self._saved_nodes = nodes
        turn = geodesic_curvatures(geodesic_curvature, self.count, nodes)
        with exclusive:
            self._allocate()
            self._place(position, direction, turn, 0 if at == "start" else self.middle)

    @property
    def middle(self) -> int:
        """The number of the middle node."""
        return self.nodes // 2

    def _allocate(self) -> None:
        self._arrays = allocate(
            self._parameters, self.nodes, self.clamped, self.growth, self.surface.moving, self.device
        )
        self._f, self._past = self._arrays.f, self._arrays.past
        self._run = BoundLaunches(self._arrays, self.surface, self._clock)

    def _place(self, position: np.ndarray, direction: np.ndarray, turn: np.ndarray, node: int) -> None:
        """The frame at one node from what the user gave, then the others outwards."""
        shape, f = (self.count, self.nodes), self._f
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

    # --- steps ------------------------------------------------------------------------------------------------------

    def prepare_step(self, dt: float) -> None:
        """Refine rods that would grow too coarse, and let the step see the membrane as it is now."""
        if self.largest_spacing < np.inf:
            while (growing.length_at(self.growth, self.time + dt) / (self.nodes - 1) > self.largest_spacing).any():
                self.refine()
        self._run.membrane_at(self.time)

    def take_step(self) -> None:
        """Launch one step as long as ``set_step`` said."""
        self._run.advance(self.time + self._clock.step)

    @property
    def recordable(self) -> bool:
        """A step is kernels alone, unless it may refine the rods, the membrane moves, or threads share it."""
        return self.largest_spacing == np.inf and not self.surface.moving and self._run.threads == 1

    @property
    def threads(self) -> int:
        """How many threads share a step."""
        return self._run.threads

    @property
    def version(self) -> object:
        """Another object once device arrays were replaced."""
        return self._run.version

    def refine(self) -> None:
        """Put a node between each two; the next steps keep their order."""
        state = refined_state(self.state(), self.largest_spacing)
        self.restore(state)
        with exclusive:
            self._run.membrane_at(self.time)
            self._run.place(self._f.anchor)

    def evaluate(self) -> None:
        """Make tension, velocities and rates those of the present shape, force and membrane."""
        self._run.membrane_at(self.time)
        self._run.evaluate()

    # --- what contact needs -----------------------------------------------------------------------------------------

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node]."""
        return self._f.position

    @property
    def force_array(self) -> wp.array:
        """External force per length on the device [rod, node], in space."""
        return self._f.force

    @property
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]."""
        return self._f.spacing

    @property
    def transverse_drag(self) -> np.ndarray:
        """ζ⊥ [rod]."""
        return self.drag[:, 1]

    # --- readings ---------------------------------------------------------------------------------------------------

    @property
    def stride(self) -> int:
        """A refined ensemble is saved at the nodes that it began with."""
        return (self.nodes - 1) // (self._saved_nodes - 1)

    def _balance(self) -> None:
        self.evaluate()
        self._run.measure()

    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""
        f, out = self._f, self._arrays.out
        present = {"position": f.position, "rotation": f.rotation, "curvature": f.curvature, "status": f.status}
        balanced = {name: out[name] for name in ("orientation", "energy_density", "energy", "dissipation", "gauss")}
        balanced |= {name: out[name] for name in ("growth_power", "membrane_power", "load", "load_moment")}
        balanced |= {"tension": f.tension, "geodesic_rate": f.rate}
        found = {name: Reading(_up_to_date, partial(to_host, array)) for name, array in present.items()}
        found |= {name: Reading(self._balance, partial(to_host, array)) for name, array in balanced.items()}
        found["strain"] = Reading(_up_to_date, self._strain)
        found["length"] = Reading(_up_to_date, lambda: to_host(f.spacing) * (self.nodes - 1))
        found["power"] = Reading(self._balance, self._power)
        for column, name in enumerate(("constraint", "orthogonality", "arc_length")):
            found[name] = Reading(self._balance, partial(self._residual, column))
        return found

    def _residual(self, column: int) -> np.ndarray:
        """Worst |φ|/|∇φ|, |q·n| or relative error of a segment's length of each rod [rod]."""
        return to_host(self._arrays.out["residuals"])[:, column]

    def _strain(self) -> np.ndarray:
        """Twist, normal and geodesic bending (K12, −K11, Ω) (5.17), (5.18)."""
        K = to_host(self._f.curvature)
        return np.stack([K[..., 1], -K[..., 0], to_host(self._f.geodesic)], axis=-1)

    def _power(self) -> np.ndarray:
        """What growth, a moving membrane and the external force bring in."""
        out = self._arrays.out
        return to_host(out["growth_power"]) + to_host(out["membrane_power"]) + to_host(out["force_power"])

    @property
    def rotation(self) -> np.ndarray:
        """Directors as columns (q, n×q, n) [rod, node, 3, 3]."""
        return self.reading("rotation")

    @property
    def curvature(self) -> np.ndarray:
        """K11, K12, K22 [rod, node, 3] of the surface in the pair (q, n×q)."""
        return self.reading("curvature")

    @property
    def failed_at(self) -> np.ndarray:
        """When each rod was frozen [rod]; without meaning for a sound one."""
        with exclusive:
            return to_host(self._past.failed_at)

    def static(self) -> dict[str, np.ndarray]:
        """What the trajectory keeps once [rod, 3]: not the length, as filaments may grow."""
        return {"stiffness": self.stiffness, "intrinsic": self.intrinsic}

    # --- state ------------------------------------------------------------------------------------------------------

    def arrays_of_state(self) -> dict[str, wp.array]:
        """Every device array that the next step depends on."""
        arrays = {name: getattr(self._f, name) for name in STATE}
        return arrays | {f"past_{name}": getattr(self._past, name) for name in HISTORY}

    def make_room(self, state: Mapping[str, np.ndarray]) -> None:
        """Arrays of as many nodes as the state has, which a refinement may have changed."""
        nodes = state["geodesic"].shape[1]
        if nodes != self.nodes:
            self.nodes = nodes
            self._allocate()


def _up_to_date() -> None:
    """Arrays of the state are present at any moment."""
