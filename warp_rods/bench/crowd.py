"""Rods that touch, whose contact is timed: sensors packed on a dumbbell, and a film of swimmers."""

from __future__ import annotations

import time

import numpy as np
from scipy.spatial import cKDTree

from warp_rods.bench import rods
from warp_rods.bench.peers import loops
from warp_rods.contact.neighbours import Neighbours
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

FILM_NODES = 33
STRENGTH, RANGE, CORE = 40.0, 0.02, 0.03
"""Contact of the sensors, as in ``proteins.toml``."""
REACH = 8 * RANGE
"""Distance up to which nodes feel each other (docs/model.md §6)."""


class Packed:
    """Sensors on a dumbbell, at random, and what acts between their nodes."""

    def __init__(self, count: int):
        self.rods = rods.sensors(count, rods.dumbbell)
        self.position = self.rods.position.reshape(-1, 3)
        self.nodes = len(self.position)
        self._neighbours = Neighbours([self.rods], STRENGTH, RANGE, CORE, "cpu")
        self.apply, self.list = self._neighbours.apply, self._neighbours.rebuild_lists

    def pairs(self) -> np.ndarray:
        """Numbers of the nodes of each pair within reach [pair, 2]; neighbours along a rod do not act on each other."""
        found = cKDTree(self.position).query_pairs(REACH, output_type="ndarray")
        own = found[:, 0] // self.rods.nodes == found[:, 1] // self.rods.nodes
        spacing = 0.5 / (self.rods.nodes - 1)
        near = abs(found[:, 0] - found[:, 1]) * spacing < max(2 * CORE, 4 * spacing)
        return found[~(own & near)]

    def numba_forces(self, pairs: np.ndarray) -> np.ndarray:
        """The forces on the nodes [node, 3], by Numba."""
        force = np.zeros((self.nodes, 3))
        loops.pair_forces(self.position, pairs, STRENGTH, RANGE, CORE, force)
        return force


def film(count: int) -> Scene:
    """Nematic lanes, which are dense, fast to place and soon in contact, at an area fraction of 0.3."""
    cells = {
        "name": "cells", "count": count, "nodes": FILM_NODES, "bend": 5e-3, "twist": 1e-3, "placement": "nematic lanes",
        "flagella": {"profile": "uniform"}, "shape": {"kind": "mode", "amplitude": 0.3},
    }  # fmt: skip
    return Scene.parse(
        {
            "swimmers": [cells],
            "box": {"kind": "slab", "height": 0.12, "fraction": 0.3},
            "steric": {"strength": 1000.0, "range": 0.02, "core": 0.08},
            "time": {"end": 1.0},
        }
    )


def seconds_per_step(count: int, steps: int) -> float:
    """CPU seconds of a step of a film, of about ``steps`` by error from its start."""
    simulation = Simulation(film(count), "cpu")
    simulation.warm_up()
    cells, start, taken = simulation.ensembles["cells"], time.process_time(), 0
    for _ in simulation.to_next_frame():
        taken = int((cells.steps_taken + cells.steps_rejected).max())
        if taken >= steps:
            break
    return (time.process_time() - start) / taken
