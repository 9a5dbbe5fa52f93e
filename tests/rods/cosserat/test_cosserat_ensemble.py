"""Ensembles of Cosserat rods: bits do not depend on the batch, restarts, failures, wrong arguments."""

import numpy as np
import pytest
from examples.contact_steps import take_one, take_steps
from examples.cosserat import COUPLED, STIFFNESS, in_space

from warp_rods.errors import SceneError
from warp_rods.rods.cosserat.rods import CosseratRods
from warp_rods.rods.status import Status
from warp_rods.rods.together import exhaust
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

READINGS = ("position", "orientation", "strain", "stretch", "internal_force", "energy")


def different(device, chosen):
    """Some of eleven rods, one of which turns too far between two nodes."""
    scale = np.geomspace(0.5, 4.0, 11)[:, None, None]
    shape = np.array([0, 0, 0, 1, 0, 0]) + np.arange(11)[:, None, None] * np.array([0.2, 0.3, 0.4, 0.01, 0.01, 0])
    shape = np.broadcast_to(shape, (11, 17, 6))
    return in_space(device, 17, len(chosen), stiffness=(scale * COUPLED)[chosen], shape=shape[chosen])


def test_a_rod_has_the_same_bits_alone_and_in_any_company(device, verified):
    def run(chosen):
        rods = different(device, chosen)
        take_steps(rods, 1e-4, 5)
        return {name: rods.reading(name) for name in READINGS}

    together, turned = run(list(range(11))), run(list(range(10, -1, -1)))
    verified.same(
        "Cosserat rods in another order", {name: v[::-1] for name, v in turned.items()}, together,
        reference="11 different rods",
    )  # fmt: skip
    for rod in (0, 5, 10):
        verified.same(
            f"Cosserat rod {rod} alone", run([rod]), {name: v[[rod]] for name, v in together.items()},
            reference="11 different rods",
        )  # fmt: skip


def test_a_restored_rod_continues_with_the_same_bits(device, verified):
    def made():
        rods = in_space(device, 17, ends=("clamped", "free"))
        rods.force, rods.couple = [0.0, 1.0, 0.5], [0.1, 0.0, 0.2]
        return rods

    for steps in (0, 3):
        rods, other = made(), made()
        rods.step(1e-4, steps)
        state = rods.state()
        rods.step(1e-4, 3)
        other.restore(state)
        other.step(1e-4, 3)
        verified.same(
            f"Cosserat rod restored after {steps} steps", other.state(), rods.state(), reference="a run without a stop"
        )


def test_steps_by_error_meet_their_tolerance(device, verified):
    found = {}
    for tolerance in (1e-2, 1e-5):
        rods = in_space(device, 17, shape={"kind": "straight"})
        rods.advance_to(0.1, tolerance)
        found[tolerance] = rods.position
    verified.below(
        "independent", "Cosserat rod: places after steps by error, tolerance 0.01",
        measured=abs(found[1e-2] - found[1e-5]).max(), bound=1e-2, reference="tolerance 1e-5",
    )  # fmt: skip


def test_frames_at_earlier_levels_are_those_that_were(device):
    """Frames within a step come from the polynomial through the levels; each is exact but for products of screws."""
    rods, levels = in_space(device, 17), []
    for _ in range(6):
        take_one(rods, 1e-4)
        levels.append((rods.time, rods.position, rods.rotation))
    for (time, position, rotation), within in zip(levels[-3:], (1e-5, 1e-6, 1e-15), strict=True):
        rods.show_at(time)
        np.testing.assert_allclose(rods.position, position, atol=within)
        np.testing.assert_allclose(rods.rotation, rotation, atol=within)


@pytest.mark.parametrize("stiff", [1.0, 50.0, 1e4])
def test_stiff_contact_is_stable(device, stiff):
    """A straight rod, turned about x, that a wall at z = 0 on both sides pulls back: κΔt/η = ``stiff``."""
    kappa, dt = 200.0, 1e-2
    turned = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    rods = CosseratRods(
        1, 9, stiffness=STIFFNESS, position=(0, 0, 0.1), rotation=turned, drag_ratio=kappa * dt / stiff, device=device
    )
    wall, heights = np.diag([0.0, 0.0, kappa]), [0.1]
    for _ in range(60):
        take_one(rods, dt, force=lambda _t, r: -r @ wall, stiffness=lambda _r: wall)
        heights.append(float(rods.position[0, 4, 2]))
    assert max(np.abs(heights[1:])) <= 0.1 and abs(heights[-1]) < 1e-3


def test_crossing_rods_push_each_other_apart(device):
    """In a scene: steric forces, equal and opposite, keep the middle of both together at rest."""
    table = {"name": "a", "count": 2, "nodes": 33, "stiffness": [1e-2, 1e-2, 1e-2, 20.0, 20.0, 20.0]}
    placement = {"position": [[0, 0, 0], [0, 0, 0.03]], "direction": [[1.0, 0, 0], [0, 1.0, 0]]}
    steric = {"strength": 40.0, "range": 0.02, "core": 0.05}
    simulation = Simulation(
        Scene.parse({"cosserat": [table | {"placement": placement}], "steric": steric, "time": {"end": 0.1}}), device
    )
    rods = simulation.ensembles["a"]
    exhaust(simulation.advance())
    z = rods.position[:, :, 2]
    assert z[1, 16] - z[0, 16] > 0.08
    np.testing.assert_allclose(z.mean(axis=1).sum(), 0.03, atol=1e-9)


def test_a_rod_that_fails_is_frozen_and_the_others_go_on(device):
    rods, alone = in_space(device, 17, 3), in_space(device, 17)
    force = np.zeros((3, 17, 3))
    force[1, 3, 0] = 1e200
    rods._arrays.rods.force.assign(force)
    for one in (rods, alone):
        for _ in range(3):
            take_one(one, 1e-5)
    assert rods.status.tolist() == [Status.OK, rods.status[1], Status.OK] and rods.status[1] != Status.OK
    assert np.isfinite(rods.position).all() and rods.failures()[0].rod == 1
    np.testing.assert_array_equal(rods.position[[0, 2]], np.repeat(alone.position, 2, axis=0))


WRONG = {
    "stiffness": [
        ([1, 1, 1, 1, 1], "stiffness"),
        ([1, 1, 1, 1, 1, -1], "stiffness = -1"),
        (-np.eye(6)[None], "positive"),
    ],
    "natural": [(np.zeros((3, 6)), "natural"), ([0, 0, 0, 1, 0, np.nan], "natural")],
    "ends": [(("free",), "ends"), (("free", "stuck"), "stuck")],
    "shape": [
        ({"kind": "bend"}, "shape.kind"),
        ({"stretch": 0.0}, "shape.stretch"),
        ([200.0, 0, 0, 1, 0, 0], "turns by"),
    ],
    "drag_ratio": [(0.0, "drag_ratio = 0")],
    "at": [("end", "at = 'end'")],
    "nodes": [(4, "nodes = 4")],
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments_are_named(name):
    for value, words in WRONG[name]:
        with pytest.raises(SceneError, match=words):
            CosseratRods(1, **({"nodes": 17, "stiffness": STIFFNESS} | {name: value}))


def test_a_matrix_that_is_not_symmetric_is_refused():
    K = COUPLED.copy()
    K[0, 1] += 1e-3
    with pytest.raises(SceneError, match="symmetric"):
        CosseratRods(1, 17, stiffness=K[None])
