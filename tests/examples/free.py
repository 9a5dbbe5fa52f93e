"""Active rods for several tests, and the measured order of convergence."""

import numpy as np

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode

MOMENT = 5e-3
TWIST = 1e-3
SMOOTH = Flagella(profile=lambda s: -np.sin(np.pi * s))
"""An activity with f' = 0 at the ends at t = 0, so that the solution is smooth at s = 1/2, t = 0."""


def start_in_space(s):
    """k, τ, f of a coiled rod without symmetry; k and τ are zero at the ends, as required."""
    bending = (2 * beam_mode(0, s) + beam_mode(1, s)) * 1j * np.exp(2j * np.pi * s)
    twist = MOMENT / TWIST * (np.log(np.cosh(4 * s) / np.cosh(2)) / 4)
    return bending, twist, -np.sin(np.pi * s)


def strain_in_space(nodes):
    """The same as strains [node, 3]."""
    bending, twist, _ = start_in_space(np.linspace(-0.5, 0.5, nodes))
    return np.stack([twist, bending.real, bending.imag], axis=-1)


def in_space(device, nodes=65, count=1, **other) -> FreeRods:
    """Rods with bending, twist, activity and active moment."""
    given = {"bend": 1e-3, "twist": TWIST, "moment": MOMENT, "flagella": SMOOTH, "shape": strain_in_space(nodes)}
    return FreeRods(count, nodes, **(given | other), device=device)


def planar(device, nodes=65, count=1, **other) -> FreeRods:
    """Rods that stay in a plane."""
    given = {"bend": 1e-3, "twist": TWIST, "flagella": SMOOTH, "shape": {"kind": "mode", "amplitude": 3.0}}
    return FreeRods(count, nodes, **(given | other), device=device)


def passive(device, nodes=65, **other) -> FreeRods:
    """One rod without flagella."""
    return FreeRods(1, nodes, **({"bend": 5e-3, "twist": TWIST, "flagella": None} | other), device=device)


def slope(sizes, errors) -> float:
    """The order of convergence, −d log(error)/d log(size)."""
    return float(-np.polyfit(np.log(sizes), np.log(errors), 1)[0])
