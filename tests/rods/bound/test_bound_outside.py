"""Filaments in flows, under gravity, and under forces and couples by formula."""

import functools
from itertools import pairwise

import numpy as np
import pytest
from examples.bound import (
    DIRECTIONS,
    DRAG,
    INTRINSIC,
    LENGTH,
    MIDDLES,
    OURS,
    STIFFNESS,
    compatible_turn,
    energy_defect,
    order,
    read,
)
from reference import bound as twin
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods

PLANE = surfaces.make("plane", {})
TURNING = {"kind": "formula", "velocity": ["-0.8*y - 0.3*z", "0.8*x", "0.3*x"]}
OMEGA = np.array([0, -0.3, 0.8])
"""The rate at which this fluid turns."""
SHEAR = {"kind": "shear", "rate": 0.7, "direction": [0, 1, 0], "gradient": [1, 0, 1], "centre": [0.1, 0.2, 0.3]}
VANISHING = "*(1 - 4*s**2)**2"
"""Of couples about the normal, so that the conditions at free ends are those of the start."""
FORCES = [
    {"force": ["sin(y)", "0.5*x", "s - z"], "couple": [f"0.6{VANISHING}", f"(x - 0.4){VANISHING}", f"0.5*y{VANISHING}"]}
]


def on_plane(device, **other):
    return BoundRods(PLANE, [[0, 0, 0]], [[1, 0, 0]], drag=(1.0, 2.0, 0.1), device=device, **other)


@functools.cache
def smooth_turns():
    return [compatible_turn("torus", b) for b in range(len(LENGTH))]


def on_torus(device, nodes, **other):
    turns = np.stack([turn(np.linspace(-1, 1, nodes)) for turn in smooth_turns()])
    return BoundRods(
        surfaces.make(*OURS["torus"]), MIDDLES["torus"], DIRECTIONS, nodes=nodes, length=LENGTH, stiffness=STIFFNESS,
        intrinsic=INTRINSIC, drag=DRAG, geodesic_curvature=turns, device=device, **other,
    )  # fmt: skip


@pytest.mark.parametrize("by_error", [False, True], ids=["given steps", "own steps"])
def test_a_uniform_flow_carries_a_filament_on_a_plane(device, by_error, verified):
    """In the plane it moves with the fluid; across the plane the flow presses on the membrane with ζ⊥ w."""
    rods = on_plane(device, flow={"kind": "uniform", "velocity": [0.3, 0.5, -0.4]})
    start = rods.position
    rods.advance_to(0.1) if by_error else rods.step(1e-3, 100)
    which = "steps of its own" if by_error else "steps of given length"
    verified.below(
        "exact", f"filament on a plane in a uniform flow, {which}: place",
        measured=abs(rods.position - start - [0.03, 0.05, 0]).max(), bound=1e-12, reference="shifted by u t",
    )  # fmt: skip
    np.testing.assert_allclose(rods.variables()["load"][0], np.broadcast_to([0, 0, -0.8], (33, 3)), atol=1e-7)
    np.testing.assert_allclose([rods.dissipation[0], rods.power[0]], 2 * 0.4**2, rtol=1e-9)


