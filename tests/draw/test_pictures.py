"""Pictures: posters, stills and films of a small run, opened again; capsules against a closed form."""

import logging
import os
import time

import numpy as np
import pytest
from examples.drawn import FRAMES, write_run

from warp_rods.draw import film
from warp_rods.draw.clock import clock_of
from warp_rods.draw.colours import BLUE_RED, COLOURS, colour_map
from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.lettering import Canvas, round_length
from warp_rods.draw.picture import FINER, Painter
from warp_rods.draw.poster import WIDTH
from warp_rods.draw.scale import LACKING, Scale, scale_of
from warp_rods.draw.selection import Selection, parse_frames, parse_span
from warp_rods.draw.sheet import curvature_colours
from warp_rods.draw.view import View, view_of
from warp_rods.errors import RunFolderError, SceneError, WarpRodsError


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder)
    return folder


def pixels(path) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"))


def test_the_poster_has_lit_tubes_on_white(run):
    picture = pixels(EXPORTERS["poster"].export(run))
    height, width, _ = picture.shape
    assert width == WIDTH and 600 < height < 1600
    border = np.concatenate([picture[:40].reshape(-1, 3), picture[-40:].reshape(-1, 3), picture[:, :40].reshape(-1, 3)])
    assert (border == 255).all()
    for third in range(3):  # each panel has something coloured: tubes in viridis
        panel = picture[150 : height - 250, third * width // 3 : (third + 1) * width // 3].astype(int)
        assert (np.ptp(panel, axis=-1) > 60).sum() > 500
    again = EXPORTERS["poster"].export(run, run / "again.png")
    assert again.read_bytes() == (run / "poster.png").read_bytes()


@pytest.mark.parametrize(("span", "bars"), [("run", 1), ("frame", 3)])
def test_each_range_of_a_poster_has_its_bar(run, tmp_path, monkeypatch, span, bars):
    """Three panels with ranges of their own have a bar each, below it."""
    drawn = []
    whole = Canvas.colour_bar
    monkeypatch.setattr(Canvas, "colour_bar", lambda self, *bar: drawn.append(bar) or whole(self, *bar))
    picture = pixels(EXPORTERS["poster"].export(run, tmp_path / "poster.png", Selection(span=span)))
    assert len(drawn) == len({(scale.low, scale.high) for *_, scale, _ in drawn}) == bars
    shown = content(run, Selection(span=span))
    assert [bar[3] for bar in drawn] == [shown.scale(frame) for frame in (0, 2, 5)[:bars]]
    for right, y, width, *_ in drawn if bars == 3 else ():
        strip = picture[round(y) + 5, round(right - width) : round(right)].astype(int)
        assert (np.ptp(strip, axis=-1) > 40).mean() > 0.8  # viridis


@pytest.mark.parametrize("radius", [3.0, 12.0])
def test_a_tube_covers_its_projection(run, radius):
    """A capsule of length L across and radius r covers 2 r L + π r² pixels; one along the view, a disc."""
    shown = content(run, Selection(ensembles=("cell",)))
    shown.rods = shown.rods[:1]
    rods, across = shown.rods[0], np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    shown.membrane = None
    for direction, length in ((0, 100.0), (2, 0.0)):
        line = np.zeros((1, rods.nodes, 3))
        line[0, :, direction] = np.linspace(-50, 50, rods.nodes)
        rods.positions, rods.values = lambda frame, line=line: line, lambda frame: np.zeros((1, rods.nodes))
        rods.count, rods.radius = 1, radius
        painter = Painter(shown, View(across, np.zeros(3), np.array([80.0, 40.0])), 160, 80)
        painter._sheet = None
        assert painter.scale == 1.0
        painter.paint(0)
        depth = painter._rods.depth.numpy()
        area = (depth > -1e29).sum() / FINER**2
        assert area == pytest.approx(2 * radius * length + np.pi * radius**2, rel=0.03)
        nearest = depth.max() / FINER
        assert nearest == pytest.approx(radius if direction == 0 else 50 + radius, rel=0.01)


def test_views_suit_the_motion(run):
    """Rods in a plane are seen along its normal; membranes at an angle."""
    shown = content(run, Selection(ensembles=("cell",)))
    assert 0.1 < abs(view_of(shown).axes[2, 2]) < 0.9
    shown.membrane = None
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    bow = np.stack([np.linspace(-1, 1, 17), np.linspace(-1, 1, 17) ** 2, np.zeros(17)], axis=-1) @ turned.T
    for rods in shown.rods:
        rods.positions = lambda frame: bow[None]
    view = view_of(shown)
    assert abs(view.axes[2] @ turned[:, 2]) == pytest.approx(1.0, abs=1e-6) and view.axes[2, 2] > 0
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-12)
    inside = np.abs((bow - view.centre) @ view.axes[:2].T)
    assert (inside <= view.half).all() and (inside.max(axis=0) / view.half).max() > 0.9


