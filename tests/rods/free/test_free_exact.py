"""Active rods against exact solutions: relaxation, growth, the energy law, gravity and shear."""

import numpy as np
import pytest
import warp as wp
from examples.free import in_space, passive, slope
from scipy.spatial.transform import Rotation

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_root, coefficients
from warp_rods.theory import stability

TINY = 1e-6


def arc(nodes):
    return np.linspace(-0.5, 0.5, nodes)


@pytest.mark.parametrize("mode", [0, 1])
def test_beam_modes_relax_at_their_exact_rates(device, mode, verified):
    """A weakly bent passive rod: a_k decays at (β/η) x_k⁴; second order in the spacing, 0.5 % for N = 64."""
    exact = 5e-3 / 2 * beam_root(mode) ** 4
    sizes, errors = np.array([32, 64, 128]), []
    for size in sizes:
        s = arc(size + 1)
        rods = passive(device, int(size) + 1, shape={"kind": "mode", "mode": mode, "amplitude": TINY})
        dt = 2e-4 / exact
        rods.step(dt, 100)
        early = coefficients(rods.strain[0, :, 2], s, mode + 1)[mode]
        rods.step(dt, 1000)
        late = coefficients(rods.strain[0, :, 2], s, mode + 1)[mode]
        errors.append(abs(np.log(early / late) / (1000 * dt) / exact - 1))
    name = f"free rod: decay of beam mode {mode}"
    verified.below(
        "exact", f"{name}, N = 64", measured=errors[1], bound=5e-3, reference="relative to (b/η) x_k⁴, cos x cosh x = 1"
    )
    verified.order(f"{name}: order in Δs", measured=slope(sizes, errors), reference="error of the rate, N = 32 to 128")


def test_twist_relaxes_at_its_exact_rates(device, verified):
    """A straight passive rod: cos((2j+1)πs) decays at the rate of the three-point Laplacian, to round-off."""
    s, h, stiffness = arc(65), 1 / 64, 1e-3 / 3e-3
    for wave in (np.pi, 3 * np.pi):
        strain = np.zeros((65, 3))
        strain[:, 0] = 5 * np.cos(wave * s)
        rods = passive(device, shape=strain)
        laplacian = (2 * np.sin(wave * h / 2) / h) ** 2
        exact = -stiffness * laplacian * strain[1:-1, 0]
        error = np.abs(rods.rates()["twist_rate"][0, 1:-1] - exact).max()
        name = f"free rod: twist cos {wave / np.pi:.0f}πs"
        verified.below(
            "exact", f"{name}, rate", measured=error, bound=1e-10, reference="−(c/ηr)(2 sin(qΔs/2)/Δs)² τ at each node"
        )
        dt = 1e-3 / (stiffness * wave**2)
        rods.step(dt, 1000)
        left = rods.strain[0, 32, 0] / 5
        verified(
            "exact", f"{name} after a time constant", measured=left, expected=np.exp(-1),
            relative=2e-3 * wave / np.pi, reference="exp(−1) with the rate (c/ηr) q²",
        )  # fmt: skip


@pytest.mark.parametrize(("mode", "rank"), [(1, 0), (0, 1)])
def test_small_bending_grows_at_the_linear_rate(device, mode, rank, verified):
    """Constant activity, small bending: the fastest odd and even modes of (4.37) grow at their rates, to 1 %."""
    bend, s = 2e-3, arc(129)
    growth = stability.eigenvalues(bend, "tanh")[rank].real
    shape = {"kind": "mode", "mode": mode, "amplitude": TINY / 100}
    held = Flagella(diffusion=0.0, law="held")
    rods = FreeRods(1, 129, bend=bend, twist=1e-3, shape=shape, flagella=held, device=device)
    rods.step(1e-3, 1500)
    early = coefficients(rods.strain[0, :, 2], s, 2)[mode]
    rods.step(1e-3, 500)
    late = coefficients(rods.strain[0, :, 2], s, 2)[mode]
    verified(
        "independent", f"swimmer: growth of the {('even', 'odd')[mode]} mode at β⊥ = 2e-3",
        measured=np.log(late / early) / 0.5, expected=growth, relative=1e-2,
        reference="eigenvalue of (4.37) by finite elements",
    )  # fmt: skip


