"""What surface-bound filaments cannot be: each fault named by its parameter, with its value and what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.rods.per_rod import count_of, parameter

if TYPE_CHECKING:
    from warp_rods.rods.bound.rods import BoundRods

FEWEST_NODES = 9
STEEPEST = 1e-6
"""A direction whose share in the tangent plane is below this is normal to the surface."""
RULES: dict[str, Any] = {
    "length": "positive",
    "stiffness": ("positive",) * 3,
    "intrinsic": ("any finite number",) * 3,
    "drag": ("positive", "positive", "zero or more"),
}


def parameters_of(given: Mapping[str, Any], count: int) -> dict[str, np.ndarray]:
    """Each parameter [rod] or [rod, 3]; raises SceneError naming the one that is impossible."""
    return {name: parameter(name, value, count, RULES[name]) for name, value in given.items()}


def rows_of_three(name: str, given: Any, count: int | None = None) -> np.ndarray:
    """Finite numbers [rod, 3], of ``count`` rods where it is given; raises SceneError."""
    try:
        rows = np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise SceneError(f"{name}: must be finite numbers [rod, 3]: {error}") from None
    fits = rows.ndim == 2 and rows.shape[1] == 3 and len(rows) == (count or len(rows)) > 0
    if not fits or not np.isfinite(rows).all():
        asked = "[rod, 3]" if count is None else f"{(count, 3)}, one row a rod"
        raise SceneError(f"{name}: must be finite numbers {asked}; has shape {rows.shape}")
    return rows


def geodesic_curvatures(given: Any, count: int, nodes: int) -> np.ndarray:
    """Ω [rod, node] from a number, one a node, or one a node of each rod; raises SceneError."""
    try:
        turn = np.broadcast_to(np.asarray(given, dtype=float), (count, nodes)).copy()
    except (TypeError, ValueError) as error:
        raise SceneError(
            f"geodesic_curvature: must be a number, or numbers [node] or [rod, node] for {count} rods of {nodes} "
            f"nodes: {error}"
        ) from None
    if not np.isfinite(turn).all():
        raise SceneError("geodesic_curvature: must be finite at every node")
    return turn


def check(
    rods: BoundRods,
    position: np.ndarray,
    direction: np.ndarray,
    at: str,
    ends: tuple[str, str],
    growth: Mapping[str, Any] | None,
) -> None:
    """Raises SceneError naming the parameter of ``BoundRods`` that is impossible, its value and what is allowed."""
    if count_of("nodes", rods.nodes) < FEWEST_NODES:
        raise SceneError(f"nodes = {rods.nodes}: must be {FEWEST_NODES} or more")
    if isinstance(ends, str) or len(ends) != 2:
        raise SceneError(f'ends = {ends!r}: must be a pair such as ("free", "clamped")')
    for name, value, allowed in (("at", at, ("start", "middle")), *(("ends", e, ("free", "clamped")) for e in ends)):
        if value not in allowed:
            raise SceneError(f"{name} = {value!r}: must be one of {', '.join(allowed)}")
    if rods.surface.moving and "clamped" in ends:
        raise SceneError(
            "ends: must be free on a moving membrane: φ does not say how the site of a clamped end moves along the "
            "membrane, nor how its tangent turns"
        )
    spacing = growth.get("spacing") if growth is not None else None
    if spacing and (rods.length / (rods.nodes - 1) > spacing).any():
        raise SceneError(f"growth.spacing = {spacing:g}: Δs is larger at the start; use more nodes")
    _check_frames(rods, position, direction)


def _check_frames(rods: BoundRods, position: np.ndarray, direction: np.ndarray) -> None:
    # The Newton steps of placement are allowed to fail here: that is what is looked for.
    with np.errstate(all="ignore"):
        foot = rods.surface.project(position)
        n = rods.surface.normal(foot)
        q = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        along = np.linalg.norm(q - n * np.einsum("ij,ij->i", q, n)[:, None], axis=-1)
        off = np.abs(rods.surface.phi(foot)) / np.linalg.norm(rods.surface.gradient(foot), axis=-1)
    size = np.linalg.norm(rods.surface.box[1] - rods.surface.box[0])
    lost = np.flatnonzero(~(off < 1e-9 * size))
    if len(lost):
        raise SceneError(f"position[{lost[0]}] = {position[lost[0]].tolist()}: no point of the surface found from it")
    if not rods.surface.closed:
        low, high = rods.surface.box
        outside = np.flatnonzero(((foot < low) | (foot > high)).any(axis=1))
        if len(outside):
            raise SceneError(
                f"position[{outside[0]}] = {position[outside[0]].tolist()}: outside the patch of the "
                f"{rods.surface.kind}, {low.tolist()} to {high.tolist()}"
            )
    steep = np.flatnonzero(~(along > STEEPEST))
    if len(steep):
        raise SceneError(f"direction[{steep[0]}] = {direction[steep[0]].tolist()}: is normal to the surface there")
