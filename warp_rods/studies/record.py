"""The trajectory of a simulation in memory, as ``open_run`` reads it from a run folder."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import xarray as xr

from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.variables import ARC, TIME, static_variable
from warp_rods.simulation.hooks import EveryFrame
from warp_rods.simulation.loop import Simulation

__all__ = ["Record", "bytes_of_a_rod", "still"]

Frame = Mapping[str, np.ndarray]


class Record:
    """The frames of a simulation, of which it keeps the ``wanted`` variables; made before the simulation advances."""

    def __init__(self, simulation: Simulation, wanted: Collection[str]):
        self._simulation, self._wanted = simulation, wanted
        self._times: list[float] = []
        self._frames: dict[str, list[Frame]] = {name: [] for name in simulation.ensembles}
        simulation.attach(EveryFrame(), self._keep)

    def _keep(self, simulation: Simulation) -> None:
        self._times.append(simulation.time)
        for name, frame in simulation.variables().items():
            saved = simulation.ensembles[name].saved
            kept = {key: np.asarray(value, saved[key].dtype) for key, value in frame.items() if key in self._wanted}
            self._frames[name].append(kept)

    def data(self) -> xr.DataTree:
        """The trajectory so far: one group for each ensemble."""
        return _tree(self._simulation, self._times, self._frames)


def still(simulation: Simulation) -> xr.DataTree:
    """A trajectory of the shape of a whole run in which nothing moves."""
    times = simulation.frames.times.tolist()
    return _tree(simulation, times, {name: [frame] * len(times) for name, frame in simulation.variables().items()})


def bytes_of_a_rod(simulation: Simulation, wanted: Collection[str]) -> float:
    """Bytes of the trajectory of a rod in memory, on average."""
    total = sum(
        value.size * np.dtype(simulation.ensembles[name].saved[key].dtype).itemsize
        for name, frame in simulation.variables().items()
        for key, value in frame.items()
        if key in wanted
    )
    return total * len(simulation.frames.times) / simulation.rods


def _tree(simulation: Simulation, times: Sequence[float], frames: Mapping[str, Sequence[Frame]]) -> xr.DataTree:
    period = np.array(simulation.scene.period)
    space = {"period": np.where(period > 0, period, np.inf)}
    return xr.DataTree.from_dict(
        {name: _dataset(e, times, frames[name], e.static() | space) for name, e in simulation.ensembles.items()}
    )


def _dataset(ensemble: Ensemble, times: Sequence[float], frames: Sequence[Frame], static: Frame) -> xr.Dataset:
    """The variables of an ensemble with their dimensions, labels and attributes."""
    rows = {key: (ensemble.saved[key], np.stack([frame[key] for frame in frames])) for key in frames[0]}
    nodes = (ensemble.nodes - 1) // ensemble.stride + 1
    rows |= {key: (static_variable(key, value.ndim), value) for key, value in static.items()}
    rows |= {"time": (TIME, np.array(times)), "s": (ARC, np.linspace(-0.5, 0.5, nodes))}
    variables = {key: (row.dims, value, row.attributes) for key, (row, value) in rows.items()}
    labels = {dim: list(names) for row, _ in rows.values() for dim, names in row.labels.items()}
    return xr.Dataset(variables, coords=labels).set_coords(["time", "s"])
