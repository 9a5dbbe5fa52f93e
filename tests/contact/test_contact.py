"""Steps under contact: second order, cut where they must be and nowhere else, the same bits however a run is cut up."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from examples.free import slope

from warp_rods.analysis.crossings import crossings
from warp_rods.contact import steps as contact
from warp_rods.contact.steps import FINEST, LARGEST_MOVE
from warp_rods.rods import recorded
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

COLLISIONS = {
    "head-on": ([[-0.6, 0, 0], [0.6, 0.03, 0.01]], [[1, 0, 0], [-1, 0, 0]]),
    "crossed": ([[-0.7, -0.05, 0], [0, -0.8, 0.02]], [[1, 0, 0], [0, 1, 0]]),
}
"""Middle points and directions of two straight swimmers that collide at t = 0.1 to 0.2."""
SMOOTH = {"strength": 20.0, "range": 0.1, "core": 0.12}
"""Contact that swimmers feel from afar."""
CLEAR = {"strength": 500.0, "range": 0.04, "core": 0.2}
"""Contact that does not reach from one part of a straight rod to another: pairs of one rod are left out sharply below
2ε along it, which is a first order of Δs where the range is not far below that."""
HARD = {"strength": 2000.0, "range": 0.02, "core": 0.08}
"""Contact as in a swarm."""


def collision(kind: str, nodes: int = 33, *, steric=SMOOTH, end=0.5, step=1e-3, every=None, **table) -> Simulation:
    position, direction = COLLISIONS[kind]
    cells = {
        "name": "cells", "count": 2, "nodes": nodes, "bend": 5e-3, "twist": 1e-3, "flagella": {"profile": "uniform"},
        "shape": {"kind": "straight"}, "placement": {"position": position, "direction": direction}, **table,
    }  # fmt: skip
    time = {"end": end, "step": step, "save_every": every or end}
    return Simulation(Scene.parse({"swimmers": [cells], "steric": steric, "time": time}), "cpu")


def frames(simulation: Simulation) -> list[dict[str, np.ndarray]]:
    """Every frame from the present one to the last."""
    found = [simulation.variables()["cells"]]
    while simulation.frame < len(simulation.frames.times) - 1:
        for _ in simulation.to_next_frame():
            pass
        found.append(simulation.variables()["cells"])
    return found


def passed_through(simulation: Simulation, found: list[dict[str, np.ndarray]]) -> int:
    """Crossings over all frames."""
    position = np.array([f["position"] for f in found])
    dims, period = ("frame", "rod", "node", "axis"), np.array(simulation.scene.period)
    data = xr.Dataset(
        {"position": (dims, position), "status": (("frame", "rod"), np.array([f["status"] for f in found])),
         "length": ("rod", np.ones(position.shape[1])), "period": ("axis", np.where(period > 0, period, np.inf))},
        coords={"time": ("frame", simulation.frames.times[: len(found)]), "rod": np.arange(position.shape[1])},
    )  # fmt: skip
    return int(crossings(data)["crossings"].sum())


@pytest.mark.parametrize("kind", COLLISIONS)
def test_a_collision_is_second_order_in_time(kind):
    counts, found = np.array([250, 500, 1000, 2000]), []
    for count in counts:
        simulation = collision(kind, step=0.5 / count)
        found.append(frames(simulation)[-1])
        assert simulation.contact.finest == 1
    assert found[-1]["steric_energy"].min() > 0.03 and np.abs(found[-1]["strain"]).max() > 0.5
    for name in ("position", "orientation", "strain"):
        errors = [np.abs(b[name] - a[name]).max() for a, b in pairwise(found)]
        assert slope(counts[:-1], errors) == pytest.approx(2, abs=0.2), (name, errors)


@pytest.mark.parametrize("kind", COLLISIONS)
def test_a_collision_of_hard_rods_is_second_order_in_time(kind):
    """The core four times the range, as in a swarm, where contact is weak and its end near: pairs come and go."""
    counts = np.array([500, 1000, 2000, 4000])
    found = [frames(collision(kind, 17, steric=HARD, step=0.5 / count))[-1]["position"] for count in counts]
    errors = [np.abs(b - a).max() for a, b in pairwise(found)]
    assert slope(counts[:-1], errors) == pytest.approx(2, abs=0.2), errors


@pytest.mark.parametrize("kind", COLLISIONS)
def test_a_collision_is_second_order_in_the_spacing(kind):
    """From Δs = ε/3 on, so that the core is resolved."""
    sizes, found = np.array([16, 32, 64, 128]), []
    for size in sizes:
        last = frames(collision(kind, int(size) + 1, steric=CLEAR, step=5e-4))[-1]
        found.append({name: last[name][:, :: size // 16] for name in ("position", "strain")})
    for name in found[0]:
        errors = [np.abs(b[name] - a[name]).max() for a, b in pairwise(found)]
        assert slope(sizes[:-1], errors) == pytest.approx(2, abs=0.2), (name, errors)


@pytest.mark.parametrize("kind", COLLISIONS)
def test_steps_far_too_long_for_the_contact_give_the_same_answer(kind):
    """Of 0.02, in which a contact that pulls back at thousands per time would throw rods anywhere."""
    long = collision(kind, steric=HARD, end=0.8, step=0.02)
    found = frames(long)
    short = collision(kind, steric=HARD, end=0.8, step=2.5e-4)
    expected = frames(short)[-1]
    assert long.contact.finest > 1 and not long.contact.unresolved
    assert np.abs(found[-1]["position"] - expected["position"]).max() < 2e-3


@pytest.mark.parametrize("kind", COLLISIONS)
def test_nothing_passes_through(kind):
    """Frames at every one of the long steps; without sterics the crossed pair does pass through."""
    run = collision(kind, steric=HARD, end=1.2, step=0.02, every=0.02)
    found = frames(run)
    assert run.contact.finest > 1 and not run.contact.unresolved
    assert max(f["steric_energy"].max() for f in found) > 1e-3
    assert passed_through(run, found) == 0
    free = collision("crossed", steric={**HARD, "strength": 0.0}, end=1.2, step=0.02, every=0.02)
    free_frames = frames(free)
    for f in free_frames:  # both in one plane
        f["position"][:, :, 2] = 0.0
    assert passed_through(free, free_frames) > 0


def test_a_reasonable_step_is_never_cut():
    run = collision("crossed", steric=HARD, end=1.2, step=4e-4)
    frames(run)
    assert run.contact.parts == run.contact.finest == 1 and not run.contact.unresolved


def test_no_node_moves_further_than_its_share_of_the_core_in_a_step(monkeypatch):
    """Seen from outside, in every stretch that is kept; those that are redone begin again where they began."""
    run = collision("crossed", steric=HARD, end=0.6, step=0.05)
    cells, walk, stretches = run.ensembles["cells"], run.contact._walk, []

    def watched(dt, steps):
        begun, ways = cells.time, []
        for _ in range(steps):
            before = cells.position
            walk(dt, 1)
            ways.append(np.linalg.norm(cells.position - before, axis=-1).max())
        stretches.append((begun, max(ways)))

    monkeypatch.setattr(run.contact, "_walk", watched)
    frames(run)
    share = LARGEST_MOVE * HARD["core"] * (1 + 1e-9)
    kept = dict(stretches)
    assert len(kept) < len(stretches)
    assert max(kept.values()) <= share < max(way for _, way in stretches)
    assert list(kept) == sorted(kept)


def test_bits_do_not_depend_on_how_many_threads_there_are(monkeypatch):
    """Small slices for two threads, where there are two: rods of one ensemble, and nodes that gather their forces."""
    bits = []
    for worth in (recorded.WORTH_A_THREAD, 20):
        monkeypatch.setattr(recorded, "WORTH_A_THREAD", worth)
        run = collision("crossed", steric=HARD, end=0.4, step=0.02)
        bits.append(frames(run)[-1]["position"].tobytes())
        assert run.contact.finest > 1
    assert run.contact._surroundings.recordable == (recorded.cores() == 1)
    assert bits[0] == bits[1]


def test_a_run_goes_on_to_the_same_bits_while_its_steps_are_cut():
    def start():
        return collision("crossed", steric=HARD, end=0.8, step=0.02, every=0.1)

    whole = start()
    states, found = [whole.state()], [whole.variables()["cells"]]
    while whole.frame < len(whole.frames.times) - 1:
        for _ in whole.to_next_frame():
            pass
        found.append(whole.variables()["cells"])
        states.append(whole.state())
    assert max(int(state["parts"]) for state in states) > 1
    for k, state in enumerate(states[:-1]):
        again = start()
        if k % 2:
            again.warm_up()
        again.restore(state)
        for expected, got in zip(found[k:], frames(again), strict=True):
            for name in ("position", "strain", "activity", "steric_energy"):
                assert expected[name].tobytes() == got[name].tobytes(), (k, name)


def test_a_state_says_how_far_steps_are_cut():
    """Also where contact alone would not: steps that were cut for a fast node grow again only little by little."""
    run = collision("head-on")
    run.contact.parts = 4
    state = run.state()
    other = collision("head-on")
    other.restore(state)
    assert other.contact.parts == 4


def test_saving_more_often_changes_no_bit():
    """Steps of 2⁻¹⁰, so that all times are exact; lists are made at every frame."""
    bits = set()
    for every in (2**-10, 2**-6, 2**-3, 2**-2):
        run = collision("head-on", steric=HARD, end=0.25, step=2**-10, every=every)
        bits.add(frames(run)[-1]["position"].tobytes())
        assert run.contact.finest == 1
    assert len(bits) == 1


def growing(step: float, strength: float = 10.0) -> Simulation:
    """A filament that grows on a plane and is refined in the first steps, and a swimmer just above that it repels."""
    growth = {"rate": 1.0, "until": 1.0, "spacing": 0.5 / 32 + 1.5e-5}
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


def test_a_refinement_in_a_stretch_that_is_redone_is_redone_too(monkeypatch):
    """Nodes may move by so little that the first steps are too long; the filament is refined in the second of them."""
    monkeypatch.setattr(contact, "LARGEST_MOVE", 0.002)
    run = growing(4e-4)
    sensor, undone = run.ensembles["sensor"], []
    restore = sensor.restore

    def watched(state):
        before = sensor.nodes
        restore(state)
        undone.append((before, sensor.nodes))

    monkeypatch.setattr(sensor, "restore", watched)
    frames(run)
    assert (65, 33) in undone and sensor.nodes == 65
    assert run.contact.finest > 1 and not run.contact.unresolved
    again = growing(4e-4)
    frames(again)
    monkeypatch.undo()
    plain = growing(1e-4)
    frames(plain)
    for name in ("sensor", "cells"):
        got = run.ensembles[name].variables()["position"]
        assert got.tobytes() == again.ensembles[name].variables()["position"].tobytes()
        moved = np.abs(got - growing(1e-3).ensembles[name].variables()["position"]).max()
        apart = np.abs(got - plain.ensembles[name].variables()["position"]).max()
        assert 0 < apart < 0.01 * moved


def breathing(step: float) -> Simulation:
    """Filaments in each other's way on a sphere that swells and shrinks."""
    scene = {
        "surface": {"kind": "sphere", "radius": "1 + 0.2*sin(6*t)"},
        "filaments": [{
            "name": "sensor", "count": 16, "nodes": 33, "length": 0.6, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
        }],
        "steric": {"strength": 5.0, "range": 0.04, "core": 0.05},
        "time": {"end": 0.125, "step": step, "save_every": 0.03125},
    }  # fmt: skip
    return Simulation(Scene.parse(scene), "cpu")


