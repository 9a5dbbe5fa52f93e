"""The statistics behind the reproduced claims, on made-up ensembles whose answer is known; and films of rods."""

import numpy as np
import pytest
import xarray as xr

from warp_rods.errors import RodFailure
from warp_rods.reproductions.film import film
from warp_rods.reproductions.sensor_tests import (
    comes_to_rest,
    median_settling,
    more_robust,
    settle_sooner,
    sits_at_the_sign,
)
from warp_rods.rods.free.rods import FreeRods


def ensemble(settled, gauss, dissipation=1.0) -> xr.Dataset:
    """Two frames of rods of two seeds: nothing at the start, these values at the end."""
    rods = len(settled)
    late = {"gauss": gauss, "dissipation": np.broadcast_to(dissipation, rods)}
    frames = {name: (("frame", "rod"), np.stack([np.zeros(rods), values])) for name, values in late.items()}
    seed = np.arange(rods) % 2
    return xr.Dataset({**frames, "settling_time": ("rod", settled)}, {"seed": ("rod", seed)})


RNG = np.random.default_rng(0)
QUICK, SLOW = RNG.uniform(0.0, 1.0, 40), RNG.uniform(2.0, 3.0, 40)


def test_all_who_settle_sooner_are_found():
    narrow, wide = ensemble(QUICK, np.full(40, 1.0)), ensemble(SLOW, np.full(40, 1.0))
    assert median_settling(0.5, narrow).ours == pytest.approx(np.median(QUICK))
    chance = settle_sooner(0.5, narrow, wide)
    assert chance.ours == 1.0 and chance.holds
    assert "2 of 2 seeds" in chance.reading


def test_those_who_never_settle_count_as_last():
    chance = settle_sooner(0.5, ensemble(np.full(40, np.inf), QUICK), ensemble(SLOW, QUICK))
    assert chance.ours == 0.0 and not chance.holds


def test_like_ensembles_show_no_difference():
    one, other = ensemble(SLOW, QUICK, QUICK), ensemble(SLOW[::-1], QUICK[::-1], QUICK[::-1])
    assert settle_sooner(0.5, one, other).ours == pytest.approx(0.5)
    for claim in (settle_sooner(0.5, one, other), more_robust(0.5, one, other), comes_to_rest(0.5, one, other)):
        assert not claim.holds


@pytest.mark.parametrize(("sign", "holds"), [(1.0, True), (-1.0, False)])
def test_those_who_sit_at_a_sign_are_set_against_its_area(sign, holds):
    row = sits_at_the_sign(0.0, ensemble(SLOW, np.full(40, 2.0)), sign, 0.6)
    assert row.ours == (1.0 if sign > 0 else 0.0) and row.holds is holds


def test_a_smaller_spread_and_less_dissipation_are_found():
    narrow, wide = ensemble(SLOW, 1 + 0.1 * QUICK, 1e-3 * QUICK), ensemble(SLOW, 1 + QUICK, QUICK)
    assert more_robust(0.5, narrow, wide).ours == pytest.approx(0.1)
    assert more_robust(0.5, narrow, wide).holds
    assert comes_to_rest(0.5, narrow, wide).ours == pytest.approx(1e-3)
    assert comes_to_rest(0.5, narrow, wide).holds


def test_a_film_has_its_frames_and_names_what_is_lost():
    rods = FreeRods(2, 33, bend=[5e-3, 4e-3], twist=1e-3, device="cpu")
    seen = film(rods, [0.0, 0.01, 0.025], 1e-3, ("strain", "energy", "status"))
    assert seen["time"].to_numpy().tolist() == [0.0, 0.01, 0.025] and rods.time == pytest.approx(0.025)
    assert seen["strain"].shape == (3, 2, 33, 3) and seen["bending_stiffness"].to_numpy().tolist() == [5e-3, 4e-3]
    lost = FreeRods(1, 33, bend=5e-3, twist=1e-3, shape={"kind": "mode", "amplitude": 300.0}, device="cpu")
    with pytest.raises(RodFailure, match=r"rod 0 bent by .*'bend': 0.005"):
        film(lost, [0.0, 0.01], 1e-3)
