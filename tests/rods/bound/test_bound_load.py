"""The load on the membrane, from the balances of forces and moments on the filament."""

import numpy as np
import pytest
import xarray as xr
from examples.bound import LENGTH, compatible_turn, order, read, smooth_filaments, twin_rod, twin_state
from reference import bound as twin

import warp_rods as wr
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods

NODES = (65, 129, 257)
"""With 33 nodes the boundary layers at the ends are not resolved."""


def drag_force(rods, b, rod, state):
    """ζu at nodes in the frame, from the velocities on the device."""
    from_half, from_node = twin.at_nodes(state.geodesic, rod.spacing)
    u2 = read(rods, "velocity_across")[b]
    u1 = from_half @ read(rods, "velocity_along")[b, :-1] + from_node @ u2
    return np.stack([rod.drag[0] * u1, rod.drag[1] * u2, np.zeros_like(u1)], -1)


def forces(rods, b, nodes):
    """Internal force and remaining force per length of one rod in space [node, 3]; its frames and Δs."""
    rod, state = twin_rod("torus", b, nodes), twin_state(rods, b)
    m, strain = read(rods, "moment")[b], twin.strain(read(rods, "curvature")[b], state.geodesic)
    inner = twin.internal_force(strain, m, twin.slope(m, rod.spacing), read(rods, "tension")[b])
    inner, drag = (np.einsum("nij,nj->ni", state.rotation, v) for v in (inner, drag_force(rods, b, rod, state)))
    return inner, rods.force[b] - rods.variables()["load"][b] - drag, state.rotation, rod.spacing


@pytest.fixture(scope="module")
def refined(device):
    """The results of ``forces`` for each number of nodes and each of two rods on the torus."""
    turns = [compatible_turn("torus", rod) for rod in range(len(LENGTH))]
    runs = [smooth_filaments("torus", nodes, device, turns) for nodes in NODES]
    for rods in runs:
        rods.evaluate()
    return [[forces(rods, b, nodes) for b in range(rods.count)] for rods, nodes in zip(runs, NODES, strict=True)]


def test_local_balance_in_all_directions_is_second_order(refined, verified):
    """∂s(Rλ⃗) + f − load = ζu along q, n×q and n, except at two nodes from each end."""
    errors = []
    for run in refined:
        residuals = [np.einsum("nij,ni->nj", R, twin.slope(inner, h) + outer) for inner, outer, R, h in run]
        errors.append([np.abs(r[2:-2]).max(axis=0) for r in residuals])
    verified.order(
        "load on the membrane: balance of forces at each node, order in Δs",
        measured=order(np.array(NODES) - 1, np.reshape(errors, (len(NODES), -1))),
        reference="∂s(RΛ) + f − load = ζu in three directions, two filaments",
    )  # fmt: skip


def test_whole_filament_balances_to_second_order(refined, verified):
    """∫(f − load − ζu) ds + [Rλ⃗] = 0; the forces of the membrane on free ends are included."""
    errors = [
        [np.linalg.norm(twin.total(outer, h) + inner[-1] - inner[0]) for inner, outer, _R, h in run] for run in refined
    ]
    verified.order(
        "load on the membrane: balance of forces on a filament, order in Δs",
        measured=order(np.array(NODES) - 1, errors), reference="∫(f − load − ζu) ds + [RΛ] = 0",
    )  # fmt: skip


def moment_residual(rods, b, nodes) -> float:
    """|[Rm + r×Rλ⃗] − ∫ (χ + ζr ω0) q − r×(f − load − ζu) ds|: the balance of moments about the origin."""
    inner, outer, R, h = forces(rods, b, nodes)
    values, q = rods.variables(), R[:, :, 0]
    r, m = values["position"][b], np.einsum("nij,nj->ni", R, read(rods, "moment")[b])
    state, rod, K = twin_state(rods, b), twin_rod("torus", b, nodes), read(rods, "curvature")[b]
    u1, u2 = (drag_force(rods, b, rod, state) / [rod.drag[0], rod.drag[1], 1.0]).T[:2]
    couple = values["load_moment"][b] + rod.drag[2] * (K[:, 1] * u1 + K[:, 2] * u2)
    section = m + np.cross(r, inner)
    return np.linalg.norm(section[-1] - section[0] - twin.total(couple[:, None] * q - np.cross(r, outer), h))


