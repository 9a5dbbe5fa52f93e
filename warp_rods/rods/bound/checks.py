"""Checks of the parameters of surface-bound filaments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.rods.bound.along import Components, for_each_rod
from warp_rods.rods.per_rod import along, parameter
from warp_rods.scene.filaments import NO_TIP

if TYPE_CHECKING:
    from warp_rods.rods.bound.rods import BoundRods

FEWEST_NODES = 9
SMALLEST_TANGENT = 1e-6
"""A direction with a smaller component in the tangent plane is regarded as normal to the surface."""
RULES: dict[str, Any] = {
    "length": "positive",
    "stiffness": ("positive",) * 3,
    "intrinsic": (arguments.ANY,) * 3,
    "drag": ("positive", "positive", "zero or more"),
}


def lengths(given: Any, count: int) -> np.ndarray:
    """Lengths [rod]; raises SceneError naming an impossible value."""
    return parameter("length", given, count, RULES["length"])


def along_rods(
    given: Mapping[str, Any], count: int, nodes: int, grows: bool, named: Mapping[str, np.ndarray] | None = None
) -> dict[str, Components]:
    """Each parameter with three components; raises SceneError naming one with an impossible value.

    named: parameters of formulas [rod].
    """
    given = {name: for_each_rod(value, count, named or {}) for name, value in given.items()}
    found = {name: Components(name, value, count, nodes, RULES[name]) for name, value in given.items()}
    for name, components in found.items():
        if grows and components.along:
            raise SceneError(
                f"{name}: must be uniform along filaments that grow, whose nodes move along the material; leave "
                f"growth out, or give numbers and formulas in t"
            )
    return found


def rows_of_three(name: str, given: Any, count: int | None = None) -> np.ndarray:
    """Finite numbers [rod, 3], of ``count`` rods if it is given; raises SceneError."""
    expected = "[rod, 3]" if count is None else f"{(count, 3)}, one row for each rod"
    rows = arguments.reals(name, given)
    fits = rows.ndim == 2 and rows.shape[1] == 3 and len(rows) == (count or len(rows)) > 0
    if not fits or not np.isfinite(rows).all():
        raise SceneError(f"{name}: must be finite numbers {expected}; has shape {rows.shape}")
    return rows


def geodesic_curvatures(
    given: Any, count: int, nodes: int, named: Mapping[str, np.ndarray] | None = None
) -> np.ndarray:
    """Ω [rod, node] from a number, a formula of s, or values [node] or [rod, node]; raises SceneError."""
    if isinstance(given, str):
        given = along("geodesic_curvature", given, np.linspace(-0.5, 0.5, nodes), named)
    expected = f"a number, a formula of s, or numbers [node] or [rod, node] for {count} rods of {nodes} nodes"
    return arguments.fitted("geodesic_curvature", given, (count, nodes), expected)


def checked_ends(ends: Any) -> tuple[str, str]:
    """The pair of ends; raises SceneError."""
    allowed = ("free", "clamped")
    pair = tuple(ends) if isinstance(ends, (tuple, list, np.ndarray)) else ()
    if len(pair) != 2:
        raise arguments.wrong("ends", ends, 'a pair such as ("free", "clamped")')
    return _one_of("ends", pair[0], allowed), _one_of("ends", pair[1], allowed)


def _one_of(name: str, value: Any, allowed: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in allowed:
        raise arguments.wrong(name, value, f"one of {', '.join(allowed)}")
    return str(value)


def check(rods: BoundRods, position: np.ndarray, direction: np.ndarray, at: Any, grows: bool) -> None:
    """Raises SceneError naming a parameter of ``BoundRods`` with an impossible value, and what is allowed."""
    if rods.nodes < FEWEST_NODES:
        raise SceneError(f"nodes = {rods.nodes}: must be {FEWEST_NODES} or more")
    _one_of("at", at, ("start", "middle"))
    if rods.surface.moving and all(rods.clamped):
        raise SceneError(
            'ends = ["clamped", "clamped"]: a filament keeps its length, and cannot follow two points of a moving '
            "membrane that move apart: free one end"
        )
    if grows and all(rods.clamped):
        raise SceneError(f"growth{NO_TIP}")
    if (rods.length / (rods.nodes - 1) > rods.largest_spacing).any():
        raise SceneError(f"growth.spacing = {rods.largest_spacing:g}: Δs is larger at the start; use more nodes")
    _check_frames(rods, position, direction)


def _check_frames(rods: BoundRods, position: np.ndarray, direction: np.ndarray) -> None:
    # Newton steps may fail here; positions for which they do are reported.
    with np.errstate(all="ignore"):
        foot = rods.surface.project(position)
        n = rods.surface.normal(foot)
        q = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        along = np.linalg.norm(q - n * np.einsum("ij,ij->i", q, n)[:, None], axis=-1)
        distance = np.abs(rods.surface.phi(foot)) / np.linalg.norm(rods.surface.gradient(foot), axis=-1)
    size = np.linalg.norm(rods.surface.box[1] - rods.surface.box[0])
    failed = np.flatnonzero(~(distance < 1e-9 * size))
    if len(failed):
        where = f"position[{failed[0]}] = {position[failed[0]].tolist()}"
        raise SceneError(f"{where}: no point of the surface was found near it; give a position closer to the surface")
    if not rods.surface.closed:
        low, high = rods.surface.box
        outside = np.flatnonzero(((foot < low) | (foot > high)).any(axis=1))
        if len(outside):
            raise SceneError(
                f"position[{outside[0]}] = {position[outside[0]].tolist()}: outside the patch of the "
                f"{rods.surface.kind}, {low.tolist()} to {high.tolist()}"
            )
    normal = np.flatnonzero(~(along > SMALLEST_TANGENT))
    if len(normal):
        raise SceneError(f"direction[{normal[0]}] = {direction[normal[0]].tolist()}: is normal to the surface there")
