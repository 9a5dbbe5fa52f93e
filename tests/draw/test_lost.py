"""Rods that a simulation really lost: they are drawn grey where they were frozen, and are in no file of data."""

import json

import numpy as np
import pytest
from examples.losses import DOOMED, SOUND, scene

from warp_rods.draw.colours import COLOURS
from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.scale import LACKING
from warp_rods.draw.selection import Selection
from warp_rods.simulation.runner import simulate

LOST, FRAMES = 1, 5
"""Rod 1 is lost between the first frame and the second."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lossy") / "run"
    simulate(scene(SOUND, DOOMED, SOUND), folder, device="cpu")
    return folder


@pytest.mark.parametrize("colour", [name for name, row in COLOURS.items() if row.kind != "angle" and name != "gauss"])
def test_no_colour_shows_or_counts_the_last_valid_state(run, colour):
    row, shown = COLOURS[colour], content(run, Selection(colour=colour, frames=slice(1, None)))
    (rods,) = shown.rods
    for frame in range(shown.frames):
        assert np.isfinite(rods.data["position"].values).all()  # as the program saves it
        assert np.isnan(rods.values(frame)[LOST]).all() and np.isfinite(rods.values(frame)[[0, 2]]).all()
        assert (shown.scale(frame).rgb(rods.values(frame))[LOST] == LACKING).all()
    if row.kind == "amount":
        (every,) = content(run, Selection(colour=colour)).rods  # of the run, before the rod was lost, too
        assert shown.scale(0).high <= np.nanmax([every.values(frame) for frame in range(FRAMES)])
    np.testing.assert_array_equal(rods.positions(3), rods.data["position"].values[4])


def test_tables_have_no_row_of_numbers_for_them(run, tmp_path):
    import pandas as pd

    table = pd.read_csv(EXPORTERS["csv"].export(run, tmp_path / "rods.csv"))
    missing = table[["x", "y", "z", "energy_density"]].isna().all(axis=1)
    np.testing.assert_array_equal(missing, (table.rod == LOST) & (table.frame > 0))
    records = json.loads(EXPORTERS["wcon"].export(run, tmp_path / "rods.wcon").read_text())["data"]
    lost = [set(record["x"][0]) == {None} for record in records if record["id"] == f"cells {LOST}"]
    assert lost == [False, True, True, True, True] and len(records) == 3 * FRAMES


def test_beads_stay_where_they_were_and_have_no_value(run, tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd", reason="gsd is not installed: pip install 'warp-rods[files]'")
    with hoomd.open(str(EXPORTERS["gsd"].export(run, tmp_path / "rods.gsd")), "r") as frames:
        for number, frame in enumerate(frames):
            saved = content(run).rods[0].data["position"].values[number].reshape(-1, 3)
            np.testing.assert_allclose(frame.particles.position, saved, atol=1e-6)
            known = np.isfinite(frame.log["particles/energy_density"]).reshape(3, 17).all(axis=1)
            assert known.tolist() == [True, number == 0, True]


def test_the_microscope_does_not_see_them(run, tmp_path):
    pytest.importorskip("tifffile", reason="tifffile is not installed: pip install 'warp-rods[images]'")
    from PIL import Image

    folder = EXPORTERS["microscope"].export(run, tmp_path / "images")
    for number in range(FRAMES):
        with Image.open(folder / "masks.ome.tif") as masks:
            masks.seek(number)
            assert np.unique(np.asarray(masks)).tolist() == ([0, 1, 2, 3] if number == 0 else [0, 1, 3])
