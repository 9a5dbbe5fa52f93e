"""What is measured of rods frame by frame, from a group of a trajectory: shape, motion and balances.

Each function takes an ``xarray.Dataset`` with the variables of ``variables.py`` and returns a DataArray with
units, long_name and source in its attributes. Units are the trajectory's own of length, force and time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.writhe import writhe as writhe_of
from warp_rods.rods import modes
from warp_rods.rods.free.shapes import from_midpoint

FRAMES = ("frame", "rod")
STILL = 1e-9
"""Dissipation, of the largest that a rod ever has, below which it is round-off."""


def described(
    dataset: xr.Dataset, dims: Sequence[str], values: Any, units: str, long_name: str, source: str
) -> xr.DataArray:
    """Values with their dims, the time of each frame, and attributes as the trajectory has them."""
    coords = {"time": dataset["time"]} if "frame" in dims and "time" in dataset.coords else {}
    attributes = {"units": units, "long_name": long_name, "source": source}
    return xr.DataArray(values, dims=tuple(dims), coords=coords, attrs=attributes)


def need(dataset: xr.Dataset, *names: str) -> None:
    """Raises ValueError where the dataset lacks one of these variables, naming it."""
    missing = [name for name in names if name not in dataset]
    if missing:
        raise ValueError(f"the group has no {', '.join(missing)}: it has {', '.join(sorted(map(str, dataset)))}")


def taken(table: Mapping[str, Callable[..., xr.DataArray]], dataset: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """The measures of these names in a table of them; raises ValueError with those there are for one that is not."""
    if unknown := [name for name in names if name not in table]:
        raise ValueError(f"no measure called {', '.join(unknown)}: there are {', '.join(table)}")
    return xr.Dataset({name: table[name](dataset) for name in names})


def bending(dataset: xr.Dataset, twist_free: bool = False) -> np.ndarray:
    """Ω₁ + iΩ₂ [frame, rod, node]; of swimmers in the gauge of (C.49), in which Ω₁ is odd and Ω₂ even.

    The gauge is one angle a rod for all frames, by least squares: how directors were chosen in the cross-section
    changes no more than a common sign. A planar rod that bends evenly has its signed curvature in Ω₂, one that
    bends oddly in Ω₁. Filaments keep their frame: the membrane gives it. ``twist_free`` turns each node back by
    ∫τ from the middle, which keeps the parities and stays smooth when twist winds the material frame up within a
    node spacing.
    """
    need(dataset, "strain")
    strain = dataset["strain"].transpose("frame", "rod", "node", "strain_component").to_numpy()
    k = strain[..., 1] + 1j * strain[..., 2]
    if twist_free:
        turn = from_midpoint(strain[..., 0].reshape(-1, k.shape[-1])).reshape(k.shape)
        k = k * np.exp(1j * turn * lengths(dataset)[:, None])
    if "activity" not in dataset:
        return k
    # k(s)k(−s) is the square of the even part less that of the odd: both are real and negative in the gauge.
    angle = -0.5 * np.angle(-np.sum(k * k[..., ::-1], axis=(0, 2)))
    return k * np.exp(1j * angle)[:, None]


def lengths(dataset: xr.Dataset) -> np.ndarray:
    """Length of each rod [rod]; 1 where the group does not say."""
    return dataset["length"].to_numpy() if "length" in dataset else np.ones(dataset.sizes["rod"])


def mode_coefficients(dataset: xr.Dataset, count: int = 6, twist_free: bool = False) -> xr.DataArray:
    """a_k = ∫ Ω_c φ_k d(s/L) on the first ``count`` L²-normalised beam modes (frame, rod, component, mode).

    component 1, 2: the two bendings, in the gauge of ``bending``; a swimmer with the symmetry of C.4 has odd
    modes in 1 and even ones in 2, (4.49), (4.50). ``twist_free``: of the Bishop frame, see ``bending``.
    """
    k = bending(dataset, twist_free)
    values = [modes.coefficients(part, dataset["s"].to_numpy(), count) for part in (k.real, k.imag)]
    found = described(
        dataset, (*FRAMES, "component", "mode"), np.stack(values, axis=2),
        "1/length", "bending on the beam modes", "∫ Ω φ_k ds, (4.49), (4.50)",
    )  # fmt: skip
    return found.assign_coords(component=[1, 2], mode=np.arange(count))


def twist_harmonics(dataset: xr.Dataset, count: int = 6) -> xr.DataArray:
    """b_k = ∫ Ω₀ γ_k d(s/L) on the first ``count`` harmonics (frame, rod, harmonic)."""
    need(dataset, "strain")
    twist = dataset["strain"].isel(strain_component=0).transpose("frame", "rod", "node").to_numpy()
    values = modes.harmonic_coefficients(twist, dataset["s"].to_numpy(), count)
    found = described(
        dataset, (*FRAMES, "harmonic"), values, "1/length", "twist on the harmonics", "∫ Ω₀ γ_k ds, (4.48)"
    )
    return found.assign_coords(harmonic=np.arange(count))


def total_twist(dataset: xr.Dataset) -> xr.DataArray:
    """Turns of the material about the centre line from end to end, ∫ τ ds/2π (frame, rod)."""
    need(dataset, "strain")
    twist = dataset["strain"].isel(strain_component=0).transpose("frame", "rod", "node").to_numpy()
    turns = np.trapezoid(twist, dataset["s"].to_numpy(), axis=-1) * lengths(dataset) / (2 * np.pi)
    return described(dataset, FRAMES, turns, "1", "total twist in turns", "∫ τ ds / 2π")


def writhe(dataset: xr.Dataset) -> xr.DataArray:
    """Writhe of the open centre line, right-handed coils positive (frame, rod): ``warp_rods.writhe``."""
    return described(dataset, FRAMES, writhe_of(_positions(dataset)), "1", "writhe", "Gauss integral")


def speed(dataset: xr.Dataset, since: float | None = None, until: float | None = None) -> xr.DataArray:
    """U_swim = |∫ R u dt|/T = |r(T) − r(0)|/T of the middle node (rod), T from ``since`` to ``until``.

    The frames next to the two times are taken; the first and the last frame where they are not given.
    Raises ValueError where both are the same frame.
    """
    time = dataset["time"].to_numpy()
    first = 0 if since is None else int(np.argmin(abs(time - since)))
    last = len(time) - 1 if until is None else int(np.argmin(abs(time - until)))
    if first >= last:
        raise ValueError(f"no two frames between {since} and {until}: frames from {time[0]:g} to {time[-1]:g}")
    middle = _middle(dataset)
    way = np.linalg.norm(middle[last] - middle[first], axis=-1) / (time[last] - time[first])
    return described(dataset, ("rod",), way, "length/time", "swimming speed", "|∫ R u dt|/T, §4.4")


def instantaneous_speed(dataset: xr.Dataset) -> xr.DataArray:
    """|dr/dt| of the middle node, by central differences of the frames (frame, rod); second order in them."""
    velocity = _rate(dataset, _middle(dataset))
    return described(
        dataset, FRAMES, np.linalg.norm(velocity, axis=-1), "length/time", "speed of the midpoint", "|∂t r(0, t)|"
    )


def energy_balance(dataset: xr.Dataset) -> xr.DataArray:
    """(dE/dt − power + dissipation)/dissipation (frame, rod), dE/dt by central differences of the frames.

    Small, and second order in the spacing of the frames, where nothing is lost or made from nothing. E is the
    elastic energy; for filaments with the rod's share of the steric energy, which balances summed over rods.
    NaN where hardly anything is dissipated.
    """
    need(dataset, "energy", "dissipation")
    energy, lost = dataset["energy"].to_numpy(), dataset["dissipation"].to_numpy()
    if "power" in dataset:
        imbalance = _rate(dataset, energy) - dataset["power"].to_numpy() + lost
    else:
        stored = dataset["steric_energy"].to_numpy() if "steric_energy" in dataset else 0.0
        imbalance = _rate(dataset, energy + stored) + lost
    ratio = np.divide(imbalance, lost, out=np.full_like(lost, np.nan), where=lost > STILL * lost.max(axis=0))
    return described(dataset, FRAMES, ratio, "1", "energy imbalance over dissipation", "(dE/dt − P + D)/D")


def twist_energy(dataset: xr.Dataset) -> xr.DataArray:
    """½ ∫ β∥ τ² ds of swimmers (frame, rod); see ``bending_energy``."""
    return described(dataset, FRAMES, _energies(dataset)[1], "force*length", "energy of twist", "½ ∫ β∥ τ² ds")


def bending_energy(dataset: xr.Dataset) -> xr.DataArray:
    """½ ∫ β⊥ |Ω⊥|² ds of swimmers (frame, rod).

    The stiffnesses are read off the trajectory, from energy density against strains, to its single precision.
    Raises ValueError for filaments, whose stiffness has three values.
    """
    return described(dataset, FRAMES, _energies(dataset)[0], "force*length", "energy of bending", "½ ∫ β⊥ |Ω⊥|² ds")


def arc_length(dataset: xr.Dataset) -> xr.DataArray:
    """Worst relative error of the arc length between two nodes (frame, rod); filaments have it saved.

    A segment is an arc that turns by the mean twist-free bending of its nodes: the chord says how long it is.
    """
    if "arc_length" in dataset:
        return dataset["arc_length"]
    step = lengths(dataset)[:, None] / (dataset.sizes["node"] - 1)
    k = bending(dataset, twist_free=True)
    turn = abs(k[..., 1:] + k[..., :-1]) / 2 * step
    chord = np.linalg.norm(np.diff(_positions(dataset), axis=2), axis=-1)
    error = abs(chord / (step * np.sinc(turn / (2 * np.pi))) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "worst relative error of a segment's length", "|∂s r| = 1")


def orthonormality(dataset: xr.Dataset) -> xr.DataArray:
    """Worst error in norm of the saved quaternions, | |q|² − 1 | (frame, rod); 1e-7 is their round-off."""
    need(dataset, "orientation")
    q = dataset["orientation"].transpose("frame", "rod", "node", "quaternion").to_numpy().astype(np.float64)
    error = abs(np.sum(q**2, axis=-1) - 1).max(axis=-1)
    return described(dataset, FRAMES, error, "1", "worst error of a frame's norm", "RᵀR = 1")


def _positions(dataset: xr.Dataset) -> np.ndarray:
    need(dataset, "position")
    return dataset["position"].transpose("frame", "rod", "node", "axis").to_numpy()


def _middle(dataset: xr.Dataset) -> np.ndarray:
    """Position of the middle node [frame, rod, 3]."""
    need(dataset, "position")
    middle = dataset["position"].isel(node=dataset.sizes["node"] // 2)
    return middle.transpose("frame", "rod", "axis").to_numpy()


def _rate(dataset: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Time derivative of values [frame, ...], second order on frames of any spacing."""
    time = dataset["time"].to_numpy()
    if len(time) < 3:
        raise ValueError(f"a rate of change needs three frames or more: there are {len(time)}")
    return np.gradient(values, time, axis=0, edge_order=2)


def _energies(dataset: xr.Dataset) -> np.ndarray:
    """Energy of bending and of twist [2, frame, rod]."""
    need(dataset, "activity", "energy_density")
    k, twist = bending(dataset), dataset["strain"].isel(strain_component=0).transpose("frame", "rod", "node").to_numpy()
    halves = 0.5 * np.stack([abs(k) ** 2, twist**2])
    density = dataset["energy_density"].transpose("frame", "rod", "node").to_numpy().astype(np.float64)
    # Least squares a rod, without what is not strained: the density is β⊥ halves[0] + β∥ halves[1].
    normal = np.einsum("afrn,bfrn->rab", halves, halves)
    stiffness = np.einsum("rab,bfrn,frn->ra", np.linalg.pinv(normal, rcond=1e-14, hermitian=True), halves, density)
    whole = np.trapezoid(halves, dataset["s"].to_numpy(), axis=-1) * lengths(dataset)
    return stiffness.T[:, None] * whole
