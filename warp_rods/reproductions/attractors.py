"""Fig 4.3a–d: attractors of swimmers with an active moment, reached from several initial shapes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from warp_rods.analysis.motion import instantaneous_speed, speed
from warp_rods.analysis.motion_class import period, shape_class
from warp_rods.analysis.shape import mode_coefficients, twist_harmonics
from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.reproductions.swimmers import LATE, SAVE_EVERY, STARTS, Case, late_frames, late_times, simulate

VIEW = (-70.0, 35.0)
"""Width of a panel of Fig 4.3, in units of L."""
SPEED_TOLERANCE = 0.02
"""Largest relative difference of the mean speed |u| of the midpoint between two late motions that count as equal."""


class Panel(NamedTuple):
    """A panel of Fig 4.3: parameters of the caption, ηr chosen here, the class of motion, and its published name."""

    bend: float
    twist: float
    moment: float
    rotational_drag: float
    motion: str
    published: str


PANELS = {
    "a": Panel(2.5e-4, 1e-4, 6e-3, 3e-3, "twisted-U", "a U-shaped swimmer with a twist"),
    "b": Panel(8e-5, 1e-5, 1.35e-2, 3e-3, "waving", "a limit cycle, waving while twisting"),
    "c": Panel(5.45e-5, 1e-3, 1e-2, 5e-3, "S", "convergence to a twisted-S shape"),
    "d": Panel(1.25e-4, 1e-3, 2e-2, 1e-3, "flapping", "periodic flapping"),
}
"""By the letter in Fig 4.3. ``motion`` is a class of ``motion_class``. 3e-3 is the default ηr of this package."""


def attractor(letter: str, quick: bool) -> Result:
    """One of Fig 4.3a–d: bodies over half a period, or approaching a fixed shape, and trajectories of six starts."""
    panel, starts = PANELS[letter], list(STARTS)[:2] if quick else list(STARTS)
    end = 60.0  # twist relaxes at the rate π²β∥/ηr, which is 0.03 in panel b
    early = np.concatenate([np.linspace(0.0, 4.0, 401), np.arange(4.1, end - LATE - 0.05, 0.1)])
    times = np.concatenate([early, late_times(end)])
    motion = simulate([Case(*panel[:4], start) for start in starts], times)
    coordinates = _coordinates(motion)
    data = xr.Dataset(
        {
            **{name: coordinates[..., index] for index, name in enumerate(("a0", "a1", "b0"))},
            "position": motion["position"].astype(np.float32),
        },
        attrs={**panel._asdict(), "starts": starts},
    )
    settled = late_frames(motion)
    cycle_time = float(period(settled, float(settled["time"][0]))[0])
    rows = _rows(panel, settled, starts, cycle_time)
    rows += _coordinate_rows(coordinates.isel(rod=0, frame=slice(-settled.sizes["frame"], None)), cycle_time)
    note = (
        f"β⊥ = {panel.bend:g}, β∥ = {panel.twist:g}, M = {panel.moment:g} (caption); ηr = {panel.rotational_drag:g} "
        f"chosen to give the published motion (fig4.3map); symmetry of C.4 imposed; late: the last {LATE:g} of "
        f"{end:g} time units"
    )
    return Result(_figure(motion, coordinates, starts, cycle_time), rows, data, (note,))


def _rows(panel: Panel, settled: xr.Dataset, starts: list[str], cycle_time: float) -> list[Comparison]:
    classes = shape_class(settled, float(settled["time"][0])).to_numpy()
    midpoint_speed = instantaneous_speed(settled).mean("frame").to_numpy()
    same = int(((classes == classes[0]) & (abs(midpoint_speed / midpoint_speed[0] - 1) < SPEED_TOLERANCE)).sum())
    agrees, reached = bool(classes[0] == panel.motion), f"{same} of {len(starts)}"
    rows = [
        Comparison("motion", panel.published, str(classes[0]), "from the coil (C.63)–(C.65), late", agrees),
        Comparison("starts that come to it", "a range of initial conditions", reached, ", ".join(starts)),
        Comparison("period, ζ∥L/f*", "", cycle_time if np.isfinite(cycle_time) else "steady", "of the shape"),
        Comparison("mean |u| of the midpoint, f*/ζ∥", "", float(midpoint_speed[0])),
        Comparison("largest |Ω₀|, 1/L", "", float(abs(settled["strain"][..., 0]).max()), "late, over all starts"),
    ]  # fmt: skip
    if panel.motion == "flapping":
        ratio = float(speed(settled)[0] / midpoint_speed[0])
        published = "average speeds tend to zero"
        rows.append(
            Comparison("U_swim over mean |u|", published, ratio, f"over T = {LATE:g}, from the coil", ratio < 0.1)
        )
    return rows


def _coordinate_rows(coordinates: xr.DataArray, cycle_time: float) -> list[Comparison]:
    """Amplitudes of a limit cycle, or the coordinates of a fixed shape."""
    names = ("a₀", "a₁", "b₀")
    if np.isfinite(cycle_time):
        found = {f"half range of {name}, 1/L": np.ptp(coordinates[:, i].to_numpy()) / 2 for i, name in enumerate(names)}
    else:
        found = {f"{name}, 1/L": float(coordinates[-1, i]) for i, name in enumerate(names)}
    return [Comparison(name, "", float(value), "(4.48)–(4.50), late, from the coil") for name, value in found.items()]


def _coordinates(motion: xr.Dataset) -> xr.DataArray:
    """a₀, a₁, b₀ (frame, rod, coordinate) of (4.48)–(4.50), with the sign that makes the larger late bending positive.

    Rotating the directors by π about the tangent changes the signs of a₀ and a₁ and nothing else.
    """
    modes = mode_coefficients(motion, 2).to_numpy()
    bends = np.stack([modes[:, :, 1, 0], modes[:, :, 0, 1]], axis=-1)
    mean = bends[-1 - round(LATE / SAVE_EVERY) :].mean(axis=0)
    larger = np.take_along_axis(mean, np.abs(mean).argmax(axis=1)[:, None], axis=1)
    twist = twist_harmonics(motion, 1).to_numpy()
    values = np.concatenate([bends * np.where(larger < 0, -1.0, 1.0), twist], axis=-1)
    return xr.DataArray(values, {"time": motion["time"]}, ("frame", "rod", "coordinate"), attrs={"units": "1/L"})


def _figure(motion: xr.Dataset, coordinates: xr.DataArray, starts: list[str], cycle_time: float) -> Any:
    figure = plots.figure(plots.COLUMN, 112)
    top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(1, 1.35))[:, 0]
    _snapshots(top, motion, cycle_time)
    axes = bottom.add_subplot(projection="3d")
    values = coordinates.to_numpy()
    approach = values[: -1 - round(LATE / SAVE_EVERY)]
    for rod, (start, colour) in enumerate(zip(starts, plots.OKABE_ITO, strict=False)):
        axes.plot(*approach[:401, rod].T, color=colour, linewidth=0.6, label=start)
        # Later frames are too far apart to be joined by lines.
        axes.plot(*approach[401:, rod].T, ".", color=colour, markersize=0.8, markeredgewidth=0, rasterized=True)
        axes.plot(*values[:1, rod].T, "o", color=colour, markersize=2.5)
    if np.isfinite(cycle_time):
        last = values[-1 - round(cycle_time / SAVE_EVERY) :, 0]
        axes.plot(*last.T, color="black", linewidth=1.0, label="limit cycle")
    else:
        axes.plot(*values[-1:, 0].T, "*", color="black", markersize=6, label="fixed shape", zorder=10)
    axes.set_xlabel("$a_0$ (1/L)", labelpad=-5)
    axes.set_ylabel("$a_1$ (1/L)", labelpad=-5)
    axes.set_zlabel("$b_0$ (1/L)", labelpad=-4)
    axes.tick_params(pad=-2)
    axes.locator_params(nbins=5)
    axes.view_init(22, -55)
    axes.set_box_aspect((1, 1, 0.8), zoom=1.2)
    bottom.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, columnspacing=0.8)
    return figure


def _snapshots(figure: Any, motion: xr.Dataset, cycle_time: float) -> None:
    """Six bodies in two rows, coloured by bending, over half a period or approaching a fixed shape."""
    time = motion["time"].to_numpy()
    wanted = np.array([0.0, 0.1, 0.4, 1.0, 2.0, time[-1]])
    if np.isfinite(cycle_time):
        wanted = time[-1] - cycle_time / 2 * np.linspace(1, 0, 6)
    frames = [int(np.argmin(abs(time - when))) for when in wanted]
    lines = motion["position"].isel(frame=frames, rod=0).to_numpy()
    lines = lines - lines.mean(axis=1, keepdims=True)
    bending = np.linalg.norm(motion["strain"].isel(frame=frames, rod=0).to_numpy()[..., 1:], axis=-1)
    limits = (0.0, float(bending.max()))
    panels = figure.subplots(2, 3)
    for axes, line, bend, frame in zip(panels.flat, lines, bending, frames, strict=True):
        drawn = plots.tubes(axes, [line], [bend], radius=0.024, view=VIEW, limits=limits)
        axes.set_title(f"t = {time[frame]:.2f}", fontsize=6)
    plots.scale_bar(panels[1, 0], 0.25, "L/4")
    plots.one_scale(list(panels.flat))
    figure.colorbar(drawn, ax=panels, shrink=0.7, aspect=18, label="bending $|\\Omega_\\perp|$ (1/L)")
