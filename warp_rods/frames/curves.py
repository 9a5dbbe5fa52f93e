"""Frames, curvature and torsion of curves that are given by points (dissertation, §3.3).

position [..., node, 3]: points at equal steps of any smooth parameter, as the nodes of a rod. closed: the curve goes on
from the last node to the first, which is not repeated. Derivatives are central differences, one-sided at the ends of an
open curve: all results are second order in the spacing. A frame [..., node, 3, 3] has its directors as columns, the
tangent first. Neighbouring nodes at the same point are a SceneError that names them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.frames import checks
from warp_rods.frames.strains import tell_straight, turned

LEAST = 5
"""Nodes that one-sided third derivatives need."""
ROUNDING = 16 * float(np.finfo(float).eps)
"""Second differences of points below this share of their coordinates are round-off."""
REVERSAL = 1e-12
"""1 + the cosine of an angle between tangents below which it counts as π."""


def arc_length(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """Arc length [..., node] from the first node, along the polygon through the nodes (length).

    Of a closed curve with one entry more, the whole length.
    """
    points = checks.curves(position, closed, 2)
    step = np.diff(points, axis=-2, append=points[..., :1, :]) if closed else np.diff(points, axis=-2)
    length = np.linalg.norm(step, axis=-1)
    return np.concatenate([np.zeros_like(length[..., :1]), np.cumsum(length, axis=-1)], axis=-1)


def tangent(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """Unit tangents [..., node, 3]."""
    return _tangent(checks.curves(position, closed, LEAST), closed)


def curvature(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """κ = |r′ × r″|/|r′|³ ≥ 0 [..., node], 1/length."""
    points = checks.curves(position, closed, LEAST)
    first, second = _slope(points, closed), _second(points, closed)
    return np.linalg.norm(np.cross(first, second), axis=-1) / np.linalg.norm(first, axis=-1) ** 3


def torsion(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """τ = (r′ × r″)·r‴/|r′ × r″|² [..., node], 1/length, positive for right-handed helices.

    Where the curvature vanishes to round-off, τ is undefined: it is NaN there, and a RuntimeWarning names the first
    such node. Near such a node it is inaccurate.
    """
    points = checks.curves(position, closed, LEAST)
    binormal, straight = _binormal(points, closed)
    tell_straight("torsion", straight, "torsion and the Frenet frame")
    size = np.where(straight, np.nan, np.sum(binormal**2, axis=-1))
    return np.sum(binormal * _third(points, closed), axis=-1) / size


def frenet_frame(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """The Frenet frame (T, N, B) [..., node, 3, 3] (3.49).

    N and B are NaN where the curvature vanishes to round-off, with a RuntimeWarning, and jump to the other side where
    it passes through zero: ``bishop_frame`` does not.
    """
    points = checks.curves(position, closed, LEAST)
    along = _tangent(points, closed)
    binormal, straight = _binormal(points, closed)
    tell_straight("frenet_frame", straight, "normal and binormal")
    size = np.where(straight, np.nan, np.linalg.norm(binormal, axis=-1))
    binormal = binormal / size[..., None]
    return np.stack([along, np.cross(binormal, along), binormal], axis=-1)


def bishop_frame(position: ArrayLike, closed: bool = False, normal: ArrayLike | None = None) -> np.ndarray:
    """The frame without twist [..., node, 3, 3] (3.61), by parallel transport of the tangents from the first node.

    normal [..., 3]: the second director at the first node, made perpendicular to the tangent; any by default. On a
    closed curve it does not close: by the angle that is missing see ``twist`` and ``writhe``.
    """
    return parallel_transport(_tangent(checks.curves(position, closed, LEAST), closed), normal)


def material_frame(
    position: ArrayLike, angle: ArrayLike, closed: bool = False, normal: ArrayLike | None = None
) -> np.ndarray:
    """The Bishop frame turned about its tangent by ϑ [..., node], ∫ Ω[0] ds of a rod with the twist Ω[0] (3.52)."""
    return turned(bishop_frame(position, closed, normal), checks.nodal_numbers("angle", angle, LEAST))


def parallel_transport(tangents: ArrayLike, normal: ArrayLike | None = None) -> np.ndarray:
    """Frames [..., node, 3, 3] with these tangents [..., node, 3], each turned from the last the shortest way.

    normal: as in ``bishop_frame``. Tangents may be those of nodes or of the segments of a polygon. Raises SceneError
    where a tangent is zero or opposite to the one before, for which there is no shortest way.
    """
    t = checks.nodal_vectors("tangents", tangents, 1)
    size = np.linalg.norm(t, axis=-1, keepdims=True)
    if (size == 0).any():
        raise SceneError(f"tangents{checks.place(checks.first(size[..., 0] == 0))} = 0: must not be zero")
    t = t / size
    cosine = 1 + np.sum(t[..., 1:, :] * t[..., :-1, :], axis=-1)
    if (cosine < REVERSAL).any():
        at = checks.first(cosine < REVERSAL)
        raise SceneError(f"tangents{checks.place(at)}: the next one must not be opposite; take points closer together")
    side = _start(t[..., 0, :], normal)
    sides = [side]
    for i in range(t.shape[-2] - 1):
        before, after = t[..., i, :], t[..., i + 1, :]
        along = np.sum(side * after, axis=-1) / cosine[..., i]
        side = _across(side - along[..., None] * (before + after), after)
        sides.append(side)
    second = np.stack(sides, axis=-2)
    return np.stack([np.broadcast_to(t, second.shape), second, np.cross(t, second)], axis=-1)


def _start(along: np.ndarray, normal: ArrayLike | None) -> np.ndarray:
    """A unit vector across the first tangent."""
    if normal is None:
        given = np.eye(3)[np.argmin(np.abs(along), axis=-1)]
    else:
        given = checks.vectors("normal", normal)
        if (np.linalg.norm(np.cross(along, given), axis=-1) < REVERSAL).any():
            raise arguments.wrong("normal", normal, "a vector that is not along the first tangent")
    return _across(given, along)


def _across(v: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The direction of v across a unit vector."""
    across = v - np.sum(v * along, axis=-1, keepdims=True) * along
    return across / np.linalg.norm(across, axis=-1, keepdims=True)


