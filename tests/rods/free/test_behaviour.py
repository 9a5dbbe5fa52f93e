"""Reversals and tumbles: when they happen, what they do to a swimmer, and that their bits depend on nothing else."""

from zlib import crc32

import numpy as np
import pytest
from examples.free import slope

import warp_rods as wr
from warp_rods.errors import SceneError
from warp_rods.kernels.free import behaviour as kernels
from warp_rods.rods import together as steps_together
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status
from warp_rods.scene.behaviour import BEHAVIOURS
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

RATE = 1.0
REVERSAL = {"reversal": {"rate": RATE}}
BOTH = {"reversal": {"rate": 0.7}, "tumble": {"rate": 1.5, "duration": 0.2, "turn": 1.2}}
DRIVEN = {"profile": "uniform", "law": "driven", "relaxation": 2e-2, "diffusion": 0.0}
RELAXATION = 2e-2


def swimmers(count: int, behaviour, nodes: int = 17, **changes) -> FreeRods:
    given = {"bend": 0.1, "twist": 0.1, "shape": {"kind": "straight"}, "flagella": DRIVEN, "seed": 11, "device": "cpu"}
    return FreeRods(count, nodes, behaviour=behaviour, **(given | changes))


def bent(count: int, behaviour, **changes) -> FreeRods:
    """Swimmers that bend, so that their motion depends on what they do."""
    return swimmers(count, behaviour, bend=8e-3, shape={"kind": "mode", "amplitude": 1.0}, **changes)


def philox(counter: list[int], key: int) -> list[int]:
    """Philox4x32-10 in Python's whole numbers."""
    word, mask = list(counter), 2**32 - 1
    k = [key & mask, key >> 32]
    for _ in range(10):
        p, q = 0xD2511F53 * word[0], 0xCD9E8D57 * word[2]
        word = [(q >> 32) ^ word[1] ^ k[0], q & mask, (p >> 32) ^ word[3] ^ k[1], p & mask]
        k = [(k[0] + 0x9E3779B9) & mask, (k[1] + 0xBB67AE85) & mask]
    return word


def draws(seed: int, stream: int, kind: int, event: int) -> list[float]:
    """The five numbers in (0, 1) of an event."""
    w = philox([event, kind, stream & (2**32 - 1), stream >> 32], seed)
    more = philox([event, kind + 2**16, stream & (2**32 - 1), stream >> 32], seed)
    return [(((w[0] << 20) + (w[1] >> 12)) + 0.5) / 2**52, *((word + 0.5) / 2**32 for word in (*w[2:], *more[:2]))]


def history(seed: int, stream: int, name: str, end: float, rate: float, duration=0.0, turn=0.0) -> list[tuple]:
    """(time, front, back, angle, axis) from the start to after the end: when a phase begins, and what it does."""
    kind, time, found = int(getattr(kernels, BEHAVIOURS[name].kernel)), 0.0, []
    while time <= end:
        n = len(found)
        u = draws(seed, stream, kind, n)
        wait, front, back, angle = -np.log(u[0]) / rate, 1.0, 1.0, 0.0
        if name == "reversal":
            front = back = (-1.0) ** n
        elif n % 2:
            wait, front, back, angle = duration, 2 * u[1] - 1, 2 * u[2] - 1, turn * np.sqrt(-np.log(u[3]))
        found.append((time, front, back, angle, 2 * np.pi * u[4]))
        time += wait
    return [*found, (time, *[np.nan] * 4)]


