"""A user's script: type-checked against the installed package by ``.ci/run`` (not run)."""

from typing import assert_type

import numpy as np
import xarray as xr
from matplotlib.figure import Figure  # noqa: TID253 (not run)

import warp_rods as wr

run = wr.run("scenes/swimmer.toml", out="runs/a")
assert_type(run, wr.Run)
assert_type(run.messages, list[str])
assert_type(wr.open_run("runs/a"), xr.DataTree)

rods = wr.FreeRods(2, 65, bend=[5e-3, 1e-3], twist=1e-3)
rods.step(1e-3, steps=10)
rods.step(np.float32(1e-3), np.int64(10))
assert_type(rods.bend, np.ndarray)
assert_type(rods.count, int)
assert_type(rods.flagella, wr.Flagella)
rods.bend = rods.bend  # type: ignore[assignment]
rods.count = 3  # type: ignore[assignment]
rods.force = [0.0, 0.0, 0.1]
position: np.ndarray = rods.position
assert_type(rods.time, float)
assert_type(rods.failures()[0].what, str)

torus = wr.surfaces.make("torus", {"major": 1.0, "minor": 0.4})
assert_type(torus, wr.Surface)
bound = wr.BoundRods(torus, [[1.4, 0, 0]], [[0, 1, 0.3]])
energy: np.ndarray = bound.energy
assert_type(bound.length, np.ndarray)
assert_type(bound.surface, wr.Surface)
assert_type(bound.ends, tuple[str, str])

assert_type(wr.measure(run.data, "speed"), xr.Dataset)
assert_type(wr.plot(run.data, "speed"), Figure)
assert_type(wr.plots.figure(), Figure)
assert_type(wr.__version__, str)


def enough(simulation: wr.Simulation) -> None:
    if simulation.now > 1.0:
        simulation.stop("enough")


wr.run(wr.Scene.load("scenes/swimmer.toml"), hooks=[(wr.every(time=0.1), enough)])
