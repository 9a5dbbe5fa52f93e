"""An ensemble of extensible and shearable rods (docs/model.md §10; dissertation, (3.63) to (3.79))."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.device import exclusive
from warp_rods.errors import SceneError
from warp_rods.kernels.cosserat.equal_steps import lay_out
from warp_rods.kernels.lanes import Screw
from warp_rods.kernels.layout import to_host
from warp_rods.rods.cosserat.arrays import FRAMES, PAST, allocate
from warp_rods.rods.cosserat.checks import (
    FEWEST_NODES,
    STRAIGHT,
    between_nodes,
    check_strain,
    held,
    initial_strain,
    natural_strains,
    stiffness_matrices,
)
from warp_rods.rods.cosserat.launches import CosseratLaunches
from warp_rods.rods.cosserat.readings import CosseratReadings
from warp_rods.rods.ensemble import Ensemble, Fixed, Parameter
from warp_rods.rods.modes import beam_root
from warp_rods.rods.pace import PACE, restart_pace
from warp_rods.rods.per_rod import frames, parameter, vectors
from warp_rods.rods.tiles import Tiled, tiled
from warp_rods.rods.variables import COSSERAT_VARIABLES

FIRST_STEP = 1e-6
"""The first step that rods try, in units of ζ∥L/f*."""


class CosseratRods(CosseratReadings, Ensemble):
    """Rods that stretch, shear, bend and twist, each with its own parameters. NumPy in, NumPy out; no files.

    Quantities are dimensionless as in docs/model.md §1.2, with the length at rest of a rod of U0 = (1, 0, 0) as L. The
    energy per length is ½ (ξ − ξ0)ᵀ K (ξ − ξ0) of the strains ξ = (Ω, U): twist, two bendings; stretch, two shears.

    stiffness K: its diagonal [6] or [rod, 6], or symmetric positive definite matrices [1, 6, 6] or [rod, 6, 6].
    natural ξ0: [6], or values that broadcast to [rod, node, 6]. drag_ratio η, rotational_drag ηr: one number for all
    rods or one for each; drag is per length at rest, in the directors. shape: a table as in a scene, or strains that
    broadcast to [rod, node, 6]; None: at rest. ends: "free", "hinged" (its place is held) or "clamped" (its frame is).
    position [rod, 3], rotation [rod, 3, 3]: the frame at the start of the middle node, or of the first one (at =
    "start"). ``force`` and ``couple`` per length, in space, can be set.

    Raises SceneError naming the parameter for fewer than 5 nodes, and for impossible values or shapes.
    """

    saved = COSSERAT_VARIABLES
    step_tolerance = 2e-3
    _launches: CosseratLaunches

    stiffness = Parameter("Stiffness K [rod, 6, 6].")
    drag_ratio = Parameter("Drag ratio η = ζ⊥/ζ∥ [rod].")
    rotational_drag = Parameter("Rotational drag ηr [rod].")
    natural = Fixed[np.ndarray]("Natural strain ξ0 [rod, node, 6].")
    ends = Fixed[tuple[str, str]]("What holds both ends.")

    def __init__(
        self,
        count: int,
        nodes: int = 65,
        *,
        stiffness: Any,
        natural: Any = STRAIGHT,
        drag_ratio: Any = 2.0,
        rotational_drag: Any = 3e-3,
        shape: Any = None,
        ends: Any = ("free", "free"),
        position: Any = (0.0, 0.0, 0.0),
        rotation: Any = np.eye(3),  # noqa: B008 (never changed)
        at: str = "middle",
        device: Any = None,
    ):
        count, nodes = arguments.whole("count", count), arguments.whole("nodes", nodes, FEWEST_NODES)
        if at not in ("middle", "start"):
            raise arguments.wrong("at", at, "one of middle, start")
        parameters = {"stiffness": stiffness_matrices(stiffness, count)}
        parameters["drag_ratio"] = parameter("drag_ratio", drag_ratio, count)
        parameters["rotational_drag"] = parameter("rotational_drag", rotational_drag, count)
        rest, may_not = natural_strains(natural, count, nodes), held(ends)
        strain = between_nodes(initial_strain(shape, rest))
        check_strain(strain)
        places = parameter("position", position, count, (arguments.ANY,) * 3)
        first = frames(rotation, count)
        rest.setflags(write=False)
        super().__init__(count, nodes, parameters, device, natural=rest, ends=tuple(ends))
        with exclusive:
            drag = (self.drag_ratio, self.rotational_drag)
            may_not = np.broadcast_to(may_not, (count, 2, 6))
            self._arrays = allocate(self.stiffness, between_nodes(rest), drag, may_not, self.device)
            self._place(strain, places, first, 0 if at == "start" else nodes // 2)
            self._launches = CosseratLaunches(self._arrays, self._clock)
        self._settled = False

    def _place(self, strain: np.ndarray, position: np.ndarray, rotation: np.ndarray, node: int) -> None:
        """Lay out the frames at the start from that of a node."""
        a, every = self._arrays, (self.count, self.nodes)
        Tiled(a.now.position, self.count).assign(np.broadcast_to(position[:, None], (*every, 3)))
        Tiled(a.now.rotation, self.count).assign(np.broadcast_to(rotation.reshape(-1, 1, 9), (*every, 9)))
        inputs = [a.rods, tiled(strain, Screw, self.device), node, a.now]
        wp.launch(lay_out, dim=a.now.position.shape[0], inputs=inputs, device=self.device)
        a.pace.step.fill_(FIRST_STEP)

    # --- steps --------------------------------------------------------------------------------------------------------

    def prepare_step(self, dt: float) -> bool:
        """Before a first step let the directors settle: moments across balance at once, as they have no drag."""
        if not self._settled:
            self._launches.settle()
            self._settled = True
        return False

    def predict_step(self) -> None:
        """Extrapolate to the end of the step."""
        self._launches.predict()

    @property
    def _step_error(self) -> wp.array:
        """Error of the step tried [rod]: of bending and twist, and of places."""
        return self._arrays.trial.error

    def finish_step(self) -> None:
        """Advance the time on the host."""
        super().finish_step()
        self._launches.show_at(self.time)

    def show_at(self, time: float) -> None:
        """Make ``time``, readings and positions those of a time within the last step."""
        super().show_at(time)
        self._launches.show_at(time)

    def show(self) -> None:
        """Put ``position_array`` at the present state."""
        self._launches.find_frames()

    def gather(self) -> None:
        """Begin anew from the present state, with no past."""
        a = self._arrays
        with exclusive:
            self._launches.find_frames()
            for name in FRAMES:
                wp.copy(getattr(a.now, name), getattr(a.shown, name))
            for name in PAST:
                getattr(a.past, name).zero_()
            wp.copy(a.past.stress_before, a.now.stress)
            restart_pace(a.pace, self.time)
        self._settled = False

    @property
    def pace_arrays(self) -> Any:
        """``Pace`` on the device."""
        return self._arrays.pace

    @property
    def first_step(self) -> float:
        """The first step that the rods try."""
        return FIRST_STEP

    @property
    def natural_time(self) -> float:
        """The shortest time in which bending relaxes, η/501 b."""
        stiffest = self.stiffness[:, (1, 2), (1, 2)].max(axis=1)
        return float(np.min(self.drag_ratio / (beam_root(0) ** 4 * stiffest)))

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._launches.threads

    # --- what acts ----------------------------------------------------------------------------------------------------

    @property
    def couple(self) -> np.ndarray:
        """External couple per length in space [rod, node, 3]. Set it to one vector, or one for each node."""
        with exclusive:
            return to_host(self._arrays.rods.couple)

    @couple.setter
    def couple(self, value: Any) -> None:
        try:
            given = vectors(value, self.count, self.nodes)
        except SceneError as error:
            raise SceneError(str(error).replace("force", "couple")) from None
        if self.time < self.reached:  # steps by error have gone beyond the time from which this couple acts
            self.bring_together()
        with exclusive:
            self._arrays.rods.couple.assign(given)

    @property
    def force_array(self) -> wp.array:
        """External force per length in space on the device [rod, node]."""
        return self._arrays.rods.force

    @property
    def contact_stiffness_array(self) -> wp.array:
        """K of contact in space on the device [rod, node] (3, 3); allocated by the first call."""
        if not self._arrays.rods.touched:
            with exclusive:
                self._launches.enable_contact()
        return self._arrays.rods.contact_stiffness

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node], where the last step or ``show`` has put it."""
        return self._arrays.position

    @property
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]."""
        return self._arrays.spacing

    @property
    def status_array(self) -> wp.array:
        """``Status`` on the device [rod]."""
        return self._arrays.rods.status

    @property
    def failed_at(self) -> np.ndarray:
        """The time at which each rod was frozen [rod]; meaningless for the others."""
        with exclusive:
            return to_host(self._arrays.failed_at)

    # --- state --------------------------------------------------------------------------------------------------------

    def static(self) -> dict[str, np.ndarray]:
        """What a trajectory saves once: names of ``variables.STATIC``."""
        own = {"drag_ratio": self.drag_ratio, "rotational_drag": self.rotational_drag, "natural_strain": self.natural}
        return {"length": np.ones(self.count), "stiffness_matrix": self.stiffness.reshape(-1, 36), **own}

    def _settings(self, rod: int) -> dict[str, Any]:
        natural = self.natural[rod]
        uniform = (natural == natural[0]).all()
        return {"natural": natural[0].tolist() if uniform else "varies along the rod", "ends": list(self.ends)}

    def arrays_of_state(self) -> dict[str, wp.array | Tiled]:
        """Every device array that the next step depends on."""
        a = self._arrays
        arrays: dict[str, wp.array | Tiled] = {name: Tiled(getattr(a.now, name), self.count) for name in FRAMES}
        arrays |= {name: Tiled(getattr(a.past, name), self.count) for name in PAST}
        arrays |= {f"pace_{name}": getattr(a.pace, name) for name in PACE}
        return arrays | {"couple": a.rods.couple, "status": a.rods.status, "failed_at": a.failed_at}

    def restore(self, state: Any) -> None:
        """Return to a ``state`` of an ensemble with the same parameters."""
        super().restore(state)
        self._settled = bool((state["pace_levels"] > 1).any())
        self._launches.show_at(self.time)
        self._launches.find_frames()
