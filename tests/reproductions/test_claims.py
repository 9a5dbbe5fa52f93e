"""The statistics of the reproductions on ensembles with known answers, and simulations for reproductions."""

import numpy as np
import pytest
import xarray as xr

from warp_rods.errors import RodFailure
from warp_rods.reproductions.integrate import integrate
from warp_rods.reproductions.sensor_statistics import (
    curvature_spread,
    final_dissipation,
    median_settling_time,
    settling_order,
    share_at_preferred_curvature,
)
from warp_rods.rods.free.rods import FreeRods


def ensemble(settled, gauss, dissipation=1.0) -> xr.Dataset:
    """Two frames of rods of two seeds: zero at the start, these values at the end."""
    rods = len(settled)
    late = {"gauss": gauss, "dissipation": np.broadcast_to(dissipation, rods)}
    frames = {name: (("frame", "rod"), np.stack([np.zeros(rods), values])) for name, values in late.items()}
    seed = np.arange(rods) % 2
    return xr.Dataset({**frames, "settling_time": ("rod", settled)}, {"seed": ("rod", seed)})


RNG = np.random.default_rng(0)
QUICK, SLOW = RNG.uniform(0.0, 1.0, 40), RNG.uniform(2.0, 3.0, 40)


def test_earlier_settling_is_found():
    narrow, wide = ensemble(QUICK, np.full(40, 1.0)), ensemble(SLOW, np.full(40, 1.0))
    assert median_settling_time(0.5, narrow).ours == pytest.approx(np.median(QUICK))
    chance = settling_order(0.5, narrow, wide)
    assert chance.ours == 1.0 and chance.statement_holds
    assert "2 of 2 seeds" in chance.reading


def test_rods_that_never_settle_count_as_last():
    chance = settling_order(0.5, ensemble(np.full(40, np.inf), QUICK), ensemble(SLOW, QUICK))
    assert chance.ours == 0.0 and not chance.statement_holds


def test_equal_ensembles_show_no_difference():
    one, other = ensemble(SLOW, QUICK, QUICK), ensemble(SLOW[::-1], QUICK[::-1], QUICK[::-1])
    assert settling_order(0.5, one, other).ours == pytest.approx(0.5)
    for row in (settling_order(0.5, one, other), curvature_spread(0.5, one, other), final_dissipation(0.5, one, other)):
        assert not row.statement_holds


@pytest.mark.parametrize(("sign", "holds"), [(1.0, True), (-1.0, False)])
def test_the_share_at_a_sign_is_compared_with_its_area(sign, holds):
    row = share_at_preferred_curvature(0.0, ensemble(SLOW, np.full(40, 2.0)), sign, 0.6)
    assert row.ours == (1.0 if sign > 0 else 0.0) and row.statement_holds is holds


def test_a_smaller_spread_and_a_lower_dissipation_are_found():
    narrow, wide = ensemble(SLOW, 1 + 0.1 * QUICK, 1e-3 * QUICK), ensemble(SLOW, 1 + QUICK, QUICK)
    assert curvature_spread(0.5, narrow, wide).ours == pytest.approx(0.1)
    assert curvature_spread(0.5, narrow, wide).statement_holds
    assert final_dissipation(0.5, narrow, wide).ours == pytest.approx(1e-3)
    assert final_dissipation(0.5, narrow, wide).statement_holds


def test_integration_gives_the_frames_asked_for_and_names_failed_rods():
    rods = FreeRods(2, 33, bend=[5e-3, 4e-3], twist=1e-3, device="cpu")
    found = integrate(rods, [0.0, 0.01, 0.025], ("strain", "energy", "status"))
    assert found["time"].to_numpy().tolist() == [0.0, 0.01, 0.025] and rods.time == 0.025
    assert found["strain"].shape == (3, 2, 33, 3) and found["bending_stiffness"].to_numpy().tolist() == [5e-3, 4e-3]
    failing = FreeRods(1, 33, bend=5e-3, twist=1e-3, shape={"kind": "mode", "amplitude": 300.0}, device="cpu")
    with pytest.raises(RodFailure, match=r"rod 0 bent by .*'bend': 0.005"):
        integrate(failing, [0.0, 0.01])