def test_moments_on_a_whole_filament_balance_to_second_order(device, verified):
    turns = [compatible_turn("torus", rod) for rod in range(len(LENGTH))]
    errors = []
    for nodes in NODES:
        rods = smooth_filaments("torus", nodes, device, turns)
        rods.evaluate()
        errors.append([moment_residual(rods, b, nodes) for b in range(rods.count)])
    verified.order(
        "load on the membrane: balance of moments on a filament, order in Δs",
        measured=order(np.array(NODES) - 1, errors), reference="about the origin, two filaments",
    )  # fmt: skip


def test_great_circle_at_rest_pushes_its_membrane_outwards(device, verified):
    """Bent more than its intrinsic curvature, m2 > 0: λ = −m2/R, load = m2/R² along n, and no motion.

    On a sphere K11 = K22 = −1/R and K12 = 0: (D.61) gives λ at the ends, F1 = 0 makes it constant, and the load is
    n·(∂sλ⃗ + Ω×λ⃗) = −λ/R.
    """
    R, B2 = 0.8, 1.3
    sigma = np.array([0.4, -0.5, 0.0])
    rods = BoundRods(
        surfaces.make("sphere", {"radius": R}),
        np.array([[0.5, 0.3, 0.6]]),
        np.array([[0.2, 0.9, -0.4]]),
        nodes=33,
        length=1.1,
        stiffness=[0.7, B2, 0.9],
        intrinsic=sigma,
        drag=[1.0, 2.0, 0.3],
        device=device,
    )
    found = rods.variables()
    m2 = B2 * (1 / R - sigma[1])
    outwards = rods.position[0] / R
    verified(
        "exact", "great circle at rest on its sphere: tension", measured=found["tension"][0], expected=-m2 / R,
        relative=1e-12, reference="−m2/R, from (D.61)",
    )  # fmt: skip
    verified.below(
        "exact", "great circle at rest on its sphere: load, relative",
        measured=np.abs(found["load"][0] - m2 / R**2 * outwards).max() / m2, bound=1e-11, reference="m2/R² outwards",
    )  # fmt: skip
    verified.below(
        "exact", "great circle at rest on its sphere: dissipation", measured=found["dissipation"][0], bound=1e-18,
        reference="0",
    )  # fmt: skip


def frame_of(rods) -> xr.Dataset:
    """The present frame of an ensemble as a dataset of one frame, in double precision."""
    values = rods.variables()
    return xr.Dataset({name: (rods.saved[name].dims, value[None]) for name, value in values.items()})


def on_membrane(rods) -> np.ndarray:
    """Force and torque on the membrane, as measured [force or torque, rod, 3]."""
    found = wr.measure(frame_of(rods), "force_on_membrane", "torque_on_membrane")
    return np.stack([found.force_on_membrane[0], found.torque_on_membrane[0]])


def test_great_circle_at_rest_exerts_no_net_force_and_torque(device, verified):
    """Its ends press with −m2/R along the tangent and with the couple m2: as much as the whole density does."""
    R, sigma, B2, errors, torques = 0.8, np.array([0.4, -0.5, 0.0]), 1.3, [], []
    m1, m2 = 0.7 * (0.0 - sigma[0]), B2 * (1 / R - sigma[1])
    for nodes in (17, 33, 65):
        rods = BoundRods(
            surfaces.make("sphere", {"radius": R}), [[0.5, 0.3, 0.6]], [[0.2, 0.9, -0.4]],
            nodes=nodes, length=1.1, stiffness=[0.7, B2, 0.9], intrinsic=sigma, drag=[1.0, 2.0, 0.3], device=device,
        )  # fmt: skip
        q, q1, _ = np.moveaxis(rods.rotation[0, [0, -1]], -1, 0)
        sign = np.array([[1.0], [-1.0]])
        # K11 = K22 = −1/R, K12 = 0: λ = −m2/R, λ2 = −K22 m1 = m1/R, λ3 = 0.
        np.testing.assert_allclose(rods.end_load[0], sign * (-m2 * q + m1 * q1) / R, atol=1e-11)
        np.testing.assert_allclose(rods.end_moment[0], sign * (m1 * q + m2 * q1), atol=1e-11)
        np.testing.assert_allclose(rods.stretch_force[0], 0.0, atol=1e-11)
        assert np.linalg.norm(twin.total(rods.variables()["load"][0], 1.1 / (nodes - 1))) > 1.0  # without its ends
        force, torque = np.linalg.norm(on_membrane(rods), axis=-1)[:, 0]
        torques.append(torque)
        errors.append(force)
    name = "great circle at rest, with its ends"
    verified.below(
        "conservation", f"{name}: torque on its membrane", measured=torques, bound=1e-11, reference="0, N = 16, 32, 64"
    )
    verified.order(
        f"{name}: force on its membrane, order in Δs", measured=order(np.array([16, 32, 64]), errors), reference="0"
    )


