"""The trajectory of a simulation in memory, as ``open_run`` reads it from a run folder."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import xarray as xr

from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.variables import ARC, TIME, static_variable
from warp_rods.scene.scene import Scene
from warp_rods.simulation.hooks import EveryFrame
from warp_rods.simulation.loop import Simulation

__all__ = ["Record", "bytes_of_a_rod", "drifting", "still"]

DRIFT = 1e-3
"""In a run, small enough for measures that follow rods through a periodic box."""

Frames = Mapping[str, np.ndarray]
"""Variables of an ensemble, [frame, …] where they change."""


class Record:
    """The frames of a simulation, of which it keeps the ``wanted`` variables; made before the simulation advances."""

    def __init__(self, simulation: Simulation, wanted: Collection[str]):
        self._simulation, self._wanted, self._count = simulation, wanted, 0
        self._frames: dict[str, dict[str, np.ndarray]] = {name: {} for name in simulation.ensembles}
        simulation.attach(EveryFrame(), self._keep)

    def _keep(self, simulation: Simulation) -> None:
        frames = _lean(simulation, self._wanted) if simulation.own_steps else simulation.variables()
        for name, frame in frames.items():
            saved, kept = simulation.ensembles[name].saved, self._frames[name]
            for key, value in frame.items():
                if key in self._wanted:
                    if self._count == 0:
                        kept[key] = np.empty((len(simulation.frames.times), *value.shape), saved[key].dtype)
                    kept[key][self._count] = value
        self._count += 1

    def data(self, scene: Scene | None = None) -> xr.DataTree:
        """The trajectory so far: one group for each ensemble. scene: that of the points, where this is a batch."""
        frames = {name: {key: v[: self._count] for key, v in kept.items()} for name, kept in self._frames.items()}
        return _tree(self._simulation, self._simulation.frames.times[: self._count], frames, scene)


def _lean(simulation: Simulation, wanted: Collection[str]) -> dict[str, dict[str, np.ndarray]]:
    """``simulation.variables()`` of rods that feel nothing, without those that are not wanted."""
    found = {}
    for name, ensemble in simulation.ensembles.items():
        ensemble.show()
        of_contact = [key for key in ("steric_energy", "wall_energy") if key in wanted and key in ensemble.saved]
        found[name] = ensemble.variables(wanted) | {key: np.zeros(ensemble.count) for key in of_contact}
    return found


def still(simulation: Simulation) -> xr.DataTree:
    """A trajectory of the shape of a whole run in which nothing moves."""
    times = simulation.frames.times
    frames = {
        name: {key: np.broadcast_to(value, (len(times), *value.shape)) for key, value in frame.items()}
        for name, frame in simulation.variables().items()
    }
    return _tree(simulation, times, frames)


def drifting(simulation: Simulation) -> xr.DataTree:
    """As ``still``, but every number drifts, by rates that differ between rods; ``DRIFT`` is the fastest.

    What a measure takes from the motion, such as the bins of a histogram of speeds, is not what it is in ``still``.
    """
    times = simulation.frames.times

    def moved(value: np.ndarray) -> np.ndarray:
        if value.dtype.kind != "f":
            return np.broadcast_to(value, (len(times), *value.shape))
        rates = np.linspace(DRIFT, 2 * DRIFT, len(value)) / 2
        path = np.multiply.outer(times / times[-1], rates)  # [frame, rod]
        return value + path.reshape(*path.shape, *(1,) * (value.ndim - 1))

    frames = {name: {k: moved(v) for k, v in frame.items()} for name, frame in simulation.variables().items()}
    return _tree(simulation, times, frames)


def bytes_of_a_rod(simulation: Simulation, wanted: Collection[str]) -> float:
    """Bytes of the trajectory of a rod in memory, on average."""
    total = sum(
        value.size * np.dtype(simulation.ensembles[name].saved[key].dtype).itemsize
        for name, frame in simulation.variables().items()
        for key, value in frame.items()
        if key in wanted
    )
    return total * len(simulation.frames.times) / simulation.rods


def _tree(
    simulation: Simulation, times: np.ndarray, frames: Mapping[str, Frames], scene: Scene | None = None
) -> xr.DataTree:  # fmt: skip
    """Groups with the attributes of ``open_run``: units, and the scene for its box and its membrane."""
    scene = scene or simulation.scene
    period = np.array(scene.period)
    space = {"period": np.where(period > 0, period, np.inf)}
    about = {"scene": scene.to_toml(), "units": scene.units.said if scene.units else "dimensionless"}
    groups = {name: _dataset(e, times, frames[name], e.static() | space) for name, e in simulation.ensembles.items()}
    return xr.DataTree.from_dict({name: group.assign_attrs(about) for name, group in groups.items()})


def _dataset(ensemble: Ensemble, times: np.ndarray, frames: Frames, static: Frames) -> xr.Dataset:
    """The variables of an ensemble with their dimensions, labels and attributes."""
    rows = {key: (ensemble.saved[key], values) for key, values in frames.items()}
    nodes = (ensemble.nodes - 1) // ensemble.stride + 1
    rows |= {key: (static_variable(key, value.ndim), value) for key, value in static.items()}
    rows |= {"time": (TIME, times), "s": (ARC, np.linspace(-0.5, 0.5, nodes))}
    variables = {key: (row.dims, value, row.attributes) for key, (row, value) in rows.items()}
    labels = {dim: list(names) for row, _ in rows.values() for dim, names in row.labels.items()}
    return xr.Dataset(variables, coords=labels).set_coords(["time", "s"])
