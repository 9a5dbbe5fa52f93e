"""Twice as many cells for filaments that have grown: shape and history by cubic splines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline, interp1d

from warp_rods.errors import SceneError

MOST_NODES = 100_000


def refined_state(state: Mapping[str, np.ndarray], largest_spacing: float) -> dict[str, np.ndarray]:
    """The state of an ensemble with a node put between each two, Ω by cubic splines, the force linearly.

    The frames between are to be made anew from the anchor's. Raises SceneError where that takes too many nodes.
    """
    nodes = state["geodesic"].shape[1]
    if 2 * nodes > MOST_NODES:
        raise SceneError(f"growth.spacing = {largest_spacing:g}: needs more than {MOST_NODES} nodes a rod")
    fine = dict(state)
    coarse_at, fine_at = np.linspace(0.0, 1.0, nodes), np.linspace(0.0, 1.0, 2 * nodes - 1)
    for name in ("geodesic", "past_geodesic", "past_rate"):
        fine[name] = CubicSpline(coarse_at, state[name], axis=1)(fine_at)
    for name in ("position", "rotation", "curvature"):
        fine[name] = np.repeat(state[name], 2, axis=1)[:, :-1]
    fine["force"] = interp1d(coarse_at, state["force"], axis=1)(fine_at)
    fine["spacing"] = state["spacing"] / 2
    return fine
