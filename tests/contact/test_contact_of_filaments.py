"""Steps under contact for filaments: refinement during growth, and moving membranes."""

from itertools import pairwise

import numpy as np
import pytest
from examples.free import slope

from warp_rods.rods import together
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation


def finish(simulation: Simulation) -> None:
    """Advance to the last frame."""
    for _ in simulation.advance():
        pass


def growing(step: float, strength: float = 10.0) -> Simulation:
    """A filament that grows on a plane and is refined at t = 8.2e-4, and a swimmer close above it."""
    growth = {"rate": 1.0, "until": 1.0, "spacing": 0.5 / 32 + 2.55e-5}
    scene = {
        "surface": {"kind": "plane"},
        "filaments": [{
            "name": "sensor", "count": 1, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
            "placement": {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]}, "growth": growth,
        }],
        "swimmers": [{
            "name": "cells", "count": 1, "nodes": 33, "bend": 5e-3, "twist": 1e-3, "shape": {"kind": "straight"},
            "flagella": {"profile": "uniform"},
            "placement": {"position": [[0.1, 0.02, 0.04]], "direction": [[0.8, 0.6, 0]]},
        }],
        "steric": {"strength": strength, "range": 0.05, "core": 0.08},
        "time": {"end": 0.016, "step": step, "save_every": 0.016},
    }  # fmt: skip
    return Simulation(Scene.parse(scene), "cpu")


def test_a_refinement_in_a_step_that_is_repeated_stays_and_changes_no_place(monkeypatch):
    """After two steps nodes may move so little that the third is too long; the filament is refined in it."""

    def finish_with_little_moves(run):
        for done in run.advance():
            if done == 2:
                monkeypatch.setattr(together, "LARGEST_MOVE", 0.002)
        monkeypatch.undo()

    run = growing(4e-4)
    sensor, tried = run.ensembles["sensor"], []
    attempt = run.together._try

    def watched(dt):
        before = sensor.nodes
        move = attempt(dt)
        tried.append((before, sensor.nodes, move > together.LARGEST_MOVE))
        return move

    run.together._try = watched
    finish_with_little_moves(run)
    assert (33, 65, True) in tried and sensor.nodes == 65 and not run.together.unresolved
    again = growing(4e-4)
    finish_with_little_moves(again)
    plain = growing(1e-4)
    finish(plain)
    for name in ("sensor", "cells"):
        got = run.ensembles[name].variables()["position"]
        assert got.tobytes() == again.ensembles[name].variables()["position"].tobytes()
        moved = np.abs(got - growing(1e-3).ensembles[name].variables()["position"]).max()
        apart = np.abs(got - plain.ensembles[name].variables()["position"]).max()
        assert 0 < apart < 0.01 * moved


def breathing(step: float) -> Simulation:
    """Filaments in contact on a sphere that swells and shrinks."""
    scene = {
        "surface": {"kind": "sphere", "radius": "1 + 0.2*sin(6*t)"},
        "filaments": [{
            "name": "sensor", "count": 16, "nodes": 33, "length": 0.6, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
        }],
        "steric": {"strength": 5.0, "range": 0.04, "core": 0.05},
        "time": {"end": 0.125, "step": step, "save_every": 0.03125},
    }  # fmt: skip
    return Simulation(Scene.parse(scene), "cpu")


def last_frame_from(run: Simulation, start: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The last frame of a run that continues from this state."""
    run.restore(start)
    while run.frame < 4:
        for _ in run.to_next_frame():
            pass
    return run.ensembles["sensor"].variables()


@pytest.mark.long
def test_contact_on_a_moving_membrane_is_second_order_in_time_and_resumes_with_the_same_bits(verified):
    """From a state in which stiff modes have relaxed: at t = 0 all contacts start at once, which no step resolves."""
    first = breathing(0.125 / 512)
    for _ in first.to_next_frame():
        pass
    start = first.state()
    assert first.variables()["sensor"]["steric_energy"].sum() > 1e-3
    counts = np.array([64, 128, 256, 512])
    found = [last_frame_from(breathing(0.125 / count), start) for count in counts]
    assert not found[-1]["status"].any()
    errors = [[np.abs(b[name] - a[name]).max() for a, b in pairwise(found)] for name in ("position", "strain")]
    verified.order(
        "filaments in contact on a breathing sphere: order in Δt", measured=[slope(counts[:-1], e) for e in errors],
        reference="successive differences of places and strains",
    )  # fmt: skip
    while first.frame < 4:
        for _ in first.to_next_frame():
            pass
    expected = first.ensembles["sensor"].variables()["position"]
    verified.same(
        "filaments in contact on a breathing sphere, restored", found[-1]["position"], expected, reference="no stop"
    )
