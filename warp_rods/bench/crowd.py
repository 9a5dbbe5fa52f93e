"""A film of swimmers that touch, whose contact is timed."""

from __future__ import annotations

import time

import numpy as np
from scipy.spatial import cKDTree

from warp_rods.bench.peers import loops
from warp_rods.contact.neighbours import Neighbours
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

NODES, STEP, STEPS = 33, 2.5e-4, 200
STERIC = {"strength": 1000.0, "range": 0.02, "core": 0.08}
CUTOFF = 8.0
"""Reach of the forces in units of the range (docs/model.md §6)."""


def scene(count: int, steps: int = STEPS) -> Scene:
    """Nematic lanes, which are dense, fast to place and soon in contact, at an area fraction of 0.3."""
    cells = {
        "name": "cells", "count": count, "nodes": NODES, "bend": 5e-3, "twist": 1e-3, "placement": "nematic lanes",
        "flagella": {"profile": "uniform"}, "shape": {"kind": "mode", "amplitude": 0.3},
    }  # fmt: skip
    time = {"end": STEP * steps, "step": STEP, "save_every": STEP * steps}
    return Scene.parse(
        {"swimmers": [cells], "box": {"kind": "slab", "height": 0.12, "fraction": 0.3}, "steric": STERIC, "time": time}
    )


class Crowd:
    """A film after some steps, and what acts between its nodes."""

    def __init__(self, count: int, steps: int = STEPS):
        self.simulation = Simulation(scene(count, steps), "cpu")
        for _ in self.simulation.to_next_frame():
            pass
        self.rods = self.simulation.ensembles["cells"]
        self.position = self.rods.position.reshape(-1, 3)
        self.nodes = len(self.position)
        self.period = float(self.simulation.scene.period[0])
        strength, reach, core = STERIC.values()
        period = self.simulation.scene.period
        self.apply = Neighbours([self.rods], strength, reach, core, "cpu", period=period).apply

    def pairs(self) -> np.ndarray:
        """Numbers of the nodes of each pair of two rods within reach [pair, 2]."""
        wrapped = np.mod(self.position, [self.period, self.period, np.inf])
        wrapped[:, 2] = self.position[:, 2] + self.period / 2
        box = [self.period, self.period, 0.0]
        found = cKDTree(wrapped, boxsize=box).query_pairs(CUTOFF * STERIC["range"], output_type="ndarray")
        return found[found[:, 0] // NODES != found[:, 1] // NODES]

    def numba_forces(self, pairs: np.ndarray) -> np.ndarray:
        """The forces on the nodes [node, 3], by Numba."""
        force = np.zeros((self.nodes, 3))
        strength, reach, core = STERIC.values()
        loops.pair_forces(self.position, pairs, self.period, strength, reach, core, force)
        return force


def seconds_per_step(count: int, steps: int) -> float:
    """CPU seconds of a step of a film, from its start."""
    simulation = Simulation(scene(count, steps), "cpu")
    simulation.warm_up()
    start = time.process_time()
    for _ in simulation.to_next_frame():
        pass
    seconds, rods = time.process_time() - start, simulation.ensembles["cells"]
    return seconds / int((rods.steps_taken + rods.steps_rejected).max())
