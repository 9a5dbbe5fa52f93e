"""An ensemble of free active Kirchhoff rods (docs/model.md §2; dissertation, chapter 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.device import exclusive
from warp_rods.errors import SceneError
from warp_rods.kernels.free.load import force_field
from warp_rods.kernels.free.state import CARRIED_APART
from warp_rods.kernels.layout import to_host
from warp_rods.rods.along import Along, at_half_nodes, at_nodes, product
from warp_rods.rods.changes import Changes, Sampled
from warp_rods.rods.ensemble import Ensemble, Failure, Fixed, Parameter
from warp_rods.rods.free.arrays import (
    CARRIER,
    PAST,
    SHAPE,
    allocate,
    allocate_couple,
    allocate_natural,
    carried_alike,
    put_down,
    set_carrier,
    set_ends,
)
from warp_rods.rods.free.behaviour import Behaviours, behaviours_of, drag_of_turning, seed_and_streams, turning
from warp_rods.rods.free.checks import (
    along_rods,
    check_nodes,
    check_symmetry,
    parameters_of,
    symmetric_starts,
)
from warp_rods.rods.free.ends import End, ends_of, needs_places
from warp_rods.rods.free.flagella import Flagella, odd_targets
from warp_rods.rods.free.holding import Holding, places_of_ends
from warp_rods.rods.free.launches import FreeLaunches
from warp_rods.rods.free.natural import Natural
from warp_rods.rods.free.readings import FreeReadings
from warp_rods.rods.free.shapes import from_node, initial_strain
from warp_rods.rods.modes import beam_root
from warp_rods.rods.outside import Outside
from warp_rods.rods.pace import PACE, restart_pace
from warp_rods.rods.per_rod import each_rod, frames, named_numbers, parameter, vectors
from warp_rods.rods.tiles import Tiled
from warp_rods.rods.variables import SWIMMER_VARIABLES, variables_of_behaviours
from warp_rods.scene.flagella import ODD_TARGET, WITHOUT_BEHAVIOUR

FRAME = ("rotation", "position", "angle")
MIDPOINT = (*FRAME, "angular_velocity", "velocity", "roll_rate")
BEFORE = ("rotation_before", "position_before", "angle_before")
CONTACT_STATE = {"contact_velocity": "velocity", "contact_lag": "lag"}
"""Name in a state → array of contact; see ``kernels/free/load.py``."""
STIFF_IN_TWIST = 10.0
"""β∥/β⊥ above which order 4 is less stable than order 3."""
ALMOST_STRAIGHT = 0.999
STRAIGHT = (
    ": its ends are held {:.6g} apart, and it is 1 long; a rod between two held ends cannot be stretched, and one that "
    "is straight cannot be brought together: begin with a little bend, and stay below its length"
)
"""What is said of a rod that fails where its ends are this far apart."""
FIRST_STEP = 1e-6
"""The first step that a rod tries, in units of ζ∥L/f*."""


def highest_order(bend: np.ndarray, twist: np.ndarray, planar: np.ndarray) -> np.ndarray:
    """The highest order of each rod: 3 where twist is much stiffer than bending, unless there is none.

    Bending and twist are each implicit in their own equation only.
    """
    return np.where((twist > STIFF_IN_TWIST * bend) & ~planar, 3, 4).astype(np.int32)


def _check_symmetric(ends: tuple[End, End], behaves: bool, odd: np.ndarray) -> None:
    """Raises SceneError for rods that would lose the symmetry that is imposed; odd: targets of the flagella [rod]."""
    if not (ends[0].plain and ends[1].plain):
        raise SceneError("symmetric = true: the ends must be free and without loads")
    if behaves:
        raise SceneError(f"symmetric = true: {WITHOUT_BEHAVIOUR}")
    if not odd.all():
        raise SceneError(f"symmetric = true: {ODD_TARGET}")


class FreeRods(FreeReadings, Ensemble):
    """Active rods, each with its own parameters. NumPy in, NumPy out; no files.

    Quantities are dimensionless as in docs/model.md §1.2: length L, velocity f*/ζ∥, time ζ∥L/f*. One number for all
    rods or one for each: bend β⊥ and twist β∥, which are stiffnesses and not strains, as in a scene; moment M,
    drag_ratio η, rotational_drag ηr. Stiffnesses and drags, also drag_along ζ∥, may change along the rod: values
    [rod, node], or a formula in s (−1/2 to 1/2), such as "1e-3*(1 + s)"; and so may natural_bend, the natural Ω[2] of
    the material (or a dict of ``second`` and ``third``, Ω[1] and Ω[2]), and natural_twist, whose formulas may have t,
    too. ends: two of "free", "hinged", "clamped", or of dicts {kind, thrust, torque, force, couple, turning, motion,
    rotation} (docs/model.md §2.11); positions and frames are then those of a held end.

    flagella: ``Flagella``, a mapping with its fields, or None for passive rods. shape: a table as in a scene, or
    strains [rod, node, 3] of the material frame, twist first; they are set to 0 at the ends, which are free. behaviour:
    what rods with the law ``driven`` do at random times, ``{"reversal": {"rate": 0.5}, "tumble": {"rate": 1, …}}``; its
    random numbers follow from the seed (0 to 2^64 − 1), or seeds [rod], and streams [rod], by default 0, 1, ….
    position [rod, 3], rotation [rod, 3, 3]: the material frame of the middle node at the start. symmetric: impose the
    π-rotation symmetry of appendix C.4, for rods that start with it in the gauge of (C.49). external: force per
    length in space, a function ``(t, position [rod, node, 3], rotation [rod, node, 3, 3]) -> [rod, node, 3]`` or a
    ``wp.func`` ``(x, tangent, t) -> vec3d``; the columns of rotation are the directors of the Bishop frame, tangent
    first. It is evaluated at the extrapolated end of every step, and at every reading; a rod for which it is not
    finite is frozen. couple: a couple per length about the tangent: a number, one for each rod, values [rod, node],
    or a formula in s and t. parameters: numbers by name, one for all rods or one for each, which may stand in
    formulas of the shape, along the rods and of the ends: ``parameters={"k": [6.0, 7.0]}``. flow, gravity, forces: as
    the tables of a scene, ``{"kind": "shear", "rate": 1.0}``, a force per length (one vector or one for each rod),
    ``[{"force": ["sin(x)", 0, 0], "couple": …}]``.

    Raises SceneError naming the parameter for even nodes or fewer than 17, and for impossible values or shapes.
    """

    saved = SWIMMER_VARIABLES
    step_tolerance = 1e-2
    _launches: FreeLaunches

    bend = Parameter("Bending stiffness β⊥ [rod]; the same as ``bending_stiffness``.")
    twist = Parameter(
        "Twist stiffness β∥ [rod]; the same as ``twist_stiffness``. The twist itself is ``strain[..., 0]``."
    )
    bending_stiffness = Parameter("Bending stiffness β⊥ [rod], as trajectories name it.", of="bend")
    twist_stiffness = Parameter("Twist stiffness β∥ [rod], as trajectories name it.", of="twist")
    moment = Parameter("Active moment M [rod].")
    drag_ratio = Parameter("Drag ratio η = ζ⊥/ζ∥ [rod].")
    drag_along = Parameter("Drag along ζ∥ [rod], in units of that by which quantities are made dimensionless.")
    rotational_drag = Parameter("Rotational drag ηr [rod].")
    natural_bend = Fixed[np.ndarray]("Natural bending strains [rod, node, 2] at the present time.")
    natural_twist = Fixed[np.ndarray]("Natural twist [rod, node].")
    ends = Fixed[tuple[End, End]]("What holds or loads the first and the last end.")
    relaxation = Parameter("Relaxation time τf of the flagella [rod].")
    diffusion = Parameter("Diffusion D of the flagellar field [rod]; 0 for a law without diffusion.")
    flagella = Fixed[Flagella]("The flagella: profile at the start, activity law and its parameters.")
    behaviour = Fixed[Mapping[str, Mapping[str, Any]]]("What the rods do at random times, with its parameters.")
    symmetric = Fixed[bool]("Whether the symmetry under rotation by π is imposed.")

    def __init__(
        self,
        count: int,
        nodes: int = 65,
        *,
        bend: Any,
        twist: Any,
        moment: Any = 0.0,
        drag_ratio: Any = 2.0,
        drag_along: Any = 1.0,
        rotational_drag: Any = 3e-3,
        natural_bend: Any = 0.0,
        natural_twist: Any = 0.0,
        ends: Any = None,
        flagella: Flagella | Mapping[str, Any] | None = Flagella(),  # noqa: B008 (frozen)
        behaviour: Mapping[str, Mapping[str, Any]] | None = None,
        seed: Any = 0,
        streams: Any = None,
        shape: Any = None,
        couple: Any = 0.0,
        parameters: Mapping[str, Any] | None = None,
        flow: Any = None,
        gravity: Any = None,
        forces: Any = None,
        symmetric: bool = False,
        device: Any = None,
        external: Callable | None = None,
        position: Any = (0.0, 0.0, 0.0),
        rotation: Any = np.eye(3),  # noqa: B008 (never changed)
    ):
        count, nodes = check_nodes(count, nodes)
        read, symmetric = Flagella.read(flagella), arguments.truth("symmetric", symmetric)
        given = {"bend": bend, "twist": twist, "drag_ratio": drag_ratio, "drag_along": drag_along}
        named = named_numbers(parameters, count)
        values = along_rods(given | {"rotational_drag": rotational_drag}, count, nodes, named)
        values |= parameters_of({"moment": moment}, count)
        own = {"relaxation": read.relaxation, "diffusion": read.effective_diffusion}
        values |= parameters_of(own, count, "flagella.")
        if external is not None and not isinstance(external, wp.Function):
            arguments.function("external", external, 3, "a function (t, position, rotation), a wp.func, or None")
        held = ends_of(ends, count, named)
        behaviours = behaviours_of(behaviour, count, read)
        if symmetric:
            _check_symmetric(held, bool(behaviours), odd_targets(read, count))
        random = seed_and_streams(seed, streams, count)
        natural = Natural(natural_bend, natural_twist, count, nodes, named)
        turned = Along("couple", couple, count, nodes, arguments.ANY, in_time=True, named=named)
        outside = Outside(flow, gravity, forces, count)
        fixed = {"flagella": read, "symmetric": symmetric, "ends": held, "behaviour": behaviours}
        fixed |= {"natural_bend": natural.bending, "natural_twist": natural.twist}
        super().__init__(count, nodes, values, device, **fixed)
        self.saved = SWIMMER_VARIABLES | variables_of_behaviours(behaviours)
        law, law_parameters = self.flagella.law_index, self.flagella.law_parameters(count)
        with exclusive:
            self._arrays = allocate(self._parameters, nodes, law, law_parameters, self.symmetric, self.device)
            self._natural = natural
            if natural.any:
                allocate_natural(self._arrays, natural)
            set_ends(self._arrays, *held)
            self._couple = turned
            if self._turned:
                self._enable_couple()
            place = parameter("position", position, count, (arguments.ANY,) * 3)
            self._place(shape, place, frames(rotation, count), named)
            self._behaviours: Behaviours | None = None
            if behaviours:
                drag = drag_of_turning(product(self.drag_along, self.drag_ratio), nodes)
                self._behaviours = Behaviours(behaviours, self._arrays, law_parameters, drag, *random)
            self._launches = FreeLaunches(self._arrays, self._clock)
            self._holding: Holding | None = None
            if needs_places(*held):
                self._hold(held)
            self._outside = outside if outside.flows or outside.pushes else None
            if self._outside is not None:
                self._expose(self._outside)
            self._external: Callable | None = None
            if external is not None:
                self._use(external)

    def _hold(self, ends: tuple[End, End]) -> None:
        """Hold ends at the places and directions that they have now, or load them in space."""
        self._enable_forces()
        self._launches.enable_hold()
        twist, a = Tiled(self._arrays.now.twist, self.count).numpy(), self._arrays
        angles = from_node(twist, a.rods.tracked)[:, [0, -1]]
        place, frame = places_of_ends(a, angles)
        self._bend_ends(ends, frame)
        self._holding = Holding(ends, a, place, frame)

    def _bend_ends(self, ends: tuple[End, End], frame: np.ndarray) -> None:
        """Give ends with couples in space the strain that these demand; frame [rod, end, 3, 3]: of the material."""
        bending, twist = (Tiled(field, self.count) for field in (self._arrays.now.bending, self._arrays.now.twist))
        k, tau = bending.numpy(), twist.numpy()
        turn = from_node(tau, self._arrays.rods.tracked)
        for node, end, side in ((0, ends[0], -1.0), (-1, ends[1], 1.0)):
            if not end.couple.any():
                continue
            couple = side * np.einsum("rji,rj->ri", frame[:, node], end.couple)
            stiff, soft = (v if v.ndim == 1 else v[:, node] for v in (self.twist, self.bend))
            across = (couple[:, 1] + 1j * couple[:, 2]) * np.exp(1j * turn[:, node]) / soft
            k[:, node, 0] += across.real
            k[:, node, 1] += across.imag
            tau[:, node] += couple[:, 0] / stiff
        bending.assign(k)
        twist.assign(tau)

    @property
    def _turned(self) -> bool:
        """Whether rods have a couple per length of their own."""
        return self._couple.varies or bool(self._couple.values.any())

    def _enable_couple(self) -> None:
        if self.symmetric:
            raise SceneError("symmetric = true: a couple could break the symmetry")
        allocate_couple(self._arrays, at_nodes(self._couple.values, self.nodes))

    def _expose(self, outside: Outside) -> None:
        """Let a flow, gravity and forces act; a uniform flow carries free rods, and does nothing else."""
        held = self.ends[0].held or self.ends[1].held
        if outside.uniform is not None and not held:
            set_carrier(self._arrays, carried_alike(outside.uniform))
            outside = outside.without_flow()
        if outside.flows or outside.pushes:
            self._enable_forces()
            self._launches.enable_outside(outside)
        else:
            self._launches.record()

    def _use(self, external: Callable) -> None:
        """Let a function give the external force."""
        is_kernel = isinstance(external, wp.Function)
        self._enable_forces(force_field(external) if is_kernel else None)
        self._external = None if is_kernel else external
        self.reserve_force("external")

    def _place(self, shape: Any, position: np.ndarray, rotation: np.ndarray, named: Mapping[str, np.ndarray]) -> None:
        """Set the state at the start; material and Bishop frame agree at the middle node."""
        clamped = (self.ends[0].kind == "clamped", self.ends[1].kind == "clamped")
        strain = initial_strain(shape, self.nodes, self._parameters, self.flagella, clamped, named)
        self._set_end_strains(strain)
        turn = from_node(strain[..., 0], self._arrays.rods.tracked)
        bishop = (strain[..., 1] + 1j * strain[..., 2]) * np.exp(1j * turn)
        activity = self.flagella.start(np.linspace(-0.5, 0.5, self.nodes), self.count)
        alone = all(end.plain for end in self.ends) and not (self._natural.any or self._turned)
        kept = odd_targets(self.flagella, self.count) & (alone and not turning(self.behaviour))
        self.symmetric_start = symmetric_starts(bishop, strain[..., 0], activity) & kept
        """Whether each rod starts with the symmetry (C.49) up to round-off, and nothing of its own breaks it [rod]."""
        self._passive = self.flagella.law == "held" and not activity.any()
        if self.symmetric:
            check_symmetry(bishop, strain[..., 0], activity)
        now, midpoint = self._arrays.now, self._arrays.midpoint
        Tiled(now.bending, self.count).assign(np.stack([bishop.real, bishop.imag], axis=-1))
        Tiled(now.twist, self.count).assign(strain[..., 0])
        Tiled(now.activity, self.count).assign(activity)
        midpoint.rotation.assign(rotation)
        midpoint.position.assign(position)
        self._arrays.pace.step.fill_(FIRST_STEP)
        in_a_plane = (bishop.imag == 0).all(axis=1) | (bishop.real == 0).all(axis=1)
        turned = self._turned or turning(self.behaviour)
        planar = in_a_plane & (strain[..., 0] == 0).all(axis=1) & (self.moment == 0) & (not turned)
        bend, twist = (v if v.ndim == 1 else v.max(axis=1) for v in (self.bend, self.twist))
        self._arrays.pace.highest_order.assign(highest_order(bend, twist, planar))

    def _set_end_strains(self, strain: np.ndarray) -> None:
        """Ends that are not clamped have their natural strain, but for the twist that a torque demands."""
        for node, end, side in ((0, self.ends[0], -1.0), (-1, self.ends[1], 1.0)):
            if end.kind != "clamped":
                twist = self.twist if self.twist.ndim == 1 else self.twist[:, node]
                strain[:, node, 0] = self.natural_twist[:, node] + side * end.torque / twist
                strain[:, node, 1:] = self.natural_bend[:, node]

    def _enable_forces(self, field: Any = None) -> None:
        if self.symmetric:
            raise SceneError("symmetric = true: an external force could break the symmetry")
        self._launches.enable_forces(field)

    def predict_step(self) -> None:
        """Extrapolate to the end of the step, and evaluate there an external force that a function gives."""
        if self._holding is not None:
            with exclusive:
                self._holding.set_places(self.reached)
                self._holding.set_velocities(self.reached + self._clock.step)
        self._launches.predict()
        self._set_natural(self.reached + self._clock.step)
        self._evaluate_external(self.reached + self._clock.step)

    @property
    def _step_error(self) -> wp.array:
        """Error of the step tried [rod]: of the strains, of f, and under forces of the middle frame."""
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

    @property
    def has_own_steps(self) -> bool:
        """True for rods without external forces whose natural shape and couple do not change in time."""
        return self._arrays.force is None and not (self._natural.varies or self._couple.varies)

    @property
    def changes_in_time(self) -> bool:
        """Whether a natural shape changes in time, or something moves or loads an end."""
        moved = any(end.in_space or end.turning.any() or end.thrust.any() or end.torque.any() for end in self.ends)
        return self._natural.varies or moved

    def _find_changes(self) -> Changes:
        """Motions of ends, natural shapes, couples, flows and forces that change in time."""
        motions = [m for end in self.ends for m in (end.motion, end.rotation) if m is not None]
        formulas: list[Sampled] = [motion.sampled for motion in motions]
        formulas += [part.sampled for part in self._natural.parts]
        if self._couple.varies:
            formulas.append(self._couple.sampled)
        if self._outside is not None:
            formulas += self._outside.sampled(lambda: self.position)
        return Changes(formulas, [m.table for m in motions if m.table is not None])

    def take_own_steps(self, time: float, allowed: float) -> None:
        """Launch steps of each rod until it reaches ``time``; the error of a step is that of the strains and of f.

        No step passes an event of its rod. Those before ``time`` happen, and the rod goes on; a rod that has come to a
        later one waits there, so that ``events`` counts those before ``time``.
        """
        self._launches.advance_past(time, allowed, time)
        while self._behaviours is not None and self._behaviours.find_next() < time:
            self._behaviours.meet(time)
            self._launches.advance_past(time, allowed, time)

    def next_event(self) -> float:
        """The time of the next event of a rod; an event at the time reached happens."""
        return np.inf if self._behaviours is None else self._behaviours.next_event(self.reached)

    @property
    def events(self) -> dict[str, np.ndarray]:
        """The number of events of each behaviour so far [rod]; the beginning and the end of a tumble are two."""
        return {} if self._behaviours is None else self._behaviours.counts

    def gather(self) -> None:
        """Begin anew from the present state, with no past."""
        a = self._arrays
        with exclusive:
            self._launches.find_frames()
            for name in SHAPE:
                wp.copy(getattr(a.now, name), getattr(a.shown, name))
            for name in FRAME:
                wp.copy(getattr(a.midpoint, name), getattr(a.shown_midpoint, name))
            put_down(a, self.time)
            restart_pace(a.pace, self.time)
            if a.contact.present:
                for array in CONTACT_STATE.values():
                    getattr(a.contact, array).zero_()

    @property
    def pace_arrays(self) -> Any:
        """``Pace`` on the device."""
        return self._arrays.pace

    @property
    def first_step(self) -> float:
        """The first step that the rods try, short on every scale of the rods."""
        return FIRST_STEP

    @property
    def natural_time(self) -> float:
        """The shortest of the times of relaxation of the flagella, of bending, η/501 β⊥, and of buckling, 16 β⊥ η."""
        drag = product(self.drag_along, self.drag_ratio)
        times = [drag.min() / (beam_root(0) ** 4 * self.bend.max())]
        if not self._passive:
            times += [self.relaxation.min(), product(16 * self.bend, drag).min()]
        return float(min(times))

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._launches.threads

    def _set_natural(self, time: float) -> None:
        """Let a natural shape and a couple that change in time be those of a time."""
        if self._couple.varies:
            with exclusive:
                Tiled(self._arrays.couple, self.count).assign(at_half_nodes(self._couple.at(time)))
        if self._natural.varies:
            bending, twist = self._natural.at(time)
            with exclusive:
                Tiled(self._arrays.rods.natural_bending, self.count).assign(bending)
                Tiled(self._arrays.rods.natural_twist, self.count).assign(twist)

    def _apply_external(self) -> None:
        self._set_natural(self.time)
        if self._holding is not None:
            with exclusive:
                self._holding.set_velocities(self.time)
                self._holding.forget_drift()
        if self._external is not None:
            with exclusive:
                self._launches.find_frames()
            self._evaluate_external(self.time)

    def _evaluate_external(self, time: float) -> None:
        """Take the force that a Python function, if one was given, has at this time and the places in the arrays."""
        if self._external is None:
            return
        with exclusive:
            position, rotation = to_host(self._arrays.position), to_host(self._arrays.rotation)
        given = self._external(time, position, rotation)
        self._set_force(vectors(given, self.count, self.nodes, finite=False))

    def _read_force(self) -> np.ndarray:
        if self._arrays.force is None:
            return np.zeros((self.count, self.nodes, 3))
        if self._force_from == "external":
            with exclusive:
                self._apply_external()
                self._launches.find_force()
        return super()._read_force()

    @property
    def force_array(self) -> wp.array:
        """External force per length in space on the device [rod, node]; allocated by the first call."""
        with exclusive:
            if self._arrays.force is None:
                self._enable_forces()
        assert self._arrays.force is not None
        return self._arrays.force

    @property
    def contact_stiffness_array(self) -> wp.array:
        """K of contact in space on the device [rod, node] (3, 3); allocated by the first call."""
        if self._arrays.stiffness is None:
            _ = self.force_array
            with exclusive:
                self._launches.enable_contact()
        return self._arrays.contact.stiffness

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node]; with external forces where the last step or ``show`` has put it."""
        if self._arrays.force is None:
            self._launches.find_frames()
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

    def failures(self) -> list[Failure]:
        """The frozen rods; of those between two held ends also that they were pulled straight."""
        found = super().failures()
        if self._holding is None or not all(end.held for end in self.ends):
            return found
        apart = [float(self._holding.apart(failure.time)[failure.rod]) for failure in found]
        return [
            failure._replace(what=failure.what + STRAIGHT.format(distance)) if distance > ALMOST_STRAIGHT else failure
            for failure, distance in zip(found, apart, strict=True)
        ]

    def static(self) -> dict[str, np.ndarray]:
        """What a trajectory saves once: names of ``variables.STATIC``."""
        stiffness = {"bending_stiffness": self.bend, "twist_stiffness": self.twist}
        names = ("moment", "drag_ratio", "rotational_drag")
        values = {"length": np.ones(self.count), **stiffness, **{name: self._parameters[name] for name in names}}
        if (self.drag_along != 1).any():
            values["drag_along"] = self.drag_along
        values = {name if value.ndim == 1 else f"{name}_along": value for name, value in values.items()}
        if self._natural.any:
            strain = np.concatenate([self.natural_twist[..., None], self.natural_bend], axis=-1)
            values["rest_strain"] = strain
        return values

    def _settings(self, rod: int) -> dict[str, Any]:
        settings = {"flagella": self.flagella.of_rod(rod, self.count), "symmetric": self.symmetric}
        of_rod = {
            name: {key: float(each_rod(v, self.count)[rod]) for key, v in b.items()}
            for name, b in self.behaviour.items()
        }
        return settings | ({"behaviour": of_rod} if of_rod else {})

    def arrays_of_state(self) -> dict[str, wp.array | Tiled]:
        """Every device array that the next step depends on."""
        a = self._arrays
        fields = {name: getattr(a.now, name) for name in SHAPE}
        fields |= {f"{name}_{level}": getattr(getattr(a.past, level), name) for level in PAST for name in SHAPE}
        if a.contact.present:
            fields |= {name: getattr(a.contact, array) for name, array in CONTACT_STATE.items()}
        arrays: dict[str, wp.array | Tiled] = {name: Tiled(array, self.count) for name, array in fields.items()}
        arrays |= {f"midpoint_{name}": getattr(a.midpoint, name) for name in (*MIDPOINT, *BEFORE)}
        if a.midpoint.carrier.kind == CARRIED_APART:
            arrays |= {f"carrier_{name}": getattr(a.midpoint.carrier, name) for name in CARRIER}
        arrays |= {f"pace_{name}": getattr(a.pace, name) for name in PACE}
        arrays |= {"status": a.rods.status, "failed_at": a.failed_at}
        if self._behaviours is not None:
            arrays |= self._behaviours.arrays_of_state()
        return arrays

    def check_state(self, state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The arrays of a state, which may be one without contact; what it lacks of contact is zero."""
        if not isinstance(state, Mapping) or not (self._arrays.contact.present or CONTACT_STATE.keys() & state.keys()):
            return super().check_state(state)
        none = np.zeros((self.count, self.nodes, 3))
        given = super().check_state({**dict.fromkeys(CONTACT_STATE, none), **state})
        for name in CONTACT_STATE:
            if (shape := given[name].shape) != none.shape:
                raise SceneError(f"state[{name!r}]: has shape {shape}; must be numbers of shape {none.shape}")
        return given

    def allocate_for(self, state: Mapping[str, np.ndarray]) -> None:
        """Allocate the external force and contact if the state has them."""
        if "force" in state:
            _ = self.force_array
        if CONTACT_STATE.keys() & state.keys():
            _ = self.contact_stiffness_array

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state`` of an ensemble with the same parameters."""
        super().restore(state)
        if self._behaviours is not None:
            with exclusive:
                self._behaviours.set_targets()
        self._launches.show_at(self.time)
        if self._arrays.force is not None:
            self._launches.find_frames()
