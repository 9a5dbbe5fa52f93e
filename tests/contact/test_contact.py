"""Steps under contact: second order, divided where necessary, with bits that depend on the scene only."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from examples.free import slope

from warp_rods.analysis.crossings import crossings
from warp_rods.rods import slices, together
from warp_rods.rods.together import LARGEST_MOVE, MOST_PARTS
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

COLLISIONS = {
    "head-on": ([[-0.6, 0, 0], [0.6, 0.03, 0.01]], [[1, 0, 0], [-1, 0, 0]]),
    "crossed": ([[-0.7, -0.05, 0], [0, -0.8, 0.02]], [[1, 0, 0], [0, 1, 0]]),
}
"""Middle points and directions of two straight swimmers that collide at t = 0.1 to 0.2."""
SMOOTH = {"strength": 20.0, "range": 0.1, "core": 0.12}
"""Contact of long range."""
CLEAR = {"strength": 500.0, "range": 0.04, "core": 0.2}
"""Contact without interaction between parts of one straight rod: pairs of one rod are left out sharply below 2ε along
it, which is an error of first order in Δs unless the range is much smaller."""
HARD = {"strength": 2000.0, "range": 0.02, "core": 0.08}
"""Contact as in a swarm."""


def collision(kind: str, nodes: int = 33, *, steric=SMOOTH, end=0.5, step=1e-3, every=None, **table) -> Simulation:
    position, direction = COLLISIONS[kind]
    cells = {
        "name": "cells", "count": 2, "nodes": nodes, "bend": 5e-3, "twist": 1e-3, "flagella": {"profile": "uniform"},
        "shape": {"kind": "straight"}, "placement": {"position": position, "direction": direction}, **table,
    }  # fmt: skip
    time = {"end": end, "save_every": every or end} | ({} if step is None else {"step": step})
    return Simulation(Scene.parse({"swimmers": [cells], "steric": steric, "time": time}), "cpu")


def frames(simulation: Simulation) -> list[dict[str, np.ndarray]]:
    """All frames from the present one to the last."""
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
def test_a_collision_is_second_order_in_time(kind, verified):
    counts, found = np.array([250, 500, 1000, 2000]), []
    for count in counts:
        simulation = collision(kind, step=0.5 / count)
        found.append(frames(simulation)[-1])
        assert simulation.together.finest == 1
    assert found[-1]["steric_energy"].min() > 0.03 and np.abs(found[-1]["strain"]).max() > 0.5
    names = ("position", "orientation", "strain")
    errors = [[np.abs(b[name] - a[name]).max() for a, b in pairwise(found)] for name in names]
    verified.order(
        f"{kind} collision: order in Δt", measured=[slope(counts[:-1], e) for e in errors],
        reference="successive differences of three readings, Δt = 2e-3 to 2.5e-4",
    )  # fmt: skip


@pytest.mark.parametrize("kind", COLLISIONS)
def test_a_collision_of_hard_rods_is_second_order_in_time(kind, verified):
    """The core is four times the range, as in swarms: contact is weak and pairs cross the cut-off."""
    counts = np.array([500, 1000, 2000, 4000])
    found = [frames(collision(kind, 17, steric=HARD, step=0.5 / count))[-1]["position"] for count in counts]
    errors = [np.abs(b - a).max() for a, b in pairwise(found)]
    name = f"{kind} collision of hard rods: order in Δt"
    verified.order(name, measured=slope(counts[:-1], errors), reference="Δt = 1e-3 to 1.25e-4")


@pytest.mark.parametrize("kind", COLLISIONS)
def test_a_collision_is_second_order_in_the_spacing(kind, verified):
    """Δs ≤ ε/3, so that the core is resolved."""
    sizes, found = np.array([16, 32, 64, 128]), []
    for size in sizes:
        last = frames(collision(kind, int(size) + 1, steric=CLEAR, step=5e-4))[-1]
        found.append({name: last[name][:, :: size // 16] for name in ("position", "strain")})
    errors = [[np.abs(b[name] - a[name]).max() for a, b in pairwise(found)] for name in found[0]]
    verified.order(
        f"{kind} collision: order in Δs", measured=[slope(sizes[:-1], e) for e in errors],
        reference="places and strains, N = 16 to 128",
    )  # fmt: skip


@pytest.mark.parametrize("kind", COLLISIONS)
def test_steps_much_too_long_for_the_contact_give_the_same_solution(kind, verified):
    """Up to its error of second order. Contact rates of thousands would make explicit steps above 4e-4 unstable."""
    expected = frames(collision(kind, steric=HARD, end=0.8, step=1.25e-4))[-1]["position"]

    def error(run):
        found = frames(run)[-1]["position"]
        assert not run.together.unresolved
        return np.abs(found - expected).max()

    lengths = np.array([0.01, 0.005, 0.0025, 0.00125])
    errors = [error(collision(kind, steric=HARD, end=0.8, step=step)) for step in lengths]
    verified.order(
        f"{kind} collision of hard rods in steps far above the explicit bound: order in Δt",
        measured=slope(1 / lengths, errors), reference="Δt = 1.25e-4; explicit steps are bounded by 4e-4",
    )  # fmt: skip
    assert errors[2] < 3e-4
    divided = collision(kind, steric=HARD, end=0.8, step=0.02)
    assert error(divided) < 1.01 * errors[0] and divided.together.finest == 2
    assert error(collision(kind, steric=HARD, end=0.8, step=None)) < 2e-3


@pytest.mark.parametrize("kind", COLLISIONS)
def test_nothing_passes_through(kind, verified):
    """With a frame at every long step, as high on the barrier as shorter steps. Without it the crossed pair passes."""
    run = collision(kind, steric=HARD, end=1.2, step=0.02, every=0.02)
    short = collision(kind, steric=HARD, end=1.2, step=2.5e-3, every=0.02)
    found = frames(run)
    assert run.together.finest > 1 and not run.together.unresolved
    highest = [max(f["steric_energy"].max() for f in these) for these in (found, frames(short))]
    assert highest[1] > 1e-3 and abs(highest[0] / highest[1] - 1) < 0.15
    verified(
        "constraint", f"{kind} collision of hard rods in long steps: crossings", measured=passed_through(run, found),
        expected=0, within=0, reference="rods do not pass through each other",
    )  # fmt: skip
    free = collision("crossed", steric={**HARD, "strength": 0.0}, end=1.2, step=0.02, every=0.02)
    free_frames = frames(free)
    for f in free_frames:  # projected onto one plane
        f["position"][:, :, 2] = 0.0
    assert passed_through(free, free_frames) > 0


def test_a_reasonable_step_is_never_divided():
    run = collision("crossed", steric=HARD, end=1.2, step=4e-4)
    frames(run)
    assert run.together.finest == 1 and not run.together.unresolved


def test_no_node_moves_farther_than_allowed_in_a_step(monkeypatch):
    """In every step that is accepted; one that is repeated starts from the same time."""
    run = collision("crossed", steric=HARD, end=0.6, step=0.05)
    tried, accepted = [], []
    attempt, accept = run.together._try, run.together._accept

    def watched(dt):
        tried.append((run.ensembles["cells"].reached, attempt(dt)))
        return tried[-1][1]

    monkeypatch.setattr(run.together, "_try", watched)
    monkeypatch.setattr(run.together, "_accept", lambda move: (accepted.append(tried[-1]), accept(move)))
    frames(run)
    assert len(accepted) < len(tried)
    assert max(move for _, move in accepted) <= LARGEST_MOVE < max(move for _, move in tried)
    assert accepted == sorted(accepted)


def test_bits_do_not_depend_on_the_number_of_threads(monkeypatch, verified):
    """Small slices for two threads, if there are two cores, for stepping rods and for summing pair forces."""
    bits = []
    for nodes in (slices.NODES_PER_THREAD, 20):
        monkeypatch.setattr(slices, "NODES_PER_THREAD", nodes)
        run = collision("crossed", steric=HARD, end=0.8, step=0.02)
        bits.append(frames(run)[-1]["position"])
        assert run.together.finest > 1
    verified.same("crossed collision by two threads", bits[1], bits[0], reference="one thread")


def test_a_restored_run_with_divided_steps_continues_with_the_same_bits(verified):
    def start():
        return collision("crossed", steric=HARD, end=0.8, step=0.02, every=0.1)

    whole = start()
    states, found = [whole.state()], [whole.variables()["cells"]]
    while whole.frame < len(whole.frames.times) - 1:
        for _ in whole.to_next_frame():
            pass
        found.append(whole.variables()["cells"])
        states.append(whole.state())
    assert whole.together.finest > 1
    restored, expected = {}, {}
    for k, state in enumerate(states[:-1]):
        again = start()
        if k % 2:
            again.warm_up()
        again.restore(state)
        frames_again = frames(again)
        names = ("position", "strain", "activity", "steric_energy")
        ours, theirs = ({n: np.array([f[n] for f in part]) for n in names} for part in (frames_again, found[k:]))
        restored |= {f"{n} {k}": ours[n] for n in names}
        expected |= {f"{n} {k}": theirs[n] for n in names}
    verified.same("collision in divided steps, restored at each frame", restored, expected, reference="no stop")


def test_a_state_contains_the_number_of_parts():
    """Contact does not determine it: after a fast node has passed, parts of a step become longer only gradually."""
    run = collision("head-on")
    run.together._parts = 4
    state = run.state()
    other = collision("head-on")
    other.restore(state)
    assert other.together._parts == 4


def test_saving_more_often_does_not_change_the_bits(verified):
    """Steps of 2⁻¹⁰, so that all times are exact; lists are rebuilt at every frame."""
    bits = []
    for every in (2**-10, 2**-6, 2**-3, 2**-2):
        run = collision("head-on", steric=HARD, end=0.25, step=2**-10, every=every)
        bits.append(frames(run)[-1]["position"])
        assert run.together.finest == 1
    often = np.array(bits[:-1])
    verified.same("collision saved more often", often, np.array([bits[-1]] * 3), reference="saved once")


def test_contact_that_the_shortest_substeps_do_not_resolve_is_reported(monkeypatch):
    """Swimmers move by a quarter of the core in a step; less is allowed, with at most two substeps."""
    monkeypatch.setattr(together, "LARGEST_MOVE", LARGEST_MOVE / 5)
    for most in (2, MOST_PARTS):
        monkeypatch.setattr(together, "MOST_PARTS", most)
        run = collision("crossed", steric=HARD, end=0.8, step=0.02)
        frames(run)
        told = [line for line in run.new_warnings() if "rods may have passed through each other" in line]
        assert run.together.unresolved == (most == 2) == bool(told)
        assert run.together.finest == 2 if most == 2 else 2 < run.together.finest <= MOST_PARTS


def test_rods_that_start_nearly_in_one_place_fly_apart(monkeypatch):
    """The first steps are divided as their error demands, however few substeps later ones may have."""
    monkeypatch.setattr(together, "MOST_PARTS", 2)
    place = {"placement": {"position": [[0, 0, 0], [0, 0.01, 0]]}}
    found = []
    for step in (1e-3, 1e-4):
        run = collision("head-on", steric={**HARD, "strength": 2e4}, end=0.02, step=step, **place)
        found.append(frames(run))
        assert not run.together.unresolved and run.together.control.taken > 20
    apart = [np.abs(f[-1]["position"][0, 16] - f[-1]["position"][1, 16]).max() for f in found]
    assert apart[0] > 0.05 and apart[0] == pytest.approx(apart[1], rel=1e-2)
