"""Shapes of rods: bending on the beam modes, twist on the harmonics, total twist and writhe."""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, lengths, positions, strains
from warp_rods.frames import writhe as writhe_of
from warp_rods.rods import modes
from warp_rods.rods.free.shapes import from_midpoint


def bending(dataset: xr.Dataset, twist_free: bool = False) -> np.ndarray:
    """Ω₁ + iΩ₂ [frame, rod, node]; of swimmers in the gauge of (C.49), in which Ω₁ is odd and Ω₂ even.

    The gauge is one angle per rod for all frames, by least squares, so that the choice of directors in the
    cross-section only affects a common sign. A planar rod with even bending has its signed curvature in Ω₂, one with
    odd bending in Ω₁. The frame of filaments is fixed by the membrane. ``twist_free`` rotates the frame at each node
    back by ∫τ from the middle. This preserves parities, and the result is smooth even where the material frame rotates
    by more than a radian from node to node.
    """
    strain = strains(dataset)
    k = strain[..., 1] + 1j * strain[..., 2]
    if twist_free:
        turn = from_midpoint(strain[..., 0].reshape(-1, k.shape[-1])).reshape(k.shape)
        k = k * np.exp(1j * turn * lengths(dataset)[..., None])
    if "activity" not in dataset:
        return k
    # k(s)k(−s) is the square of the even part minus that of the odd part, which is real and negative in the gauge.
    angle = -0.5 * np.angle(-np.sum(k * k[..., ::-1], axis=(0, 2)))
    return k * np.exp(1j * angle)[:, None]


def mode_coefficients(dataset: xr.Dataset, count: int = 6, twist_free: bool = False) -> xr.DataArray:
    """Bending on the beam modes (frame, rod, component, mode).

    a_k = ∫ Ω φ_k d(s/L) for the first ``count`` L²-normalised modes (4.49), (4.50). ``component`` 1 and 2 are the two
    bendings in the gauge of ``shape.bending``: a swimmer with the symmetry of appendix C.4 has odd modes in 1 and even
    modes in 2. ``twist_free``: bending in the Bishop frame.
    """
    k = bending(dataset, twist_free)
    values = [modes.coefficients(part, dataset["s"].to_numpy(), count) for part in (k.real, k.imag)]
    found = described(
        dataset, (*FRAMES, "component", "mode"), np.stack(values, axis=2),
        "1/length", "bending on the beam modes", "∫ Ω φ_k ds, (4.49), (4.50)",
    )  # fmt: skip
    return found.assign_coords(component=[1, 2], mode=np.arange(count))


def twist_harmonics(dataset: xr.Dataset, count: int = 6) -> xr.DataArray:
    """Twist on the harmonics (frame, rod, harmonic).

    b_k = ∫ Ω₀ γ_k d(s/L) for the first ``count`` harmonics (4.48).
    """
    twist = strains(dataset)[..., 0]
    values = modes.harmonic_coefficients(twist, dataset["s"].to_numpy(), count)
    found = described(
        dataset, (*FRAMES, "harmonic"), values, "1/length", "twist on the harmonics", "∫ Ω₀ γ_k ds, (4.48)"
    )
    return found.assign_coords(harmonic=np.arange(count))


def total_twist(dataset: xr.Dataset) -> xr.DataArray:
    """Turns of the material frame about the centre line (frame, rod).

    ∫ τ ds/2π from end to end, by the trapezoid rule.
    """
    twist = strains(dataset)[..., 0]
    turns = np.trapezoid(twist, dataset["s"].to_numpy(), axis=-1) * lengths(dataset) / (2 * np.pi)
    return described(dataset, FRAMES, turns, "1", "total twist in turns", "∫ τ ds / 2π")


def writhe(dataset: xr.Dataset) -> xr.DataArray:
    """Writhe of the open centre line (frame, rod).

    The Gauss integral of the polygon through the nodes, positive for right-handed coils.
    """
    return described(dataset, FRAMES, writhe_of(positions(dataset)), "1", "writhe", "Gauss integral")
