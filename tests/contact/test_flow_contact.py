"""Rods that touch each other and a wall, in background flows."""

import numpy as np

import warp_rods as wr
from warp_rods.simulation.loop import Simulation

CROWD = {
    "swimmers": [
        {
            "name": "cells", "count": 2, "nodes": 33, "bend": 1e-2, "twist": 1e-3,
            "placement": {"position": [[0, 0, -0.02], [0.1, 0.0, 0.02]], "direction": [[1, 0, 0], [0, 1, 0.1]]},
        }
    ],
    "steric": {"strength": 20.0, "range": 0.02, "core": 0.04},
    "time": {"end": 0.1},
}  # fmt: skip


def run(**tables):
    simulation = Simulation(wr.Scene.parse(CROWD | tables), "cpu")
    while not simulation.finished:
        for _ in simulation.to_next_frame():
            pass
    return simulation.ensembles["cells"]


def test_rods_in_contact_are_carried_by_a_uniform_flow():
    time = {"end": 0.1, "step": 1e-3}
    still, moved = run(time=time), run(time=time, flow={"kind": "uniform", "velocity": [3.0, -2.0, 1.0]})
    assert np.abs(still.force).max() > 0.1
    np.testing.assert_allclose(moved.strain, still.strain, rtol=0, atol=1e-7)
    np.testing.assert_allclose(moved.position - [0.3, -0.2, 0.1], still.position, rtol=0, atol=1e-9)


def test_rods_that_a_flow_presses_on_a_wall_come_to_rest():
    """In a slab, against stiff walls: they end where the wall pushes with the drag of the flow, 2 · 0.5, per length."""
    wall = {"strength": 2000.0, "range": 0.05}
    flow = {"kind": "formula", "velocity": [0, 0, "0.5 + 0*x"]}
    box = {"kind": "slab", "height": 0.4, "wall": wall}
    table = CROWD["swimmers"][0] | {"flagella": {"profile": "none", "law": "held"}, "shape": {"kind": "straight"}}
    placed = {"placement": {"position": [[0, 0, 0], [0, 3, 0]]}}
    rods = run(swimmers=[table | placed], box=box, flow=flow, time={"end": 1.0})
    np.testing.assert_allclose(rods.position[..., 2], 0.2 - 0.05 + 2 * 0.5 / 2000, rtol=0, atol=1e-4)
