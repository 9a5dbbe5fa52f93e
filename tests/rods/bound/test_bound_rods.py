"""Surface-bound filaments against exact solutions (docs/model.md §7), and orders of accuracy.

References are closed forms and conservation laws, orders are fitted slopes. Every tolerance is round-off or follows
from the order.
"""

from itertools import pairwise

import numpy as np
import pytest
from examples.contact_steps import take_steps
from reference.exact import beam_decay_rates, cylinder_angles, sphere_decay_rates

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.modes import beam_mode

ORDER = pytest.approx(2.0, abs=0.2)
TORUS = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
PARAMETERS = {
    "length": 1.2,
    "stiffness": (1.0, 1.2, 0.8),
    "intrinsic": (0.7, 1.0, 0.3),
    "drag": (1.0, 2.0, 0.3),
}


def arc(nodes: int) -> np.ndarray:
    return np.linspace(-0.5, 0.5, nodes)


def on_torus(nodes: int, device: str = "cpu") -> BoundRods:
    """A bent filament across the torus, with all coefficients different from zero."""
    s = arc(nodes)
    turn = 0.3 + 2 * np.cos(np.pi * s) ** 4 * np.sin(5 * s + 1)
    return BoundRods(
        TORUS, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=nodes, geodesic_curvature=turn, device=device, **PARAMETERS
    )


def decay_rate(rods: BoundRods, rate: float) -> float:
    """Decay rate of a small geodesic curvature, measured over one time constant after half a time constant."""
    dt = 2e-3 / rate
    rods.step(dt, 250)
    first = rods.strain[0, rods.middle, 2]
    rods.step(dt, 500)
    return float(np.log(first / rods.strain[0, rods.middle, 2]) / (500 * dt))


def test_a_filament_on_the_plane_decays_like_a_beam(device):
    rods = BoundRods(
        surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], nodes=65, device=device,
        geodesic_curvature=1e-4 * beam_mode(0, arc(65)), drag=(1.0, 2.0, 0.1), stiffness=(1.0, 1.0, 0.7),
    )  # fmt: skip
    exact = beam_decay_rates(0.7, 2.0, 1.0, 1)[0]
    assert decay_rate(rods, exact) == pytest.approx(exact, rel=0.012)


@pytest.mark.parametrize("extra", [(1.0, 0.0), (4.0, 2.0)], ids=["plain", "with B2, σ2"])
def test_the_decay_on_a_sphere_does_not_depend_on_normal_bending(device, extra):
    radius, length, drag = 0.8, 1.1, (1.0, 2.0, 0.3)
    rods = BoundRods(
        surfaces.make("sphere", {"radius": radius}), [[radius, 0, 0]], [[0, 1, 0]], nodes=65, length=length,
        stiffness=(1.0, extra[0], 0.7), intrinsic=(0.0, extra[1], 0.0), drag=drag,
        geodesic_curvature=1e-4 * beam_mode(0, arc(65)), device=device,
    )  # fmt: skip
    exact = sphere_decay_rates(0.7, drag[1], drag[2], radius, length, 1)[0]
    assert decay_rate(rods, exact) == pytest.approx(exact, rel=0.012)


def test_a_filament_on_a_sphere_relaxes_to_a_great_circle():
    rods = BoundRods(
        surfaces.make("sphere", {"radius": 1.0}), [[1, 0, 0]], [[0, 1, 1]], nodes=33, length=2.0,
        geodesic_curvature=3 * beam_mode(1, arc(33)),
    )  # fmt: skip
    rods.step(2e-3, 2000)
    normal = np.linalg.svd(rods.position[0])[2][2]
    assert np.abs(rods.position[0] @ normal).max() < 1e-9
    assert np.abs(rods.strain[0, :, 2]).max() < 1e-8


CYLINDER = [
    ((1.0, 1.0, 1.0), (0.5, 1.0, 0.0)),
    ((1.0, 1.0, 1.0), (-0.5, 1.0, 0.0)),
    ((0.5, 2.0, 1.0), (0.0, 0.9, 0.0)),
    ((2.0, 1.0, 0.5), (0.6, 0.2, 0.0)),
]


