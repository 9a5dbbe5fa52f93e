"""Scenes that are too large, too wide or too long-ranged are refused with the key, before memory is taken."""

import pytest

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

CELLS = {"name": "c", "count": 2, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
FILAMENTS = {"name": "f", "count": 4, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
STERIC = {"strength": 1.0, "range": 0.02, "core": 0.08}


def scene(**tables) -> Scene:
    return Scene.parse({"time": {"end": 1.0}, **tables})


def test_more_nodes_than_memory_are_refused():
    with pytest.raises(SceneError, match=r"swimmers\[0\]\.count = 10000000, nodes = 999 need about .* GiB"):
        Simulation(scene(swimmers=[CELLS | {"count": 10**7, "nodes": 999}]), "cpu")


def test_more_neighbours_than_memory_are_refused():
    tables = {"surface": {"kind": "sphere", "radius": 1.0}, "filaments": [FILAMENTS | {"nodes": 99_999}]}
    with pytest.raises(SceneError, match=r"filaments\[0\]\.nodes = 99999: each has .* neighbours"):
        Simulation(scene(**tables, steric=STERIC), "cpu")


def test_a_range_whose_square_overflows_is_refused():
    with pytest.raises(SceneError, match=r"steric\.range = 1e\+300: must be 1e\+100 at most"):
        Simulation(scene(swimmers=[CELLS], steric=STERIC | {"range": 1e300}), "cpu")


def test_a_box_of_any_size_has_a_grid_of_cells():
    box = {"kind": "periodic", "size": [1e10, 1e10, 1e10]}
    simulation = Simulation(scene(swimmers=[CELLS | {"placement": "random"}], box=box, steric=STERIC), "cpu")
    assert simulation.rods == 2
