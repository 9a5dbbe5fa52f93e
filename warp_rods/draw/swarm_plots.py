"""One small plot for each measure of swarms: functions ``(axes, measured)`` of what ``swarm.measure`` gave.

Axes are those of Matplotlib; ``measured`` is one DataArray, whose attributes name the axes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.plots import OKABE_ITO

BLUE = OKABE_ITO[0]
GUIDE = {"color": "0.5", "linewidth": 0.8, "linestyle": "--"}
LATE = 0.5
"""Part of the run, its end, that correlations are averaged over."""


def over_time(axes: Any, measured: xr.DataArray) -> None:
    """One value a frame against time."""
    axes.plot(*_timed(axes, measured), color=BLUE)
    axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    axes.set_ylabel(_label(measured))


def order(axes: Any, measured: xr.DataArray) -> None:
    """An order between 0 and 1 against time, beside that of as many rods of any direction."""
    over_time(axes, measured)
    axes.axhline(measured.attrs["isotropic"], label="any direction, 1/√N", **GUIDE)
    axes.set_ylim(0, 1.02)
    axes.legend()


def local_order(axes: Any, measured: xr.DataArray) -> None:
    """The mean over the rods against time, and between which values the middle half of them is."""
    low, high = measured.quantile([0.25, 0.75], "rod").to_numpy()
    time, mean = _timed(axes, measured.mean("rod"))
    axes.fill_between(time, low, high, color=BLUE, alpha=0.25, linewidth=0, label="middle half of the rods")
    axes.plot(time, mean, color=BLUE, label=f"mean, within a distance of {measured.attrs['radius']:.3g}")
    axes.set_ylim(0, 1.02)
    axes.set_ylabel(_label(measured))
    axes.legend()


def speed_distribution(axes: Any, measured: xr.DataArray) -> None:
    """Density of probability against speed."""
    axes.stairs(measured, _bin_edges(measured["speed"].to_numpy()), color=BLUE, fill=True, alpha=0.25)
    axes.stairs(measured, _bin_edges(measured["speed"].to_numpy()), color=BLUE)
    axes.set(xlim=(0, None), ylim=(0, None), xlabel=_label(measured["speed"]), ylabel=_label(measured))


def mean_square_displacement(axes: Any, measured: xr.DataArray) -> None:
    """Against lag, both logarithmic, with the slopes of straight motion and of diffusion."""
    lag, msd = measured["lag"].to_numpy(), measured.to_numpy()
    axes.loglog(lag, msd, color=BLUE)
    limits = axes.get_ylim()
    axes.plot(lag, msd[0] * (lag / lag[0]) ** 2, label="lag²", **GUIDE)
    axes.plot(lag, msd[-1] * lag / lag[-1], label="lag", **(GUIDE | {"linestyle": ":"}))
    axes.set(ylim=limits, xlabel=_label(measured["lag"]), ylabel=_label(measured))
    _readable(axes.xaxis)
    _readable(axes.yaxis)
    axes.legend()


def displacement_exponent(axes: Any, measured: xr.DataArray) -> None:
    """Against lag, with those of straight motion and of diffusion."""
    axes.semilogx(measured["lag"], measured, color=BLUE)
    for value in (1, 2):
        axes.axhline(value, **GUIDE)
    axes.set(ylim=(0, 2.1), xlabel=_label(measured["lag"]), ylabel=_label(measured))
    _readable(axes.xaxis)


def pair_correlation(axes: Any, measured: xr.DataArray) -> None:
    """g(r), mean over the later half of the frames, with the band that independent rods stay in in one of them."""
    late = _late(measured)
    error = 1 / np.sqrt(np.maximum(late["expected"].mean("frame").to_numpy(), 1e-9))
    r = late["r"].to_numpy()
    axes.fill_between(r, 1 - error, 1 + error, color="0.85", linewidth=0, label="uniform, one frame")
    axes.plot(r, late.mean("frame"), color=BLUE, label="later half")
    axes.set(xlim=(0, None), xlabel=_label(measured["r"]), ylabel=_label(measured))
    axes.set_ylim(0, 1.1 * max(1.5, float(late.mean("frame").max())))
    axes.legend()


def velocity_correlation(axes: Any, measured: xr.DataArray) -> None:
    """C_v(r), mean over the later half of the frames."""
    late = _late(measured)
    there = late.notnull().any("frame")
    values = late[:, there.to_numpy()].mean("frame")
    axes.plot(values["r"], values, color=BLUE, marker="o")
    axes.axhline(0, **GUIDE)
    axes.set_ylim(min(-0.2, 1.1 * float(values.min())), max(0.5, 1.1 * float(values.max())))
    axes.set(xlim=(0, None), xlabel=_label(measured["r"]), ylabel=_label(measured))


def density_map(axes: Any, measured: xr.DataArray) -> None:
    """The map of the last frame; in space its mean along z."""
    last = measured.isel(frame=-1)
    last = last.mean("z") if last.ndim == 3 else last
    one, other = last.dims
    limits = [_bin_edges(last[side].to_numpy()) for side in (one, other)]
    drawn = axes.pcolormesh(*limits, last.to_numpy().T, vmin=0, rasterized=True)
    axes.set(aspect="equal", xlabel=f"{one} (length)", ylabel=f"{other} (length)")
    axes.figure.colorbar(drawn, ax=axes, label=_label(measured))
    axes.set_title(f"at t = {float(last['time']):.4g}" + (", mean along z" if measured.ndim == 4 else ""))


def shape_shares(axes: Any, measured: xr.DataArray) -> None:
    """Shares of the classes against time, one on top of the other."""
    time, _ = _timed(axes, measured)
    names = [str(name) for name in measured["shape"].to_numpy()]
    axes.stackplot(time, measured.transpose("shape", "frame").to_numpy(), labels=names, colors=OKABE_ITO, linewidth=0)
    axes.set(xlim=(time[0], time[-1]), ylim=(0, 1), ylabel=_label(measured))
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], labels[::-1], loc="center left", bbox_to_anchor=(1.0, 0.5))


def crossings(axes: Any, measured: xr.DataArray) -> None:
    """Number of crossings so far against time."""
    time, values = _timed(axes, measured)
    axes.step(time, np.cumsum(values), where="post", color=BLUE)
    axes.set_ylim(-0.05, max(1.0, 1.05 * float(values.sum())))
    axes.set_ylabel("crossings so far")


def _readable(axis: Any) -> None:
    """A logarithmic axis with a few plain numbers on it, even where it spans less than a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _timed(axes: Any, measured: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Times and values; the axis below is that of time."""
    axes.set_xlabel("time")
    return measured["time"].to_numpy(), measured.to_numpy()


def _label(measured: xr.DataArray) -> str:
    return str(measured.attrs["long_name"]) + _in(str(measured.attrs.get("units", "1")))


def _in(units: str) -> str:
    return f" ({units.replace('^2', '²').replace('^3', '³')})" if units not in ("", "1") else ""


def _late(measured: xr.DataArray) -> xr.DataArray:
    return measured.isel(frame=slice(int(LATE * measured.sizes["frame"]), None))


def _bin_edges(middles: np.ndarray) -> np.ndarray:
    """Edges of bins of even width with these middles."""
    half = (middles[1] - middles[0]) / 2 if len(middles) > 1 else 0.5
    return np.append(middles - half, middles[-1] + half)