def balance_error(rods, b, nodes, kind="torus") -> np.ndarray:
    """|force and torque on the membrane − those of the external force and of minus the drag| of one rod."""
    rod, state, K = twin_rod(kind, b, nodes), twin_state(rods, b), read(rods, "curvature")[b]
    drag = drag_force(rods, b, rod, state)
    u1, u2 = (drag / [rod.drag[0], rod.drag[1], 1.0]).T[:2]
    q, r = state.rotation[:, :, 0], state.position
    f = rods.force[b] - np.einsum("nij,nj->ni", state.rotation, drag)
    couple = -rod.drag[2] * (K[:, 1] * u1 + K[:, 2] * u2)
    free = np.stack([twin.total(f, rod.spacing), twin.total(np.cross(r, f) + couple[:, None] * q, rod.spacing)])
    return np.linalg.norm(on_membrane(rods)[:, b] - free, axis=-1)


def test_stretch_force_is_the_force_that_does_work_along_the_membrane(device, verified):
    """λ + K12 m1 − K11 m2; it vanishes at free ends, where the tension does not."""
    rods = smooth_filaments("torus", 33, device, [compatible_turn("torus", rod) for rod in range(len(LENGTH))])
    rods.evaluate()
    K, m = rods.curvature, read(rods, "moment")
    expected = rods.tension + K[..., 1] * m[..., 0] - K[..., 0] * m[..., 1]
    np.testing.assert_allclose(rods.stretch_force, expected, rtol=0, atol=1e-12)
    verified.below(
        "exact", "stretch force at free ends", measured=np.abs(rods.stretch_force[:, [0, -1]]), bound=1e-12,
        reference="0",
    )  # fmt: skip
    assert np.abs(rods.tension[:, [0, -1]]).min() > 0.01


@pytest.mark.long
@pytest.mark.parametrize("kind", ["torus", "cassini"])
def test_what_a_filament_feels_it_passes_on_to_its_membrane(kind, device, verified):
    """External force less drag is the force on the membrane, and so for the torque; bent filaments that move."""
    turns = [compatible_turn(kind, rod) for rod in range(len(LENGTH))]
    errors = []
    for nodes in NODES:
        rods = smooth_filaments(kind, nodes, device, turns)
        rods.evaluate()
        errors.append(np.concatenate([balance_error(rods, b, nodes, kind) for b in range(rods.count)]))
    verified.order(
        f"force and torque of a filament on its membrane, {kind}: order in Δs",
        measured=order(np.array(NODES) - 1, errors), reference="external force less drag, two filaments",
    )  # fmt: skip


def test_after_steps_the_balance_is_of_second_order(device, verified):
    """Whatever Ω at the ends was at the start: also for a filament with a clamped end."""
    for ends in (("free", "free"), ("clamped", "free")):
        errors = []
        for nodes in (33, 65, 129):
            rods = BoundRods(
                surfaces.make("ellipsoid", {"radii": [1.0, 1.4, 0.8]}), [[0.5, 0.7, 0.5]], [[0.4, 0.8, -0.3]],
                nodes=nodes, length=0.9, stiffness=[0.6, 0.9, 1.1], intrinsic=[0.5, 0.3, 0.4], drag=[1.0, 2.0, 0.3],
                ends=ends, device=device,
            )  # fmt: skip
            rods.force = [0.3, -0.2, 0.5]
            rods.step(2e-4, 1000)
            values, R = rods.variables(), rods.rotation[0]
            u1, u2 = read(rods, "velocity_along")[0], read(rods, "velocity_across")[0]
            u1 = np.concatenate([[1.5 * u1[0] - 0.5 * u1[1]], (u1[1:-1] + u1[:-2]) / 2, [1.5 * u1[-2] - 0.5 * u1[-3]]])
            drag = u1[:, None] * R[:, :, 0] + 2.0 * u2[:, None] * R[:, :, 1]
            expected = twin.total(np.array([0.3, -0.2, 0.5]) - drag, values["length"][0] / (nodes - 1))
            assert np.linalg.norm(expected) > 0.1
            errors.append(np.linalg.norm(on_membrane(rods)[0, 0] - expected))
        verified.order(
            f"force of a filament on its membrane after steps, {ends[0]} and {ends[1]}: order in Δs",
            measured=order(np.array([32, 64, 128]), np.array(errors)), within=0.25,
            reference="external force less drag",
        )  # fmt: skip
