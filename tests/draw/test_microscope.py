"""Images as of a fluorescence microscope: what was put in is recovered from them."""

import dataclasses
import tracemalloc

import numpy as np
import pytest
from examples.drawn import FRAMES, write_run
from scipy.special import ndtr

from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.microscope import light
from warp_rods.draw.microscope.camera import MOST, counts
from warp_rods.draw.microscope.light import Field, Sources, expected, sources
from warp_rods.draw.microscope.masks import masks
from warp_rods.draw.microscope.settings import Complete, microscope, widths
from warp_rods.draw.selection import Selection
from warp_rods.errors import SceneError

PLANE = Field(left=-1.0, top=1.0, pixel=0.02, rows=100, columns=100, heights=np.zeros(1))
SETTINGS = Complete(width=0.03, depth=0.1, pixel=0.02, spacing=0.1, focus=0.0, photons=1e4)


def straight(length: float, angle: float, place=(0.0, 0.0, 0.0)) -> np.ndarray:
    """A straight rod [1, node, 3] in a plane."""
    along = np.linspace(-0.5, 0.5, 33)[:, None] * length
    return (np.array(place) + along * [np.cos(angle), np.sin(angle), 0.0])[None]


def bead(place) -> Sources:
    return Sources(np.array([place]), np.array([1e5]), np.zeros(1, int))


def moments(image: np.ndarray, field: Field) -> tuple[float, np.ndarray, np.ndarray]:
    """Sum of an image, its mean place and its variances along x and y."""
    x = field.left + field.pixel * (np.arange(field.columns) + 0.5)
    y = field.top - field.pixel * (np.arange(field.rows) + 0.5)
    weights, total = (image.sum(axis=0), image.sum(axis=1)), image.sum()
    mean = np.array([(w * at).sum() / total for w, at in zip(weights, (x, y), strict=True)])
    variance = [(w * (at - m) ** 2).sum() / total for w, at, m in zip(weights, (x, y), mean, strict=True)]
    return total, mean, np.array(variance)


@pytest.mark.parametrize("width", [0.02, 0.03, 0.05])
def test_a_bead_has_the_width_of_the_point_spread_function(width):
    """Pixels integrate it: a Gaussian of variance σ² has σ² + p²/12 on pixels of edge p."""
    image = expected(bead([0.113, -0.271, 0.0]), PLANE, width, 0.1)[0]
    total, mean, variance = moments(image, PLANE)
    assert total == pytest.approx(1e5, rel=2e-6)
    assert mean == pytest.approx([0.113, -0.271], abs=1e-5)
    assert np.sqrt(variance - PLANE.pixel**2 / 12) == pytest.approx(width, rel=1e-3)
    row, column = np.unravel_index(image.argmax(), image.shape)
    assert (row, column) == (63, 55)  # y = 1 − 0.02 (row + ½): rows go down, so that y points up on a screen


def test_a_bead_has_its_depth_in_a_stack():
    field = dataclasses.replace(PLANE, heights=np.linspace(-0.5, 0.5, 41))
    stack = expected(bead([0.0, 0.0, 0.05]), field, 0.03, 0.1)
    along = stack.sum(axis=(1, 2)) / 1e5
    assert along.max() == pytest.approx(1.0, rel=2e-6)  # all photons at its own height
    mean = (along * field.heights).sum() / along.sum()
    assert mean == pytest.approx(0.05, abs=1e-4)
    assert np.sqrt((along * (field.heights - mean) ** 2).sum() / along.sum()) == pytest.approx(0.1, rel=1e-3)


def test_widths_are_those_of_the_peak_of_the_diffraction_pattern():
    """The Airy pattern and the axial sinc² have, at a tenth of a width, the values of the Gaussian to 1e-5."""
    from scipy.special import j1

    lateral, axial = widths(0.52, 1.2, 1.333)
    assert lateral == pytest.approx(0.225 * 0.52 / 1.2, rel=1e-3)
    v = 2 * np.pi * 1.2 * (lateral / 10) / 0.52
    u = 2 * np.pi * 1.2**2 * (axial / 10) / (1.333 * 0.52)
    gaussian = np.exp(-0.5 * 0.1**2)
    assert (2 * j1(v) / v) ** 2 == pytest.approx(gaussian, abs=1e-5)
    assert np.sinc(u / 4 / np.pi) ** 2 == pytest.approx(gaussian, abs=1e-5)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_length_of_a_rod_is_recovered_from_its_image(angle):
    """By its light, and by its outline: a line has half of its brightness at both ends."""
    photons = expected(sources(straight(1.0, angle), 1e4, 0.01), PLANE, 0.03, 0.1)
    taken = counts(photons, SETTINGS, (0, 0))[0].astype(float)
    seen = (taken - SETTINGS.offset) / SETTINGS.gain - SETTINGS.background
    assert seen.sum() / 1e4 == pytest.approx(1.0, abs=0.05)  # the noise of 10⁴ pixels is 0.04
    rows, columns = np.indices(seen.shape)
    x, y = -0.99 + 0.02 * columns, 0.99 - 0.02 * rows
    along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    near = np.abs(across) < 0.1
    edges = np.arange(-0.8, 0.8001, 0.02)
    profile = np.histogram(along[near], edges, weights=seen[near])[0]
    profile /= np.histogram(along[near], edges)[0]
    half = np.median(profile[20:60]) / 2
    middle = edges[:-1] + 0.01
    left, right = np.interp(half, profile[:30], middle[:30]), np.interp(-half, -profile[50:], middle[50:])
    assert right - left == pytest.approx(1.0, abs=0.02)  # a pixel