@pytest.mark.parametrize(("stiffness", "intrinsic"), CYLINDER)
def test_a_filament_on_a_cylinder_relaxes_to_the_angle_of_least_energy(stiffness, intrinsic):
    radius = 0.7
    start = np.array([-1.2, -0.6, -0.1, 0.1, 0.6, 1.2])
    direction = np.stack([0 * start, np.cos(start), np.sin(start)], axis=-1)
    rods = BoundRods(
        surfaces.make("cylinder", {"radius": radius}), np.tile([radius, 0, 0], (6, 1)), direction, nodes=33,
        stiffness=stiffness, intrinsic=intrinsic,
    )  # fmt: skip
    rods.step(4e-3, 10_000)
    t = rods.rotation[:, rods.middle, :, 0]
    azimuthal = np.cross([0, 0, 1], rods.position[:, rods.middle] / radius)
    found = np.arctan(t[:, 2] / np.einsum("ij,ij->i", t, azimuthal))
    allowed = cylinder_angles(stiffness, intrinsic, radius)
    nearest = np.abs(found[:, None] - allowed).min(axis=1)
    assert nearest.max() < 1e-6


def test_two_hands_are_degenerate_on_a_cylinder_only_without_twist():
    both = cylinder_angles((0.5, 2.0, 1.0), (0.0, 0.9, 0.0), 0.7)
    assert len(both) == 2 and both[0] == pytest.approx(-both[1])
    rods = BoundRods(
        surfaces.make("cylinder", {"radius": 0.7}), [[0.7, 0, 0]] * 2, [[0, 1, 0.3], [0, 1, -0.3]], nodes=33,
        stiffness=(0.5, 2.0, 1.0), intrinsic=(0.0, 0.9, 0.0),
    )  # fmt: skip
    rods.step(4e-3, 10_000)
    twist, energy = rods.strain[:, 16, 0], rods.variables()["energy"]
    assert twist[0] == pytest.approx(-twist[1], rel=1e-8) and abs(twist[0]) > 0.1
    assert energy[0] == pytest.approx(energy[1], rel=1e-10)


def slope(differences) -> float:
    """Order from successive differences of solutions, each with half the step of the previous one."""
    return float(np.polyfit(np.arange(len(differences)), -np.log2(differences), 1)[0])


