"""Planar swimmers with the symmetry of C.4 at many stiffnesses: their motions, and the range of β⊥ of each motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis import motion_class
from warp_rods.reproductions.integrate import integrate
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode, coefficients
from warp_rods.theory.continuation import Branch, follow
from warp_rods.theory.steady import FixedShape, Swimmer, settled

FRAME = 0.04
"""Time between frames, a fifteenth of the period of waving."""
LATE = 7.0
"""Duration of the late part of a simulation that is analysed, nearly three periods of flapping."""
TWIST = 1e-3
"""β∥, which has no effect in a plane."""
WAVING = {"kind": "mode", "mode": 0, "amplitude": 3.0}
FLAPPING = {"kind": "mode", "mode": 2, "amplitude": 2.0}
"""Initial shapes from which a soft swimmer comes to wave and to flap."""


@dataclass(frozen=True)
class Motion:
    """Late motion of swimmers [rod]: stiffness, class, period, a_k [frame, rod, mode], final strain and activity."""

    bends: np.ndarray
    classes: np.ndarray
    periods: np.ndarray
    coefficients: np.ndarray
    strain: np.ndarray
    activity: np.ndarray

    def rod(self, number: int) -> Motion:
        """The motion of one swimmer."""
        one = slice(number, number + 1)
        return Motion(
            self.bends[one], self.classes[one], self.periods[one], self.coefficients[:, one], self.strain[one],
            self.activity[one],
        )  # fmt: skip


def bent_strains(starts: Sequence[tuple[int, float]], nodes: int) -> np.ndarray:
    """Strains [start, node, 3] of κ = amplitude φ_mode, for pairs of mode and amplitude."""
    s = np.linspace(-0.5, 0.5, nodes)
    strain = np.zeros((len(starts), nodes, 3))
    strain[..., 2] = [amplitude * beam_mode(mode, s) for mode, amplitude in starts]
    return strain


def swimmers(bends: Any, nodes: int, shape: Any, activity: Any = "tanh") -> FreeRods:
    """Swimmers with these bending stiffnesses [rod]; ``shape`` and ``activity`` as ``FreeRods`` takes them."""
    return FreeRods(
        len(bends), nodes, bend=bends, twist=TWIST, shape=shape, flagella=Flagella(profile=activity),
        symmetric=True, device="cpu",
    )  # fmt: skip


def late_motion(
    bends: Any, nodes: int, shape: Any, activity: Any = "tanh", *, time: float, frame: float = FRAME
) -> Motion:
    """Their motion at the end of a simulation of duration ``time``, in frames ``frame`` apart."""
    rods = swimmers(bends, nodes, shape, activity)
    frames = integrated(rods, time - LATE + frame * np.arange(round(LATE / frame) + 1))
    since = float(frames["time"][0])
    return Motion(
        np.asarray(bends), motion_class.shape_class(frames, since).to_numpy(),
        motion_class.period(frames, since).to_numpy(), modes(frames), rods.strain, rods.activity,
    )  # fmt: skip


def integrated(rods: FreeRods, times: Sequence[float] | np.ndarray) -> xr.Dataset:
    """Strain and activity at these times."""
    return integrate(rods, times, ("strain", "activity", "status"))


def modes(frames: xr.Dataset) -> np.ndarray:
    """a_0, a_1, a_2 of the signed curvature [frame, rod, mode]."""
    return coefficients(frames["strain"].to_numpy()[..., 2], frames["s"].to_numpy(), 3)


def amplitudes(shape: FixedShape, count: int = 3) -> np.ndarray:
    """a_k of a planar fixed shape [mode]."""
    return coefficients(shape.curvature, np.linspace(-0.5, 0.5, shape.swimmer.nodes), count)


def stability_segments(branch: Branch) -> Iterator[tuple[bool, np.ndarray, np.ndarray]]:
    """Segments of a branch between its bifurcations: stable or not, β⊥ [point], a_k [point, mode], ends included."""
    points = [(shape.swimmer.parameters["bend"], amplitudes(shape)) for shape in branch.shapes]
    ends = [(found.value, amplitudes(found.shape)) for found in branch.bifurcations]
    changes = np.flatnonzero(np.diff(branch.stable)) + 1
    if len(changes) != len(ends):
        raise ArithmeticError("the stability of the branch must change at each bifurcation and nowhere else")
    starts, stops = [0, *changes], [*changes, len(points)]
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        piece = ends[max(number - 1, 0) : number] + points[start:stop] + ends[number : number + 1]
        bends, shapes = zip(*piece, strict=True)
        yield bool(branch.stable[start]), np.array(bends), np.array(shapes)


def end_of_motion(
    kind: str, bend: float, nodes: int, ratio: float, *, time: float, within: float, rods: int = 6
) -> float:  # fmt: skip
    """Stiffness at which a class of motion ceases to exist, followed from the stiffness ``bend`` in small steps.

    A batch of ``rods`` swimmers starts from the last state with this motion, at stiffnesses between ``bend`` and
    ``ratio`` times that. The search goes on from the last swimmer that kept the motion, with ``ratio`` reduced to the
    interval in which it was lost, until the logarithm of ``ratio`` is below ``within``. Returned is the geometric mean
    of the last interval. Small steps avoid jumps to another motion.
    """
    shape = {"waving": WAVING, "flapping": FLAPPING}[kind]
    start = late_motion([bend], nodes, shape, time=2 * time)
    if start.classes[0] != kind:
        raise ArithmeticError(f"at β⊥ = {bend:g} the swimmer is {start.classes[0]}, not {kind}: start elsewhere")
    strain, activity = start.strain[0], start.activity[0]
    while abs(np.log(ratio)) > within:
        bends = bend * np.geomspace(1.0, ratio, rods + 1)[1:]
        found = late_motion(bends, nodes, _repeated(rods, strain), _repeated(rods, activity), time=time)
        kept = int(np.argmin(np.append(found.classes == kind, False)))
        if kept < rods:
            ratio = ratio ** (1 / rods)
        if kept:
            bend, strain, activity = float(bends[kept - 1]), found.strain[kept - 1], found.activity[kept - 1]
    return bend * float(np.sqrt(ratio))


def _repeated(rods: int, values: np.ndarray) -> np.ndarray:
    return np.broadcast_to(values, (rods, *values.shape))


def u_branch(nodes: int, low: float, high: float = 1.2e-2) -> tuple[Branch, Branch]:
    """The branch of the U from β⊥ = 5e-3 upwards, around its fold and back to 4e-3; and downwards to ``low``."""
    u = settled(Swimmer(nodes, {"bend": 5e-3, "twist": TWIST}, symmetric=True), WAVING, time=6.0)
    return follow(u, "bend", 4e-3, high), follow(u, "bend", low, 5e-3, upwards=False)
