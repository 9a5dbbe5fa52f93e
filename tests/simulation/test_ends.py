"""Open surfaces of formulas: filaments are placed inside, warned of near the end, and frozen there with a status."""

import numpy as np
import pytest

from warp_rods.errors import RodFailure, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

SHEET = {"kind": "expression", "phi": "z - 0.1*sin(2*x)", "box": [[-1, 1], [-1, 1], [-1, 1]]}


def scene(placement, count: int = 1, steric: bool = False, **values) -> Scene:
    filaments = {
        "name": "f", "count": count, "nodes": 17, "length": 0.6, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
        "placement": placement,
    }  # fmt: skip
    tables = {"steric": {"strength": 20, "range": 0.02, "core": 0.04}} if steric else {}
    return Scene.parse({"surface": SHEET, "filaments": [filaments | values], "time": {"end": 0.2}, **tables})


def at(*position) -> dict:
    return {"position": [list(position)], "direction": [[0, 1, 0]]}


@pytest.mark.parametrize("steric", [False, True])
def test_filaments_are_placed_whole_inside_the_box(steric):
    simulation = Simulation(scene("random", 20, steric), "cpu")
    rods = simulation.ensembles["f"]
    assert not rods.status.any() and (np.abs(rods.position) <= 1).all()


@pytest.mark.long
def test_filaments_that_stick_out_or_do_not_fit_are_refused():
    with pytest.raises(SceneError, match=r"filaments\[0\].placement: rod 0 reached the end of its surface, the box"):
        Simulation(scene(at(0, 0.9, 0)), "cpu")
    with pytest.raises(SceneError, match=r"filaments\[0\].length = 3: no place was found where the filament is in"):
        Simulation(scene("random", length=3.0), "cpu")


def test_a_filament_near_the_end_is_warned_of_and_frozen_there():
    simulation = Simulation(scene(at(0, 0, 0)), "cpu")
    simulation.ensembles["f"].force = np.array([0.0, 4.0, 0.0])
    lines = []
    with pytest.raises(RodFailure, match="rod 0 reached the end of its surface, the box beyond which φ is not given"):
        while not simulation.finished:
            for _ in simulation.to_next_frame():
                pass
            simulation.variables()
            lines += simulation.new_warnings()
            simulation.new_failures()
    assert len(lines) == 1
    assert "1 of f are close to the end of their surface (rod 0 is 0.0" in lines[0] and "is frozen" in lines[0]
