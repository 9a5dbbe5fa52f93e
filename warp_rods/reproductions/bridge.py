"""Fig 5.3: a filament grows from its nucleation site around the bridge between two cells, and buckles."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.kymograph import TERMS, dissipation_peaks, energy_terms
from warp_rods.draw import plots
from warp_rods.membranes import surfaces
from warp_rods.membranes.mesh import triangulate
from warp_rods.reproductions.integrate import integrate
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.theory import buckling

NECK, BODY, WIDTH = 0.4, 1.0, 1.0
STIFFNESS, INTRINSIC, DRAG = (1.0, 1.0, 0.1), (0.0, 1.0, 0.0), (1.0, 2.0, 0.1)
"""Membrane ρ(z) = neck + (body − neck)(1 − exp(−z²/width²)), B, σ, ζ. The text gives none; they are chosen here."""
NECKS = {0.3: (0.3, 0.6), 0.4: (0.7, 1.0), 0.5: (1.2, 1.6)}
"""Radius of the neck → two lengths between which a filament along the waist becomes unstable."""
FIRST, LAST = 0.4, 2.0
"""Lengths of the filament at the start and at the end."""
INITIAL_SLOPE = 1e-3
"""Slope of the initial direction to the waist; a filament exactly along the waist would stay there."""
VIEW = (-120.0, 12.0)
SNAPSHOTS = (0.8, 1.2, 1.6, 2.0)
VARIABLES = ("position", "strain", "energy_density", "energy", "dissipation", "length", "load", "status")


def grow(quick: bool) -> Result:
    """Shapes, kymographs of the three energies, dissipation, critical lengths, and how sudden the buckling is."""
    rates = np.array([0.2, 0.1]) if quick else np.array([0.2, 0.1, 0.05])
    nodes = 33 if quick else 65
    data = _growing_filaments(rates, nodes)
    terms = energy_terms(data)
    lengths = {neck: _critical_length(neck, quick) for neck in (list(NECKS)[1:] if quick else NECKS)}
    rows = _critical_rows(lengths) + _suddenness_rows(data, rates)
    rows += [_localisation_row(name, terms[name], data, lengths[NECK]) for name in TERMS]
    rows.append(_load_row(data, lengths[NECK]))
    note = (
        f"ρ(z) = {NECK:g} + {BODY - NECK:g}(1 − exp(−z²)), B = {STIFFNESS}, σ = {INTRINSIC}, ζ = {DRAG}, "
        f"L = {FIRST:g} … {LAST:g} at rates {', '.join(f'{rate:g}' for rate in rates)}, {nodes} nodes; "
        "the text gives none of these"
    )
    kept = xr.merge([data.drop_vars("load"), terms])
    return Result(_figure(data, terms, lengths[NECK], rates), rows, kept, (note,))


def _bridge(neck: float) -> surfaces.Surface:
    return surfaces.make("bridge", {"neck": neck, "body": BODY, "width": WIDTH, "length": 3.0})


def _growing_filaments(rates: np.ndarray, nodes: int) -> xr.Dataset:
    """One filament (rod) for each rate, with frames at the same lengths; ``clock`` (frame, rod) has their times."""
    surface, parts = _bridge(NECK), []
    for rate in rates:
        rods = BoundRods(
            surface, np.array([[-NECK, 0.0, 0.0]]), np.array([[0.0, -1.0, INITIAL_SLOPE]]), nodes=nodes, length=FIRST,
            stiffness=STIFFNESS, intrinsic=INTRINSIC, drag=DRAG, at="start", ends=("clamped", "free"),
            growth={"rate": float(rate), "until": LAST}, device="cpu",
        )  # fmt: skip
        parts.append(integrate(rods, np.linspace(0.0, (LAST - FIRST) / rate, 161), VARIABLES))
    whole = xr.concat([part.drop_vars("time") for part in parts], "rod", data_vars="all")
    time = np.linspace(0.0, LAST - FIRST, 161)[:, None] / rates
    return whole.assign_coords(clock=(("frame", "rod"), time))


def _critical_length(neck: float, quick: bool) -> float:
    """Length at which a filament along the waist becomes unstable; second order in Δs, extrapolated from two grids."""
    parameters = {"stiffness": STIFFNESS, "intrinsic": INTRINSIC, "drag": DRAG}
    coarse, fine = (
        buckling.critical_length(
            buckling.Clamped(_bridge(neck), [-neck, 0.0, 0.0], [0.0, -1.0, 0.0], nodes, parameters), NECKS[neck]
        )
        for nodes in ((17, 33) if quick else (33, 65))
    )
    return (4 * fine - coarse) / 3


def _critical_rows(lengths: dict[float, float]) -> list[Comparison]:
    published, reading = "certain critical lengths", "loss of stability along the waist, eigenvalues of ∂Ω/∂t"
    rows = [Comparison(f"critical length, neck {neck:g}", published, at, reading) for neck, at in lengths.items()]
    ratio = max(lengths.values()) / min(lengths.values())
    published, reading = "highly dependent on membrane geometry", "necks of the form of Fig 5.3"
    return [*rows, Comparison("largest over smallest critical length", published, ratio, reading, ratio > 1.2)]


def _suddenness_rows(data: xr.Dataset, rates: np.ndarray) -> list[Comparison]:
    """Length at the peak of the dissipation, and exponent of its energy in the growth rate: 0 for a sudden event."""
    energy, at = [], []
    for rod in range(len(rates)):
        one = data.isel(rod=[rod]).assign_coords(time=("frame", data["clock"].to_numpy()[:, rod]))
        peak = dissipation_peaks(one.isel(frame=slice(5, None)))  # without the initial relaxation
        energy.append(float(peak["peak_energy"][0]))
        at.append(float(peak["peak_length"][0]))
    exponent = float(np.polyfit(np.log(rates), np.log(energy), 1)[0])
    published = "sudden, rapid conformational changes"
    reading = "d log(energy of the peak of dissipation)/d log(rate): 0 for a jump, 1 for a smooth branch with a delay"
    delay = "above the critical length: buckling needs time to develop"
    return [
        Comparison(f"length at which dissipation peaks, rate {rates[-1]:g}", "", at[-1], delay),
        Comparison(
            "power of the rate in the energy that buckling spends", published, exponent, reading, bool(exponent < 0.3)
        ),
    ]


def _localisation_row(name: str, term: xr.DataArray, data: xr.Dataset, critical: float) -> Comparison:
    """Largest over mean density of an energy along the slowest filament, before buckling and at the end."""
    density, length = term.isel(rod=-1).to_numpy(), data["length"].isel(rod=-1).to_numpy()
    before = int(np.argmin(abs(length - 0.95 * critical)))
    peak = [float(density[frame].max() / max(density[frame].mean(), 1e-12)) for frame in (before, -1)]
    largest = [float(density[frame].max()) for frame in (before, -1)]
    reading = f"before buckling: {peak[0]:.2f}; largest density {largest[0]:.2g} → {largest[1]:.2g}"
    published = "localization of twist and curvature"
    return Comparison(f"{name.replace('_', ' ')}: largest over mean, L = 2", published, peak[1], reading, peak[1] > 2)


def _load_row(data: xr.Dataset, critical: float) -> Comparison:
    """Largest load on the membrane over that before buckling."""
    load = np.linalg.norm(data["load"].isel(rod=-1).to_numpy(), axis=-1).max(axis=-1)
    before = int(np.argmin(abs(data["length"].isel(rod=-1).to_numpy() - 0.95 * critical)))
    ratio = float(load.max() / load[before])
    name = "largest load on the membrane over that before buckling"
    return Comparison(name, "large stresses", ratio, "force per length, (5.31), (5.32)", ratio > 2)


def _figure(data: xr.Dataset, terms: xr.Dataset, critical: float, rates: np.ndarray) -> Any:
    figure = plots.figure(plots.PAGE, 112)
    top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.15, 1))[:, 0]
    _shapes(top, data)
    panels = bottom.subplots(1, 4, width_ratios=(1, 1, 1, 1.1))
    length, arc = data["length"].isel(rod=-1).to_numpy(), terms["arc"].isel(rod=-1).to_numpy()
    labels = ("twist $\\mathcal{E}_1$", "normal bending $\\mathcal{E}_2$", "geodesic bending $\\mathcal{E}_3$")
    for axes, name, label in zip(panels, TERMS, labels, strict=False):
        values = terms[name].isel(rod=-1).to_numpy()
        x = np.broadcast_to(length[:, None], arc.shape)
        drawn = axes.pcolormesh(x, arc, values, shading="gouraud", rasterized=True)
        axes.axvline(critical, color="white", linewidth=0.7, linestyle=":")
        axes.set_xlabel("length L (units of length)")
        bottom.colorbar(drawn, ax=axes, location="top", label=f"{label} (B/length²)", aspect=15)
    panels[0].set_ylabel("arc length from the nucleation site")
    _dissipation(panels[3], data, critical, rates)
    return figure


def _shapes(figure: Any, data: xr.Dataset) -> None:
    mesh, slow = triangulate(_bridge(NECK), 48), data.isel(rod=-1)
    frames = [int(np.argmin(abs(slow["length"].to_numpy() - length))) for length in SNAPSHOTS]
    limits = (0.0, float(slow["energy_density"].isel(frame=frames).max()))
    panels = figure.subplots(1, len(SNAPSHOTS))
    for axes, frame, length in zip(panels, frames, SNAPSHOTS, strict=True):
        now = slow.isel(frame=frame)
        line = now["position"].to_numpy()
        energy = [now["energy_density"].to_numpy()]
        drawn = plots.tubes(axes, [line], energy, radius=0.03, view=VIEW, limits=limits, membrane=mesh)
        plots.tubes(axes, [line[:2]], radius=0.05, view=VIEW, colour="white")  # the nucleation site
        axes.set_title(f"L = {length:g}")
    plots.scale_bar(panels[0], 0.5, "0.5")
    for axes in panels:
        axes.set_ylim(panels[0].get_ylim())
    figure.colorbar(drawn, ax=panels, shrink=0.7, label="elastic energy per length (B/length²)")


def _dissipation(axes: Any, data: xr.Dataset, critical: float, rates: np.ndarray) -> None:
    for rod, (rate, colour) in enumerate(zip(rates, plots.OKABE_ITO, strict=False)):
        dissipated = data["dissipation"].isel(rod=rod).to_numpy()[3:] / rate
        axes.semilogy(data["length"].isel(rod=rod).to_numpy()[3:], dissipated, color=colour, label=f"rate {rate:g}")
    axes.axvline(critical, color="0.4", linewidth=0.7, linestyle=":")
    axes.set_xlabel("length L (units of length)")
    axes.set_ylabel("energy dissipated per length grown (B/length²)")
    axes.legend()
