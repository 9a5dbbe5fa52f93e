"""What surface-bound filaments cannot be: checked before anything is allocated."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.errors import SceneError

FEWEST_NODES = 9
STEEPEST = 1e-6
"""A direction whose share in the tangent plane is below this is normal to the surface."""


def check(rods: Any, position: np.ndarray, direction: np.ndarray, at: str, ends: tuple[str, str]) -> None:
    """Raises SceneError naming the parameter of ``BoundRods`` that is impossible, its value and what is allowed."""
    if rods.nodes < FEWEST_NODES:
        raise SceneError(f"nodes = {rods.nodes}: must be {FEWEST_NODES} or more")
    for name, value, allowed in (("at", at, ("start", "middle")), *(("ends", e, ("free", "clamped")) for e in ends)):
        if value not in allowed:
            raise SceneError(f"{name} = {value!r}: must be one of {', '.join(allowed)}")
    if rods.surface.moving and "clamped" in ends:
        raise SceneError(
            "ends: must be free on a membrane that moves: how the site of a clamped end is carried along, and how its "
            "tangent turns, is not said by φ"
        )
    for name, lowest in (("length", 0.0), ("stiffness", 0.0), ("intrinsic", -np.inf), ("drag", 0.0)):
        values = getattr(rods, name)
        wrong = ~np.isfinite(values) | (values <= lowest)
        if name == "drag":
            wrong[:, 2] &= values[:, 2] != 0.0
        if wrong.any():
            raise SceneError(f"{name} = {values[wrong][0]:g}: must be a {'finite' if lowest else 'positive'} number")
    if (rods.length / (rods.nodes - 1) > rods.largest_spacing).any():
        raise SceneError(f"growth.spacing = {rods.largest_spacing:g}: Δs is more at the start; use more nodes")
    _check_frames(rods, position, direction)


def _check_frames(rods: Any, position: np.ndarray, direction: np.ndarray) -> None:
    for name, given in (("position", position), ("direction", direction)):
        if given.shape != (rods.count, 3) or not np.isfinite(given).all():
            raise SceneError(f"{name}: must be finite numbers [rod, 3], has shape {given.shape}")
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
