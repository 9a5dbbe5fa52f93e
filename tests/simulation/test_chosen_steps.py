"""Steps by error from a contradicted start, warnings where nodes do not suffice, and rods that cannot fit."""

import numpy as np
import pytest

from warp_rods.contact.overlap import MOST_ROUNDS, without_overlap
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling, surfaces
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

SWIMMER = {"name": "c", "count": 1, "nodes": 65, "bend": 5e-3, "twist": 1e-3}
MODE = {"kind": "mode", "mode": 0, "amplitude": 3.0}


def swimmer(end: float = 0.3, step: float | None = None, **values) -> Simulation:
    time = {"end": end, "save_every": end} | ({"step": step} if step else {})
    return Simulation(Scene.parse({"swimmers": [SWIMMER | {"shape": MODE} | values], "time": time}), "cpu")


def finished(simulation: Simulation) -> dict[str, np.ndarray]:
    for _ in simulation.advance():
        pass
    return next(iter(simulation.variables().values()))


def test_an_end_ten_times_later_does_not_move_a_bent_filament(verified):
    """Its ends contradict its start. Under an isotropic drag no force moves its mean: its middle is displaced by
    1 − 2 sin ½ when it has become an arc of radius 1."""
    for end in (1.0, 10.0):
        filament = {
            "name": "f", "count": 1, "nodes": 33, "length": 1.0, "stiffness": [1, 1, 1], "intrinsic": [0, 0, 1],
            "drag": [1, 1, 0.1], "placement": {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]},
        }  # fmt: skip
        tables = {"surface": {"kind": "plane"}, "filaments": [filament], "time": {"end": end, "save_every": end}}
        simulation = Simulation(Scene.parse(tables), "cpu")
        last = finished(simulation)
        verified(
            "exact", f"filament on a plane that bends to σ3 = 1, end = {end:g}: displacement of its middle",
            measured=last["position"][0, 16, 1], expected=2 * np.sin(0.5) - 1, relative=0.002,
            reference="an arc of radius 1 whose mean has not moved",
        )  # fmt: skip
        assert simulation.steps_taken < 300


def test_swimmers_with_too_few_nodes_are_told():
    for nodes in (17, 33):
        (line,) = swimmer(nodes=nodes, bend=1.3e-4, symmetric=True).warnings
        assert "a swimmer of β⊥ = 0.00013 may wave" in line and line.endswith("use 141 nodes or more")
    assert not swimmer(nodes=141, bend=1.3e-4, symmetric=True).warnings
    with pytest.raises(SceneError, match=r"swimmers\[0\].shape.mode = 12: 17 nodes for the 13.5 half-waves"):
        swimmer(nodes=17, bend=1e-2, shape=MODE | {"mode": 12})
    (line,) = swimmer(nodes=33, bend=1e-2, shape=MODE | {"mode": 5}).warnings
    assert "the 6.5 half-waves of the mode 5" in line and line.endswith("use 119 nodes or more")


def test_points_on_a_flat_box_are_uniform_and_found_fast(monkeypatch):
    """Few lines through the sphere around the box meet the cylinder inside it."""
    drawn = []
    original = sampling._crossings
    monkeypatch.setattr(sampling, "_crossings", lambda *given: drawn.append(1) or original(*given))
    ring = surfaces.make("cylinder", {"radius": 50.0, "length": 1.0})
    x = sampling.uniform_points(ring, 2000, np.random.default_rng(2))
    assert len(drawn) < 200
    np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 1]), 50.0, rtol=1e-12)
    for values in (x[:, 2] + 0.5, np.arctan2(x[:, 1], x[:, 0]) / (2 * np.pi) + 0.5):
        counts = np.histogram(values, bins=10, range=(0, 1))[0]
        assert np.abs(counts - 200).max() < 4 * np.sqrt(200)


def test_rods_that_cannot_fit_are_given_up_early():
    """Discs of diameter 0.1 in a unit square jam at about 60; 90 are told long before the last round."""
    rng, rounds = np.random.default_rng(4), []

    def draw(rods):
        rounds.append(len(rods))
        x = np.concatenate([rng.uniform(size=(len(rods), 2)), np.zeros((len(rods), 1))], axis=1)
        return (x,), x[:, None, :]

    with pytest.raises(SceneError, match=r"count = 90: after \d+ draws only \d+ fit 0.1 apart; place fewer"):
        without_overlap(90, draw, 0.1, OccupiedSpace((), np.zeros(3)))
    assert len(rounds) < MOST_ROUNDS / 4
    rounds.clear()
    assert len(without_overlap(50, draw, 0.1, OccupiedSpace((), np.zeros(3))).poses[0]) == 50
