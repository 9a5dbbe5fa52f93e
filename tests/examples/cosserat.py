"""Cosserat rods for several tests, and the exact rates of small motions of a straight one."""

import numpy as np
from scipy.optimize import brentq

from warp_rods.rods.cosserat.rods import CosseratRods

BEND, TWIST, STRETCH, SHEAR = 1.0, 0.7, 900.0, 300.0
DRAG_RATIO, ROTATIONAL_DRAG = 2.0, 3e-3
STIFFNESS = (TWIST, BEND, BEND, STRETCH, SHEAR, SHEAR)
SMALL = 1e-5


def bending_rate(bend: float, shear: float, drag_ratio: float) -> float:
    """Decay rate Γ of the slowest bending of a free straight rod that shears.

    η Γ w = −n', n = S(w' − θ), b θ'' + n = 0: w = cos ks and cosh κs with k² − κ² = ηΓ/S, k²κ² = ηΓ/b. Without moment
    and force at the ends, k tan(k/2) + κ tanh(κ/2) = 0.
    """

    def wavenumbers(rate):
        a, p = drag_ratio * rate / (2 * shear), drag_ratio * rate / bend
        square = a + np.sqrt(a * a + p)
        return np.sqrt(square), np.sqrt(p / square)

    def mismatch(rate):
        k, kappa = wavenumbers(rate)
        return k * np.sin(k / 2) + kappa * np.tanh(kappa / 2) * np.cos(k / 2)

    kirchhoff = 4.730040744862704**4 * bend / drag_ratio
    return brentq(mismatch, 0.05 * kirchhoff, 1.01 * kirchhoff, xtol=1e-12, rtol=1e-14)


def small_strain(kind: str, nodes: int) -> np.ndarray:
    """A small strain [node, 6] of the slowest mode."""
    s = np.linspace(-0.5, 0.5, nodes)
    strain = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], (nodes, 1))
    strain[:, {"stretch": 3, "twist": 0, "bend": 2}[kind]] += SMALL * np.cos(np.pi * s)
    return strain


RATES = {
    "stretch": STRETCH * np.pi**2,
    "twist": TWIST * np.pi**2 / ROTATIONAL_DRAG,
    "bend": bending_rate(BEND, SHEAR, DRAG_RATIO),
}
"""Of the slowest modes."""


def straight(device, kind: str, nodes: int) -> CosseratRods:
    """A straight rod that is strained a little."""
    parameters = {"drag_ratio": DRAG_RATIO, "rotational_drag": ROTATIONAL_DRAG}
    return CosseratRods(1, nodes, stiffness=STIFFNESS, **parameters, shape=small_strain(kind, nodes), device=device)


def measured_rate(rods: CosseratRods, rate: float, step: float) -> float:
    """The decay rate between 0.6 and 1.2 of 1/``rate``, in steps of ``step`` of it."""
    steps = round(0.6 / step)
    rods.step(step / rate, steps)
    before = rods.energy[0]
    rods.step(step / rate, steps)
    return float(np.log(before / rods.energy[0]) / (2 * steps * step / rate))


COUPLED = np.array([
    [0.8, 0.1, 0.0, 2.0, 0.0, 1.0],
    [0.1, 1.0, 0.2, 0.0, 3.0, 0.0],
    [0.0, 0.2, 1.3, 1.0, 0.0, -2.0],
    [2.0, 0.0, 1.0, 300.0, 10.0, 0.0],
    [0.0, 3.0, 0.0, 10.0, 90.0, 5.0],
    [1.0, 0.0, -2.0, 0.0, 5.0, 120.0],
])  # fmt: skip
"""A stiffness in which every strain has a part in every stress."""


def natural_in_space(nodes: int) -> np.ndarray:
    """Natural strains [node, 6] that vary along the rod."""
    s = np.linspace(-0.5, 0.5, nodes)
    one = np.ones(nodes)
    return np.stack([2 * one, 3 * np.cos(2 * s), -1 + s, 1 + 0.1 * s, 0.05 * one, -0.1 * s], axis=-1)


def in_space(device, nodes=33, count=1, **other) -> CosseratRods:
    """Coupled rods away from their natural shape; without moment and force at the ends at the start."""
    s = np.linspace(-0.5, 0.5, nodes)
    bump = (np.cos(np.pi * s) ** 2)[:, None] * np.array([3.0, -2.0, 4.0, 0.05, 0.1, -0.1])
    natural = natural_in_space(nodes)
    given = {"stiffness": COUPLED[None], "natural": natural, "shape": natural + bump, "rotational_drag": 0.05}
    return CosseratRods(count, nodes, **(given | other), device=device)
