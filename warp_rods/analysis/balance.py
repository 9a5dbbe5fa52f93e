"""Where energy is and whether it balances, and how well the constraints of a rod hold."""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, lengths, need, positions, rate, strains
from warp_rods.analysis.shape import bending

REST = 1e-9
"""Dissipation below this share of a rod's largest is round-off."""


def energy_balance(dataset: xr.Dataset) -> xr.DataArray:
    """Energy imbalance over the dissipation (frame, rod).

    (dE/dt − power + dissipation)/dissipation, with dE/dt from differences between frames: small, and second order in
    the spacing of the frames, where the balance closes. E is the elastic energy; of filaments also the rod's share of
    the steric energy, which balances when summed over rods. NaN where hardly anything is dissipated.
    """
    need(dataset, "energy", "dissipation")
    energy, lost = dataset["energy"].to_numpy(), dataset["dissipation"].to_numpy()
    if "power" in dataset:
        imbalance = rate(dataset, energy) - dataset["power"].to_numpy() + lost
    else:
        stored = dataset["steric_energy"].to_numpy() if "steric_energy" in dataset else 0.0
        imbalance = rate(dataset, energy + stored) + lost
    ratio = np.divide(imbalance, lost, out=np.full_like(lost, np.nan), where=lost > REST * lost.max(axis=0))
    return described(dataset, FRAMES, ratio, "1", "energy imbalance over dissipation", "(dE/dt − P + D)/D")


def bending_energy(dataset: xr.Dataset) -> xr.DataArray:
    """Elastic energy of bending (frame, rod).

    ½ ∫ β⊥ |Ω⊥|² ds. The stiffness is fitted to the saved energy density, to its single precision. Raises ValueError
    for filaments, whose stiffness has three values: see ``energy_terms``.
    """
    return described(dataset, FRAMES, _energies(dataset)[0], "force*length", "energy of bending", "½ ∫ β⊥ |Ω⊥|² ds")


def twist_energy(dataset: xr.Dataset) -> xr.DataArray:
    """Elastic energy of twist (frame, rod).

    ½ ∫ β∥ τ² ds; see ``bending_energy``.
    """
    return described(dataset, FRAMES, _energies(dataset)[1], "force*length", "energy of twist", "½ ∫ β∥ τ² ds")


def arc_length(dataset: xr.Dataset) -> xr.DataArray:
    """Worst relative error of a segment's length (frame, rod).

    Saved for filaments. For swimmers a segment is an arc that turns by the mean twist-free bending of its two nodes,
    and its length follows from the chord.
    """
    if "arc_length" in dataset:
        return dataset["arc_length"]
    step = lengths(dataset)[:, None] / (dataset.sizes["node"] - 1)
    k = bending(dataset, twist_free=True)
    turn = abs(k[..., 1:] + k[..., :-1]) / 2 * step
    chord = np.linalg.norm(np.diff(positions(dataset), axis=2), axis=-1)
    error = abs(chord / (step * np.sinc(turn / (2 * np.pi))) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "worst relative error of a segment's length", "|∂s r| = 1")


def orthonormality(dataset: xr.Dataset) -> xr.DataArray:
    """Worst error of the norm of a quaternion (frame, rod).

    | |q|² − 1 |; 1e-7 is their round-off.
    """
    need(dataset, "orientation")
    q = dataset["orientation"].transpose("frame", "rod", "node", "quaternion").to_numpy().astype(np.float64)
    error = abs(np.sum(q**2, axis=-1) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "worst error of a frame's norm", "RᵀR = 1")


def _energies(dataset: xr.Dataset) -> np.ndarray:
    """Energy of bending and of twist [2, frame, rod]."""
    need(dataset, "activity", "energy_density")
    halves = 0.5 * np.stack([abs(bending(dataset)) ** 2, strains(dataset)[..., 0] ** 2])
    density = dataset["energy_density"].transpose("frame", "rod", "node").to_numpy().astype(np.float64)
    # Least squares per rod; the density is β⊥ halves[0] + β∥ halves[1], and a strain that vanishes is left out.
    normal = np.einsum("afrn,bfrn->rab", halves, halves)
    stiffness = np.einsum("rab,bfrn,frn->ra", np.linalg.pinv(normal, rcond=1e-14, hermitian=True), halves, density)
    whole = np.trapezoid(halves, dataset["s"].to_numpy(), axis=-1) * lengths(dataset)
    return stiffness.T[:, None] * whole