def test_a_camera_follows_rods_that_travel_far(run):
    """The picture is as large as one rod needs, and is where the rod is."""
    shown = content(run, Selection(ensembles=("cell",)))
    shown.membrane = None
    bow = np.stack([np.linspace(-0.5, 0.5, 17), np.linspace(-1, 1, 17) ** 2 / 4, np.zeros(17)], axis=-1)
    for rods in shown.rods:
        rods.positions = lambda frame: (bow + np.array([0.0, 5.0 * frame, 0.0]))[None]
    view = view_of(shown)
    assert view.follows and view.half.max() < 0.9
    np.testing.assert_allclose(view.at(shown, 4).centre - view.at(shown, 1).centre, [0, 15.0, 0], atol=1e-12)


def test_films_have_all_frames(run):
    from PIL import Image

    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = EXPORTERS["mp4"].export(run, fps=12)
    assert ffmpeg.count_frames_and_secs(str(path)) == (FRAMES, pytest.approx(FRAMES / 12, abs=0.01))
    frames = ffmpeg.read_frames(str(path))
    assert next(frames)["size"] == (1280, 720)
    first, *_, last = (np.frombuffer(frame, np.uint8).astype(int) for frame in frames)
    assert np.abs(first - last).max() > 100 and first.mean() > 150
    with Image.open(EXPORTERS["gif"].export(run, selection=Selection(frames=slice(0, 3)))) as film:
        assert film.n_frames == 3 and film.info["duration"] == 40


@pytest.mark.skipif(os.name != "posix", reason="a script takes the place of ffmpeg")
@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("cat > /dev/null; echo first >&2; echo 'no such encoder' >&2; exit 3", "code 3: no such encoder"),
        ("echo gone >&2; exit 1", "code 1: gone"),  # the pipe is broken
        ("cat > /dev/null; exit 7", "code 7: it said nothing"),
    ],
)
def test_ffmpeg_that_fails_is_told_with_its_last_words(run, tmp_path, monkeypatch, script, said):
    fake = tmp_path / "ffmpeg"
    fake.write_text(f"#!/bin/sh\n{script}\n")
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    with pytest.raises(RunFolderError, match=f"cannot be written: ffmpeg ended with {said}"):
        EXPORTERS["mp4"].export(run, tmp_path / "film.mp4")
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.skipif(os.name != "posix", reason="a script takes the place of ffmpeg")
def test_ffmpeg_ends_with_an_export_that_is_stopped(run, tmp_path, monkeypatch):
    fake = tmp_path / "ffmpeg"
    fake.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/process\nexec sleep 600\n")
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))

    def stopped(*_arguments):
        while not (tmp_path / "process").exists() or not (tmp_path / "process").read_text().strip():
            time.sleep(0.01)
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(film, "pictures", stopped)
    with pytest.raises(KeyboardInterrupt):
        EXPORTERS["mp4"].export(run, tmp_path / "film.mp4")
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "process").read_text()), 0)
    assert not list(tmp_path.glob("*.mp4")) + list(tmp_path.glob(".*"))


def test_stills_have_the_resolution_that_was_asked_for(run):
    folder = EXPORTERS["png"].export(run, selection=Selection(frames=slice(2, None, 3)), dpi=50)
    assert sorted(path.name for path in folder.iterdir()) == ["frame_2.png", "frame_5.png"]
    assert pixels(folder / "frame_5.png").shape == (240, 320, 3)
    assert EXPORTERS["png"].export(run, selection=Selection(frames=slice(1)), dpi=50) == folder  # replaces the folder
    assert [path.name for path in folder.iterdir()] == ["frame_0.png"]


