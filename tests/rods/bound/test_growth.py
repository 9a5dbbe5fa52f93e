"""Clamped ends and growth (docs/model.md §3.3, §3.8): exact solutions, power balance, orders, refinement."""

from itertools import pairwise

import numpy as np
import pytest
from examples.bound import energy_defect
from scipy.optimize import brentq

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound import growth
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.together import exhaust
from warp_rods.scene.scene import Scene

CLAMPED = {"at": "start", "ends": ("clamped", "free")}
TORUS = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
PARAMETERS = {"stiffness": (1.0, 1.2, 0.8), "intrinsic": (0.7, 1.0, 0.3), "drag": (1.0, 2.0, 0.3)}


SITE = {
    "surface": {"kind": "torus", "major": 1.0, "minor": 0.4},
    "filaments": [
        {"name": "f", "count": 1, "nodes": 17, "length": 0.6, "stiffness": [1, 1, 1], "drag": [1, 2, 0.3],
         "ends": ["clamped", "clamped"],
         "placement": {"at": "start", "position": [[1.4, 0, 0]], "direction": [[0, 1, 0]]}}
    ],
    "time": {"end": 1.0},
}  # fmt: skip


def on_torus(nodes: int, device: str = "cpu", **changes) -> BoundRods:
    """A filament from a nucleation site on the torus, with all coefficients non-zero and smooth at its free end."""
    x = np.linspace(0, 1, nodes)
    turn = PARAMETERS["intrinsic"][2] + (1 - x) ** 4 * (1 + 4 * x)
    settings = {"length": 0.6, **CLAMPED, **PARAMETERS, **changes}
    return BoundRods(
        TORUS, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=nodes, geodesic_curvature=turn, device=device, **settings
    )


def cantilever(nodes: int) -> tuple[float, np.ndarray]:
    """First root of cos x cosh x = −1 and the curvature of its mode, clamped at the first node."""
    x = brentq(lambda x: np.cos(x) * np.cosh(x) + 1, 1.5, 2.5)
    s = x * np.linspace(0, 1, nodes)
    ratio = (np.sinh(x) - np.sin(x)) / (np.cosh(x) + np.cos(x))
    return x, np.cosh(s) + np.cos(s) - ratio * (np.sinh(s) + np.sin(s))


@pytest.mark.parametrize("ends", [("clamped", "free"), ("free", "clamped")])
def test_a_cantilever_on_the_plane_decays_like_a_beam(device, ends, verified):
    root, mode = cantilever(65)
    turn = 1e-4 * (mode if ends[0] == "clamped" else mode[::-1])
    rods = BoundRods(
        surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], nodes=65, at="start", ends=ends, geodesic_curvature=turn,
        device=device,
    )  # fmt: skip
    rate = root**4 / 2.0
    rods.step(1e-3 / rate, 500)
    first = rods.strain[0, :, 2]
    rods.step(1e-3 / rate, 1000)
    node = np.abs(first).argmax()
    verified(
        "exact", f"cantilever on a plane, {' and '.join(ends)}: decay in a time constant, N = 64",
        measured=np.log(first[node] / rods.strain[0, node, 2]), expected=1, within=1e-3,
        reference="(B3/ζ⊥)(x/L)⁴, cos x cosh x = −1",
    )  # fmt: skip


@pytest.mark.parametrize(("ends", "node"), [(("clamped", "free"), 0), (("free", "clamped"), -1)])
def test_a_clamped_end_does_not_move_by_a_bit(ends, node, verified):
    rods = on_torus(33, ends=ends)
    position, rotation = rods.position[0, node], rods.rotation[0, node]
    rods.step(1e-3, 200)
    found = {"position": rods.position[0, node], "rotation": rods.rotation[0, node]}
    verified.same(
        f"clamped {'first' if node == 0 else 'last'} end: its frame after 200 steps", found,
        {"position": position, "rotation": rotation}, reference="its site",
    )  # fmt: skip


def test_the_drift_of_a_second_clamped_end_decreases_with_the_step(verified):
    """The last end is clamped through its velocities; its drift vanishes with Δt and Δs, and bending is much larger.

    Δt falls as Δs², so that the drift falls as Δs² where it is of first order in Δt or of second order in Δs.
    """
    drifts = []
    for nodes, step in ((33, 4e-4), (65, 1e-4), (129, 2.5e-5)):
        rods = on_torus(nodes, ends=("clamped", "clamped"))
        start = rods.position[0]
        rods.force = np.array([0.0, 0.0, 5.0])
        rods.step(step, round(0.1 / step))
        moved = np.linalg.norm(rods.position[0] - start, axis=-1)
        drifts.append(moved[-1])
    verified.order(
        "filament with two clamped ends: drift of the second, order in Δs at Δt ∝ Δs²",
        measured=-np.polyfit(np.arange(3), np.log2(drifts), 1)[0], within=0.25, reference="0 drift",
    )  # fmt: skip
    assert drifts[1] < 1e-5 and moved.max() > 50 * drifts[1]


