"""Branches of fixed shapes: known bifurcations of a swimmer, and eigenvalues against simulations in time."""

import numpy as np
import pytest
from examples.free import slope
from reference import waving
from reference.steady_u import fold
from test_steady import ROTATING

from warp_rods.errors import SceneError
from warp_rods.rods.modes import coefficients
from warp_rods.theory import stability
from warp_rods.theory.continuation import follow
from warp_rods.theory.steady import FixedShape, Swimmer, at_rest, settled, start
from warp_rods.theory.steady_equations import Equations


def u_swimmer(nodes, bend):
    swimmer = Swimmer(nodes, {"bend": bend, "twist": 1e-3}, symmetric=True)
    return settled(swimmer, {"kind": "mode", "amplitude": 3.0}, time=4.0)


def limit(values):
    """Second-order extrapolation of the values at N and 2N."""
    return (4 * values[1] - values[0]) / 3


@pytest.mark.long
def test_the_u_ends_in_a_fold(verified):
    """At 8.876e-3, second order in Δs. After the fold the branch is unstable and turns back."""
    branches = [follow(u_swimmer(nodes, 8e-3), "bend", 7.9e-3, 1e-2) for nodes in (33, 65, 129)]
    folds = [branch.of_kind("fold")[0].value for branch in branches]
    verified(
        "published", "stiffness at which the U ends, by continuation", measured=limit(folds[1:]), expected=fold(),
        relative=1e-5,
        reference="`solve_bvp` (tests/reference/steady_u.py); the dissertation prints 9.1e-3, 2.5 % more",
    )  # fmt: skip
    verified.order(
        "stiffness at which the U ends: order in Δs", measured=slope([32, 64], np.abs(np.diff(folds))),
        reference="N = 32, 64, 128",
    )  # fmt: skip
    for branch, last in zip(branches, folds, strict=True):
        assert [found.kind for found in branch.bifurcations] == ["fold"]
        assert branch.values.max() <= last
        assert branch.values[-1] == pytest.approx(7.9e-3, rel=1e-12)
        end = branch.values.argmax()
        assert branch.stable[:end].all()
        assert not branch.stable[end + 1 :].any()


@pytest.mark.long
def test_the_u_starts_to_wave_at_a_hopf_bifurcation(verified):
    """At 1.456e-4, second order in Δs; the frequency is that of the leading eigenvalue."""
    hopfs = [
        follow(u_swimmer(nodes, 1.7e-4), "bend", 1.4e-4, 1.7e-4, upwards=False).of_kind("Hopf")[0]
        for nodes in (65, 129)
    ]
    verified(
        "independent", "stiffness at which the U starts to wave, by continuation",
        measured=limit([hopf.value for hopf in hopfs]), expected=waving.hopf(),
        relative=1e-4, reference="Galerkin method in the material frame (tests/reference/waving.py)",
    )  # fmt: skip
    for hopf in hopfs:
        leading = hopf.shape.eigenvalues(1)[0]
        assert abs(leading.real) < 1e-5
        assert abs(leading.imag) == pytest.approx(hopf.frequency, rel=1e-6)


def twisted_u():
    """The twisted U of Fig 4.3a at a rotational drag of 1e-2, at a stiffness below its Hopf bifurcation."""
    parameters = {"bend": 3e-4, "twist": 1e-4, "moment": 6e-3, "rotational_drag": 1e-2}
    u = settled(Swimmer(65, parameters, planar=False, symmetric=True), {"kind": "writhe", "amplitude": 6.0}, time=8.0)
    return follow(u, "bend", 1.6e-4, 3e-4, upwards=False).shapes[-1]


def planar_u():
    return follow(u_swimmer(65, 1.5e-4), "bend", 1.35e-4, 1.5e-4, upwards=False).shapes[-1]


@pytest.mark.parametrize("unstable", [planar_u, twisted_u])
def test_a_simulation_grows_at_the_rate_of_the_eigenvalue(unstable, verified):
    """Beyond the Hopf point any small perturbation makes a₀ − a₀* oscillate at Im μ and grow at Re μ."""
    u = unstable()
    leading = u.eigenvalues(1)[0]
    assert leading.real > 0.3
    s = np.linspace(-0.5, 0.5, 65)
    perturbed = u.fields + 1e-6 * np.array([[0.0], [1.0], [0.0], [0.0]]) * np.cos(np.pi * s) ** 2
    rods = FixedShape(u.swimmer, perturbed).rods()
    rods.step(5e-4, 10_000)  # all other modes have decayed by then
    oscillation = []
    for _ in range(60):
        rods.step(5e-4, 100)
        oscillation.append(coefficients((rods.rates()["bending"][0] - u.bending).imag, s, 1)[0])
    # An oscillation x_j of one complex pair of eigenvalues obeys x_{j+1} = p x_j + q x_{j−1}.
    x = np.array(oscillation)
    p, q = np.linalg.lstsq(np.stack([x[1:-1], x[:-2]], axis=1), x[2:], rcond=None)[0]
    rate = np.log(np.roots([1.0, -p, -q])[0]) / 5e-2
    name = f"{'planar' if u.swimmer.planar else 'twisted'} U beyond its Hopf point, by time steps"
    verified(
        "independent", f"{name}: growth rate", measured=rate.real, expected=leading.real, relative=0.01,
        reference="Re μ of the Jacobian",
    )  # fmt: skip
    verified(
        "independent", f"{name}: angular frequency", measured=abs(rate.imag), expected=abs(leading.imag),
        relative=0.001, reference="Im μ of the Jacobian",
    )  # fmt: skip