@pytest.mark.parametrize("name", COLOURS)
def test_every_colour_has_values_and_a_scale(run, name):
    shown = content(run, Selection(colour=name, frames=slice(1, None, 2)))
    for rods in shown.rods:
        values = rods.values(1)
        assert values.shape == (rods.count, rods.nodes)
        if name != "gauss" or rods.name == "sensors":
            assert np.isfinite(values).all() == (name != "activity" or rods.name == "cell")
        rgb = shown.scale(1).rgb(values)
        assert rgb.shape == (*values.shape, 3) and rgb.min() >= 0 and rgb.max() <= 1
    assert shown.scale(0).ticks(3)[0] < shown.scale(0).ticks(3)[1]


def test_speed_and_heading_are_those_of_the_motion(run):
    """Central differences between frames of the run next to each other, whatever frames are chosen."""
    data = content(run).rods[0].data
    speed = COLOURS["speed"].values(data, range(1, 5))
    moved = data.position.values[2:6] - data.position.values[0:4]
    np.testing.assert_allclose(speed, np.linalg.norm(moved, axis=-1) / 0.2, rtol=1e-12)
    strided = COLOURS["speed"].values(data, range(1, 5, 3))
    np.testing.assert_array_equal(strided, speed[::3])
    heading = COLOURS["heading"].values(data, range(5, 0, -2))
    ends = data.position.values[[5, 3, 1]][:, :, [7, 9]]
    tangent = ends[:, :, 1] - ends[:, :, 0]
    np.testing.assert_allclose(heading[..., 0], np.arctan2(tangent[..., 1], tangent[..., 0]), rtol=0, atol=1e-12)


def test_scales():
    amount = scale_of(COLOURS["speed"], np.array([1.0, 2.0, np.nan]))
    assert 1.0 <= amount.low < amount.high <= 2.0
    np.testing.assert_array_equal(amount.rgb(np.array([np.nan]))[0], LACKING)
    signed = scale_of(COLOURS["tension"], np.array([-3.0, 1.0]))
    assert signed.low == -signed.high and signed.high == pytest.approx(3.0, rel=0.02)
    energy = Scale(COLOURS["energy_density"], 0.0, 4.0)
    np.testing.assert_allclose(energy.fraction(np.array([-1.0, 0.0, 1.0, 4.0, 9.0])), [0, 0, 0.5, 1, 1])
    np.testing.assert_allclose(energy.ticks(3), [0, 1, 4])
    angle = scale_of(COLOURS["heading"], np.zeros(1))
    np.testing.assert_allclose(angle.rgb(np.array([-np.pi])), angle.rgb(np.array([np.pi])), atol=0.02)


def test_scales_of_few_values_and_of_constants():
    """98 % of zeros leave the others their range; constants are in the middle, and round-off is no range."""
    few = np.concatenate([np.zeros(980), [5.0], np.zeros(19)])
    ends = {}
    for name in ("tension", "energy_density", "speed"):
        scale = scale_of(COLOURS[name], few)
        ends[name] = scale.low, scale.high
    assert ends == {"tension": (-5.0, 5.0), "energy_density": (0.0, 5.0), "speed": (0.0, 5.0)}
    for value in (5e-7, 3.0, 3e8):
        scale = scale_of(COLOURS["speed"], value * (1 + 1e-15 * np.arange(-3, 3)))
        assert (scale.low, scale.high) == (0.0, pytest.approx(2 * value))
        assert scale.fraction(np.array([value]))[0] == pytest.approx(0.5)
        assert scale_of(COLOURS["twist"], np.full(5, -value)).low == -value
    noise = 1e-17 * np.random.default_rng(1).normal(size=1000)
    scale = scale_of(COLOURS["twist"], noise, round_off=1e-12)
    np.testing.assert_allclose(scale.fraction(noise), 0.5, atol=1e-12)
    rods = scale_of(COLOURS["rod"], np.repeat(np.arange(100.0), 17))
    assert (rods.low, rods.high) == (0.0, 99.0)


