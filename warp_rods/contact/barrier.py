"""Whether sterics keep rods apart: they are barriers of a height, and have a mesh."""

from __future__ import annotations

import numpy as np

from warp_rods.kernels.contact.steric import REACH

ENOUGH = 1.5
"""Force of a barrier, in pushes of one swimmer, that was seen to hold in dense swarms of soft cells."""


def crossing_force(strength: float, range: float, core: float) -> float:
    """The largest force between two straight rods that cross at right angles, middle over middle, at a distance h.

    The integral of −G' h/ρ over both (5.39) is 2π h G, of the distance, less its tangent at the reach's end.
    """
    h = np.linspace(0, REACH * range, 4000)
    return float((2 * np.pi * h * _potential(h, strength, range, core)).max())


def flank_force(strength: float, range: float, core: float) -> float:
    """The largest force of a rod that comes with its tip into the flank of another, ∫ G ds along that one.

    The integral of −∂G/∂z over both, from the tip on, at no distance: less than the force of crossing middles.
    """
    s = np.linspace(0, REACH * range, 4000)
    return float(2 * np.trapezoid(_potential(s, strength, range, core), s))


def _potential(r: np.ndarray, strength: float, range: float, core: float) -> np.ndarray:
    """G at distances r up to the reach, which come last, less its tangent there."""
    rho = np.hypot(r, core)
    G = strength * np.exp(-rho / range) / (4 * np.pi * rho)
    F_end = (1 / rho[-1] + 1 / range) * G[-1]
    return G - G[-1] + F_end * (rho - rho[-1])


def doubts(name: str, spacing: float, strength: float, range: float, core: float, swims: bool) -> list[str]:
    """Lines for the user on what rods of an ensemble may pass through: between nodes, or over the barrier.

    spacing of the nodes, length. A swimmer pushes with 1 at most (f* L); what drives a filament is not known here.
    """
    found = []
    if spacing > core:
        found.append(
            f"{name}: nodes are {spacing:.3g} apart, more than the steric core, {core:.3g}: rods may pass between "
            f"them; use {np.ceil(10 * spacing / core) / 10:g} times as many nodes, or a wider core"
        )
    force = flank_force(strength, range, core)
    if swims and 0 < force < ENOUGH:
        found.append(
            f"{name}: a flank holds a tip with {force:.2g} at most, and a swimmer pushes with 1: rods may pass through "
            f"each other; use steric.strength = {strength * ENOUGH / force:.3g} or more"
        )
    return found