def test_energy_law_holds_to_round_off(device, verified):
    """dE/dt of the equations discretised in s is power − dissipation, for any shape, activity and external force."""
    rng = np.random.default_rng(3)
    strain = rng.normal(size=(4, 65, 3)) * 5
    rods = FreeRods(
        4, 65, bend=[1e-4, 1e-3, 1e-3, 5e-3], twist=[1e-3, 1e-4, 1e-3, 1e-3], moment=[1e-2, 1e-2, -2e-2, 0],
        shape=strain, flagella=Flagella(profile=rng.normal(size=(4, 65))), device=device,
    )  # fmt: skip
    rods.force = rng.normal(size=(4, 65, 3))
    rates = rods.rates()
    bend, twist = rods.bend[:, None], rods.twist[:, None]
    bent = bend * (rates["bending"].conj() * rates["bending_rate"]).real
    change = np.sum(bent + twist * rates["twist"] * rates["twist_rate"], axis=1) / 64
    defect = np.abs(change - rods.power + rods.dissipation).max() / rods.dissipation.max()
    verified.below(
        "conservation", "free rods: dE/dt − power + dissipation of the equations in Δs, over the dissipation",
        measured=defect, bound=1e-12, reference="§2.3: zero, whatever shape, activity and external force",
    )  # fmt: skip


def test_energy_law_of_a_run_is_second_order(device, verified):
    steps, errors = np.array([50, 100, 200]), []
    for count in steps:
        rods, dt = in_space(device), 0.1 / count
        rods.step(0.02 / count, 5)  # the first step is an Euler step
        rods.step(dt, 1)
        energy, power = [], []
        for _ in range(count):
            energy.append(rods.energy[0])
            power.append(rods.power[0] - rods.dissipation[0])
            rods.step(dt)
        errors.append(abs(np.trapezoid(power, dx=dt) - (energy[-1] - energy[0])))
    verified.order(
        "free rods: energy law over a run, order in Δt", measured=slope(steps, errors),
        reference="energy gained − ∫ (power − dissipation) dt",
    )  # fmt: skip


def gravity(t, position, rotation):
    return np.broadcast_to([0.0, 0.0, -0.3], position.shape)


@wp.func
def gravity_kernel(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    return wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(-0.3))


@pytest.mark.parametrize("external", [gravity, gravity_kernel])
def test_a_straight_rod_sinks_sideways(device, external, verified):
    """Under a uniform force F a straight rod keeps its direction and moves with velocity F∥ + F⊥/η."""
    rotation = Rotation.from_rotvec([0.3, -0.7, 0.2]).as_matrix()
    tangent = rotation[:, 0]
    rods = passive(device, shape={"kind": "straight"}, rotation=rotation, external=external)
    rods.step(1e-2, 100)
    force = np.array([0.0, 0.0, -0.3])
    along = tangent * (tangent @ force)
    error = np.abs(rods.position[0, 32] - along - (force - along) / 2).max()
    verified.below(
        "exact", f"free rod: sinking sideways, {'force in Python' if external is gravity else 'force as a kernel'}",
        measured=error, bound=1e-12, reference="u = F∥ + F⊥/η",
    )  # fmt: skip
    np.testing.assert_allclose(rods.rotation[0, :, :, 0], np.broadcast_to(tangent, (65, 3)), rtol=0, atol=1e-12)


@wp.func
def shear_flow(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    """Drag of the flow (y, 0, 0) on a rod of drag ratio 2."""
    flow = wp.vec3d(x[1], wp.float64(0.0), wp.float64(0.0))
    along = wp.dot(tangent, flow) * tangent
    return wp.float64(2.0) * flow - along


def shear_flow_numpy(t, position, rotation):
    flow = position[..., 1:2] * np.array([1.0, 0.0, 0.0])
    tangent = rotation[..., 0]
    return 2 * flow - np.sum(tangent * flow, axis=-1, keepdims=True) * tangent


def test_a_straight_rod_turns_in_shear(device, verified):
    """cot θ = cot θ₀ + γ̇ t for a thin rod in the plane of shear; second order in time, for both kinds of force."""
    steps, errors = np.array([25, 50, 100]), []
    for count in steps:
        rotation = Rotation.from_rotvec([0, 0, 2.0]).as_matrix()
        rods = passive(device, shape={"kind": "straight"}, rotation=rotation, external=shear_flow)
        rods.step(2 / count, count)
        tangent = rods.rotation[0, 32, :, 0]
        errors.append(abs(tangent[0] / tangent[1] - (1 / np.tan(2.0) + 2)))
    verified.order(
        "free rod: turning in shear, order in Δt", measured=slope(steps, errors), reference="cot θ = cot θ₀ + γ̇t"
    )
    other = passive(device, shape={"kind": "straight"}, rotation=rotation, external=shear_flow_numpy)
    other.step(2 / count, count)
    np.testing.assert_allclose(other.position, rods.position, rtol=0, atol=1e-12)
