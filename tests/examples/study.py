"""Small studies that take a second or two."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.scene.scene import Scene
from warp_rods.studies.columns import Column
from warp_rods.studies.new_store import create
from warp_rods.studies.plan import Plan
from warp_rods.studies.store import OWN, STORE, Store

CELL = {"name": "cell", "count": 1, "nodes": 17, "bend": 5e-3, "twist": 1e-3,
        "shape": {"mode": 0, "amplitude": 3.0, "perturbation": 0.1}}  # fmt: skip
SENSOR = {"name": "sensors", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1.0, 1.0, 1.0],
          "intrinsic": [0.0, 0.0, 0.0], "drag": [1.0, 2.0, 0.1]}  # fmt: skip
TIME = {"end": 0.06, "save_every": 0.005}
BEND = {"swimmers.cell.bend": {"from": 1e-3, "to": 1e-2, "num": 4, "scale": "log"}}
MOMENT = {"swimmers.cell.moment": [0.0, 2e-3, 1e-2]}


def cells(sweep: dict[str, Any] | None = None, **tables: Any) -> Scene:
    """Swimmers over bending stiffness and active moment, two seeds."""
    table = {**BEND, **MOMENT, "seeds": 2, "measure": ["speed", "class", "modes"], **(sweep or {})}
    return Scene.parse({"swimmers": [CELL], "time": TIME, "sweep": table, **tables})


def sensors(**sweep: Any) -> Scene:
    """Filaments on a sphere over a component of their intrinsic strains."""
    table = {"filaments.sensors.intrinsic.1": [0.0, 1.0], "seeds": [3, 8], "measure": ["gauss"], **sweep}
    surface = {"kind": "sphere", "radius": 1.0}
    return Scene.parse({"surface": surface, "filaments": [SENSOR], "time": TIME, "sweep": table})


# --- stores that are written by hand ---------------------------------------------------------------------------------

SPEED = Column("speed", attributes={"units": "length/time", "long_name": "speed", "ancillary_variables": "settled"})
CLASS = Column("class", text=True, attributes={"units": "1", "long_name": "class"})


def store_of(plan: Plan, folder, chunk=None, columns=(SPEED, CLASS)) -> Store:
    """A study in a folder of which no point is computed."""
    (folder / "scene.toml").write_text(plan.scene.to_toml())
    own = [name for name in OWN if name != "trajectory"]
    return create(folder / STORE, plan.axes, columns, chunk or plan.shape, own, {"scene": plan.scene.to_toml()}, {})


def put(store: Store, mask: np.ndarray, **values) -> None:
    """Write values, which are [key, …] or one for all, at the points of a mask."""
    for chunk in store.chunks():
        here = np.zeros_like(mask)
        here[store.region(chunk)] = mask[store.region(chunk)]
        points = [tuple(map(int, point)) for point in np.argwhere(here)]
        at = tuple(np.array(points).T)
        if points:
            whole = {
                name: np.broadcast_to(np.asarray(v), mask.shape)[at] for name, v in ({"state": 1} | values).items()
            }
            store.put(chunk, points, whole)
