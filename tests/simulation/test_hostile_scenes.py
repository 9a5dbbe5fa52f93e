"""Scenes that ended in a traceback, took minutes, or ran where they must not: each runs, or names its key."""

import pytest

from warp_rods.errors import RodFailure, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.runner import simulate

CELLS = {"name": "c", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
FILAMENTS = {"name": "f", "count": 2, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
BOX = [[-1, 1], [-1, 1], [-1, 1]]
SPHERE = {"kind": "sphere", "radius": 1}
PLANE = {"kind": "plane", "size": 5e8}
STERIC = {"strength": 5, "range": 0.02, "core": 0.03}
HUGE = 10**400


def on(surface: dict, **filaments) -> dict:
    return {"surface": surface, "filaments": [FILAMENTS | filaments]}


REFUSED = {
    "a bound of a box": (
        on({"kind": "expression", "phi": "x", "box": [[-HUGE, 1], *BOX[1:]]}),
        r"surface\.box = .* numbers that increase",
    ),
    "a parameter": (
        on({"kind": "expression", "phi": "x - R", "box": BOX, "parameters": {"R": HUGE}}),
        r"surface\.parameters\.R = 1000.* must be a number",
    ),
    "a spacing": (
        on({"kind": "grid", "file": "none.ply", "spacing": HUGE}),
        r"surface\.spacing = 1000.* must be a positive",
    ),
    "a count": (
        {"swimmers": [CELLS | {"count": 10**7, "nodes": 33}]},
        r"swimmers\[0\]\.count = 10000000.* at most about",
    ),
    "a small surface": ({"swimmers": [CELLS], "surface": {"kind": "plane", "size": 1e-300}}, r"surface\.size = 1e-300"),
    "growth without times": (
        on(SPHERE, growth={"time": [], "length": []}),
        r"growth\.time = \[\]: must be increasing times",
    ),
    "a high mode": (
        {"swimmers": [CELLS | {"shape": {"mode": 1_000_000}}]},
        r"swimmers\[0\]\.shape\.mode = 1000000: must be",
    ),
    "a mode beyond numbers": (
        {"swimmers": [CELLS | {"shape": {"mode": HUGE}}]},
        r"swimmers\[0\]\.shape\.mode = 1000.*: must be",
    ),
    "a mode above the grid": (
        {"swimmers": [CELLS | {"shape": {"mode": 12, "amplitude": 3.0}}]},
        r"shape\.mode = 12: 17 nodes for the 13\.5 half-waves",
    ),
    "neighbours": (
        on(SPHERE, count=4, nodes=99_999) | {"steric": STERIC},
        r"filaments\[0\]\.count = 4, nodes = 99999.* not one",
    ),
    "an intrinsic strain": (
        on(PLANE, intrinsic=[0, 0, 1e308]) | {"steric": STERIC},
        r"filaments\[0\]\.intrinsic\[2\] = 1e\+308.* at most 1e\+30",
    ),
    "a range": (
        {"swimmers": [CELLS], "steric": STERIC | {"range": 1e300}},
        r"steric\.range = 1e\+300.* at most 1e\+30",
    ),
    "a crowd": (
        on({"kind": "cassini", "a": 1.0, "b": 1.1}, count=257) | {"steric": STERIC | {"strength": 40}},
        r"filaments\[0\]\.count = 257: after \d+ draws only \d+ fit 0\.03 apart",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_run_names_its_key(name):
    tables, said = REFUSED[name]
    with pytest.raises(SceneError, match=said) as caught:
        Simulation(Scene.parse({"time": {"end": 1}, **tables}), "cpu")
    assert caught.value.exit_code == 2


RUN = {
    "a huge box": {
        "swimmers": [CELLS | {"count": 2, "placement": "random"}],
        "box": {"kind": "periodic", "size": [1e10, 1e10, 1e10]},
        "steric": {"strength": 1, "range": 0.02, "core": 0.08},
    },
    "the smallest surface": {"swimmers": [CELLS], "surface": {"kind": "plane", "size": 1e-30}},
}


@pytest.mark.parametrize("name", RUN)
def test_what_can_run_does(name, tmp_path):
    scene = Scene.parse({"time": {"end": 1e-6, "save_every": 1e-6}, **RUN[name]})
    done = simulate(scene, tmp_path / "run", device="cpu")
    assert done.data.children[done.order[0]].sizes["frame"] == 2


def test_filaments_that_bend_too_sharply_are_named(tmp_path):
    scene = Scene.parse({"time": {"end": 1e-6, "save_every": 1e-6}, **on(PLANE, intrinsic=[0, 0, 1e20])})
    with pytest.raises(RodFailure, match=r"f: rod 0 .* a bend that is too sharp for the spacing of its nodes"):
        simulate(scene, tmp_path / "run", device="cpu")


def test_a_run_whose_frames_are_as_close_as_its_steps_resumes(tmp_path):
    tables = {"swimmers": [CELLS], "time": {"end": 5e-3, "save_every": 1e-4, "step": 1e-4}}
    simulate(Scene.parse(tables), tmp_path / "run", device="cpu")
    longer = {**tables, "time": tables["time"] | {"end": 6e-3}}
    done = simulate(Scene.parse(longer), tmp_path / "run", device="cpu", resume=True)
    assert done.data["c"].sizes["frame"] == 61


def test_a_start_whose_direction_is_round_off_is_told_with_the_remedy():
    symmetric = {"swimmers": [CELLS | {"shape": {"kind": "mode", "mode": 1, "amplitude": 2.0}}]}
    notes = Simulation(Scene.parse({"time": {"end": 1}, **symmetric}), "cpu").notes
    assert any("round-off chooses the side" in line and "shape.perturbation = 1e-3" in line for line in notes)
    seeded = {"swimmers": [CELLS | {"shape": {"kind": "mode", "mode": 1, "amplitude": 2.0, "perturbation": 1e-3}}]}
    assert not any("round-off" in line for line in Simulation(Scene.parse({"time": {"end": 1}, **seeded}), "cpu").notes)
