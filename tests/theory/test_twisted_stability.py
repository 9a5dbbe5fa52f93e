"""Growth rates of a straight, twisted swimmer, against the planar spectrum (M = 0) and simulations (M > 0)."""

import numpy as np
import pytest

from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.theory import stability
from warp_rods.theory.steady import Swimmer, at_rest, start
from warp_rods.theory.twisted_stability import growth_rates


def test_without_a_moment_each_planar_rate_is_double(verified):
    exact = stability.eigenvalues(2e-3, "tanh", count=2).real
    coarse, fine = (growth_rates(bend=2e-3, twist=1e-3, nodes=n, count=4) for n in (65, 129))
    np.testing.assert_allclose(fine[::2], fine[1::2], rtol=1e-6)
    errors = [np.abs(found[::2].real - exact).max() for found in (coarse, fine)]
    verified.order(
        "twisted rod at M = 0: order in Δs of its rates", measured=np.log2(errors[0] / errors[1]),
        reference="eigenvalues of (4.37) by finite elements, each double",
    )  # fmt: skip


def test_the_twist_follows_the_sharpness_of_the_profile(verified):
    """At sharpness 20, not half the twist of sharpness 10: the rates are those of a Jacobian about the twist that
    balances that profile. Second order in Δs."""
    given = {"bend": 1e-3, "twist": 1e-3, "moment": 1e-2}
    rates = [growth_rates(**given, sharpness=20.0, nodes=n)[0].real for n in (65, 129, 257)]
    s = np.linspace(-0.5, 0.5, 65)
    f, twist = -np.tanh(20 * s), 10 * (np.log(np.cosh(20 * s)) - np.log(np.cosh(10.0))) / 20
    shape = start(Swimmer(65, given, planar=False, held=tuple(f)), np.stack([twist, 0 * s, 0 * s], axis=-1), f)
    verified(
        "independent", "twisted rod, sharpness 20: fastest rate", measured=rates[0],
        expected=at_rest(shape).eigenvalues(1)[0].real, relative=2e-3, reference="Jacobian about the balanced twist",
    )  # fmt: skip
    verified.order(
        "twisted rod, sharpness 20: order in Δs of the fastest rate",
        measured=np.log2((rates[0] - rates[1]) / (rates[1] - rates[2])), reference="N = 64, 128, 256",
    )  # fmt: skip


@pytest.mark.parametrize("moment", [1e-2, 2e-2])
def test_with_a_moment_rods_grow_at_the_fastest_rate(moment, verified):
    """From noise, while the fastest mode dominates and is still small: within 1 % at N = 128."""
    settings = {"bend": 2e-3, "twist": 1e-3, "moment": moment, "nodes": 129}
    fastest = growth_rates(**settings)[0]
    nodes, s = settings.pop("nodes"), np.linspace(-0.5, 0.5, 129)
    noise = 1e-13 * np.cos(np.pi * s) ** 4 * np.stack([np.cos(3 * s + 1), np.sin(5 * s)])
    twist = moment / 1e-3 * (np.log(np.cosh(10 * s)) - np.log(np.cosh(5.0))) / 10
    rods = FreeRods(
        1, nodes, **settings, flagella=Flagella(law="held", diffusion=0.0), shape=np.stack([twist, *noise], axis=-1)
    )
    rods.step(2e-4, 5000)
    sizes = []
    for _ in range(2):
        rods.step(2e-4, 5000)
        sizes.append(np.linalg.norm(rods.strain[0, :, 1:]))
    assert sizes[-1] < 1e-2
    verified(
        "independent", f"twisted rod, M = {moment:g}: growth from noise by time steps",
        measured=np.log(sizes[1] / sizes[0]), expected=fastest.real, relative=0.01,
        reference="fastest rate of linear theory",
    )  # fmt: skip
