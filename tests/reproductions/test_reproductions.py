"""Every reproduction in its quick form, all in one call as in CI, against the numbers of ``reproduced.csv``."""

import csv
from pathlib import Path

import pytest
from rich.console import Console

from warp_rods.reproductions import reproduce
from warp_rods.reproductions.catalogue import REPRODUCTIONS

with (Path(__file__).parent / "reproduced.csv").open(encoding="utf-8") as file:
    KNOWN = list(csv.DictReader(file))
"""name, quantity, value, tolerance (absolute; empty for text), and the reason for that tolerance."""


pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduced")
    return {outcome.name: outcome for outcome in reproduce.run(["all"], True, folder, Console(quiet=True))}


@pytest.mark.parametrize("name", REPRODUCTIONS)
def test_each_writes_a_figure_and_data(outcomes, name):
    assert not outcomes[name].error
    assert all(path.exists() for path in outcomes[name].files)


@pytest.mark.parametrize("known", KNOWN, ids=lambda known: f"{known['name']}: {known['quantity']}")
def test_numbers_agree_with_the_stored_ones(outcomes, known):
    found = {row.quantity: row.ours for row in outcomes[known["name"]].rows}
    ours = found[known["quantity"]]
    if not known["tolerance"]:
        assert ours == known["value"]
    else:
        assert ours == pytest.approx(float(known["value"]), abs=float(known["tolerance"]), rel=0)


def test_every_reproduction_has_a_stored_number():
    assert {known["name"] for known in KNOWN} == set(REPRODUCTIONS)
