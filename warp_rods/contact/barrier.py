"""The steric barrier: its height, and warnings if rods may pass over it or between nodes (docs/model.md §6.1)."""

from __future__ import annotations

import numpy as np

from warp_rods.kernels.contact.steric import CUTOFF

SUFFICIENT_FORCE = 1.5
"""Maximal force of a barrier, in units of the force f* L of one swimmer, that kept dense swarms of soft cells apart."""


def crossing_force(strength: float, range: float, core: float) -> float:
    """The largest force between two straight rods that cross at right angles, each far from its ends.

    At a distance h the integral of −G' h/ρ over both rods (5.39) is 2π h G, with the tangent at the cut-off subtracted.
    """
    h = np.linspace(0, CUTOFF * range, 4000)
    return float((2 * np.pi * h * _potential(h, strength, range, core)).max())


def flank_force(strength: float, range: float, core: float) -> float:
    """The largest force on the tip of a straight rod that runs into the flank of another, ∫ G ds along the flank.

    It is reached where the tip touches the flank, and is less than the force between crossing rods.
    """
    s = np.linspace(0, CUTOFF * range, 4000)
    return float(2 * np.trapezoid(_potential(s, strength, range, core), s))


def _potential(r: np.ndarray, strength: float, range: float, core: float) -> np.ndarray:
    """G at distances r, the last of which is the cut-off, with the tangent at the cut-off subtracted."""
    rho = np.hypot(r, core)
    G = strength * np.exp(-rho / range) / (4 * np.pi * rho)
    F_cutoff = (1 / rho[-1] + 1 / range) * G[-1]
    return G - G[-1] + F_cutoff * (rho - rho[-1])


def barrier_warnings(name: str, strength: float, range: float, core: float) -> list[str]:
    """A warning if swimmers of an ensemble may pass over the barrier.

    The force of a swimmer is 1 at most, in units of f* L.
    """
    found = []
    force = flank_force(strength, range, core)
    if 0 < force < SUFFICIENT_FORCE:
        enough = strength * SUFFICIENT_FORCE / force
        unit = 10.0 ** (np.floor(np.log10(enough)) - 2)
        found.append(
            f"{name}: the steric barrier withstands a force of {force:.2g} at most, and a swimmer pushes with 1: "
            f"rods may pass through each other; use steric.strength = {np.ceil(enough / unit) * unit:.3g} or more"
        )
    return found
