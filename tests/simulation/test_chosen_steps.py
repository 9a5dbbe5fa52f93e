"""The step that a run chooses where it is accuracy that bounds it, and warnings where nodes or steps do not suffice."""

import numpy as np
import pytest

from warp_rods.contact.overlap import MOST_ROUNDS, without_overlap
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling, surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.step_limits import SAFETY
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.watch import StepWatch

SWIMMER = {"name": "c", "count": 1, "nodes": 65, "bend": 5e-3, "twist": 1e-3}
MODE = {"kind": "mode", "mode": 0, "amplitude": 3.0}


def swimmer(end: float = 0.3, step: float | None = None, **values) -> Simulation:
    time = {"end": end, "save_every": end} | ({"step": step} if step else {})
    return Simulation(Scene.parse({"swimmers": [SWIMMER | {"shape": MODE} | values], "time": time}), "cpu")


def finished(simulation: Simulation) -> dict[str, np.ndarray]:
    for _ in simulation.advance():
        pass
    return next(iter(simulation.variables().values()))


def test_an_end_ten_times_later_does_not_move_a_bent_filament():
    """Its ends contradict its start: in the limit of short steps its middle is displaced by 0.0414."""
    for end in (1.0, 10.0):
        filament = {
            "name": "f", "count": 1, "nodes": 33, "length": 1.0, "stiffness": [1, 1, 1], "intrinsic": [0, 0, 1],
            "drag": [1, 2, 0.1], "placement": {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]},
        }  # fmt: skip
        tables = {"surface": {"kind": "plane"}, "filaments": [filament], "time": {"end": end, "save_every": end}}
        last = finished(Simulation(Scene.parse(tables), "cpu"))
        assert last["position"][0, 16, 1] == pytest.approx(-0.04136, rel=0.02)


def test_filaments_with_little_drag_along_are_resolved():
    def run(factor: float) -> tuple[float, dict]:
        filament = {
            "name": "f", "count": 6, "nodes": 33, "length": 0.3, "stiffness": [1, 1, 1], "intrinsic": [0, -0.8, 0],
            "drag": [0.1, 2, 0.1],
        }  # fmt: skip
        tables = {"seed": 5, "surface": {"kind": "undulated"}, "filaments": [filament]}
        time = {"end": 0.1, "save_every": 0.1}
        chosen = Simulation(Scene.parse(tables | {"time": time}), "cpu").step_size
        simulation = Simulation(Scene.parse(tables | {"time": time | {"step": chosen * factor}}), "cpu")
        return chosen, finished(simulation)

    (chosen, found), (_, exact) = run(1.0), run(1 / 8)
    assert chosen < 1.2e-4
    assert np.abs(found["gauss"] - exact["gauss"]).max() < 0.02 * np.abs(exact["gauss"]).max()


CASES = {
    "flagella faster than the step": ({"symmetric": True, "flagella": {"relaxation": 3e-5}}, 3 * 3e-5),
    "very stiff": ({"bend": 3.0}, 0.1 * 2 / (500.56 * 3.0)),
    "very soft": ({"bend": 3e-6, "nodes": 487}, 30 * 3e-6 * 2),
    "stiff against twist": ({"bend": 8e-5, "twist": 8e-2, "moment": 6e-3, "nodes": 165}, 1000 * 8e-5**2 / 8e-2),
    "stiff against twist, but planar": ({"bend": 8e-5, "twist": 8e-2, "nodes": 165}, 1e-3),
    "as usual": ({}, 1e-3),
}


@pytest.mark.parametrize("name", CASES)
def test_the_bounds_of_swimmers(name):
    values, bound = CASES[name]
    assert swimmer(**values).step_size == pytest.approx(min(SAFETY * bound, 0.3 / 1000), rel=0.01)
    warnings = swimmer(step=2 * bound, **values).warnings
    assert len(warnings) == 1 and f"is above {bound:.3g}, the bound for c" in warnings[0]


def test_a_swimmer_with_fast_flagella_swims_in_the_right_direction():
    found = finished(swimmer(**CASES["flagella faster than the step"][0]))
    exact = finished(swimmer(step=1e-5, **CASES["flagella faster than the step"][0]))
    assert found["energy"] == pytest.approx(exact["energy"], rel=1e-3)
    np.testing.assert_allclose(found["position"], exact["position"], atol=1e-3)


def test_swimmers_with_too_few_nodes_are_told():
    for nodes in (17, 33):
        (line,) = swimmer(nodes=nodes, bend=1.3e-4, symmetric=True).warnings
        assert "a swimmer of β⊥ = 0.00013 may wave" in line and line.endswith("use 141 nodes or more")
    assert not swimmer(nodes=141, bend=1.3e-4, symmetric=True).warnings
    with pytest.raises(SceneError, match=r"swimmers\[0\].shape.mode = 12: 17 nodes for the 13.5 half-waves"):
        swimmer(nodes=17, bend=1e-2, shape=MODE | {"mode": 12})
    (line,) = swimmer(nodes=33, bend=1e-2, shape=MODE | {"mode": 5}).warnings
    assert "the 6.5 half-waves of the mode 5" in line and line.endswith("use 119 nodes or more")


def test_a_step_above_the_bound_where_a_filament_has_come_to_is_warned_of_once():
    neck = surfaces.make("bridge", {"neck": 0.1, "body": 1.0, "width": 0.3, "length": 6.0})
    rods = BoundRods(neck, [[1.0, 0, 2.5], [0.1, 0, 0]], [[0, 1, 0], [0, 1, 0]], nodes=17, length=0.1)
    watch = StepWatch(1e-3)
    (line,) = watch.check(0.5, {"f": rods})
    assert line.startswith("at t = 0.5 the step 0.001 is above") and "the bound for rod 1 of f where it is now" in line
    assert not watch.check(0.6, {"f": rods})
    assert not StepWatch(1e-9).check(0.5, {"f": rods})


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
