"""Where along a filament its energy sits, against time, and when it is let go of: growth and buckling (thesis Fig 5.3).

Each function takes one ensemble of filaments of a trajectory (``open_run(dir)[name].to_dataset()``) and gives
variables with units and source.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

TERMS = {"twist_energy": "twist", "normal_energy": "normal bending", "geodesic_energy": "geodesic bending"}


def energy_terms(data: xr.Dataset) -> xr.Dataset:
    """The energy density of each strain, ½ B_i (Ω_i − σ_i)², along the filaments: kymographs.

    ``twist_energy``, ``normal_energy``, ``geodesic_energy`` (frame, rod, node), force, over the coordinates ``time``
    and ``arc`` (frame, rod, node): the arc length from the first node, which grows with the filament.
    """
    density = 0.5 * data.stiffness * (data.strain - data.intrinsic) ** 2
    density = density.transpose("frame", "rod", "node", "strain_component")
    said = {k: _said("force", f"energy per length of {v}", "½ B (Ω − σ)², (5.28)") for k, v in TERMS.items()}
    terms = {name: density.isel(strain_component=i, drop=True).assign_attrs(said[name]) for i, name in enumerate(TERMS)}
    arc = ((data.s - data.s[0]) * data.length).transpose("frame", "rod", "node")
    return xr.Dataset(terms).assign_coords(arc=arc.assign_attrs(_said("length", "arc length from the first node")))


def energy_per_length(data: xr.Dataset) -> xr.Dataset:
    """dE/dL of growing filaments: what their energy, elastic and steric, gains per length that they grow.

    ``energy_per_length(frame, rod)``, force, second order in the time between frames; NaN where none grows. A growing
    tip brings in e(tip); what is missing to it goes to drag, or to buckling, where this drops.
    """
    energy, length = _rates(data.energy + data.steric_energy, data.time), _rates(data.length, data.time)
    slope = (energy / length.where(length > 0)).rename("energy_per_length")
    return slope.assign_attrs(_said("force", "energy gained per length grown", "dE/dL")).to_dataset()


def dissipation_peaks(data: xr.Dataset) -> xr.Dataset:
    """The largest peak of each filament's dissipation over its background, the median of the frames.

    Cut the frames of a start far from rest, and those without growth, first. Gives ``peak_ratio(rod)``, largest
    dissipation over background; ``peak_time(rod)``, ``peak_length(rod)`` when; ``peak_energy(rod)`` the energy
    dissipated above the background about it, for as long as the ratio is above half of the largest. Smooth growth at
    a rate dissipates in proportion to its square; the energy of a sudden event hardly depends on the rate.
    """
    spent = data.dissipation.transpose("frame", "rod")
    floor = np.maximum(np.nanmedian(spent.values, axis=0), np.finfo(float).tiny)
    ratio = spent / floor
    at = ratio.fillna(0.0).argmax("frame")
    during = _around(ratio.values >= 0.5 * ratio.isel(frame=at).values, at.values)
    excess = ((spent - floor) * during).fillna(0.0)
    steps = np.diff(data.time.values)[:, None]
    energy = (0.5 * steps * (excess.values[1:] + excess.values[:-1])).sum(axis=0)
    length = data.length.transpose("frame", "rod")
    return xr.Dataset(
        {
            "peak_ratio": ratio.isel(frame=at).assign_attrs(_said("1", "largest dissipation over its background")),
            "peak_length": length.isel(frame=at).assign_attrs(_said("length", "length of the rod at the peak")),
            "peak_energy": ("rod", energy, _said("force*length", "dissipated above the background in the peak")),
            "peak_time": ("rod", data.time.values[at.values], _said("time", "time of the peak")),
        }
    ).drop_vars("time")


def _around(condition: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Of a condition [frame, rod], the stretch of frames in which it holds without a break about ``at`` [rod]."""
    breaks = np.cumsum(~condition, axis=0)
    return condition & (breaks == np.take_along_axis(breaks, at[None], axis=0))


def _rates(values: xr.DataArray, time: xr.DataArray) -> xr.DataArray:
    values = values.transpose("frame", "rod")
    return values.copy(data=np.gradient(values.values, time.values, axis=0))


def _said(units: str, long_name: str, source: str = "") -> dict[str, str]:
    return {"units": units, "long_name": long_name, **({"source": source} if source else {})}