def _tangent(points: np.ndarray, closed: bool) -> np.ndarray:
    first = _slope(points, closed)
    size = np.linalg.norm(first, axis=-1)
    turns_back = size <= ROUNDING * np.abs(points).max(axis=(-1, -2))[..., None]
    if turns_back.any():
        at = checks.first(turns_back)
        raise SceneError(
            f"position{checks.place(at[:-1])}: the curve turns back on itself at node {at[-1]}: no tangent"
        )
    return first / size[..., None]


def _binormal(points: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """r′ × r″ in steps of the nodes, and whether it is round-off [..., node]."""
    first, second = _slope(points, closed), _second(points, closed)
    across = np.cross(first, second)
    rounding = ROUNDING * np.abs(points).max(axis=(-1, -2))[..., None] * np.linalg.norm(first, axis=-1)
    return across, np.linalg.norm(across, axis=-1) <= rounding


def _slope(p: np.ndarray, closed: bool) -> np.ndarray:
    """r′ in steps of the nodes."""
    if closed:
        return 0.5 * (np.roll(p, -1, axis=-2) - np.roll(p, 1, axis=-2))
    return np.gradient(p, axis=-2, edge_order=2)


def _second(p: np.ndarray, closed: bool) -> np.ndarray:
    """r″ in steps of the nodes."""
    if closed:
        return np.roll(p, -1, axis=-2) - 2 * p + np.roll(p, 1, axis=-2)
    return _with_ends(np.diff(p, 2, axis=-2), p, [2, -5, 4, -1], 1)


def _third(p: np.ndarray, closed: bool) -> np.ndarray:
    """r‴ in steps of the nodes."""
    if closed:
        near, far = (np.roll(p, -i, axis=-2) - np.roll(p, i, axis=-2) for i in (1, 2))
        return 0.5 * far - near
    inner = 0.5 * (p[..., 4:, :] - p[..., :-4, :]) - (p[..., 3:-1, :] - p[..., 1:-3, :])
    beside = _with_ends(inner, p, [-1.5, 5, -6, 3, -0.5], -1)  # the second and the last but one
    return _with_ends(beside, p, [-2.5, 9, -12, 7, -1.5], -1)


def _with_ends(inner: np.ndarray, p: np.ndarray, weights: list[float], parity: int) -> np.ndarray:
    """Inner values between one-sided differences at both ends."""
    w, n = np.array(weights)[:, None], len(weights)
    first, last = np.sum(w * p[..., :n, :], axis=-2), parity * np.sum(w * p[..., : -n - 1 : -1, :], axis=-2)
    return np.concatenate([first[..., None, :], inner, last[..., None, :]], axis=-2)
