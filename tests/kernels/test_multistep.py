"""Formulas on levels at any times: exact for polynomials; Magnus steps of fourth order."""

import numpy as np
import pytest
import warp as wp
from scipy.integrate import solve_ivp

from warp_rods.kernels.layout import Scalars1D, Scalars2D, Vectors2D, real
from warp_rods.kernels.lie import se3_compose, se3_exp
from warp_rods.kernels.magnus import RATES, mean_over, twist_over
from warp_rods.kernels.multistep import LEVELS, Levels, formula_of, local_error_scale, weights_at

wp.set_module_options({"enable_backward": False})

TIMES = (1.0, 0.8, 0.5, 0.45, 0.1)
END = 1.3


@wp.kernel
def formulas(at: Levels, order: int, t: real, result: Scalars1D):
    formula = formula_of(at, order, t)
    w = weights_at(at, order + 1, t)
    for j in range(LEVELS):
        result[j] = formula.value[j]
        result[LEVELS + j] = formula.slope[j]
        result[2 * LEVELS + j] = w[j]
    result[3 * LEVELS] = formula.rate
    result[3 * LEVELS + 1] = local_error_scale(at, order, t)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_formula_is_exact_for_polynomials_of_its_order(device, order, verified):
    result = wp.zeros(3 * LEVELS + 2, dtype=wp.float64, device=device)
    wp.launch(formulas, dim=1, inputs=[Levels(*TIMES), order, END, result], device=device)
    value, slope, higher = result.numpy()[: 3 * LEVELS].reshape(3, LEVELS)
    rate, scale = result.numpy()[3 * LEVELS :]
    at, errors = np.array(TIMES), []
    for degree in range(order + 1):
        x = at**degree
        derivative = degree * END ** max(degree - 1, 0)
        errors.append(abs(rate * (END**degree - value @ x) + slope @ x - derivative) / max(derivative, 1))
        assert higher @ x == pytest.approx(END**degree, rel=1e-11)
        if degree < order:
            assert value @ x == pytest.approx(END**degree, rel=1e-11)
    verified.below(
        "exact", f"backward formula of order {order} at uneven times: slopes of monomials up to it", measured=errors,
        bound=1e-11, reference="exact derivatives",
    )  # fmt: skip
    # The first monomial that the formula misses: the x that solves "formula = exact slope" differs from the exact one.
    x, exact = at ** (order + 1), END ** (order + 1)
    found = value @ x + ((order + 1) * END**order - slope @ x) / rate
    assert found - exact == pytest.approx(scale * (exact - higher @ x), rel=1e-9)


@wp.kernel
def carry(omega: Vectors2D, u: Vectors2D, roll: Scalars2D, at: Levels, R: wp.array(dtype=wp.mat33d), r: Scalars1D):
    theta, mu = twist_over(omega, u, 0, at, RATES, at[1], at[0])
    D, d = se3_exp(theta, mu)
    Q, q = se3_compose(R[0], wp.vec3d(r[0], r[1], r[2]), D, d)
    R[0] = Q
    for i in range(3):
        r[i] = q[i]
    r[3] = r[3] + (at[0] - at[1]) * mean_over(roll, 0, at, RATES, at[1], at[0])


def rates(t):
    """(ω, u) that do not commute at different times."""
    omega = np.array([1.0 + np.sin(2 * t), np.cos(3 * t), t])
    return omega, np.array([np.cos(t), 0.3 * t * t, np.sin(4 * t)])


def test_frames_are_carried_with_fourth_order(device, verified):
    def motion(t, y):
        omega, u = rates(t)
        R = y[:9].reshape(3, 3)
        hat = np.array([[0, -omega[2], omega[1]], [omega[2], 0, -omega[0]], [-omega[1], omega[0], 0]])
        return np.concatenate([(R @ hat).ravel(), R @ u, omega[:1]])

    exact = solve_ivp(motion, (0, 1), np.r_[np.eye(3).ravel(), np.zeros(4)], rtol=1e-12, atol=1e-12).y[:, -1]
    counts, errors = np.array([10, 20, 40, 80]), []
    for count in counts:
        R = wp.array([np.eye(3)], dtype=wp.mat33d, device=device)
        r = wp.zeros(4, dtype=wp.float64, device=device)
        h = 1 / count
        for n in range(count):
            at = [(n + 1 - j) * h for j in range(LEVELS)]
            omega, u = (np.array([[rates(t)[k] for t in at[:RATES]]]) for k in (0, 1))
            arrays = [wp.array(x, dtype=wp.vec3d, device=device) for x in (omega, u)]
            roll = wp.array(np.ascontiguousarray(omega[..., 0]), dtype=wp.float64, device=device)
            wp.launch(carry, dim=1, inputs=[*arrays, roll, Levels(*at), R, r], device=device)
        errors.append(abs(np.r_[R.numpy().ravel(), r.numpy()] - exact).max())
    verified.order(
        "Magnus steps of a frame", measured=-np.polyfit(np.log(counts), np.log(errors), 1)[0], expected=4, within=0.3,
        reference="SciPy's `solve_ivp`, rtol = 1e-12",
    )  # fmt: skip
