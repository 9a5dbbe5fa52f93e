"""Plots of what a trajectory holds, without a measure: the table ``VIEWS``, whose functions take (axes, ensemble).

To add one, write a function ``(axes, data, **options)`` of Matplotlib axes and one ensemble, and give it a row. Its
first line is its description. A row applies to the ensembles that hold the variables it needs.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.described import without_failed
from warp_rods.analysis.shape import mode_coefficients
from warp_rods.draw.labels import BLUE, GUIDE, ORANGE, above, label, named, named_in, panels, times
from warp_rods.draw.style import OKABE_ITO

__all__ = ["VIEWS", "View", "views"]

SIGNED_MAP = "RdBu_r"
"""Colours of values of both signs, white at 0."""
FAR, SAME = 0.4, 1e-6
"""Values that all are above this part of the largest ones are far from 0; those that differ by less are the same."""
STRAINS = {
    "normal": "normal curvature",
    "geodesic": "geodesic curvature",
    "bend1": "bending strain 1",
    "bend2": "bending strain 2",
}
"""What strains are called, where the name of the component alone says too little."""
STEEP = 30.0
"""Sums whose largest value is above so many times the median are drawn on a logarithmic axis."""
MOST_LINES = 12
"""Rods of a phase portrait, at most."""


@dataclass(frozen=True)
class View:
    """What it shows, its function, and the variables that it needs."""

    what: str
    function: Callable[..., None]
    needs: tuple[str, ...]


def energies(axes: Any, data: xr.Dataset) -> None:
    """Energies of all rods together, elastic, steric and in walls; below, the power dissipated and put in."""
    data = without_failed(data)
    upper, lower = panels(axes, 2)
    known = [name for name in ("energy", "steric_energy", "wall_energy") if name in data]
    _sums(upper, data, [name for name in known if name == "energy" or (data[name] != 0).any()])
    _sums(lower, data, [name for name in ("dissipation", "power", "growth_power", "membrane_power") if name in data])
    upper.set_ylabel(named_in(data, "energy", "force*length"))
    lower.set_ylabel(named_in(data, "power", "force*length/time"))
    times(lower, data)


NAMES = {
    "energy": "elastic",
    "steric_energy": "steric",
    "wall_energy": "in the walls",
    "dissipation": "dissipated",
    "power": "put in",
    "growth_power": "by growth",
    "membrane_power": "by the membrane",
}


def _sums(axes: Any, data: xr.Dataset, names: list[str]) -> None:
    """The sums over the rods; a variable that is 0 throughout is left out unless it is the first.

    The axis is logarithmic where a linear one would show a peak alone; values below 0 are then left out.
    """
    totals = {name: data[name].sum("rod") for name in names}
    first = totals[names[0]]
    steep = bool((first > 0).all() and first.max() > STEEP * first.median())
    for name, colour in zip(names, OKABE_ITO, strict=False):
        if name == names[0] or (totals[name] != 0).any():
            shown = totals[name].where(totals[name] > 0) if steep else totals[name]
            style = "--" if name == "power" else "-"  # in steady motion it is what is dissipated
            axes.plot(data["time"], shown, style, color=colour, label=NAMES[name])
    if steep:
        axes.set_yscale("log")
    else:
        axes.axhline(0, **GUIDE)
    above(axes)


def kymograph(axes: Any, data: xr.Dataset, variable: str, component: str | None = None, rod: int = 0) -> None:
    """A variable along one rod over time; the colours end at the 99th percentile of its size.

    Those of values far from 0, as of a curvature that changes by little, begin at the 1st percentile instead of 0.

    Raises ValueError where there is no such rod, and where the variable is 0 throughout.
    """
    if not 0 <= rod < data.sizes["rod"]:
        raise ValueError(f"rod = {rod}: there are {data.sizes['rod']}, counted from 0")
    values = data[variable].isel(rod=rod)
    if component is not None:
        values = values.sel({values.dims[-1]: component}).assign_attrs(
            values.attrs | {"long_name": STRAINS.get(component, component)}
        )
    values = values.transpose("frame", "node")
    numbers = values.to_numpy()
    if not np.any(numbers):
        raise ValueError(f"{component or variable} of rod {rod} is 0 throughout: there is nothing to draw")
    along = data["s"].to_numpy()
    ends, name = np.broadcast_to(along, numbers.shape), "position along the rod s"
    if "length" in data and "rod" in data["length"].dims:
        length = data["length"].isel(rod=rod).to_numpy()
        ends, name = (
            (along - along[0]) * np.broadcast_to(length, len(numbers))[:, None],
            named_in(data, "arc length", "length"),
        )
    time = np.broadcast_to(data["time"].to_numpy()[:, None], numbers.shape)
    low, top = _ends(numbers)
    signed = low < 0
    drawn = axes.pcolormesh(
        time, ends, numbers, vmin=low, vmax=top,
        cmap=SIGNED_MAP if signed else None, shading="gouraud", rasterized=True,
    )  # fmt: skip
    axes.figure.colorbar(drawn, ax=axes, extend="both" if low else "max", label=label(values))
    axes.set(title=f"rod {rod}", ylabel=name)
    times(axes, data)


def _ends(numbers: np.ndarray) -> tuple[float, float]:
    """Both ends of the colours: symmetric where there are values below 0, and from 0 where values come near to it."""
    top = max(float(np.nanquantile(np.abs(numbers), 0.99)), np.finfo(float).tiny)
    if (numbers < 0).any():
        return -top, top
    low = float(np.nanquantile(numbers, 0.01))
    return (low if FAR * top < low < (1 - SAME) * top else 0.0), top


def phase_portrait(axes: Any, data: xr.Dataset) -> None:
    """The two largest bending modes against each other, a line for each of up to twelve rods."""
    data = without_failed(data)
    every = -(-data.sizes["rod"] // MOST_LINES)
    found = mode_coefficients(data.isel(rod=slice(None, None, every)))
    power = (found**2).mean(("frame", "rod")).transpose("component", "mode").to_numpy()
    largest = np.argsort(-power, axis=None, kind="stable")[:2]
    chosen = sorted(zip(*np.unravel_index(largest, power.shape), strict=True), key=lambda pair: (pair[1], pair[0]))
    first, second = (found.isel(component=c, mode=m).transpose("rod", "frame").to_numpy() for c, m in chosen)
    for x, y in zip(first, second, strict=True):
        axes.plot(x, y, color=BLUE, linewidth=0.6, alpha=1.0 if len(first) < 4 else 0.6)
    axes.plot(first[:, 0], second[:, 0], "o", color="0.5", label="start", zorder=3)
    axes.plot(first[:, -1], second[:, -1], "o", color=ORANGE, label="end", zorder=3)
    names = [named(f"bending mode {m}, component {c + 1}", found.attrs["units"]) for c, m in chosen]
    axes.set(xlabel=names[0], ylabel=names[1])
    above(axes)


def _along(variable: str, what: str) -> View:
    return View(f"Kymograph of {what}, of one rod", partial(kymograph, variable=variable), (variable,))


VIEWS: dict[str, View] = {
    "energies": View("Energies and powers of all rods together", energies, ("energy", "dissipation")),
    "phase_portrait": View("The two largest bending modes against each other", phase_portrait, ("strain",)),
    "kymograph_activity": _along("activity", "the flagellar field"),
    "kymograph_tension": _along("tension", "the tension"),
    "kymograph_energy": _along("energy_density", "the elastic energy per length"),
}
"""By name; ``views(data)`` adds a kymograph for each strain of an ensemble."""


def views(data: xr.Dataset) -> dict[str, View]:
    """The views of an ensemble: the rows of ``VIEWS`` whose variables it holds, and kymographs of its strains."""
    found = {name: row for name, row in VIEWS.items() if all(need in data for need in row.needs)}
    for variable, dimension in (("strain", "strain_component"), ("stretch", "stretch_component")):
        for component in data[dimension].to_numpy() if variable in data else ():
            component = str(component)
            function = partial(kymograph, variable=variable, component=component)
            found[f"kymograph_{component}"] = View(
                f"Kymograph of {STRAINS.get(component, component)}, of one rod", function, (variable,)
            )
    return found


def options_of(row: View) -> tuple[str, ...]:
    """The names of the options of a view."""
    bound = row.function.keywords if isinstance(row.function, partial) else {}
    return tuple(name for name in list(inspect.signature(row.function).parameters)[2:] if name not in bound)