def test_the_driven_law_relaxes_to_its_target(device, verified):
    """τf ∂t f = g − f: f = g + (f0 − g) e^(−t/τf), with g from back to front along the rod."""
    s, f0 = np.linspace(-0.5, 0.5, 33), 0.3
    rods = FreeRods(
        2, 33, bend=0.1, twist=0.1, shape={"kind": "straight"}, device=device,
        flagella={"law": "driven", "front": [0.5, 0.2], "back": [-0.4, 0.9], "steepness": [10.0, 25.0],
                  "relaxation": 0.1, "diffusion": 0.0, "profile": f0 * np.ones(33)},
    )  # fmt: skip
    rods.advance_to(0.15, 1e-6)
    front, back, steep = (np.array(v)[:, None] for v in ([0.5, 0.2], [-0.4, 0.9], [10.0, 25.0]))
    g = (front + back) / 2 + (front - back) / 2 * np.tanh(steep * s)
    verified.below(
        "exact", "law driven: f at t = 1.5 τf against g + (f0 − g) exp(−t/τf)", bound=1e-6,
        measured=np.abs(rods.activity - (g + (f0 - g) * np.exp(-1.5))), reference="closed form",
    )  # fmt: skip


def test_times_and_targets_are_those_of_the_twin():
    """Every event of some rods, of both behaviours together, against Philox in whole numbers."""
    streams = np.array([0, 3, 2**40 + 1, 2**64 - 1], dtype=np.uint64)
    rods, end = swimmers(4, BOTH, streams=streams, seed=2**63 + 5), 6.0
    for time in np.arange(0.25, end + 0.1, 0.25):
        rods.advance_to(time)
        target = np.moveaxis(rods._arrays.rods.law_parameters.numpy(), -1, 1).reshape(-1, 4)[:4, :2]
        for rod, stream in enumerate(streams.tolist()):
            expected = np.ones(2)
            for column, (name, values) in enumerate(BOTH.items()):
                told = history(2**63 + 5, stream, name, end, **values)
                past = [row for row in told if row[0] < time]
                expected *= past[-1][1:3]
                assert rods.events[name][rod] == len(past) - 1
                following = rods.state()["event_time"][rod, column]
                assert following == pytest.approx(told[len(past)][0], rel=1e-13)
            # Targets are those on the way beyond this time, which no event has ended.
            np.testing.assert_allclose(target[rod], expected, atol=1e-14)
    assert min(counts.min() for counts in rods.events.values()) >= 1


@pytest.mark.parametrize("along", [False, True])
def test_a_tumble_turns_a_stiff_rod_by_the_angle_that_was_drawn(along, device, verified):
    """About the drawn axis of its Bishop frame, to first order in what the couple bends it: µ/12b < 0.01 here."""
    drag = {"drag_ratio": "2 + s", "drag_along": 1.5} if along else {"drag_ratio": 3.0}
    tumble, streams = {"rate": 0.5, "duration": 0.2, "turn": 1.2}, [2, 3, 5, 8]
    rods = swimmers(
        4, {"tumble": tumble}, nodes=33, bend=10.0, twist=10.0, streams=streams, device=device, **drag,
        flagella={**DRIVEN, "front": 0.0, "back": 0.0, "profile": "none"},
    )  # fmt: skip
    errors = []
    for time in np.arange(0.5, 6.1, 0.5):
        rods.advance_to(time)
        for rod, stream in enumerate(streams):
            past = [row for row in history(11, stream, "tumble", 6.0, **tumble) if row[0] < time]
            if len(past) != 3 or time - past[-1][0] > 0.5:
                continue  # only where the first tumble has just ended: the frame was that of the start
            angle, axis = past[1][3:]
            turned = rods.rotation[rod, 16, :, 0]
            expected = np.cos(angle) * np.array([1.0, 0, 0])
            expected += np.sin(angle) * np.array([0.0, np.sin(axis), -np.cos(axis)])
            errors.append(np.linalg.norm(turned - expected))
    assert len(errors) >= 2
    verified.below(
        "exact", f"tumble: direction of a stiff rod after it{', drag along the rod' if along else ''}", bound=2e-3,
        measured=max(errors), reference="a turn by the angle drawn about the axis drawn",
    )  # fmt: skip