@pytest.mark.parametrize(
    "changes",
    [{"ends": ("free", "clamped"), "at": "start"}, {"growth": {"rate": 2.0, "until": 2.4}}],
    ids=["clamped", "clamped and growing"],
)
def test_power_balances_to_second_order(changes, verified):
    """At t = 0.1."""
    residuals = []
    for nodes in (17, 33, 65):
        rods = on_torus(nodes, **changes)
        rods.step(1e-4, 1000)
        residuals.append(energy_defect(rods, 1e-4))
    verified.order(
        f"{'growing' if 'growth' in changes else 'clamped'} filament: |dE/dt + dissipation − power|, order in Δs",
        measured=-np.polyfit([0, 1, 2], np.log2(residuals), 1)[0], reference="N = 16, 32, 64",
    )  # fmt: skip


def test_growth_is_second_order_in_space_and_time(device, verified):
    grown = {"growth": {"rate": 2.0, "until": 2.4}, "device": device}

    def orders(runs):
        errors = [np.abs(a - b).max() for a, b in pairwise(runs)]
        return np.polyfit(np.arange(len(errors)), -np.log2(errors), 1)[0]

    lines = []
    for nodes in (17, 33, 65, 129):
        rods = on_torus(nodes, **grown)
        rods.step(2e-4, 250)
        lines.append(rods.position[0, :: (nodes - 1) // 16])
    verified.order("growing filament: order in Δs", measured=orders(lines), reference="N = 16 to 128")
    lines = []
    for step in (4e-3, 2e-3, 1e-3, 5e-4):
        rods = on_torus(33, **grown)
        rods.step(1e-4, 400)
        rods.step(step, round(0.16 / step))
        lines.append(rods.strain[0, :, 2])
    verified.order("growing filament: order in Δt", measured=orders(lines), reference="Δt = 4e-3 to 5e-4")


def test_refinement_during_growth_to_four_times_the_length_is_smooth(verified):
    """Against a run with the finest grid throughout. Frames are saved at the nodes of the start."""
    grown = {"rate": 1.5, "until": 2.4}
    rods, fine = on_torus(17, growth={**grown, "spacing": 0.04}), on_torus(65, growth=grown)
    energies, sizes = [], []
    for _ in range(65):
        rods.step(2e-3, 10)
        fine.step(2e-3, 10)
        energies.append((rods.variables()["energy"][0], fine.variables()["energy"][0]))
        sizes.append(rods.nodes)
    assert sorted(set(sizes)) == [17, 33, 65]
    assert rods.variables()["position"].shape == (1, 17, 3)
    assert rods.variables()["length"][0] == pytest.approx(2.4)
    refined, expected = np.array(energies).T
    np.testing.assert_allclose(refined, expected, rtol=3e-3)
    verified.below(
        "independent", "filament that grows fourfold and is refined twice: places",
        measured=np.abs(rods.variables()["position"][0] - fine.position[0, ::4]).max(), bound=2e-4,
        reference="the finest grid from the start",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "free"), ("free", "clamped")])
