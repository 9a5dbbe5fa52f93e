"""Known results for swimmers (docs/model.md §7): the steady U and its bifurcations, in simulations.

References are those of ``reference/exact.py``. tests/theory/test_exact.py compares them with
other methods.
"""

import numpy as np
import pytest
from reference.exact import HOPF, SADDLE_NODE, STEADY_U

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients


@pytest.mark.parametrize(("nodes", "within"), [(65, 5e-3), (129, 1e-3)])
def test_steady_swimmers(device, nodes, within, verified):
    """The steady U of a strongly bent rod: its first mode and its speed, for two stiffnesses."""
    rods = FreeRods(2, nodes, bend=list(STEADY_U), twist=1e-3, shape={"kind": "mode", "amplitude": 3.0}, device=device)
    rods.step(1e-3, 4000)
    before = rods.position
    rods.step(1e-3, 500)
    speed = np.linalg.norm(rods.position - before, axis=-1)[:, nodes // 2] / 0.5
    amplitude = coefficients(rods.strain[..., 2], np.linspace(-0.5, 0.5, nodes), 1)[:, 0]
    verified(
        "independent", f"steady U by time steps, N = {nodes - 1}: a₀ and speed at β⊥ = 5e-3 and 1e-3",
        measured=np.stack([amplitude, speed], axis=1), expected=list(STEADY_U.values()), relative=within,
        reference="boundary value problem by SciPy's `solve_bvp`",
    )  # fmt: skip
    verified(
        "conservation", f"steady U, N = {nodes - 1}: power over dissipation", measured=rods.power / rods.dissipation,
        expected=1, within=1e-4, reference="dE/dt = 0",
    )  # fmt: skip


def test_the_u_ends_in_a_saddle_node(device, verified):
    """Continued in β from a bent state, the symmetric U exists below 8.876e-3 and not above, within 0.3 %."""

    def swim(bend, shape, activity, dt, steps):
        rods = FreeRods(
            len(bend), 65, bend=bend, twist=1e-3, shape=shape, flagella=Flagella(profile=activity),
            symmetric=True, device=device,
        )  # fmt: skip
        rods.step(dt, steps)
        return rods.strain, rods.activity

    state = swim([5e-3], {"kind": "mode", "amplitude": 3.0}, "tanh", 1e-3, 3000)
    for bend in (7e-3, 8e-3, 8.5e-3, 8.75e-3):
        state = swim([bend], *state, 2e-3, 3000)
    bends = np.array([8.85e-3, 8.90e-3])
    strain, _ = swim(bends, *state, 4e-3, 15_000)
    amplitude = coefficients(strain[..., 2], np.linspace(-0.5, 0.5, 65), 1)[:, 0]
    bent, straight = bends[amplitude > 1.4], bends[amplitude < 1e-6]
    verified(
        "independent", "stiffness at which the U ends, by time steps", measured=(bent.max() + straight.min()) / 2,
        expected=SADDLE_NODE, relative=3e-3, reference="SciPy's `solve_bvp`; bent at 8.85e-3, straight at 8.90e-3",
    )  # fmt: skip


def planar_rates(bend, nodes, states, device):
    """d/dt of (κ at inner nodes, f) for planar states [state, 2 nodes − 2], each of which is a rod of a batch."""
    strain = np.zeros((len(states), nodes, 3))
    strain[:, 1:-1, 2] = states[:, : nodes - 2]
    activity = Flagella(profile=states[:, nodes - 2 :])
    rods = FreeRods(len(states), nodes, bend=bend, twist=1e-3, shape=strain, flagella=activity, device=device)
    rates = rods.rates()
    return np.concatenate([rates["bending_rate"].imag[:, 1:-1], rates["activity_rate"]], axis=1)


def oscillation_growth(bend, nodes, device):
    """Growth rate of the leading oscillation about the symmetric U, by relaxation, Newton steps and eigenvalues."""
    rods = FreeRods(
        1, nodes, bend=bend, twist=1e-3, shape={"kind": "mode", "amplitude": 4.0}, symmetric=True, device=device
    )
    rods.step(1e-3, 12_000)
    state = np.concatenate([rods.strain[0, 1:-1, 2], rods.activity[0]])
    small = 1e-6 * np.eye(len(state))
    for _ in range(4):
        rates = planar_rates(bend, nodes, np.concatenate([state + small, state - small, state[None]]), device)
        jacobian = (rates[: len(state)] - rates[len(state) : -1]).T / 2e-6
        state = state - np.linalg.solve(jacobian, rates[-1])
    assert abs(rates[-1]).max() < 1e-6
    spectrum = np.linalg.eigvals(jacobian)
    return spectrum[abs(spectrum.imag) > 1].real.max()


@pytest.mark.long
def test_the_u_starts_to_wave_at_a_hopf_bifurcation(device, verified):
    """The growth rate vanishes at 1.456e-4, extrapolated from two grids, within 1.5 %."""
    bends = np.array([1.5e-4, 1.54e-4])
    hopf = []
    for nodes in (65, 129):
        growth = [oscillation_growth(bend, nodes, device) for bend in bends]
        hopf.append(bends[0] - growth[0] * np.diff(bends)[0] / np.diff(growth)[0])
    verified(
        "independent", "stiffness at which the U starts to wave, from Jacobians of the rates",
        measured=(4 * hopf[1] - hopf[0]) / 3, expected=HOPF, relative=1.5e-2,
        reference="Galerkin method in the material frame (tests/reference/waving.py)",
    )  # fmt: skip
