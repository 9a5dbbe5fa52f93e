"""Refinement of filaments that have grown: twice as many cells, shape and history by cubic splines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.rods.bound.arrays import CONTACT_HISTORY, GEODESIC

MOST_NODES = 100_000


def refined_state(state: Mapping[str, np.ndarray], largest_spacing: float) -> dict[str, np.ndarray]:
    """The state with a node inserted between any two adjacent nodes, Ω by cubic splines, the force linearly.

    Frames follow from that of the tracked node. Raises SceneError if there would be too many nodes.
    """
    from scipy.interpolate import CubicSpline, interp1d

    nodes = state["now"].shape[1]
    if 2 * nodes > MOST_NODES:
        raise SceneError(f"growth.spacing = {largest_spacing:g}: needs more than {MOST_NODES} nodes a rod")
    fine = dict(state)
    s_coarse, s_fine = np.linspace(0.0, 1.0, nodes), np.linspace(0.0, 1.0, 2 * nodes - 1)
    for name in GEODESIC:
        fine[name] = CubicSpline(s_coarse, state[name], axis=1)(s_fine)
    for name in ("force", "force_previous", *CONTACT_HISTORY):
        if name in state:
            fine[name] = interp1d(s_coarse, state[name], axis=1)(s_fine)
    return fine