def test_each_rod_may_have_a_rate_of_its_own():
    """The same random numbers: times of first events are in the ratio of the rates."""
    rates = [0.5, 2.0, 8.0]
    one, each = swimmers(3, {"reversal": {"rate": 1.0}}), swimmers(3, {"reversal": {"rate": rates}})
    first = (rods.state()["event_time"][:, 0] for rods in (one, each))
    np.testing.assert_allclose(next(first), next(first) * rates, rtol=1e-14)
    assert each.parameters(2)["behaviour"] == {"reversal": {"rate": 8.0}}


def test_couples_from_outside_add_to_those_of_tumbles():
    """Couples of zero in space change nothing."""
    found = []
    for forces in (None, [{"couple": [0.0, 0.0, 0.0]}]):
        rods = bent(3, BOTH, forces=forces)
        rods.step(2e-3, 500)
        found.append(rods.position)
    np.testing.assert_allclose(*found, atol=1e-10)


def test_intervals_are_exponential(verified):
    """Kolmogorov–Smirnov: of the first events of 2000 rods, and of 2000 events of one."""
    from scipy.stats import kstest

    first = swimmers(2000, {"reversal": {"rate": 2.5}}).state()["event_time"][:, 0]
    waits = [-np.log(draws(11, 0, 0, n)[0]) for n in range(2000)]
    for name, values in (("first intervals of 2000 rods", 2.5 * first), ("2000 intervals of one rod", waits)):
        found = kstest(values, "expon")
        verified.below(
            "exact", f"reversals: {name}, Kolmogorov–Smirnov distance × √n", reference="exponential",
            measured=found.statistic * np.sqrt(2000), bound=1.95,
        )  # fmt: skip
    assert abs(np.corrcoef(waits[1:], waits[:-1])[0, 1]) < 3.3 / np.sqrt(2000)


def test_a_reversing_swimmer_forgets_its_direction(verified):
    """⟨v(0) v(t)⟩ = e^(−2λt), as the flagella follow within τf; counts are those of a Poisson process.

    With that lag (e^(−2λt) − 2λτf e^(−t/τf))/(1 − (2λτf)²); within four standard errors over 240 rods.
    """
    count, end, every = 240, 8.0, 0.05
    rods, velocity, place = swimmers(count, REVERSAL), list[np.ndarray](), list[np.ndarray]()
    for time in np.arange(1, round(end / every) + 1) * every:
        rods.advance_to(time, 0.02)
        velocity.append(rods.activity[:, 8])
        place.append(rods.position[:, 8, 0])
    v, x = np.array(velocity), np.array(place)
    events = rods.events["reversal"]
    error = np.sqrt(RATE * end / count)
    verified(
        "exact", "reversals: mean count over rate × time", measured=events.mean() / (RATE * end), expected=1,
        within=4 * error / (RATE * end), reference="Poisson process, 240 rods, λT = 8; four standard errors",
    )  # fmt: skip
    assert events.var() / events.mean() == pytest.approx(1, abs=4 * np.sqrt(2 / count))
    for lag in (2, 5, 10, 20):
        t, each = lag * every, (v[lag:] * v[:-lag]).mean(axis=0)
        a, b = 2 * RATE, 1 / RELAXATION
        lagging = (np.exp(-a * t) - a / b * np.exp(-b * t)) / (1 - (a / b) ** 2)
        verified(
            "exact", f"reversals: autocorrelation of the velocity at λt = {t:g}", measured=each.mean(),
            expected=lagging, within=4 * each.std() / np.sqrt(count), reference="exp(−2λt), and the lag of f",
        )  # fmt: skip
        assert lagging == pytest.approx(np.exp(-a * t), abs=2e-3)
    lag = 40
    t, each = lag * every, ((x[lag:] - x[:-lag]) ** 2).mean(axis=0)
    expected = t / RATE - (1 - np.exp(-2 * RATE * t)) / (2 * RATE**2)
    verified(
        "exact", "reversals: mean square displacement at λt = 2", measured=each.mean(), expected=expected,
        within=4 * each.std() / np.sqrt(count), reference="∫∫ exp(−2λ|t − t′|)",
    )  # fmt: skip


