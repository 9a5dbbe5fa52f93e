"""Known results for swimmers (docs/model.md §7): the steady U and its bifurcations."""

import numpy as np
import pytest

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients

STEADY = {5e-3: (3.022, 0.4885), 1e-3: (3.936, 0.6406)}
"""β⊥ → (a₀, |U|), extrapolated to fine grids."""


@pytest.mark.parametrize(("nodes", "within"), [(65, 5e-3), (129, 1e-3)])
def test_steady_swimmers(device, nodes, within):
    """The steady U of a strongly bent rod: its first mode and its speed, for two stiffnesses."""
    rods = FreeRods(2, nodes, bend=list(STEADY), twist=1e-3, shape={"kind": "mode", "amplitude": 3.0}, device=device)
    rods.step(1e-3, 4000)
    before = rods.position
    rods.step(1e-3, 500)
    speed = np.linalg.norm(rods.position - before, axis=-1)[:, nodes // 2] / 0.5
    amplitude = coefficients(rods.strain[..., 2], np.linspace(-0.5, 0.5, nodes), 1)[:, 0]
    np.testing.assert_allclose(np.stack([amplitude, speed], axis=1), list(STEADY.values()), rtol=within)
    np.testing.assert_allclose(rods.power, rods.dissipation, rtol=1e-4)


def test_the_u_ends_in_a_saddle_node(device):
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
    strain, _ = swim([8.85e-3, 8.90e-3], *state, 4e-3, 15_000)
    amplitude = coefficients(strain[..., 2], np.linspace(-0.5, 0.5, 65), 1)[:, 0]
    assert amplitude[0] > 1.4
    assert amplitude[1] < 1e-6


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


def test_the_u_starts_to_wave_at_a_hopf_bifurcation(device):
    """The growth rate vanishes at 1.456e-4, extrapolated from two grids, within 1.5 %."""
    bends = np.array([1.5e-4, 1.54e-4])
    hopf = []
    for nodes in (65, 129):
        growth = [oscillation_growth(bend, nodes, device) for bend in bends]
        hopf.append(bends[0] - growth[0] * np.diff(bends)[0] / np.diff(growth)[0])
    assert (4 * hopf[1] - hopf[0]) / 3 == pytest.approx(1.456e-4, rel=1.5e-2)
