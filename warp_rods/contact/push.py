"""Rods that are too close are pushed apart, each as a rigid body, until all keep the clearance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_rods.contact.segments import CentreLines, OccupiedSpace, launch
from warp_rods.errors import SceneError
from warp_rods.kernels.contact import push

__all__ = ["pushed_apart"]

ONTO = 1.01
"""Rods are pushed apart to this distance, in units of the clearance; one of 1 would be approached slowly."""
MOST_PUSHES = 250
"""Rounds of pushing overlapping rods apart."""
PROGRESS, FIRST_PUSHES, FASTER, FEW_LEFT = 10, 30, 1.2, 0.1
"""Every so many rounds, but not before so many, it is estimated whether the rods will come apart: their overlap falls
about exponentially, or faster by this factor in the exponent. A few overlaps, so many clearances for each rod, come and
go."""


def pushed_apart(
    position: np.ndarray,
    rotation: np.ndarray,
    shapes: np.ndarray,
    clearance: float,
    space: OccupiedSpace,
    heights: tuple[float, float] | None = None,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Positions [rod, 3] and rotations [rod, 3, 3] of rigid rods that keep the clearance, starting from given ones.

    shapes [rod, node, 3]: centre lines about the middles. Each pair of segments that is too close is separated by the
    missing distance, through translation and rotation of both rods so that both move least; the motions of a rod are
    averaged over its pushes. heights: bounds for the middles of flat rods, which rotate about z only; rods that cross
    are separated in z. Returns None if some rods remain jammed. Raises SceneError as soon as the overlap falls so
    slowly that they are too many.
    """
    lines, rods = CentreLines(space, clearance, len(shapes), shapes.shape[1]), _rigid(position, rotation, shapes)
    rods.first, rods.apart = lines.present, ONTO * clearance
    lines.add(position[:, None] + np.einsum("rij,rnj->rni", rotation, shapes))
    if heights:
        rods.flat, rods.low, rods.high = 1, *heights
    overlaps: list[float] = []
    while len(overlaps) < MOST_PUSHES:
        if not (overlap := _push(rods, lines)):
            return rods.position.numpy().copy(), rods.rotation.numpy().copy()
        overlaps.append(overlap / clearance)
        if _is_hopeless(overlaps, len(position)):
            raise SceneError(f"count = {len(position)}: too many to be {clearance:g} apart; place fewer")
        launch(push.move_rods, rods, lines.chains)
    return None


def _rigid(position: np.ndarray, rotation: np.ndarray, shapes: np.ndarray) -> Any:
    """The struct of rigid rods, all of which are to be looked at."""
    rods, count = push.Rigid(), len(position)
    rods.position, rods.shape = (wp.array(x, dtype=wp.vec3d, device="cpu") for x in (position, shapes))
    rods.rotation = wp.array(rotation, dtype=wp.mat33d, device="cpu")
    rods.length = wp.array(np.linalg.norm(np.diff(shapes, axis=1), axis=-1).sum(axis=1), device="cpu")
    rods.shift, rods.turn = (wp.zeros(count, dtype=wp.vec3d, device="cpu") for _ in range(2))
    rods.pushes = wp.zeros(count, dtype=wp.int32, device="cpu")
    rods.moved = wp.full(count, 1, dtype=wp.int32, device="cpu")
    return rods


def _push(rods: Any, lines: CentreLines) -> float:
    """Find the pushes of a round; returns the sum of what segments are too close, 0 where none is."""
    overlap = wp.zeros(1, dtype=wp.float64, device="cpu")
    launch(push.push_rods, rods, lines.chains, overlap)
    return float(overlap.numpy()[0])


def _is_hopeless(overlaps: Sequence[float], rods: int) -> bool:
    """Whether overlaps that fall as in the last rounds do not vanish in the rounds left; in units of the clearance."""
    done = len(overlaps)
    if done < FIRST_PUSHES or done % PROGRESS or overlaps[-1] < FEW_LEFT * rods:
        return False
    factor = overlaps[-1] / overlaps[-1 - PROGRESS]
    return overlaps[-1] * factor ** (FASTER * (MOST_PUSHES - done) / PROGRESS) > ONTO - 1
