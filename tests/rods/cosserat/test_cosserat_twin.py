"""Cosserat rods: the equations in NumPy keep the energy law, and the kernels agree with them."""

import numpy as np
import pytest
from examples.contact_steps import lengths_of_steps, take_steps
from examples.cosserat import COUPLED, in_space, natural_in_space
from reference import cosserat as twin
from reference.lie import frame_matrix

NODES = 11


def between(values):
    return (values[..., 1:, :] + values[..., :-1, :]) / 2


def frames_of(rods, i):
    return np.array([frame_matrix(*one) for one in zip(rods.rotation[i], rods.position[i], strict=True)])


def some_rod(ends=("free", "free")):
    """A rod with rough strains, and frames, couples and forces."""
    rng = np.random.default_rng(3)
    natural = between(natural_in_space(NODES)) + 0.1 * rng.normal(size=(NODES - 1, 6))
    rod = twin.Rod(COUPLED, natural, np.array([0.2, 0, 0, 1, 2, 2]), ends)
    strain = natural + np.array([1, 1, 1, 0.1, 0.1, 0.1]) * rng.normal(size=natural.shape)
    load = rng.normal(size=(2, NODES, 3))
    return rod, twin.lay_out(strain, rod.spacing), *load


def test_forces_are_minus_the_gradient_of_the_energy(verified):
    rod, S, _, _ = some_rod()
    h, gradient = 1e-5, np.zeros((NODES, 6))
    for node, axis in np.ndindex(*gradient.shape):
        energies = []
        for side in (h, -h):
            moved = S.copy()
            moved[node] = S[node] @ twin.exp(side * np.eye(6)[axis])
            energies.append(twin.energy(rod, moved))
        gradient[node, axis] = (energies[0] - energies[1]) / (2 * h)
    force = twin.elastic_force(rod, S)
    verified.below(
        "independent", "Cosserat rod in NumPy: forces and couples on nodes, relative",
        measured=abs(force + gradient).max() / abs(force).max(), bound=1e-9,
        reference="differences of the energy",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "hinged")])
def test_energy_law_of_the_rod_discretised_in_space(ends, verified):
    """d(energy)/dt = power − dissipation for any frames in which moments across balance, coupled stiffness included."""
    rod, S, couple, force = some_rod(ends)
    S = twin.balance_moments(rod, S, couple, force)
    v, w = twin.rates(rod, S, couple, force), rod.weights[:, None]
    power = np.sum(w * v * twin.load_in_frame(S, couple, force))
    dissipation = np.sum(w * rod.drag * v**2)
    change = -np.sum(v * twin.elastic_force(rod, S))
    verified.below(
        "conservation", f"Cosserat rod, ends {ends}: dE/dt − power + dissipation, over dissipation",
        measured=abs(change - power + dissipation) / dissipation, bound=1e-13, reference="zero",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "hinged")])
def test_steps_agree_with_twin(device, ends, verified):
    """Steps of two lengths, the first ones of order 1, of rods with different parameters under forces and couples."""
    rng = np.random.default_rng(1)
    natural = natural_in_space(NODES) + 0.1 * rng.normal(size=(3, NODES, 6))
    stiffness = COUPLED * rng.uniform(0.5, 2, (3, 1, 1))
    drag = {"drag_ratio": rng.uniform(1.5, 3, 3), "rotational_drag": rng.uniform(0.05, 0.2, 3)}
    rods = in_space(device, NODES, 3, stiffness=stiffness, natural=natural, ends=ends, **drag)
    rods.force, rods.couple = load = rng.normal(size=(2, 3, NODES, 3))
    rods.prepare_step(1e-3)
    eta, turn = drag["drag_ratio"], drag["rotational_drag"]
    twins = [
        twin.Rod(stiffness[i], between(natural)[i], np.array([turn[i], 0, 0, 1, eta[i], eta[i]]), ends)
        for i in range(3)
    ]
    frames = [frames_of(rods, i) for i in range(3)]
    past, times = [[], [], []], [0.0]
    stresses = [[twin.stress(rod, S)] for rod, S in zip(twins, frames, strict=True)]
    for dt, steps in ((1e-3, 3), (2e-3, 3)):
        lengths = lengths_of_steps(rods, dt, steps)
        take_steps(rods, dt, steps)
        for length in lengths:
            for i, rod in enumerate(twins):
                frames[i], y, P = twin.step(
                    rod, frames[i], past[i], stresses[i], times, times[0] + length, load[1, i], load[0, i]
                )
                past[i], stresses[i] = [y], [P, stresses[i][0]]
            times = [times[0] + length, times[0]]
    errors = [abs(rods.position - np.array(frames)[:, :, :3, 3]).max()]
    errors += [abs(rods.rotation - np.array(frames)[:, :, :3, :3]).max()]
    errors += [abs(rods.energy[i] / twin.energy(rod, frames[i]) - 1) for i, rod in enumerate(twins)]
    verified.below(
        "independent", f"Cosserat rods, ends {ends}: places, frames, energies after sixteen steps of several lengths",
        measured=errors, bound=1e-10, reference="the same steps in NumPy, dense matrices and series",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "hinged")])
def test_powers_agree_with_twin(device, ends, verified):
    rods = in_space(device, NODES, ends=ends)
    rng = np.random.default_rng(5)
    rods.force = rng.normal(size=(1, NODES, 3))
    rods.prepare_step(1.0)
    rod = twin.Rod(COUPLED, between(rods.natural[0]), np.array([0.05, 0, 0, 1, 2, 2]), ends)
    S = frames_of(rods, 0)
    v, w = twin.rates(rod, S, rods.couple[0], rods.force[0]), rod.weights[:, None]
    expected = [np.sum(w * v * twin.load_in_frame(S, rods.couple[0], rods.force[0])), np.sum(w * rod.drag * v**2)]
    verified(
        "independent", f"Cosserat rod, ends {ends}: power and dissipation",
        measured=[rods.power[0], rods.dissipation[0]], expected=expected, relative=1e-10,
        reference="the same equations in NumPy",
    )  # fmt: skip