def test_the_range_of_a_run_is_that_of_all_its_frames(run):
    """Whatever frames are chosen, so that stills and films of one run can be compared."""
    whole = content(run, Selection(colour="speed"))
    for frames in (slice(-1, None), slice(0, 5, 2), slice(None, None, -1)):
        assert content(run, Selection(colour="speed", frames=frames)).scale(0) == whole.scale(0)
    own = content(run, Selection(colour="speed", frames=slice(-1, None), span="frame"))
    assert own.scale(0) == content(run, Selection(colour="speed", span="frame")).scale(FRAMES - 1)


def test_the_scale_of_an_energy_has_room_for_its_first_frame_but_the_last_is_not_dark():
    """One frame in a hundred does not change a quantile of all: the scale goes on to twice that."""
    energy = np.full((100, 50), 0.1) + 1e-4 * np.random.default_rng(1).random((100, 50))
    energy[0] = np.linspace(0.1, 0.2, 50)
    scale = scale_of(COLOURS["energy_density"], energy)
    assert scale.high == pytest.approx(np.quantile(energy[0], 0.9)) and scale.above and not scale.below
    energy[0] *= 1e4
    assert scale_of(COLOURS["energy_density"], energy).high == pytest.approx(0.2, rel=0.01)  # the others are not dark
    assert scale_of(COLOURS["speed"], energy).high < 0.2  # an even scale has no room for a peak


@pytest.mark.parametrize(("span", "tips"), [((-1e9, 1e9), 0), ((-1.0, 1e-9), 1), ((1e9, 2e9), 1)])
def test_a_bar_has_arrows_where_values_exceed_its_ends(run, tmp_path, monkeypatch, span, tips):
    drawn, whole = [], Canvas._arrow
    monkeypatch.setattr(Canvas, "_arrow", lambda self, *tip: drawn.append(tip) or whole(self, *tip))
    selection = Selection(colour="speed", span=span, frames=slice(-1, None))
    EXPORTERS["poster"].export(run, tmp_path / "poster.png", selection)
    assert len(drawn) == tips


def test_the_curvature_under_rods_has_the_hues_of_the_membrane():
    ends = np.array([0.0, 1.0])
    rods, membrane = colour_map(BLUE_RED)(ends)[:, :3], curvature_colours(2 * ends - 1)
    for own, below, more, less in zip(rods, membrane, (2, 0), (0, 2), strict=True):  # blue, then red
        assert own[more] > own[less] + 0.5 and below[more] > below[less]
    assert (colour_map(BLUE_RED)(0.5)[:3] < curvature_colours(np.zeros(1))[0] - 0.5).all()


def test_rods_on_a_membrane_have_a_least_width(run):
    shown = content(run)
    view = view_of(shown)
    painter = Painter(shown, view, 300, 200)
    for rods in shown.rods:
        rods.radius = 1e-6
        assert painter._radius(rods) == pytest.approx(view.half.max() / 150)
    shown.membrane = None
    assert Painter(shown, view, 300, 200)._radius(shown.rods[0]) == 1e-6


def test_twist_of_round_off_has_one_colour(tmp_path, monkeypatch):
    write_run(tmp_path)
    shown = content(tmp_path, Selection(("cell",), colour="twist"))
    noise = 1e-15 * np.random.default_rng(1).normal(size=(FRAMES, 2, 17))
    monkeypatch.setattr(shown.rods[0], "values", lambda frame: noise[frame])
    assert np.ptp(shown.scale(0).rgb(noise), axis=(0, 1, 2)).max() < 0.01


def test_a_run_of_one_frame_has_no_speed(tmp_path):
    """It is said, and not drawn grey."""
    write_run(tmp_path, frames=1)
    with pytest.raises(
        WarpRodsError, match=r"colour = 'speed': the trajectory of .* has one frame, and speed needs 2;"
    ):
        content(tmp_path, Selection(colour="speed"))