def test_the_variance_of_counts_is_that_of_photons_times_the_gain():
    """The photon transfer curve of a flat field: its slope is the gain, and the read noise is what darkness leaves."""
    light, flat = np.array([0.0, 20.0, 100.0, 400.0]), (400, 400)
    dark = SETTINGS.model_copy(update={"background": 0.0, "gain": 3.0, "read_noise": 2.0})
    taken = [counts(np.full(flat, level), dark, (number,)).astype(float) for number, level in enumerate(light)]
    mean, variance = np.array([t.mean() for t in taken]), np.array([t.var() for t in taken])
    assert mean == pytest.approx(dark.offset + 3.0 * light, rel=2e-3)
    assert variance == pytest.approx(9.0 * (light + 4.0) + 1 / 12, rel=0.02)  # sampling: √(2/160000) = 0.35 %
    assert np.polyfit(mean, variance, 1)[0] == pytest.approx(3.0, rel=0.02)


def test_noise_follows_seed_and_frame():
    photons = np.full((4, 50, 50), 30.0)
    first = counts(photons, SETTINGS, (7, 0))
    assert np.array_equal(first, counts(photons, SETTINGS, (7, 0)))
    others = [(SETTINGS, (8, 0)), (SETTINGS, (7, 1)), (SETTINGS.model_copy(update={"seed": 1}), (7, 0))]
    for settings, stream in others:
        assert not np.array_equal(first, counts(photons, settings, stream))
    assert counts(np.full((2, 2), 1e6), SETTINGS, (0,)).tolist() == [[MOST, MOST], [MOST, MOST]]


def test_masks_are_the_pixels_of_each_rod():
    lines = np.concatenate([straight(1.0, 0.5, (0.0, 0.3, 0.0)), straight(1.0, 0.5, (0.0, -0.3, 0.4))])
    labels = masks(lines, 0.05, PLANE)[0]
    assert np.unique(labels).tolist() == [0, 1, 2]
    for number, y in ((1, 0.3), (2, -0.3)):
        rows, columns = np.nonzero(labels == number)
        x, height = -0.99 + 0.02 * columns, 0.99 - 0.02 * rows - y
        along, across = x * np.cos(0.5) + height * np.sin(0.5), height * np.cos(0.5) - x * np.sin(0.5)
        assert np.abs(across).max() <= 0.05 and along.max() == pytest.approx(0.55, abs=0.02)
        assert along.min() == pytest.approx(-0.55, abs=0.02)
        area = 1.0 * 0.1 + np.pi * 0.05**2  # of a strip with round ends
        assert (labels == number).sum() * 0.02**2 == pytest.approx(area, rel=0.05)
    stack = masks(lines, 0.05, dataclasses.replace(PLANE, heights=np.array([0.0, 0.2, 0.4])))
    assert [np.unique(plane).tolist() for plane in stack] == [[0, 1], [0], [0, 2]]
    crossed = masks(np.concatenate([straight(1.0, 0.0), straight(1.0, 0.0, (0.0, 0.03, 0.0))]), 0.05, PLANE)[0]
    assert crossed[PLANE.rows // 2 + 1, 50] == 1 and crossed[PLANE.rows // 2 - 2, 50] == 2  # the nearer one


@pytest.mark.parametrize("width", [0.06, 0.4])  # in pixels 3 and 20: sources together, and one by one
def test_many_sources_take_bounded_memory_and_give_the_sum_of_each(width, monkeypatch):
    """A stack of a source a pixel, as before in one part; also at and beyond the edges of the field."""
    rng = np.random.default_rng(2)
    lights = Sources(rng.uniform(-1.3, 1.3, (3000, 3)) * [1, 1, 0.05], rng.uniform(1, 2, 3000), np.arange(3000))
    lines = np.concatenate([straight(0.8, angle, (0.0, 0.1 * angle, 0.0)) for angle in range(6)])
    tracemalloc.start()
    photons, labels = expected(lights, PLANE, width, 0.1)[0], masks(lines, width, PLANE)[0]
    assert tracemalloc.get_traced_memory()[1] < 2e8
    tracemalloc.stop()
    along = np.arange(101) * PLANE.pixel - 1.0
    across, down = (
        np.diff(ndtr((along - sign * lights.points[:, axis, None]) / width), axis=1) for axis, sign in ((0, 1), (1, -1))
    )
    fading = np.exp(-0.5 * (lights.points[:, 2] / 0.1) ** 2)
    exact = np.einsum("k,kr,kc->rc", lights.photons * fading, down, across)
    np.testing.assert_allclose(photons, exact, atol=1e-5 * exact.max())
    monkeypatch.setattr(light, "WIDE", 10**6)
    monkeypatch.setattr(light, "AT_ONCE", 1e12)
    np.testing.assert_array_equal(masks(lines, width, PLANE)[0], labels)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder, '[units]\nlength = "2.5 um"\ntime = "1 ms"')
    return folder


