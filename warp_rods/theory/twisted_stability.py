"""Linear stability of a straight swimmer that its active moment twists: the discrete equations, linearised."""

from __future__ import annotations

import numpy as np

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint, initial_strain

AMPLITUDE = 1e-6
"""Bending of each perturbed rod; the rates are linear in it up to its square."""


def growth_rates(
    *, bend: float, twist: float, moment: float = 0.0, drag_ratio: float = 2.0, rotational_drag: float = 3e-3,
    nodes: int = 129, sharpness: float = 10.0, count: int = 6,
) -> np.ndarray:  # fmt: skip
    """Leading ``count`` complex growth rates of the bending of a straight rod with f = −tanh(sharpness s) held fixed.

    The twist of the rod balances the active moment, β∥ τ' = −M f. Both components of the bending, in the Bishop frame.
    The Jacobian comes from one evaluation of a batch with one rod for each perturbed component. Dashed in Fig 4.2b.
    """
    fixed = {"bend": np.array([bend]), "twist": np.array([twist]), "moment": np.array([moment])}
    flagella = Flagella(law="held", sharpness=sharpness)
    twist_profile = initial_strain({"kind": "writhe", "amplitude": 0.0}, nodes, fixed, flagella)[0, :, 0]
    inner = nodes - 2
    bishop = np.zeros((2 * inner, nodes), dtype=complex)
    bishop[np.arange(inner), 1 + np.arange(inner)] = AMPLITUDE
    bishop[inner + np.arange(inner), 1 + np.arange(inner)] = 1j * AMPLITUDE
    material = bishop * np.exp(-1j * from_midpoint(twist_profile[None]))
    strain = np.stack([np.broadcast_to(twist_profile, bishop.shape), material.real, material.imag], axis=-1)
    rods = FreeRods(
        2 * inner, nodes, bend=bend, twist=twist, moment=moment, drag_ratio=drag_ratio, rotational_drag=rotational_drag,
        flagella=flagella, shape=strain, device="cpu",
    )  # fmt: skip
    rate = rods.rates()["bending_rate"][:, 1:-1] / AMPLITUDE
    jacobian = np.concatenate([rate.real, rate.imag], axis=1).T
    found = np.linalg.eigvals(jacobian)
    return found[np.argsort(-found.real)][:count]