@pytest.mark.parametrize("name", ["poster", "gif", "html", "vtkhdf", "usd"])
def test_a_membrane_that_cannot_be_followed_is_said_once(tmp_path, caplog, name):
    """Its radius jumps from one frame to the next by more than a mesh follows."""
    radius = "1.0 + 2.0*(1 + tanh(100*(t - 0.25)))"
    write_run(tmp_path, surface=f'kind = "sphere"\nradius = "{radius}"')
    with caplog.at_level(logging.WARNING):
        EXPORTERS[name].export(tmp_path)
    said = [record.message for record in caplog.records if "cannot follow" in record.message]
    assert len(said) == 1 and said[0].startswith("t = 0.3: ") and "time.save_every" in said[0]


def test_lost_rods_stay_and_are_grey(tmp_path):
    write_run(tmp_path, fail_at=3)
    shown = content(tmp_path, Selection(frames=slice(None, None, -1)))  # backwards: the last frame first
    rods = next(rods for rods in shown.rods if rods.name == "sensors")
    np.testing.assert_array_equal(rods.positions(0)[1], rods.positions(3)[1])
    assert np.isfinite(rods.positions(0)).all()
    np.testing.assert_array_equal(shown.scale(0).rgb(rods.values(0))[1, 0], LACKING)
    sound = [own.variable("energy_density", 0)[own.variable("status", 0) == 0].ravel() for own in shown.rods]
    last = content(tmp_path, Selection(frames=slice(-1, None), span="frame"))
    assert last.scale(0).high == pytest.approx(np.quantile(np.concatenate(sound), 0.98))  # stale energies do not count


@pytest.mark.parametrize(
    ("step", "time_unit", "texts"),
    [
        (0.1, "", ["t = 0.0", "t = 0.1", "t = 0.5"]),
        (0.25, "", ["t = 0.00", "t = 0.25", "t = 1.25"]),
        (1.5, "", ["t = 0.0", "t = 1.5", "t = 7.5"]),
        (1 / 3, "", ["t = 0.00", "t = 0.33", "t = 1.67"]),
        (1e-8, "", ["t = 0 · 10⁻⁸", "t = 1 · 10⁻⁸", "t = 5 · 10⁻⁸"]),
        (1e-8, "1 s", ["t = 0 ns", "t = 10 ns", "t = 50 ns"]),
        (0.25, "1 ms", ["t = 0.00 ms", "t = 0.25 ms", "t = 1.25 ms"]),
        (20.0, "1 s", ["t = 0 s", "t = 20 s", "t = 100 s"]),
    ],
)
def test_the_clock_gives_times_in_full(tmp_path, step, time_unit, texts):
    write_run(tmp_path, f'[units]\nlength = "1 um"\ntime = "{time_unit}"' if time_unit else "", step=step)
    shown = content(tmp_path)
    assert [clock_of(shown).text(shown.times[frame]) for frame in (0, 1, 5)] == texts
    for frames in (slice(-1, None), slice(None, None, 5)):  # whichever frames are chosen
        assert clock_of(content(tmp_path, Selection(frames=frames))) == clock_of(shown)


def test_the_clock_of_one_saved_frame_follows_save_every(tmp_path):
    write_run(tmp_path, save_every=0.02, frames=1)
    assert clock_of(content(tmp_path)).text(0.0) == "t = 0.00"


def test_labels_name_the_units_of_the_scene(tmp_path):
    write_run(tmp_path, '[units]\nlength = "1 um"\nforce = "1 pN"')
    shown = content(tmp_path)
    assert shown.label == "elastic energy per length (pN)"
    assert shown.named("speed", "length/time") == "speed (length/time)"  # no unit of time is given
    assert shown.named("curvature", "1/length^2") == "curvature (1/µm²)"


def test_texts_of_the_command_line():
    assert (parse_frames("0:100:5"), parse_frames("-1"), parse_frames(":")) == (
        slice(0, 100, 5),
        slice(-1, None),
        slice(None, None),
    )
    assert parse_span("0.5,2") == (0.5, 2.0) and parse_span("frame") == "frame"
    for text in ("", "a", "1:2:3:4", "::0"):
        with pytest.raises(SceneError, match=r"frames = .*: must be first:last:step"):
            parse_frames(text)
    for text in ("2,1", "1", "all"):
        with pytest.raises(SceneError, match=r"range = .*: must be"):
            parse_span(text)
    assert [round_length(most) for most in (0.99, 1.0, 7.0, 0.03)] == pytest.approx([0.5, 1.0, 5.0, 0.02])
