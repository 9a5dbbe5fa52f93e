"""Surface-bound filaments against exact solutions (docs/model.md §7), and orders of accuracy.

References are closed forms and conservation laws, orders are fitted slopes. Every tolerance is round-off or follows
from the order.
"""

from itertools import pairwise

import numpy as np
import pytest
from examples.bound import BOUNDS, constraint_errors, energy_defect
from examples.contact_steps import take_steps
from reference.exact import beam_decay_rates, cylinder_angles, sphere_decay_rates

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.modes import beam_mode

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


def test_a_filament_on_the_plane_decays_like_a_beam(device, verified):
    rods = BoundRods(
        surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], nodes=65, device=device,
        geodesic_curvature=1e-4 * beam_mode(0, arc(65)), drag=(1.0, 2.0, 0.1), stiffness=(1.0, 1.0, 0.7),
    )  # fmt: skip
    exact = beam_decay_rates(0.7, 2.0, 1.0, 1)[0]
    verified(
        "exact", "filament on a plane: decay of beam mode 0, N = 64", measured=decay_rate(rods, exact), expected=exact,
        relative=0.012, reference="(B3/ζ⊥)(x₀/L)⁴",
    )  # fmt: skip


@pytest.mark.parametrize("extra", [(1.0, 0.0), (4.0, 2.0)], ids=["plain", "with B2, σ2"])
def test_the_decay_on_a_sphere_does_not_depend_on_normal_bending(device, extra, verified):
    radius, length, drag = 0.8, 1.1, (1.0, 2.0, 0.3)
    rods = BoundRods(
        surfaces.make("sphere", {"radius": radius}), [[radius, 0, 0]], [[0, 1, 0]], nodes=65, length=length,
        stiffness=(1.0, extra[0], 0.7), intrinsic=(0.0, extra[1], 0.0), drag=drag,
        geodesic_curvature=1e-4 * beam_mode(0, arc(65)), device=device,
    )  # fmt: skip
    exact = sphere_decay_rates(0.7, drag[1], drag[2], radius, length, 1)[0]
    verified(
        "exact", f"filament on a sphere: decay of small bending, B2 = {extra[0]:g}, σ2 = {extra[1]:g}",
        measured=decay_rate(rods, exact), expected=exact, relative=0.012,
        reference="root of the spectrum of (B3/(ζ⊥ + ζr/R²))(∂² + 1/R²)²",
    )  # fmt: skip


def test_a_filament_on_a_sphere_relaxes_to_a_great_circle(verified):
    rods = BoundRods(
        surfaces.make("sphere", {"radius": 1.0}), [[1, 0, 0]], [[0, 1, 1]], nodes=33, length=2.0,
        geodesic_curvature=3 * beam_mode(1, arc(33)),
    )  # fmt: skip
    rods.step(2e-3, 2000)
    normal = np.linalg.svd(rods.position[0])[2][2]
    off = [np.abs(rods.position[0] @ normal).max(), np.abs(rods.strain[0, :, 2]).max()]
    verified.below(
        "exact", "filament on a sphere at rest: distance from a great circle, and Ω", measured=off, bound=1e-9,
        reference="a great circle through the centre",
    )  # fmt: skip


CYLINDER = [
    ((1.0, 1.0, 1.0), (0.5, 1.0, 0.0)),
    pytest.param((1.0, 1.0, 1.0), (-0.5, 1.0, 0.0), marks=pytest.mark.long),
    ((0.5, 2.0, 1.0), (0.0, 0.9, 0.0)),
    pytest.param((2.0, 1.0, 0.5), (0.6, 0.2, 0.0), marks=pytest.mark.long),
]


@pytest.mark.parametrize(("stiffness", "intrinsic"), CYLINDER)
def test_a_filament_on_a_cylinder_relaxes_to_the_angle_of_least_energy(stiffness, intrinsic, verified):
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
    verified.below(
        "exact", f"filament on a cylinder at rest, B1, B2 = {stiffness[:2]}, σ1, σ2 = {intrinsic[:2]}: angles of six",
        measured=nearest, bound=1e-9, reference="minima of ½B1(sin 2α/2R − σ1)² + ½B2(cos²α/R − σ2)²",
    )  # fmt: skip


def test_two_hands_are_degenerate_on_a_cylinder_only_without_twist(verified):
    both = cylinder_angles((0.5, 2.0, 1.0), (0.0, 0.9, 0.0), 0.7)
    assert len(both) == 2 and both[0] == pytest.approx(-both[1])
    rods = BoundRods(
        surfaces.make("cylinder", {"radius": 0.7}), [[0.7, 0, 0]] * 2, [[0, 1, 0.3], [0, 1, -0.3]], nodes=33,
        stiffness=(0.5, 2.0, 1.0), intrinsic=(0.0, 0.9, 0.0),
    )  # fmt: skip
    rods.step(4e-3, 10_000)
    twist, energy = rods.strain[:, 16, 0], rods.variables()["energy"]
    assert twist[0] == pytest.approx(-twist[1], rel=1e-8) and abs(twist[0]) > 0.1
    exact = np.sin(2 * both) / (2 * 0.7)
    verified(
        "exact", "filament on a cylinder without σ1: twists of both hands", measured=np.sort(twist),
        expected=np.sort(exact), relative=1e-6, reference="± sin 2α/2R, cos 2α = B2(2Rσ2 − 1)/(B2 − B1)",
    )  # fmt: skip
    verified(
        "symmetry", "filament on a cylinder without σ1: energies of both hands, ratio", measured=energy[0] / energy[1],
        expected=1, within=1e-10, reference="mirror images",
    )  # fmt: skip