def test_a_rod_does_the_same_alone_in_a_batch_and_between_any_frames():
    batch = bent(11, BOTH)
    batch.advance_to(2.0)
    alone = bent(1, BOTH, streams=[9])
    for time in (0.1, 0.77, 0.78, 1.5, 2.0):
        alone.advance_to(time)
    assert batch.events["tumble"][9] > 0
    for name in ("position", "strain", "activity"):
        np.testing.assert_array_equal(getattr(batch, name)[9], getattr(alone, name)[0])


@pytest.mark.parametrize("together", [False, True])
def test_the_same_bits_after_a_restart(together):
    """From a state in the middle of a tumble, in steps of their own and in equal ones."""

    def go(rods: FreeRods, end: float) -> None:
        if together:
            rods.step(2e-3, round((end - rods.time) / 2e-3))
        else:
            rods.advance_to(end)

    one, other = bent(5, BOTH), bent(5, BOTH)
    go(one, 0.8)
    while not (one.events["tumble"] % 2).any():
        go(one, one.time + 0.1)
    state, end = one.state(), one.time + 1.0
    go(one, end)
    other.restore(state)
    go(other, end)
    for name in ("position", "strain", "activity"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert all((one.events[name] == other.events[name]).all() for name in BOTH)


def test_no_step_passes_an_event_after_many_first_steps(monkeypatch):
    """Where the first steps of a given length are no longer divided by their error."""
    monkeypatch.setattr(steps_together, "MOST_STARTING", 0)
    reached, finish_step = list[float](), FreeRods.finish_step

    def finish(rods: FreeRods) -> None:
        finish_step(rods)
        reached.append(rods.reached)

    monkeypatch.setattr(FreeRods, "finish_step", finish)
    rods = bent(2, REVERSAL)
    rods.step(0.5, 4)
    events = [time for rod in range(2) for time, *_ in history(11, rod, "reversal", 2.0, RATE)[1:-1]]
    assert len(events) > 2
    np.testing.assert_allclose([min(reached, key=lambda at: abs(at - time)) for time in events], events, rtol=1e-12)


def test_the_same_bits_after_a_restart_where_a_rod_has_failed():
    """Steps together no longer end at the events of a rod that was frozen."""
    one, other = bent(2, REVERSAL), bent(2, REVERSAL)
    one.step(2e-3, 5)
    rod = int(one.state()["event_time"].argmin())
    first = one.state()["event_time"].min()
    status = np.full(2, Status.OK, dtype=np.int32)
    status[rod] = Status.UNRESOLVED
    one._arrays.rods.status.assign(status)
    state, left = one.state(), round((first - one.time) / 2e-3) + 20
    other.restore(state)
    for rods in (one, other):
        rods.step(2e-3, left)
        assert not rods.events["reversal"][rod]
    for name in ("position", "strain", "activity"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize(
    ("behaviour", "end", "steps"),
    [
        ({"reversal": {"rate": 0.7}}, 2.0, [100, 200, 400, 800]),
        pytest.param(BOTH, 1.2, [400, 800, 1600], marks=pytest.mark.long),
    ],
    ids=["reversals", "both"],
)
def test_equal_steps_keep_their_order_across_events(behaviour, end, steps, verified):
    """Steps end at events and begin anew there; against steps by error at a tolerance of 1e-7."""
    exact = bent(2, behaviour, nodes=33)
    exact.advance_to(end, 1e-7)
    assert all(counts.min() >= 1 for counts in exact.events.values())
    errors = []
    for number in steps:
        rods = bent(2, behaviour, nodes=33)
        rods.step(end / number, number)
        errors.append(np.abs(rods.position - exact.position).max())
    verified.order(
        f"equal steps across events of {', '.join(behaviour)}, order in Δt", measured=slope(np.array(steps), errors),
        within=0.3, reference="steps by error, tolerance 1e-7, N = 32",
    )  # fmt: skip


def test_swimmers_that_feel_each_other_have_the_same_events():
    """In steps together, which end at the events of every rod; walls that are far away change nothing else."""
    table = {
        "name": "cells", "count": 3, "nodes": 17, "bend": 8e-3, "twist": 1e-3, "flagella": DRIVEN, "behaviour": BOTH,
        "shape": {"kind": "mode", "amplitude": 1.0}, "placement": {"position": [[0, 0, z] for z in (-3, 0, 3)]},
    }  # fmt: skip
    scene = {"swimmers": [table], "time": {"end": 1.5, "tolerance": 2e-3}, "seed": 4}
    found = []
    for box in ({}, {"box": {"kind": "slab", "height": 40.0}}):
        simulation = Simulation(Scene(**scene, **box), "cpu")
        for _ in simulation.advance():
            pass
        found.append(simulation.ensembles["cells"])
    alone, walled = found
    assert not np.array_equal(alone.position, walled.position)
    for name in BOTH:
        np.testing.assert_array_equal(alone.events[name], walled.events[name])
    np.testing.assert_allclose(walled.position, alone.position, atol=0.01)


def test_events_are_in_the_trajectory(tmp_path):
    """Counts so far by rod and behaviour, in each frame; rods without a behaviour have none."""
    cell = {"count": 3, "nodes": 17, "bend": 0.1, "twist": 0.1, "flagella": DRIVEN}
    scene = Scene(
        swimmers=[{**cell, "name": "a", "behaviour": BOTH}, {**cell, "name": "b"}],
        time={"end": 2.0, "save_every": 0.5},
        output={"usd": False},
        seed=4,
    )
    wr.run(scene, out=tmp_path / "run")
    opened = wr.open_run(tmp_path / "run")
    events = opened["a"]["events"]
    assert events.dims == ("frame", "rod", "behaviour") and "events" not in opened["b"]
    assert events["behaviour"].values.tolist() == list(BOTH)
    stream = crc32(b"a") << 32
    for name, values in BOTH.items():
        for rod in range(3):
            times = [time for time, *_ in history(4, stream + rod, name, 2.0, **values)[1:]]
            expected = np.searchsorted(times, events["time"].values)
            np.testing.assert_array_equal(events.sel(behaviour=name)[:, rod], expected)
    assert events[-1].sum() > 3


def test_ensembles_and_rods_have_streams_of_their_own():
    """Whatever their order in the scene, and with other seeds others."""
    table = {"count": 3, "nodes": 17, "bend": 0.1, "twist": 0.1, "flagella": DRIVEN, "behaviour": REVERSAL}
    a, b = {**table, "name": "a"}, {**table, "name": "b"}

    def times(seed: int, *swimmers) -> dict[str, np.ndarray]:
        ensembles = Simulation(Scene(swimmers=swimmers, time={"end": 1.0}, seed=seed), "cpu").ensembles
        return {name: rods.state()["event_time"][:, 0] for name, rods in ensembles.items()}

    one, other = times(1, a, b), times(1, b, {**a, "count": 5})
    np.testing.assert_array_equal(one["b"], other["b"])
    np.testing.assert_array_equal(one["a"], other["a"][:3])
    assert len({*one["a"], *one["b"], *times(2, a)["a"]}) == 9


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"behaviour": {"reversals": {"rate": 1.0}}}, r"behaviour\.reversals: unknown .* known: reversal, tumble"),
        ({"behaviour": {"reversal": {}}}, r"behaviour\.reversal\.rate: missing; must be a positive number"),
        ({"behaviour": {"reversal": {"rate": -1.0}}}, r"behaviour\.reversal\.rate = -1\.0: must be a positive number"),
        ({"behaviour": {"reversal": {"rate": [1.0, 2.0]}}}, r"behaviour\.reversal\.rate: .* do not fit 3 rods"),
        ({"behaviour": {"reversal": {"rate": 1, "duration": 1}}}, r"behaviour\.reversal\.duration: unknown key"),
        ({"behaviour": {"tumble": {"rate": 1, "duration": 0.0, "turn": 1}}}, r"tumble\.duration = 0\.0: must be a num"),
        (
            {"behaviour": {"tumble": {"rate": 1, "duration": 1, "turn": -1}}},
            r"tumble\.turn = -1: must be a number from 0 to pi",
        ),
        ({"behaviour": {"tumble": {"rate": 1, "duration": 1, "turn": 3.2}}}, r"tumble\.turn = 3\.2: must be a number"),
        ({"behaviour": REVERSAL, "flagella": {}}, r'law relaxing does not have; use flagella\.law = "driven"'),
        ({"behaviour": REVERSAL, "seed": -1}, r"seed"),
        ({"behaviour": REVERSAL, "streams": [1, 2]}, r"streams = .*one for each of 3 rods"),
        ({"behaviour": REVERSAL, "symmetric": True}, r"symmetric = true: a behaviour could break the symmetry"),
        (
            {"symmetric": True, "flagella": DRIVEN | {"profile": "tanh", "front": 1.0, "back": [-1.0, -1.0, 1.0]}},
            r"symmetric = true: the target of the flagella must be odd: front = -back",
        ),
    ],
)
def test_impossible_behaviours_are_refused(changes, said):
    with pytest.raises(SceneError, match=said):
        swimmers(3, **({"behaviour": None} | changes))