def test_a_run_becomes_ome_tiff(run, tmp_path):
    """Pillow reads the pages, ome-types what they are; in the masks each rod is where it is in the run."""
    types = pytest.importorskip("ome_types", reason="ome-types is not installed: pip install 'warp-rods[test]'")
    from PIL import Image

    own = tmp_path / "own.toml"
    own.write_text("planes = 3\nspacing = 0.3\npixel = 0.05\nread_noise = 0.5\n")
    shown = content(run, Selection(frames=slice(0, 4)))
    folder = EXPORTERS["microscope"].write(shown, tmp_path / "microscope", optics=str(own))
    assert sorted(path.name for path in folder.iterdir()) == ["image.ome.tif", "masks.ome.tif", "microscope.toml"]
    size = sum(path.stat().st_size for path in folder.iterdir())
    assert EXPORTERS["microscope"].estimate(shown, optics=str(own)) == pytest.approx(size, rel=0.2)
    pixels = types.from_tiff(folder / "image.ome.tif").images[0].pixels
    assert (pixels.size_t, pixels.size_c, pixels.size_z) == (4, 2, 3) and pixels.type.value == "uint16"
    assert (pixels.physical_size_x, pixels.physical_size_x_unit.value) == (pytest.approx(0.125), "µm")
    assert pixels.physical_size_z == pytest.approx(0.75) and pixels.time_increment == pytest.approx(1e-4)
    assert pixels.time_increment_unit.value == "s"
    assert [channel.name for channel in pixels.channels] == ["cell", "sensors"]
    with Image.open(folder / "image.ome.tif") as image, Image.open(folder / "masks.ome.tif") as truth:
        assert image.n_frames == truth.n_frames == 4 * 2 * 3
        stack, labels = [], []
        for channel in range(2):
            for plane in range(3):
                image.seek((3 * 2 + channel) * 3 + plane)  # the last frame
                truth.seek((3 * 2 + channel) * 3 + plane)
                stack.append(np.asarray(image)), labels.append(np.asarray(truth))
    assert np.unique(labels[3:]).tolist() == [0, 1, 2, 3, 4]
    bright = np.array(stack).astype(float)
    assert bright[np.array(labels) > 0].mean() > 1.3 * bright[np.array(labels) == 0].mean()
    settings = microscope(shown, str(folder / "microscope.toml"))
    assert settings == microscope(shown, str(own)) and settings.width == pytest.approx(
        0.225 * 0.52 / 1.2 / 2.5, rel=1e-3
    )


def test_without_units_times_are_in_the_description(tmp_path):
    """OME has seconds where no unit is given."""
    types = pytest.importorskip("ome_types", reason="ome-types is not installed: pip install 'warp-rods[test]'")
    write_run(tmp_path)
    found = types.from_tiff(EXPORTERS["microscope"].export(tmp_path) / "image.ome.tif").images[0]
    assert found.pixels.time_increment is None and "a frame every 0.1, in units of the scene" in found.description
    assert found.pixels.physical_size_x_unit.value == "reference frame"


def test_the_same_settings_give_the_same_bytes(run, tmp_path):
    shown = content(run, Selection(("cell",)))
    first, second = (EXPORTERS["microscope"].write(shown, tmp_path / name) for name in "ab")
    assert (first / "microscope.toml").read_bytes() == (second / "microscope.toml").read_bytes()
    from PIL import Image

    with Image.open(first / "image.ome.tif") as a, Image.open(second / "image.ome.tif") as b:
        for number in range(FRAMES):
            a.seek(number), b.seek(number)
            assert np.array_equal(np.asarray(a), np.asarray(b))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("aperture = -1.0", r"aperture = -1\.0: must be a positive number"),
        ("apertur = 1.0", r"apertur: unknown key \(did you mean aperture\?\)"),
        (
            'wavelength = "green"',
            'wavelength = .green.: must be a length in quotes, such as "520 nm"',
        ),
        ("pixel", "this is not TOML"),
        (None, "cannot be read"),
        ("pixel = 1e-5", r"pixel = 1e-05: a plane would have .* pixels, which take about .*, and may take 2 GB"),
    ],
)
def test_wrong_settings_are_named(run, tmp_path, text, message):
    path = tmp_path / "own.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SceneError, match=message):
        EXPORTERS["microscope"].export(run, tmp_path / "made", optics=str(path))
    assert not (tmp_path / "made").exists()
