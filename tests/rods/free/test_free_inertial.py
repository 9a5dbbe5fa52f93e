"""Free rods against their equations in an inertial frame (appendix C.3): tension, velocities, twist, powers."""

import numpy as np
import pytest
from examples.free import MOMENT, SMOOTH, TWIST, slope, start_in_space
from reference import free, inertial

from warp_rods import frames
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode

SIZES = [65, 129, 257]


def planar(s):
    return 3j * beam_mode(0, s), 0 * s, -np.sin(np.pi * s)


def symmetric(s):
    """Ω0 and Ω2 even, Ω1 and f odd (C.49)."""
    return 3j * beam_mode(0, s) * np.exp(2j * np.pi * s), start_in_space(s)[1], -np.sin(np.pi * s)


CASES = {"planar": (planar, 0.0), "symmetric in space": (symmetric, MOMENT), "in space": (start_in_space, MOMENT)}
"""k, τ, f of a start, and M."""


def strain(start, s):
    bending, twist, _ = start(s)
    return np.stack([twist, bending.real, bending.imag], axis=-1)


@pytest.fixture(scope="module", params=CASES)
def case(request):
    """Name, start, parameters and the motion in an inertial frame."""
    start, moment = CASES[request.param]
    p = free.Parameters(bend=1e-3, twist=TWIST, moment=moment)
    s, _ = inertial.chebyshev_points()
    T = inertial.tangents(lambda x: strain(start, np.array([x]))[0], s)
    _, twist, f = start(s)
    return request.param, start, p, inertial.evaluate(p, T, twist, f)


def test_the_printed_tension_keeps_the_length(case, verified):
    """(C.19) as printed: with its λ the velocities (C.15) obey r′·ṙ′ = 0 (C.13)."""
    name, _, _, motion = case
    size = abs(motion.velocity).max()
    verified.below(
        "constraint", f"appendix C.3, {name}: r′·ṙ′ over |ṙ|", measured=abs(motion.stretching).max() / size, bound=1e-6,
        reference="0",
    )  # fmt: skip


def test_rates_agree_with_the_inertial_frame(case, verified):
    """λ, ṙ, ω0 and ∂tΩ0 of the staggered scheme in the Bishop frame."""
    name, start, p, motion = case
    errors = []
    for nodes in SIZES:
        s, h = np.linspace(-0.5, 0.5, nodes), 1 / (nodes - 1)
        bishop, _ = frames.bishop_strain(strain(start, s), h, start=nodes // 2)
        _, twist, f = start(s)
        shape = free.Shape((bishop[:, 1] + 1j * bishop[:, 2])[None], twist[None], f[None])
        rates = free.evaluate(shape, p, h)
        R, _ = frames.path_product(bishop, h, rule="magnus", start=nodes // 2)
        body = np.stack([free.even_mean(rates.axial)[0], rates.transverse[0].real, rates.transverse[0].imag], axis=-1)
        velocity = np.einsum("nij,nj->ni", R, body)[1:-1]
        half = (s[1:] + s[:-1]) / 2
        apart = [
            rates.tension[0] - motion.at(s, motion.tension),
            velocity - motion.at(s, motion.velocity)[1:-1],
            rates.roll[0] - motion.at(half, motion.roll),
            (rates.twist[0] - motion.at(s, motion.twist_rate))[1:-1],
        ]
        errors.append([np.sqrt(np.mean(difference**2)) for difference in apart])
    exact = np.array(errors)[-1] < 1e-9  # of a planar rod, ω0 and ∂tΩ0 vanish
    assert (exact == ([False, False, True, True] if name == "planar" else False)).all()
    verified.order(
        f"free rods against appendix C.3, {name}: λ, ṙ, ω0, ∂tΩ0: order in Δs",
        measured=[slope(SIZES, column) for column in np.array(errors).T[~exact]],
        reference="Chebyshev points in an inertial frame",
    )  # fmt: skip


def test_an_ensemble_agrees_with_the_inertial_frame(case, device, verified):
    """Tension, dissipation and power of rods on the device at the start."""
    name, start, p, motion = case
    weights = np.linalg.solve(inertial.chebyshev.chebvander(2 * motion.s, inertial.POINTS).T, moments())
    _, _, f = start(motion.s)
    s, _ = inertial.chebyshev_points()
    T = inertial.tangents(lambda x: strain(start, np.array([x]))[0], s)
    along = inertial.dot(T, motion.velocity)
    lost = along**2 + p.drag_ratio * (inertial.dot(motion.velocity, motion.velocity) - along**2)
    dissipation = weights @ (lost + p.rotational_drag * motion.roll**2)
    power = weights @ (f * along + p.moment * f * motion.roll)
    errors = []
    for nodes in SIZES:
        s = np.linspace(-0.5, 0.5, nodes)
        rods = FreeRods(
            1, nodes, bend=p.bend, twist=p.twist, moment=p.moment, shape=strain(start, s), flagella=SMOOTH,
            symmetric=name == "symmetric in space", device=device,
        )  # fmt: skip
        found = [rods.tension[0] - motion.at(s, motion.tension), rods.dissipation - dissipation, rods.power - power]
        errors.append([abs(np.asarray(e)).max() for e in found])
    verified.order(
        f"FreeRods against appendix C.3, {name}: λ, dissipation, power: order in Δs",
        measured=[slope(SIZES, column) for column in np.array(errors).T],
        reference="Chebyshev points in an inertial frame",
    )  # fmt: skip


def moments() -> np.ndarray:
    """∫ T_k(2s) ds over the rod."""
    k = np.arange(inertial.POINTS + 1)
    return np.where(k % 2 == 0, 1 / (1.0 - np.where(k % 2 == 0, k, 0) ** 2), 0.0)


def test_identities_of_torsion():
    """(C.20) and (C.21) of the material strain against the centre line."""
    s, D = inertial.chebyshev_points()
    start = symmetric
    Omega = strain(start, s)
    r1 = inertial.tangents(lambda x: strain(start, np.array([x]))[0], s)
    r2, r3, r4 = D @ r1, D @ D @ r1, D @ D @ D @ r1
    turning = inertial.dot(r1, np.cross(r2, r3))
    across = Omega * [0, 1, 1]
    change = np.cross(across, D @ across)[:, 0]
    k2 = inertial.dot(r2, r2)
    for found, expected in (
        (turning, k2 * Omega[:, 0] + change),
        (
            inertial.dot(r2, r4) + k2**2,
            inertial.dot(across, D @ D @ across) - k2 * Omega[:, 0] ** 2 - 2 * Omega[:, 0] * change,
        ),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-9 * abs(expected).max())
