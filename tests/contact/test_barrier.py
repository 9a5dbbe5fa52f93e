"""The height of the steric barrier between crossing rods, and the warning that it is low."""

import numpy as np
import pytest
import xarray as xr
from reference.steric import Pairs, Rods

from warp_rods.analysis.crossings import crossings
from warp_rods.contact import barrier
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

STERIC = {"strength": 100.0, "range": 0.02, "core": 0.08}


def test_crossing_force_agrees_with_sums_over_nodes(verified):
    """The largest force over distances h between two straight, well resolved rods at right angles."""
    s = np.linspace(-0.5, 0.5, 201)
    forces = []
    for h in np.linspace(0.03, 0.045, 61):
        one = np.stack([s, 0 * s, 0 * s + h], axis=-1)
        other = np.stack([0 * s, s, 0 * s], axis=-1)
        pairs = Pairs([Rods(np.stack([one]), np.ones(1)), Rods(np.stack([other]), np.ones(1))], **STERIC)
        forces.append((pairs.forces() * pairs.weights[:, None])[:201, 2].sum())
    verified(
        "independent", "largest steric force between rods that cross",
        measured=barrier.crossing_force(100.0, 0.02, 0.08),
        expected=max(forces), relative=1e-4, reference="sums over 201 nodes in NumPy",
    )  # fmt: skip


def test_flank_force_agrees_with_sums_over_nodes(verified):
    s = np.linspace(-0.5, 0.5, 401)
    flank, tip = np.stack([0 * s, s, 0 * s], axis=-1), np.stack([s + 0.5, 0 * s, 0 * s], axis=-1)
    pairs = Pairs([Rods(line[None], np.ones(1)) for line in (flank, tip)], **STERIC)
    force = (pairs.forces() * pairs.weights[:, None])[401:, 0].sum()
    verified(
        "independent", "steric force of a flank on a tip", measured=barrier.flank_force(100.0, 0.02, 0.08),
        expected=force, relative=1e-3, reference="sums over 401 nodes in NumPy",
    )  # fmt: skip
    assert barrier.flank_force(100.0, 0.02, 0.08) < barrier.crossing_force(100.0, 0.02, 0.08)


@pytest.mark.parametrize(
    ("strength", "said"),
    [(1000.0, []), (887.0, []), (886.0, ["strength = 887"]), (500.0, ["strength = 887"]), (0.0, [])],
)
def test_low_barriers_are_warned_of(strength, said):
    """The strength that is advised suffices."""
    found = barrier.barrier_warnings("cells", strength, 0.02, 0.08)
    assert len(found) == len(said)
    assert all(text in line for text, line in zip(said, found, strict=True))


@pytest.mark.parametrize(("force", "passes"), [(0.4, True), (2.0, False)])
def test_swimmers_pass_through_a_barrier_that_is_too_low(force, passes):
    """One swims into the flank of another, which a third one supports on the other side."""
    strength = force / barrier.flank_force(1.0, 0.02, 0.08)
    cells = {
        "name": "cells", "count": 3, "nodes": 33, "bend": 0.1, "twist": 0.1, "flagella": {"profile": "uniform"},
        "shape": {"kind": "straight"},
        "placement": {"position": [[0, 0, 0], [-0.7, 0.01, 0], [0.7, -0.01, 0]],
                      "direction": [[0, 1, 0], [1, 0, 0], [-1, 0, 0]]},
    }  # fmt: skip
    scene = {"swimmers": [cells], "steric": {**STERIC, "strength": 1.001 * strength},
             "time": {"end": 0.5, "step": 5e-4, "save_every": 0.01}}  # fmt: skip
    simulation = Simulation(Scene.parse(scene), "cpu")
    assert len(simulation.warnings) == passes
    position = [simulation.variables()["cells"]["position"]]
    while simulation.frame < 50:
        for _ in simulation.to_next_frame():
            pass
        position.append(simulation.variables()["cells"]["position"])
    data = xr.Dataset(
        {"position": (("frame", "rod", "node", "axis"), np.array(position)),
         "status": (("frame", "rod"), np.zeros((51, 3), int)), "length": ("rod", np.ones(3))},
        coords={"time": ("frame", simulation.frames.times), "rod": np.arange(3)},
    )  # fmt: skip
    assert (int(crossings(data)["crossings"].sum()) > 0) == passes
    assert not simulation.together.unresolved