def test_gravity_moves_a_filament_against_its_drag(device):
    rods = BoundRods(PLANE, [[0, 0, 0]] * 2, [[1, 0, 0]] * 2, drag=(1.0, 2.0, 0.1), device=device,
                     gravity=[[0.3, 0.5, -1.0], [0, 0, 2.0]])  # fmt: skip
    start = rods.position
    rods.step(1e-3, 100)
    expected = np.array([[0.03, 0.025, 0], [0, 0, 0]])[:, None]
    np.testing.assert_allclose(rods.position - start, np.broadcast_to(expected, (2, 33, 3)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(rods.variables()["load"][:, 16, 2], [-1, 2], rtol=1e-6)


def test_fluid_that_turns_as_a_whole_turns_a_great_circle(device, verified):
    """Couple of vorticity included: without it the drag ζr ω0 of the turn about the tangent would hold it back."""
    R = 0.8
    made = {
        "nodes": 65,
        "length": 1.1,
        "stiffness": [0.7, 1.3, 0.9],
        "intrinsic": [0.4, -0.5, 0.0],
        "drag": [1.0, 2.0, 0.3],
    }
    rods = BoundRods(surfaces.make("sphere", {"radius": R}), [[0.5, 0.3, 0.6]], [[0.2, 0.9, -0.4]], flow=TURNING,
                     device=device, **made)  # fmt: skip
    start = rods.position
    rods.step(5e-3, 100)
    turned = Rotation.from_rotvec(0.5 * OMEGA).apply(start[0])
    verified.below(
        "exact", "great circle on a sphere in fluid that turns: place", measured=abs(rods.position[0] - turned).max(),
        bound=2e-5, reference="turned with the fluid",
    )  # fmt: skip
    assert abs(rods.strain[0, :, 2]).max() < 1e-6
    assert rods.dissipation[0] < 1e-6
    m2 = 1.3 * (1 / R + 0.5)
    outwards = rods.position[0] / R
    assert abs(rods.variables()["load"][0] - m2 / R**2 * outwards).max() < 1e-5


def test_forces_of_a_flow_agree_with_forces_that_are_set(device):
    """On a torus: ζ w in the frames, and the force that does the work of the couple ζr ½∇×w, (K12, K22) c0."""
    flowing, pushed = on_torus(device, 65, flow=SHEAR), on_torus(device, 65)
    x, R = pushed.position, pushed.rotation
    w = 0.7 * ((x - [0.1, 0.2, 0.3]) @ [1, 0, 1])[..., None] / np.sqrt(2) * [0, 1, 0]
    in_frame = np.einsum("rnij,rni->rnj", R, w) * DRAG[:, None, [0, 1, 1]]
    for rod in range(2):
        curl = np.array([-1.0, 0, 1.0]) * 0.7 / np.sqrt(2) / 2 * DRAG[rod, 2]
        c0 = R[rod, :, :, 0] @ curl
        K = pushed.curvature[rod]
        in_frame[rod] += np.stack([K[:, 1] * c0, K[:, 2] * c0, 0 * c0], axis=-1)
    pushed.force = np.einsum("rnij,rnj->rni", R, in_frame)
    still, found, expected = (
        rods.reading("geodesic_rate")[:, 2:-2] for rods in (on_torus(device, 65), flowing, pushed)
    )
    assert abs(found - expected).max() < 2e-2 * abs(expected - still).max()


def residuals(rods):
    """The balances of force and of moment about the origin of each rod, membrane, flow and couples included."""
    rods.evaluate()
    values, r, R = rods.variables(), rods.position, rods.rotation
    found = []
    for b in range(rods.count):
        h = LENGTH[b] / (rods.nodes - 1)
        geodesic, K = read(rods, "geodesic")[b], read(rods, "curvature")[b]
        from_half, from_node = twin.at_nodes(geodesic, h)
        u2 = read(rods, "velocity_across")[b]
        u1 = from_half @ read(rods, "velocity_along")[b, :-1] + from_node @ u2
        external = np.einsum("nij,nj->ni", R[b], read(rods, "load")[b])
        drag = np.einsum("nij,nj->ni", R[b], np.stack([DRAG[b, 0] * u1, DRAG[b, 1] * u2, 0 * u1], -1))
        couple = np.einsum("nij,nj->ni", R[b], read(rods, "couple")[b])
        couple -= (values["load_moment"][b] + DRAG[b, 2] * (K[:, 1] * u1 + K[:, 2] * u2))[:, None] * R[b, :, :, 0]
        force = external - drag - values["load"][b]
        total = twin.total(force, h) - values["end_load"][b].sum(axis=0)
        moment = twin.total(np.cross(r[b], force) + couple, h)
        moment -= (np.cross(r[b, [0, -1]], values["end_load"][b]) + values["end_moment"][b]).sum(axis=0)
        found.append([np.linalg.norm(total), np.linalg.norm(moment)])
    return found


def test_balances_with_the_membrane(device, verified):
    """Of forces and moments on whole filaments, under a flow, gravity, and forces and couples in all directions."""
    sizes = np.array([65, 129, 257])
    given = {"flow": SHEAR, "gravity": [0.2, -0.4, 0.3], "forces": FORCES}
    errors = [residuals(on_torus(device, int(nodes), **given)) for nodes in sizes]
    verified.order(
        "filaments in a flow, under gravity and couples: balances of force and moment, order in Δs",
        measured=order(sizes - 1, np.reshape(errors, (3, -1))), reference="with loads of ends; two filaments",
    )  # fmt: skip


def test_energy_law(device, verified):
    errors, sizes = [], np.array([33, 65, 129])
    for nodes in sizes:
        rods = on_torus(device, int(nodes), flow=SHEAR, gravity=[0.2, -0.4, 0.3], forces=FORCES)
        rods.step(2e-4, 500)
        errors.append(energy_defect(rods, 2e-4))
    verified.order(
        "filament in a flow, under gravity and couples: energy law, order in Δs", measured=order(sizes - 1, errors),
        reference="|dE/dt + dissipation − power|",
    )  # fmt: skip
    assert errors[-1] < 1e-3


def test_a_couple_about_the_normal_bends_a_clamped_filament(device, verified):
    """B3 Ω = µ (L − s) on a plane."""
    rods = BoundRods(PLANE, [[0, 0, 0]], [[1, 0, 0]], drag=(1.0, 2.0, 0.1), at="start", ends=("clamped", "free"),
                     forces=[{"couple": [0, 0, 0.5]}], device=device)  # fmt: skip
    rods.step(1e-2, 400)
    s = np.linspace(0, 1, 33)
    verified.below(
        "exact", "filament under a couple about the normal: geodesic curvature",
        measured=abs(rods.strain[0, :, 2] - 0.5 * (1 - s)).max(), bound=1e-6, reference="B3 Ω = µ (L − s)",
    )  # fmt: skip


def test_steps_in_a_flow_of_place_and_time_are_of_second_order(device, verified):
    flow = {"kind": "formula", "velocity": ["sin(2*y) - z*t", "cos(x - 3*t)", "x*y"]}
    start = on_torus(device, 33, flow=flow)
    start.step(2.5e-5, 2000)  # the fast initial relaxation, with the same steps in every run
    kept, steps, runs = start.state(), np.array([50, 100, 200, 400]), []
    for count in steps:
        rods = on_torus(device, 33, flow=flow)
        rods.restore(kept)
        rods.step(0.1 / count, int(count))
        runs.append(rods.variables())
    found = [
        order(steps[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)]) for name in ("position", "strain")
    ]
    verified.order(
        "filament in a flow of place and time: order in Δt", measured=found, reference="successive differences"
    )
    own = on_torus(device, 33, flow=flow)
    own.advance_to(0.15, 1e-3)
    assert own.has_own_steps and abs(own.position - runs[-1]["position"]).max() < 1e-3


def test_refined_and_restored_filaments_keep_the_flow(device):
    growth = {"rate": 0.3, "until": 2.0, "spacing": 0.035}
    made = {"flow": SHEAR, "gravity": [0, 0.3, 0], "growth": growth}
    rods, other = on_plane(device, **made), on_plane(device, **made)
    rods.step(5e-3, 100)
    assert rods.nodes == 65
    kept = rods.state()
    rods.step(5e-3, 5)
    other.restore(kept)
    other.step(5e-3, 5)
    np.testing.assert_array_equal(other.position, rods.position)


def test_faults_are_named(device):
    with pytest.raises(SceneError, match=r"flow.kind = .*: must be one of uniform"):
        on_plane(device, flow={"kind": "vortex"})
    with pytest.raises(SceneError, match="gravity"):
        on_plane(device, gravity=[1.0, 2.0])
