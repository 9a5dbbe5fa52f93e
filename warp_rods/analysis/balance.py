"""Energy of a rod and its balance, and residuals of its constraints."""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, lengths, need, positions, rate, strains
from warp_rods.analysis.shape import bending

NEGLIGIBLE = 1e-9
"""Dissipation below this fraction of the largest of a rod is round-off."""


def energy_balance(dataset: xr.Dataset) -> xr.DataArray:
    """Energy imbalance over the dissipation (frame, rod).

    (dE/dt − power + dissipation)/dissipation, with dE/dt from differences between frames. Where energy is balanced,
    this is of second order in the time between frames; it is large where the energy falls by much from one to the next,
    as at the start of filaments that relax. E is the elastic energy; for filaments it includes the rod's share of the
    steric energy, which is balanced when summed over rods. NaN where the dissipation is negligible.
    """
    need(dataset, "energy", "dissipation")
    energy, dissipated = dataset["energy"].to_numpy(), dataset["dissipation"].to_numpy()
    if "power" in dataset:
        imbalance = rate(dataset, energy) - dataset["power"].to_numpy() + dissipated
    else:
        steric = dataset["steric_energy"].to_numpy() if "steric_energy" in dataset else 0.0
        imbalance = rate(dataset, energy + steric) + dissipated
    ratio = np.divide(
        imbalance,
        dissipated,
        out=np.full_like(dissipated, np.nan),
        where=dissipated > NEGLIGIBLE * dissipated.max(axis=0),
    )
    apart = np.median(np.diff(dataset["time"].to_numpy()))
    name = f"energy imbalance over dissipation, with dE/dt from frames {apart:.3g} apart"
    return described(dataset, FRAMES, ratio, "1", name, "(dE/dt − P + D)/D")


def bending_energy(dataset: xr.Dataset) -> xr.DataArray:
    """Elastic energy of bending (frame, rod).

    ½ ∫ β⊥ |Ω⊥|² ds. The stiffness is fitted to the saved energy density, which has single precision. Raises ValueError
    for filaments, which have three stiffnesses: see ``energy_terms``.
    """
    return described(dataset, FRAMES, _energies(dataset)[0], "force*length", "energy of bending", "½ ∫ β⊥ |Ω⊥|² ds")


def twist_energy(dataset: xr.Dataset) -> xr.DataArray:
    """Elastic energy of twist (frame, rod).

    ½ ∫ β∥ τ² ds; see ``bending_energy``.
    """
    return described(dataset, FRAMES, _energies(dataset)[1], "force*length", "energy of twist", "½ ∫ β∥ τ² ds")


def arc_length(dataset: xr.Dataset) -> xr.DataArray:
    """Largest relative error of the length of a segment (frame, rod).

    For filaments this is a variable of the trajectory. For swimmers a segment is a circular arc whose curvature is the
    mean twist-free bending of its two nodes, and its length follows from the chord.
    """
    if "arc_length" in dataset:
        return dataset["arc_length"]
    step = lengths(dataset)[..., None] / (dataset.sizes["node"] - 1)
    k = bending(dataset, twist_free=True)
    turn = abs(k[..., 1:] + k[..., :-1]) / 2 * step
    chord = np.linalg.norm(np.diff(positions(dataset), axis=2), axis=-1)
    error = abs(chord / (step * np.sinc(turn / (2 * np.pi))) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "largest relative error of the length of a segment", "|∂s r| = 1")


def orthonormality(dataset: xr.Dataset) -> xr.DataArray:
    """Largest error of the norm of a quaternion (frame, rod).

    | |q|² − 1 |, with a round-off of 1e-7.
    """
    need(dataset, "orientation")
    q = dataset["orientation"].transpose("frame", "rod", "node", "quaternion").to_numpy().astype(np.float64)
    error = abs(np.sum(q**2, axis=-1) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "largest error of the norm of an orientation", "RᵀR = 1")


def _energies(dataset: xr.Dataset) -> np.ndarray:
    """Energy of bending and of twist [2, frame, rod]."""
    need(dataset, "activity", "energy_density")
    halves = 0.5 * np.stack([abs(bending(dataset)) ** 2, strains(dataset)[..., 0] ** 2])
    density = dataset["energy_density"].transpose("frame", "rod", "node").to_numpy().astype(np.float64)
    # Least squares for each rod: the density is β⊥ halves[0] + β∥ halves[1]. A strain that is zero is left out.
    normal = np.einsum("afrn,bfrn->rab", halves, halves)
    stiffness = np.einsum("rab,bfrn,frn->ra", np.linalg.pinv(normal, rcond=1e-14, hermitian=True), halves, density)
    integrals = np.trapezoid(halves, dataset["s"].to_numpy(), axis=-1) * lengths(dataset)
    return stiffness.T[:, None] * integrals