@pytest.mark.parametrize("nodes", [16, 17])
def test_refinement_moves_no_node(nodes, ends):
    """Nodes stay where they are, even numbers of them too; to the accuracy of the frames, not by half a cell."""
    rods = on_torus(nodes, ends=ends, growth={"rate": 1.5, "until": 2.4})
    rods.step(1e-3, 50)
    before, middle, gauss = rods.position[0], rods.position[0, rods.middle], rods.variables()["gauss"]
    frame = rods.rotation[0, rods.tracked], rods.position[0, rods.tracked]
    rods.refine()
    np.testing.assert_allclose(rods.rotation[0, rods.tracked], frame[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rods.position[0, rods.tracked], frame[1], rtol=0, atol=1e-8)
    cell = 0.7 / (nodes - 1)
    assert np.linalg.norm(rods.position[0, ::2] - before, axis=-1).max() < 0.03 * cell
    assert np.linalg.norm(rods.position[0, rods.middle] - middle) < 0.03 * cell
    np.testing.assert_allclose(rods.variables()["gauss"], gauss, rtol=0.02)


def test_both_tips_keep_their_shares_of_the_growth_through_a_refinement(verified):
    """Of an even number of nodes too: the same motion as without refinement, to second order in Δs."""
    grown, errors = {"rate": 1.5, "until": 2.4}, []
    for nodes in (16, 32, 64):
        rods, other = (on_torus(nodes, ends=("free", "free"), growth=grown) for _ in range(2))
        other.step(2e-4, 500)
        other.refine()
        for r, steps in ((rods, 1000), (other, 500)):
            r.step(2e-4, steps)
        errors.append(np.linalg.norm(rods.position[0] - other.position[0, ::2], axis=-1).max())
    verified.order(
        "growing filament with free ends: refined early against late, order in Δs",
        measured=-np.polyfit(np.log([15, 31, 63]), np.log(errors), 1)[0], reference="differences of places",
    )  # fmt: skip
    assert errors[-1] < 1e-3


def test_refinement_keeps_an_external_force():
    rods = on_torus(17, growth={"rate": 1.5, "until": 2.4, "spacing": 0.06})
    s = np.linspace(0, 1, 17)
    rods.force = np.stack([s, 2 - 3 * s, 0.5 + 0 * s], axis=-1)[None]
    rods.step(2e-3, 200)
    fine = np.linspace(0, 1, 33)
    np.testing.assert_allclose(rods.force[0], np.stack([fine, 2 - 3 * fine, 0.5 + 0 * fine], axis=-1), atol=1e-15)


def test_growth_between_two_clamped_ends_is_refused():
    said = r'growth: filaments grow at free tips, and ends = \["clamped", "clamped"\] has none: free one end'
    with pytest.raises(SceneError, match=said):
        on_torus(17, ends=("clamped", "clamped"), growth={"rate": 1.0, "until": 2.0})
    with pytest.raises(SceneError, match=r"filaments\[0\]\." + said):
        Scene.parse(SITE | {"filaments": [SITE["filaments"][0] | {"growth": {"rate": 1.0, "until": 2.0}}]})
    Scene.parse(SITE)


def test_a_refined_state_continues_with_the_same_bits(verified):
    grown = {"rate": 1.5, "until": 2.4, "spacing": 0.06}
    rods = on_torus(17, growth=grown)
    rods.step(2e-3, 200)
    assert rods.nodes == 33
    state = rods.state()
    rods.step(2e-3, 50)
    other = on_torus(17, growth=grown)
    other.restore(state)
    other.step(2e-3, 50)
    verified.same("growing filament, refined: a restored state", other.position, rods.position, reference="no stop")


def test_growth_starts_and_stops_at_given_times_and_follows_a_table():
    length = np.array([1.0, 2.0])
    late = growth.knots({"rate": np.array([1.0, 2.0]), "until": 3.0, "start": 0.5}, length)
    np.testing.assert_allclose(growth.length_at(late, 0.4), [1.0, 2.0])
    np.testing.assert_allclose(growth.length_at(late, 0.75), [1.25, 2.5])
    np.testing.assert_allclose(growth.rate_at(late, 0.75), [1.0, 2.0])
    np.testing.assert_allclose(growth.length_at(late, 9.0), [3.0, 3.0])
    np.testing.assert_allclose(growth.rate_at(late, 9.0), 0.0)
    rods = on_torus(17, growth={"time": [0.0, 0.1, 0.2, 0.3], "length": [0.6, 0.6, 0.8, 0.8]})
    seen = []
    for _ in range(4):
        rods.step(2e-3, 40)
        seen.append(rods.variables()["length"][0])
    np.testing.assert_allclose(seen, [0.6, 0.72, 0.8, 0.8])


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"rate": 1.0, "until": 0.5}, "until"),
        ({"rate": -1.0, "until": 2.0}, "rate"),
        ({"time": [0.0, 0.0], "length": [0.6, 1.0]}, "increasing"),
        ({"time": [0.0, 1.0], "length": [0.5, 1.0]}, "begin with"),
    ],
)
def test_impossible_growth_is_refused(table, said):
    with pytest.raises(SceneError, match=said):
        on_torus(17, growth=table)


@pytest.mark.parametrize("together", [False, True])
def test_steps_by_error_do_not_pass_a_short_growth_unseen(together, verified):
    """A filament at rest, in steps of its own or not, that grows by half for a hundredth of the time of a long step."""
    table = {"time": [0.0, 5.0, 5.01, 20.0], "length": [0.6, 0.6, 0.9, 0.9]}
    rods, exact = (on_torus(33, growth=table) for _ in range(2))
    exact.step(1e-3, 7000)
    if together:
        exhaust(rods._steps.advance_to(7.0, 0.01))
    else:
        rods.advance_to(7.0)
    assert rods.steps_taken[0] < 1000
    verified.below(
        "independent", f"a short growth in steps by error, {'together' if together else 'own'}: places",
        measured=np.abs(rods.position - exact.position).max(), bound=1e-4, reference="7000 equal steps",
    )  # fmt: skip
    start = on_torus(33, growth=table)
    start.advance_to(4.9)
    assert np.abs(start.position - exact.position).max() > 0.1
