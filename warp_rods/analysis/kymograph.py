"""Distribution of energy along growing filaments over time, and its release in buckling (Fig 5.3).

Each function takes a group of filaments (``open_run(folder)[name].to_dataset()``).
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import attributes, need, units_of

__all__ = ["TERMS", "dissipation_peaks", "energy_per_length", "energy_terms"]

TERMS = {"twist_energy": "twist", "normal_energy": "normal bending", "geodesic_energy": "geodesic bending"}
"""Variables of ``energy_terms``, and the strain of each."""
ROUND_OFF = 1e-9
"""A filament whose length changes by less than this fraction over the run does not grow."""


def energy_terms(data: xr.Dataset) -> xr.Dataset:
    """Energy density of each strain along the rod (frame, rod, node).

    ``twist_energy``, ``normal_energy`` and ``geodesic_energy`` are ½ B_i (Ω_i − σ_i)² of (5.28). The coordinate
    ``arc(frame, rod, node)`` is the arc length from the first node, which increases as the filament grows.
    """
    need(data, "stiffness", "strain", "intrinsic", "length")
    density = 0.5 * data.stiffness * (data.strain - data.intrinsic) ** 2
    density = density.transpose("frame", "rod", "node", "strain_component")
    terms = {name: density.isel(strain_component=i, drop=True) for i, name in enumerate(TERMS)}
    for name, strain in TERMS.items():
        terms[name].attrs = attributes(
            units_of(data, "force"), f"energy per length of {strain}", "½ B (Ω − σ)², (5.28)"
        )
    arc = ((data.s - data.s[0]) * data.length).transpose("frame", "rod", "node")
    return xr.Dataset(terms).assign_coords(
        arc=arc.assign_attrs(attributes(units_of(data, "length"), "arc length from the first node"))
    )


def energy_per_length(data: xr.Dataset) -> xr.Dataset:
    """Energy gained per length grown (frame, rod).

    dE/dL of the elastic and the steric energy, second order in the time between frames; NaN where a filament does not
    grow. A growing tip adds the energy per length at the tip. The difference to dE/dL is dissipated by drag, and is
    large during buckling. Raises ValueError where there is one frame.
    """
    need(data, "energy", "steric_energy", "length")
    energy, length = _rates(data.energy + data.steric_energy, data.time), _rates(data.length, data.time)
    grows = length * float(data.time[-1] - data.time[0]) > ROUND_OFF * data.length
    slope = (energy / length.where(grows)).rename("energy_per_length")
    return slope.assign_attrs(
        attributes(units_of(data, "force"), "energy gained per length grown", "dE/dL")
    ).to_dataset()


def dissipation_peaks(data: xr.Dataset) -> xr.Dataset:
    """Largest peak of the dissipation over its median (rod).

    Leave out the frames of an initial relaxation and those without growth. ``peak_ratio(rod)`` is the largest
    dissipation over the background, which is the median over the frames. ``peak_time(rod)`` and ``peak_length(rod)``
    are time and length at the peak. ``peak_energy(rod)`` is the energy dissipated above the background around the peak,
    where the ratio exceeds half of its maximum. Smooth growth dissipates in proportion to the growth rate squared; the
    energy of a sudden event is nearly independent of the rate.
    """
    need(data, "dissipation", "length")
    dissipation = data.dissipation.transpose("frame", "rod")
    background = np.maximum(np.nanmedian(dissipation.values, axis=0), np.finfo(float).tiny)
    ratio = dissipation / background
    at = ratio.fillna(0.0).argmax("frame")
    during = _around(ratio.values >= 0.5 * ratio.isel(frame=at).values, at.values)
    excess = ((dissipation - background) * during).fillna(0.0)
    steps = np.diff(data.time.values)[:, None]
    energy = (0.5 * steps * (excess.values[1:] + excess.values[:-1])).sum(axis=0)
    length, source = data.length.transpose("frame", "rod"), "max of dissipation over its median"
    return xr.Dataset(
        {
            "peak_ratio": ratio.isel(frame=at).assign_attrs(
                attributes("1", "largest dissipation over its background", source)
            ),
            "peak_length": length.isel(frame=at).assign_attrs(
                attributes(units_of(data, "length"), "length at the peak", source)
            ),
            "peak_energy": (
                "rod",
                energy,
                attributes(units_of(data, "force*length"), "energy above the background", source),
            ),
            "peak_time": (
                "rod",
                data.time.values[at.values],
                attributes(units_of(data, "time"), "time of the peak", source),
            ),
        }
    ).drop_vars("time")


def _around(condition: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The contiguous frames around ``at`` [rod] in which a condition [frame, rod] is true."""
    breaks = np.cumsum(~condition, axis=0)
    return condition & (breaks == np.take_along_axis(breaks, at[None], axis=0))


def _rates(values: xr.DataArray, time: xr.DataArray) -> xr.DataArray:
    if len(time) < 2:
        raise ValueError("a rate of change needs two frames or more; there is one")
    values = values.transpose("frame", "rod")
    return values.copy(data=np.gradient(values.values, time.values, axis=0))
