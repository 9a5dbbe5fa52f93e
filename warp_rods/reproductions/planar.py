"""Planar swimmers with the symmetry of C.4, many stiffnesses at once: what they do, and how far in β⊥ they go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis import motion_class
from warp_rods.reproductions.film import film
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode, coefficients
from warp_rods.theory.continuation import Branch, follow
from warp_rods.theory.steady import FixedShape, Swimmer, settled

STEP = 1e-3
"""Δt of the text."""
FRAME = 0.04
"""Between frames: fifteen a period of waving."""
LATE = 7.0
"""End of a run that tells what a swimmer does: nearly three periods of flapping."""
TWIST = 1e-3
"""β∥: of no effect in a plane."""
WAVING = {"kind": "mode", "mode": 0, "amplitude": 3.0}
FLAPPING = {"kind": "mode", "mode": 2, "amplitude": 2.0}
"""Shapes from which a soft swimmer comes to wave and to flap."""


@dataclass(frozen=True)
class Motion:
    """What swimmers [rod] did at the end of a run: names of ``motion_class``, periods, a_k [frame, rod, mode]."""

    bends: np.ndarray
    classes: np.ndarray
    periods: np.ndarray
    coefficients: np.ndarray
    strain: np.ndarray
    activity: np.ndarray

    def rod(self, number: int) -> Motion:
        """That of one of them."""
        one = slice(number, number + 1)
        return Motion(
            self.bends[one], self.classes[one], self.periods[one], self.coefficients[:, one], self.strain[one],
            self.activity[one],
        )  # fmt: skip


def bent(starts: Sequence[tuple[int, float]], nodes: int) -> np.ndarray:
    """Strains [start, node, 3] of κ = amplitude φ_mode, for pairs of mode and amplitude."""
    s = np.linspace(-0.5, 0.5, nodes)
    strain = np.zeros((len(starts), nodes, 3))
    strain[..., 2] = [amplitude * beam_mode(mode, s) for mode, amplitude in starts]
    return strain


def swimmers(bends: Any, nodes: int, shape: Any, activity: Any = "tanh") -> FreeRods:
    """Swimmers of these stiffnesses [rod], from shapes as ``FreeRods`` takes them."""
    return FreeRods(
        len(bends), nodes, bend=bends, twist=TWIST, shape=shape, flagella=Flagella(profile=activity),
        symmetric=True, device="cpu",
    )  # fmt: skip


def motion(bends: Any, nodes: int, shape: Any, activity: Any = "tanh", *, time: float, frame: float = FRAME) -> Motion:
    """What they do at the end of a run of length ``time``, seen every ``frame``."""
    rods = swimmers(bends, nodes, shape, activity)
    frames = filmed(rods, time - LATE + frame * np.arange(round(LATE / frame) + 1))
    since = float(frames["time"][0])
    return Motion(
        np.asarray(bends), motion_class.shape_class(frames, since).to_numpy(),
        motion_class.period(frames, since).to_numpy(), modes(frames), rods.strain, rods.activity,
    )  # fmt: skip


def filmed(rods: FreeRods, times: Sequence[float] | np.ndarray) -> xr.Dataset:
    """Frames of strain and activity."""
    return film(rods, times, STEP, ("strain", "activity", "status"))


def modes(frames: xr.Dataset) -> np.ndarray:
    """a_0, a_1, a_2 of the signed curvature [frame, rod, mode]."""
    return coefficients(frames["strain"].to_numpy()[..., 2], frames["s"].to_numpy(), 3)


def amplitudes(shape: FixedShape, count: int = 3) -> np.ndarray:
    """a_k of a planar fixed shape [mode]."""
    return coefficients(shape.curvature, np.linspace(-0.5, 0.5, shape.swimmer.nodes), count)


def arcs(branch: Branch) -> Iterator[tuple[bool, np.ndarray, np.ndarray]]:
    """Pieces of a branch between its bifurcations: stable or not, β⊥ [point], a_k [point, mode], both ends included."""
    points = [(shape.swimmer.parameters["bend"], amplitudes(shape)) for shape in branch.shapes]
    ends = [(found.value, amplitudes(found.shape)) for found in branch.bifurcations]
    changes = np.flatnonzero(np.diff(branch.stable)) + 1
    if len(changes) != len(ends):
        raise ArithmeticError("stability must change at each bifurcation of the branch, and nowhere else")
    starts, stops = [0, *changes], [*changes, len(points)]
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        piece = ends[max(number - 1, 0) : number] + points[start:stop] + ends[number : number + 1]
        bends, shapes = zip(*piece, strict=True)
        yield bool(branch.stable[start]), np.array(bends), np.array(shapes)


def end_of(kind: str, bend: float, nodes: int, ratio: float, *, time: float, within: float, rods: int = 6) -> float:
    """Stiffness at which a motion of this ``kind`` ends, followed from ``bend`` by factors towards that of ``ratio``.

    ``rods`` swimmers start from where the last one that kept its motion ended, each at another stiffness on the way,
    up to ``ratio`` away; the way is shortened to where the motion was lost, until that is ``within`` of where it was
    not. Half way between is returned. Short ways are slow changes: the motion is not thrown off.
    """
    start = {"waving": WAVING, "flapping": FLAPPING}[kind]
    here = motion([bend], nodes, start, time=2 * time)
    if here.classes[0] != kind:
        raise ArithmeticError(f"at β⊥ = {bend:g} the swimmer is {here.classes[0]}, not {kind}: start elsewhere")
    strain, activity = here.strain[0], here.activity[0]
    while abs(np.log(ratio)) > within:
        bends = bend * np.geomspace(1.0, ratio, rods + 1)[1:]
        there = motion(bends, nodes, _each(rods, strain), _each(rods, activity), time=time)
        kept = int(np.argmin(np.append(there.classes == kind, False)))
        if kept < rods:
            ratio = ratio ** (1 / rods)
        if kept:
            bend, strain, activity = float(bends[kept - 1]), there.strain[kept - 1], there.activity[kept - 1]
    return bend * float(np.sqrt(ratio))


def _each(rods: int, values: np.ndarray) -> np.ndarray:
    return np.broadcast_to(values, (rods, *values.shape))


def u_branch(nodes: int, low: float, high: float = 1.2e-2) -> tuple[Branch, Branch]:
    """The U from β⊥ = 5e-3 up round its fold and back to 4e-3, and down to ``low``."""
    u = settled(Swimmer(nodes, {"bend": 5e-3, "twist": TWIST}, symmetric=True), WAVING, time=6.0)
    return follow(u, "bend", 4e-3, high), follow(u, "bend", low, 5e-3, upwards=False)