def slope(differences) -> float:
    """Order from successive differences of solutions, each with half the step of the previous one."""
    return float(np.polyfit(np.arange(len(differences)), -np.log2(differences), 1)[0])


def test_second_order_in_space(device, verified):
    lines = []
    for nodes in (17, 33, 65, 129):
        rods = on_torus(nodes, device)
        rods.step(1e-4, 200)
        lines.append(rods.position[0, :: (nodes - 1) // 16])
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    verified.order("filament on a torus: order in Δs", measured=slope(errors), reference="N = 16 to 128")


def test_second_order_in_time(device, verified):
    lines = []
    for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        rods = on_torus(33, device)
        rods.step(2.5e-5, 2000)  # the fast initial relaxation, with the same steps in every run
        rods.step(step, round(0.1 / step))
        lines.append(rods.position[0])
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    verified.order("filament on a torus: order in Δt", measured=slope(errors), reference="Δt = 2e-3 to 2.5e-4")


def test_a_change_of_step_keeps_the_order(verified):
    def run(step: float) -> np.ndarray:
        rods = on_torus(33)
        rods.step(2.5e-5, 2000)
        for _ in range(round(0.06 / (3 * step))):
            rods.step(step)
            rods.step(2 * step)
        return rods.position[0]

    lines = [run(step) for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4)]
    errors = [np.abs(a - b).max() for a, b in pairwise(lines)]
    name = "filament on a torus: order in Δt while steps alternate between Δt and 2Δt"
    verified.order(name, measured=slope(errors), reference="Δt = 1e-3 to 1.25e-4")


def test_the_energy_decreases_by_the_dissipation(verified):
    """At t = 0.2, when the fast modes of the start have decayed."""
    residuals = []
    for nodes in (33, 65, 129):
        rods = on_torus(nodes)
        rods.step(2e-4, 1000)
        residuals.append(energy_defect(rods, 2e-4))
    verified.order(
        "filament on a torus: energy law, order in Δs", measured=slope(residuals),
        reference="|dE/dt + dissipation|, N = 32, 64, 128",
    )  # fmt: skip
    verified.below(
        "conservation", "filament on a torus: |dE/dt + dissipation| over the dissipation, N = 128",
        measured=residuals[-1], bound=2e-4, reference="0",
    )  # fmt: skip


def test_a_filament_stays_on_the_surface_and_keeps_its_length(device, verified):
    """Frames as they are kept: RᵀR = 1, normals of the surface, tangents along the chords of segments."""
    rods, found = on_torus(33, device), []
    for _ in range(10):
        rods.step(1e-3, 100)
        found.append(constraint_errors(rods))
    for name, bound in BOUNDS.items():
        verified.below(
            "constraint", f"filament on a torus: {name}", measured=[errors[name] for errors in found], bound=bound,
            reference="0, at ten times of 1000 steps",
        )  # fmt: skip


def alone_and_in_a_batch():
    """A rod, and the same together with one of other parameters."""
    alone = on_torus(33)
    position, direction = [[1.3, 0.1, 0.25], [0.0, 1.4, 0.0]], [[0.3, 1.0, 0.4], [1.0, 0.0, 0.3]]
    turn = np.stack([alone.strain[0, :, 2], 0 * arc(33)])
    each = {key: [value, np.multiply(value, 1.3)] for key, value in PARAMETERS.items()}
    return alone, BoundRods(TORUS, position, direction, nodes=33, geodesic_curvature=turn, **each)


def test_a_rod_does_not_depend_on_its_batch(verified):
    """Steps of the same length give the same bits; where the error of all rods divides the first ones, nearly so."""
    alone, batch = alone_and_in_a_batch()
    take_steps(alone, 1e-3, 50)
    take_steps(batch, 1e-3, 50)
    verified.same("filament alone and in a batch", alone.position[0], batch.position[0], reference="the batch")
    alone, batch = alone_and_in_a_batch()
    alone.step(1e-3, 50)
    batch.step(1e-3, 50)
    np.testing.assert_allclose(batch.position[0], alone.position[0], rtol=0, atol=1e-6)


def test_steps_by_error_have_the_same_bits_alone_in_a_batch_and_after_a_restart(verified):
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
    names = ("position", "strain", "orientation")
    expected = {name: getattr(alone, name)[0] for name in names}
    for said, rods in (("in a batch", batch), ("after a restart", again)):
        found = {name: getattr(rods, name)[0] for name in names}
        verified.same(f"filament in steps of its own, {said}", found, expected, reference="alone, without a stop")


def test_a_restored_state_continues_with_the_same_bits(device, verified):
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
    verified.same("filament on a torus: a restored state", other.position, expected, reference="no stop")


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


def test_a_force_moves_a_straight_filament_against_the_drag(verified):
    """On the plane u = (f∥/ζ∥, f⊥/ζ⊥): tests sign and frame of an external force."""
    rods = BoundRods(surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], drag=(1.0, 2.0, 0.1))
    rods.force = np.array([0.3, 0.5, 0.0])
    start = rods.position
    rods.step(1e-3, 100)
    verified.below(
        "exact", "straight filament on a plane under a force: path", measured=np.abs(
            rods.position - start - [0.03, 0.025, 0.0]
        ).max(), bound=1e-12, reference="u = (f∥/ζ∥, f⊥/ζ⊥)",
    )  # fmt: skip
