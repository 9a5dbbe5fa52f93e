"""Linear stability of a straight swimmer whose active moment winds it up: the discrete equations, linearised."""

from __future__ import annotations

import numpy as np

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint, initial_strain

AMPLITUDE = 1e-6
"""Bending of each perturbed rod; the rates are linear in it to its square."""


def growth_rates(
    *, bend: float, twist: float, moment: float = 0.0, drag_ratio: float = 2.0, rotational_drag: float = 3e-3,
    nodes: int = 129, sharpness: float = 10.0, count: int = 6,
) -> np.ndarray:  # fmt: skip
    """Fastest complex growth rates [count] of bending of a straight rod under f = −tanh(sharpness s), held.

    The rod's twist is the one that balances the active torque, β∥ τ' = −M f; bending in the Bishop frame, both
    components. One rod a perturbed node makes the Jacobian in one evaluation. Thesis Fig 4.2b, dashed.
    """
    fixed = {"bend": np.array([bend]), "twist": np.array([twist]), "moment": np.array([moment])}
    wound = initial_strain({"kind": "writhe", "amplitude": 0.0}, nodes, fixed)[0, :, 0] * 10 / sharpness
    inner = nodes - 2
    bishop = np.zeros((2 * inner, nodes), dtype=complex)
    bishop[np.arange(inner), 1 + np.arange(inner)] = AMPLITUDE
    bishop[inner + np.arange(inner), 1 + np.arange(inner)] = 1j * AMPLITUDE
    material = bishop * np.exp(-1j * from_midpoint(wound[None]))
    strain = np.stack([np.broadcast_to(wound, bishop.shape), material.real, material.imag], axis=-1)
    rods = FreeRods(
        2 * inner, nodes, bend=bend, twist=twist, moment=moment, drag_ratio=drag_ratio, rotational_drag=rotational_drag,
        flagella=Flagella(law="held", diffusion=0.0, sharpness=sharpness), shape=strain, device="cpu",
    )  # fmt: skip
    rate = rods.rates()["bending_rate"][:, 1:-1] / AMPLITUDE
    jacobian = np.concatenate([rate.real, rate.imag], axis=1).T
    found = np.linalg.eigvals(jacobian)
    return found[np.argsort(-found.real)][:count]
