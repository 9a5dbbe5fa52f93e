"""Flagella at the start and their laws: held flagella are held, and the twist of a writhe balances any profile."""

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.errors import SceneError
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients
from warp_rods.scene.swimmers import SwimmersTable

S = np.linspace(-0.5, 0.5, 65)
HELD = {"name": "cells", "count": 1, "nodes": 65, "bend": 2e-3, "twist": 1e-3, "flagella": {"law": "held"}}


@pytest.mark.parametrize("profile", ["tanh", "piecewise", "uniform"])
def test_held_flagella_do_not_change_at_all(device, profile, verified):
    """Without naming D: its default would take f = −sign(s) to 0.17 at the ends by t = 2."""
    shape = {"kind": "mode", "amplitude": 3.0}
    rods = FreeRods(
        1, 65, bend=2e-3, twist=1e-3, shape=shape, flagella={"law": "held", "profile": profile}, device=device
    )
    start = rods.activity
    assert np.abs(start).max() > 0.999
    assert not rods.rates()["activity_rate"].any()
    rods.step(1e-3, 2000)
    verified.same(f"held flagella, {profile}, after 2000 steps", rods.activity, start, reference="the start")


def test_the_fixed_shape_of_held_flagella_is_that_of_the_run(verified):
    """From the table of a scene; with diffusion the rod would be straight."""
    cell = SwimmersTable(**HELD)
    swimmer = wr.steady.Swimmer.of(cell)
    np.testing.assert_array_equal(swimmer.held, -np.tanh(10 * S))
    u = wr.steady.settled(swimmer, {"kind": "mode", "amplitude": 3.0})
    assert np.abs(u.curvature).max() == pytest.approx(6.55, abs=0.005)  # a regression guard, as is the speed
    assert u.speed == pytest.approx(0.576, abs=5e-4)
    rods = FreeRods(1, 65, bend=2e-3, twist=1e-3, shape={"kind": "mode", "amplitude": 3.0}, flagella={"law": "held"})
    rods.step(1e-3, 11500)
    before = rods.position[0, 32]
    rods.step(1e-3, 500)
    run, theory = (coefficients(k, S, 3)[0] for k in (rods.strain[:, :, 2], u.curvature[None]))
    speed = np.linalg.norm(rods.position[0, 32] - before) / 0.5
    verified(
        "independent", "steady swimmer with held flagella: three beam coefficients and the speed, by time steps",
        measured=[*run, speed], expected=[*theory, u.speed], within=1e-6, reference="Newton's method (`wr.steady`)",
    )  # fmt: skip


PROFILES = {
    "sharpness 10": {"profile": "tanh"},
    "sharpness 20": {"profile": "tanh", "sharpness": 20.0},
    "piecewise": {"profile": "piecewise"},
    "a function": {"profile": lambda s: -np.sin(2 * np.pi * s)},
    "values": {"profile": -(S**3)},
}


@pytest.mark.parametrize("given", PROFILES.values(), ids=PROFILES)
def test_the_twist_of_a_straight_writhe_balances_the_moment_of_its_own_flagella(device, given, verified):
    """c τ' + M f = 0 at half nodes: to round-off, or to second order for the integral in closed form."""
    flagella, c, M = Flagella.read(given), 1e-3, 2e-3
    shape = {"kind": "writhe", "amplitude": 0.0}
    rods = FreeRods(1, 65, bend=1e-3, twist=c, moment=M, shape=shape, flagella=flagella, device=device)
    tau, f = rods.strain[0, :, 0], rods.activity[0]
    left = c * np.diff(tau) * 64 + M * (f[1:] + f[:-1]) / 2
    sharp = flagella.sharpness if isinstance(given["profile"], str) else 0.0
    name = next(name for name, row in PROFILES.items() if row is given)
    verified.below(
        "exact", f"twist of a straight writhe, {name}: |c τ' + M f|/M", measured=np.abs(left).max() / M,
        bound=1e-12 + (sharp / 64) ** 2 / 12, reference="0; second order in Δs for a twist in closed form",
    )  # fmt: skip
    assert tau[0] == tau[-1] == 0 and np.abs(tau).max() > 0.01


def test_a_moment_that_no_twist_balances_is_refused():
    shape = {"kind": "writhe", "amplitude": 1.0}
    with pytest.raises(SceneError, match=r"no twist balances the active moment of rod 1, as ∫ f ds = 1 "):
        FreeRods(2, 65, bend=1e-3, twist=1e-3, moment=[0, 1e-3], shape=shape, flagella={"profile": "uniform"})
    FreeRods(1, 65, bend=1e-3, twist=1e-3, shape=shape, flagella={"profile": "uniform"})