def test_second_order_in_space(device):
    lines = []
    for nodes in (17, 33, 65, 129):
        rods = on_torus(nodes, device)
        rods.step(1e-4, 200)
        lines.append(rods.position[0, :: (nodes - 1) // 16])
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    assert slope(errors) == ORDER


def test_second_order_in_time(device):
    lines = []
    for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        rods = on_torus(33, device)
        rods.step(2.5e-5, 2000)  # the fast initial relaxation, with the same steps in every run
        rods.step(step, round(0.1 / step))
        lines.append(rods.position[0])
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    assert slope(errors) == ORDER


def test_a_change_of_step_keeps_the_order():
    def run(step: float) -> np.ndarray:
        rods = on_torus(33)
        rods.step(2.5e-5, 2000)
        for _ in range(round(0.06 / (3 * step))):
            rods.step(step)
            rods.step(2 * step)
        return rods.position[0]

    lines = [run(step) for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4)]
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    assert slope(errors) == ORDER


def identity_residual(nodes: int) -> float:
    """|dE/dt + D|/D on the torus at t = 0.01, dE/dt by central differences of small steps."""
    rods, dt = on_torus(nodes), 2e-5
    rods.step(dt, 500)
    energy, dissipated = [], []
    for _ in range(3):
        values = rods.variables()
        energy.append(values["energy"][0])
        dissipated.append(values["dissipation"][0])
        rods.step(dt)
    return abs((energy[2] - energy[0]) / (2 * dt) + dissipated[1]) / dissipated[1]


def test_the_energy_decreases_by_the_dissipation():
    residuals = [identity_residual(nodes) for nodes in (17, 33, 65)]
    assert residuals[0] / residuals[1] > 4 * 0.85 and residuals[1] / residuals[2] > 4 * 0.85
    assert residuals[2] < 1e-3


def test_a_filament_stays_on_the_surface_and_keeps_its_length(device):
    rods = on_torus(33, device)
    for _ in range(10):
        rods.step(1e-3, 100)
        values = rods.variables()
        assert values["constraint"][0] < 1e-9
        assert values["orthogonality"][0] < 1e-15
        assert values["arc_length"][0] < 1e-9


def alone_and_in_a_batch():
    """A rod, and the same together with one of other parameters."""
    alone = on_torus(33)
    position, direction = [[1.3, 0.1, 0.25], [0.0, 1.4, 0.0]], [[0.3, 1.0, 0.4], [1.0, 0.0, 0.3]]
    turn = np.stack([alone.strain[0, :, 2], 0 * arc(33)])
    each = {key: [value, np.multiply(value, 1.3)] for key, value in PARAMETERS.items()}
    return alone, BoundRods(TORUS, position, direction, nodes=33, geodesic_curvature=turn, **each)


def test_a_rod_does_not_depend_on_its_batch():
    """Steps of the same length give the same bits; where the error of all rods divides the first ones, nearly so."""
    alone, batch = alone_and_in_a_batch()
    take_steps(alone, 1e-3, 50)
    take_steps(batch, 1e-3, 50)
    np.testing.assert_array_equal(batch.position[0], alone.position[0])
    alone, batch = alone_and_in_a_batch()
    alone.step(1e-3, 50)
    batch.step(1e-3, 50)
    np.testing.assert_allclose(batch.position[0], alone.position[0], rtol=0, atol=1e-6)


def test_steps_by_error_have_the_same_bits_alone_in_a_batch_and_after_a_restart():
    """Each rod takes steps of its own; what is shown does not change them."""
    alone, batch = alone_and_in_a_batch()
    alone.advance_to(0.02)
    state = alone.state()
    alone.advance_to(0.07)
    batch.advance_to(0.07)
    again, _ = alone_and_in_a_batch()
    again.restore(state)
    again.advance_to(0.03)
    again.advance_to(0.07)
    assert len(set(batch.steps_taken)) == 2
    for name in ("position", "strain", "orientation"):
        np.testing.assert_array_equal(getattr(batch, name)[0], getattr(alone, name)[0], err_msg=name)
        np.testing.assert_array_equal(getattr(again, name), getattr(alone, name), err_msg=name)


def test_a_restored_state_continues_with_the_same_bits(device):
    rods = on_torus(33, device)
    rods.step(1e-3, 20)
    state = rods.state()
    rods.step(1e-3, 30)
    rods.step(7e-4, 5)
    expected = rods.position
    other = on_torus(33, device)
    other.restore(state)
    other.step(1e-3, 30)
    other.step(7e-4, 5)
    np.testing.assert_array_equal(other.position, expected)


def test_a_failing_rod_is_frozen_and_named_and_the_others_continue():
    rods = BoundRods(TORUS, [[1.4, 0, 0]] * 2, [[0, 1, 0.2]] * 2, nodes=33, length=[0.5, 0.6])
    force = np.zeros((2, 33, 3))
    force[1, 16] = np.nan
    rods.force_array.assign(force)
    before = rods.position[1]
    rods.step(1e-3, 10)
    (failure,) = rods.failures()
    assert failure[0] == 1 and failure[2] == "became non-finite"
    assert rods.parameters(1)["length"] == 0.6
    np.testing.assert_array_equal(rods.position[1], before)
    assert rods.status.tolist() == [0, 1] and np.isfinite(rods.position).all()
    assert np.abs(rods.position[0] - before).max() > 0


def test_a_force_moves_a_straight_filament_against_the_drag():
    """On the plane u = (f∥/ζ∥, f⊥/ζ⊥): tests sign and frame of an external force."""
    rods = BoundRods(surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], drag=(1.0, 2.0, 0.1))
    rods.force = np.array([0.3, 0.5, 0.0])
    start = rods.position
    rods.step(1e-3, 100)
    np.testing.assert_allclose(rods.position - start, np.broadcast_to([0.03, 0.025, 0.0], start.shape), atol=1e-12)
