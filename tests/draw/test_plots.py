"""Figures in the house style: sizes, bytes, and the geometry of tubes."""

from pathlib import Path

import numpy as np
import pytest

from warp_rods.draw import plots, tubes
from warp_rods.membranes.mesh import triangulate
from warp_rods.membranes.surfaces import make

S = np.linspace(-0.5, 0.5, 33)
COIL = np.stack([S, 0.2 * np.cos(9 * S), 0.2 * np.sin(9 * S)], axis=-1)


def drawn(stem):
    with plots.style():
        figure = plots.figure(plots.COLUMN, 40.0)
        left, right = figure.subplots(1, 2)
        mapped = plots.tubes(left, [COIL], [S**2], radius=0.03)
        figure.colorbar(mapped, ax=left, label="energy per length")
        plots.tubes(right, [COIL], membrane=triangulate(make("sphere", {"radius": 0.4}), 12))
        plots.scale_bar(right, 0.5, "L/2")
        plots.panel_title(left, "a")
    return plots.save(figure, stem)


def test_a_figure_is_saved_twice_to_the_same_bytes(tmp_path):
    first, again = drawn(tmp_path / "fig4.3a"), drawn(tmp_path / "again" / "fig4.3a")
    assert [path.name for path in first] == ["fig4.3a.png", "fig4.3a.svg"]
    for one, other in zip(first, again, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_a_plot_that_cannot_be_written_leaves_the_one_before(tmp_path, monkeypatch):
    before = [path.read_bytes() for path in drawn(tmp_path / "figure")]

    def broken(self, target, **_options):
        if isinstance(target, (str, Path)):
            Path(target).write_bytes(b"half")
        raise OSError("no space left")

    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "savefig", broken)
    with pytest.raises(OSError, match="no space left"):
        drawn(tmp_path / "figure")
    assert [(tmp_path / name).read_bytes() for name in ("figure.png", "figure.svg")] == before
    assert len(list(tmp_path.iterdir())) == 2


def test_a_figure_has_the_size_that_was_asked_for(tmp_path):
    from matplotlib.image import imread

    png, _ = drawn(tmp_path / "sized")
    pixels = np.array([40.0, plots.COLUMN]) / 25.4 * plots.RESOLUTION
    np.testing.assert_allclose(imread(png).shape[:2], pixels, atol=1)


def test_a_tube_has_its_radius_everywhere_and_rounded_ends():
    rings, normals = tubes._tube(COIL, 0.03, np.eye(3))
    middle = rings[len(tubes.CAP) : -len(tubes.CAP)]
    np.testing.assert_allclose(np.linalg.norm(middle - COIL[:, None], axis=-1), 0.03, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, rtol=1e-12)
    for tip, end in ((rings[0], COIL[0]), (rings[-1], COIL[-1])):
        np.testing.assert_allclose(np.linalg.norm(tip - end, axis=-1), 0.03, rtol=1e-12)


@pytest.mark.parametrize("view", [(0.0, 0.0), (-60.0, 25.0), (30.0, 90.0)])
def test_the_camera_has_a_right_handed_frame(view):
    camera = tubes._camera(view)
    np.testing.assert_allclose(camera @ camera.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(camera) == pytest.approx(1.0)


def test_a_rod_in_front_hides_one_behind():
    """Two crossing rods seen from above: the upper one is drawn last, whichever was given first."""
    upper, lower = COIL * [1, 0, 0] + [0, 0, 0.5], COIL[:, [1, 0, 2]] * [0, 1, 0]
    for lines, values in (([upper, lower], [1.0, 0.0]), ([lower, upper], [0.0, 1.0])):
        axes = plots.figure().subplots()
        plots.tubes(axes, lines, values, view=(-90.0, 90.0), colour_map="gray")
        assert axes.collections[0].get_facecolors()[-1][:3].max() > 0.3


def test_panels_of_one_scale_hold_their_drawings_in_the_middle():
    panels = list(plots.figure(plots.COLUMN, 40.0).subplots(1, 2))
    plots.tubes(panels[0], [COIL])
    plots.tubes(panels[1], [2 * COIL + 5])
    before = [np.array([axes.get_xlim(), axes.get_ylim()]) for axes in panels]
    plots.one_scale(panels)
    after = [np.array([axes.get_xlim(), axes.get_ylim()]) for axes in panels]
    np.testing.assert_allclose(np.ptp(after[0], axis=1), np.ptp(after[1], axis=1))
    np.testing.assert_allclose(after[1], before[1])
    np.testing.assert_allclose(after[0].mean(axis=1), before[0].mean(axis=1))