def finished(run: Simulation, start: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The last frame of a run that is taken up from this state."""
    run.restore(start)
    while run.frame < 4:
        for _ in run.to_next_frame():
            pass
    return run.ensembles["sensor"].variables()


def test_contact_on_a_moving_membrane_is_second_order_in_time_and_resumes_to_the_same_bits():
    """From a state in which stiff modes have settled: at t = 0 all contacts begin at once, as no step resolves."""
    first = breathing(0.125 / 512)
    for _ in first.to_next_frame():
        pass
    start = first.state()
    assert first.variables()["sensor"]["steric_energy"].sum() > 1e-3
    counts = np.array([64, 128, 256, 512])
    found = [finished(breathing(0.125 / count), start) for count in counts]
    assert not found[-1]["status"].any()
    for name in ("position", "strain"):
        errors = [np.abs(b[name] - a[name]).max() for a, b in pairwise(found)]
        assert slope(counts[:-1], errors) == pytest.approx(2, abs=0.2), (name, errors)
    while first.frame < 4:
        for _ in first.to_next_frame():
            pass
    expected = first.ensembles["sensor"].variables()["position"].tobytes()
    assert found[-1]["position"].tobytes() == expected
    uncut = {key: value for key, value in start.items() if key != "parts"}  # as runs left it that knew no cuts
    assert finished(breathing(0.125 / 512), uncut)["position"].tobytes() == expected


def test_what_even_the_finest_steps_do_not_resolve_is_said(monkeypatch):
    """Two swimmers on top of each other that fly apart, where no step may be cut into more than two."""
    monkeypatch.setattr(contact, "FINEST", 2)
    place = {"placement": {"position": [[0, 0, 0], [0, 0.01, 0]]}}
    run = collision("head-on", steric={**HARD, "strength": 2e4}, end=0.02, step=1e-3, **place)
    frames(run)
    assert run.contact.unresolved and run.contact.finest == 2
    monkeypatch.undo()
    run = collision("head-on", steric={**HARD, "strength": 2e4}, end=0.02, step=1e-3, **place)
    frames(run)
    assert not run.contact.unresolved and 2 < run.contact.finest <= FINEST