def test_a_straight_rod_buckles_where_linear_theory_predicts(verified):
    """At branch points, with f = −tanh 10s held fixed; second order in Δs."""
    exact, found = stability.marginal_stiffnesses(2), []
    for nodes in (33, 65):
        f = -np.tanh(10 * np.linspace(-0.5, 0.5, nodes))
        swimmer = Swimmer(nodes, {"bend": 1.5e-2, "twist": 1e-3}, held=tuple(f))
        straight = at_rest(start(swimmer, np.zeros((nodes, 3)), f))
        branch = follow(straight, "bend", 3e-3, 1.5e-2, upwards=False)
        assert [b.kind for b in branch.bifurcations] == ["branch point"] * 2
        found.append([b.value for b in branch.bifurcations])
    errors = np.abs(np.array(found) - exact)
    verified.order(
        "stiffnesses at which a straight rod buckles, by continuation: order in Δs",
        measured=[slope([32, 64], errors[:, mode]) for mode in range(2)], reference="eigenvalues 0 of (4.37)",
    )  # fmt: skip


@pytest.mark.long
def test_a_rotating_shape_is_followed_to_its_mirror_image(verified):
    """From M through 0, where the shape is planar, to −M, where it rotates in the opposite sense."""
    s = np.linspace(-0.5, 0.5, 65)
    k = 3 * np.cos(np.pi * s) ** 2 * np.exp(2j * s) + np.sin(2 * np.pi * s)
    swimmer = Swimmer(65, ROTATING, planar=False)
    shape = settled(swimmer, np.stack([0 * s, k.real, k.imag], axis=-1), time=12.0)
    branch = follow(shape, "moment", -2e-3, 2e-3, upwards=False)
    assert branch.values[-1] == pytest.approx(-2e-3, rel=1e-9)
    first, last = branch.shapes[0], branch.shapes[-1]
    verified(
        "symmetry", "shape that rotates, followed from M to −M: spin and speed", measured=[-last.spin, last.speed],
        expected=[first.spin, first.speed], relative=1e-6, reference="its mirror image",
    )  # fmt: skip
    np.testing.assert_allclose(abs(last.bending), abs(first.bending), atol=1e-6)
    equations = Equations(swimmer)
    for point in branch.shapes[1:-1]:
        state = equations.state(point.fields)
        rates = equations.rates(state[None], point.swimmer.parameters)[0]
        np.testing.assert_allclose(rates, point.spin * (equations.rotation @ state), atol=1e-7)


@pytest.mark.parametrize(("parameter", "low", "high"), [("drag_ratio", 2.0, 2.5), ("diffusion", 1e-3, 2e-3)])
def test_continuation_in_any_parameter_agrees_with_a_simulation(parameter, low, high, verified):
    u = u_swimmer(33, 5e-3)
    last = follow(u, parameter, low, high).shapes[-1]
    there = settled(u.swimmer.with_parameters(**{parameter: high}), {"kind": "mode", "amplitude": 3.0}, time=6.0)
    verified.below(
        "independent", f"U followed in {parameter}: fields", measured=np.abs(last.fields - there.fields).max(),
        bound=1e-8, reference="settled there by time steps",
    )  # fmt: skip


def test_the_fixed_shape_does_not_depend_on_the_relaxation_time():
    branch = follow(u_swimmer(33, 5e-3), "relaxation", 1e-2, 2e-2)
    np.testing.assert_allclose(branch.shapes[-1].fields, branch.shapes[0].fields, atol=1e-8)
    assert abs(branch.eigenvalues[-1, 1] - branch.eigenvalues[0, 1]) > 0.1


def test_impossible_arguments_are_refused():
    u = u_swimmer(33, 5e-3)
    with pytest.raises(SceneError, match="must be one of bend"):
        follow(u, "stiffness", 1e-3, 1e-2)
    with pytest.raises(SceneError, match="start between"):
        follow(u, "bend", 1e-3, 2e-3)