@pytest.mark.parametrize(
    ("behaviour", "line"),
    [
        (3, "swimmers[0].behaviour = 3: must be a table of behaviours"),
        ({"turn": {}}, "swimmers[0].behaviour.turn: unknown behaviour; known: reversal, tumble"),
        ({"reversal": 0.5}, "swimmers[0].behaviour.reversal = 0.5: must be a table { rate }"),
        ({"reversal": {}}, "swimmers[0].behaviour.reversal.rate: missing; must be a positive number, at most 10000"),
        ({"reversal": {"rate": 1e5}}, "swimmers[0].behaviour.reversal.rate = 100000.0: must be a positive number"),
        ({"reversal": {"rate": [1, 2]}}, "swimmers[0].behaviour.reversal.rate = [1, 2]: needs one entry for each of 3"),
        (
            {"tumble": {"rate": 1, "time": 1, "duration": 1, "turn": 1}},
            "swimmers[0].behaviour.tumble.time: unknown key",
        ),
    ],
)
def test_faults_of_a_scene_have_a_line_each(behaviour, line):
    table = {"name": "a", "count": 3, "nodes": 17, "bend": 0.1, "twist": 0.1, "flagella": DRIVEN}
    with pytest.raises(SceneError) as caught:
        Scene.parse({"swimmers": [{**table, "behaviour": behaviour}], "time": {"end": 1.0}})
    lines = str(caught.value).splitlines()
    assert len(lines) == 2 and line in lines[1]


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        (
            {"flagella": {}, "symmetric": True, "behaviour": REVERSAL},
            [
                "symmetric = true: a behaviour could break the symmetry; leave one of them out",
                "behaviour: acts on the target of the flagella, which the law relaxing does not have; "
                'use flagella.law = "driven"',
            ],
        ),
        (
            {"flagella": {"law": "driven", "front": [1, 1, 0.5], "back": -1}, "symmetric": True, "parameters": 3},
            [
                "parameters = 3: must be a table of numbers by name, such as { k = 7.0 }, for formulas, or a list with "
                "one for each rod",
                "symmetric = true: the target of the flagella must be odd: front = -back",
            ],
        ),
        ({"flagella": {"law": "driven"}, "symmetric": True}, ["symmetric = true: the target of the flagella must be "]),
    ],
)
def test_faults_of_flagella_behaviour_and_symmetry_are_in_one_message(changes, lines):
    table = {"name": "a", "count": 3, "nodes": 17, "bend": 0.1, "twist": 0.1, **changes}
    with pytest.raises(SceneError) as caught:
        Scene.parse({"swimmers": [table], "time": {"end": 1.0}})
    found = str(caught.value).splitlines()[1:]
    assert len(found) == len(lines)
    assert all(f"swimmers[0].{line}" in found[i] for i, line in enumerate(lines))
