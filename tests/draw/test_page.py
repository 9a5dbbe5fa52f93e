"""The page of a run: what is packed into it, its size, and that it plays in a browser without the network."""

import base64
import gzip
import io
import json
import logging
import re

import numpy as np
import pytest
from examples.chromium import opened
from examples.drawn import FRAMES, arcs, scene_text, write_run

from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.page.encoding import packed_points, packed_triangles, packed_values, quantised
from warp_rods.draw.selection import Selection
from warp_rods.draw.sheet import curvature_colours
from warp_rods.errors import SceneError
from warp_rods.simulation.trajectory import STORE, SWIMMER_VARIABLES, GroupSpec, TrajectoryWriter


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder, '[units]\nlength = "1 um"', fail_at=4)
    return content(folder)


@pytest.fixture(scope="module")
def page(shown, tmp_path_factory):
    return EXPORTERS["html"].write(shown, tmp_path_factory.mktemp("page") / "page.html")


def small(stored: np.ndarray, size: int) -> np.ndarray:
    """Signed differences from bytes in planes, as ``data.js`` reads them."""
    number = sum(plane.astype(np.int64) << (8 * i) for i, plane in enumerate(stored.reshape(size, -1)))
    return (number >> 1) ^ -(number & 1)


def test_what_is_packed_can_be_unpacked():
    rng = np.random.default_rng(1)
    points = np.cumsum(rng.normal(size=(3, 20, 3)), axis=1)
    points[..., 2] = 0.7
    numbers, low, spacing = quantised(points)
    np.testing.assert_allclose(low + spacing * numbers, points, atol=0.5001 * spacing.max())
    bends = small(np.frombuffer(packed_points(numbers), np.uint8), 2).reshape(3, 20, 3)
    bends[:, 1] += bends[:, 0]  # the second node is a first difference
    slopes = np.cumsum(np.concatenate([bends[:, :1] * 0, bends[:, 1:2] - bends[:, :1], bends[:, 2:]], axis=1), axis=1)
    found = bends[:, :1] + np.cumsum(slopes, axis=1)
    assert np.array_equal(found % 65536, numbers)
    triangles = rng.integers(0, 100_000, (50, 3))
    found = np.cumsum(small(np.frombuffer(packed_triangles(triangles), np.uint8), 4))
    assert np.array_equal(found, triangles.ravel())
    values = np.array([[0.0, 0.5, 1.0, np.nan, 0.25]])
    levels = np.cumsum(np.frombuffer(packed_values(values), np.uint8)) % 256
    assert levels.tolist() == [0, 127, 254, 255, 64]


def test_the_page_says_what_it_shows(page, shown):
    text = page.read_text(encoding="utf-8")
    facts = json.loads(re.search(r'id="facts">(.*?)</script>', text, re.S)[1])
    assert facts["times"] == pytest.approx(0.1 * np.arange(FRAMES)) and facts["metres"] == 1e-6
    assert facts["colour"]["label"] == "elastic energy per length (force)"
    assert facts["colour"]["ticks"] == [pytest.approx(shown.scale(0).ticks(3).tolist(), rel=1e-6)]
    assert [(rods["name"], rods["rods"], rods["nodes"]) for rods in facts["rods"]] == [
        ("cell", 2, 17),
        ("sensors", 4, 9),
    ]
    stored = gzip.decompress(base64.b64decode(re.search(r'id="points1">(.*?)</script>', text, re.S)[1]))
    assert len(stored) == FRAMES * 4 * 9 * 3 * 2
    assert "<title>Rods on a ball</title>" in text and not re.search(r'(src|href)="(?!data:)', text)


def test_text_of_a_scene_cannot_become_code(tmp_path, shown, monkeypatch):
    monkeypatch.setattr(shown, "title", "</script><script>alert(1)</script> @script@ & more")
    text = EXPORTERS["html"].write(shown, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "alert(1)</script>" not in text and "&lt;/script&gt;" in text and "@script@ &amp; more" in text


def test_frames_are_left_out_to_bound_the_size(shown, tmp_path, caplog):
    whole = EXPORTERS["html"].estimate(shown)
    fixed = EXPORTERS["html"].estimate(shown, limit=1e-3)
    limit = (fixed + 0.55 * (whole - fixed)) / 1e6
    with caplog.at_level(logging.WARNING):
        made = EXPORTERS["html"].write(shown, tmp_path / "page.html", limit=limit)
    assert "one frame in 2, 3 of 6" in caplog.text and "--limit" in caplog.text
    facts = json.loads(re.search(r'id="facts">(.*?)</script>', made.read_text(encoding="utf-8"), re.S)[1])
    assert facts["times"] == pytest.approx([0.0, 0.2, 0.4])
    with pytest.raises(SceneError, match=r"limit = 0\.001: one frame takes .* MB"):
        EXPORTERS["html"].write(shown, tmp_path / "none.html", limit=1e-3)
    assert not (tmp_path / "none.html").exists()


def test_a_page_with_a_moving_membrane_stays_below_its_limit(tmp_path, caplog):
    """A mesh changes in every frame, by more where frames are left out."""
    scene = scene_text(surface='kind = "sphere"\nradius = "1 + 0.3*sin(9*t)"')
    spec = GroupSpec(2, 17, SWIMMER_VARIABLES)
    writer = TrajectoryWriter.create(tmp_path / STORE, {"cell": spec}, {"title": "", "scene": scene})
    for number in range(40):
        saved = {name: np.zeros(spec.shape(v)) for name, v in spec.variables.items()}
        saved["position"] = arcs(2, 17, 1.0, 0.02 * number)
        writer.append(0.025 * number, {"cell": saved})
    writer.close()
    shown = content(tmp_path)
    whole = EXPORTERS["html"].write(shown, tmp_path / "whole.html").stat().st_size
    assert EXPORTERS["html"].estimate(shown) == pytest.approx(whole, rel=0.5)
    for share in (0.3, 0.6):
        limit = share * whole / 1e6
        with caplog.at_level(logging.WARNING):
            made = EXPORTERS["html"].write(shown, tmp_path / "page.html", limit=limit)
        assert 0.5 * share * whole < made.stat().st_size <= share * whole
        assert "one frame in" in caplog.text


@pytest.fixture(scope="module")
def browser(page, tmp_path_factory):
    """The page in Chromium, loaded."""
    with opened(page, tmp_path_factory.mktemp("profile"), (480, 320)) as found:
        found.wait_for("window.player && document.getElementById('message').textContent === ''")
        yield found


def test_it_plays_in_a_browser_without_the_network(browser, page, shown):
    """Two pictures differ, those of one frame do not; no error on the console, no request but that of the page."""
    from PIL import Image

    assert browser.value("player.playing") is True
    seen = browser.value("player.frame")
    browser.wait_for(f"player.frame !== {seen}")  # it plays by itself
    browser.value("document.getElementById('play').click()")
    assert browser.value("player.playing") is False
    pictures = {}
    for name, frame in (("first", 0), ("last", FRAMES - 1), ("again", 0)):
        browser.value(f"player.go({frame})")
        browser.wait_for("!player.stale")
        assert browser.value("document.getElementById('time').textContent") == f"t = {shown.times[frame]:.1f}"
        pictures[name] = np.asarray(Image.open(io.BytesIO(browser.screenshot())).convert("RGB")).astype(int)
    assert browser.errors == [] and browser.requests == [page.resolve().as_uri()]
    middle = {name: picture[60:250] for name, picture in pictures.items()}  # without the controls
    assert np.array_equal(middle["first"], middle["again"])
    assert (np.abs(middle["first"] - middle["last"]).max(axis=-1) > 30).sum() > 100
    spread = middle["first"].max(axis=-1) - middle["first"].min(axis=-1)
    assert (spread > 80).sum() > 50  # rods have colours, the membrane is grey
    grey = (middle["first"].max(axis=-1) < 235) & (spread < 40)
    assert grey.sum() > 1000
    assert browser.value("document.getElementById('length').textContent").endswith("µm")


def test_the_places_on_the_page_are_those_of_the_run(browser, shown):
    """What the page itself unpacks, of rods of which one is lost at the end."""
    for frame in (0, FRAMES - 1):
        rods = f"player.scene.rods[1], points = rodPoints(rods.points, {frame}, rods.rods, rods.nodes)"
        code = f"(() => {{ const rods = {rods}; return [[...points], rods.boxes[{frame}]] }})()"
        numbers, (low, spacing) = browser.value(code)
        found = np.array(low) + np.array(spacing) * np.reshape(numbers, (4, 9, 3))
        np.testing.assert_allclose(found, shown.rods[1].positions(frame), atol=2e-5)


def test_a_membrane_has_the_colours_of_the_poster(tmp_path):
    """A byte a point: red outside of a torus and blue inside, and a bar that says so."""
    write_run(tmp_path, '[units]\nlength = "1 um"', surface='kind = "torus"\nmajor = 1.0\nminor = 0.4')
    own = content(tmp_path, Selection(("sensors",)))
    page = EXPORTERS["html"].write(own, tmp_path / "page.html")
    with opened(page, tmp_path / "profile", (480, 320)) as browser:
        browser.wait_for("window.player && document.getElementById('message').textContent === ''")
        tints = np.reshape(browser.value("[...player.scene.tints(player.scene.sheets[0], 0)]"), (-1, 3))
        expected = curvature_colours(own.membrane.ratio(0))
        np.testing.assert_allclose(tints, expected, atol=0.01)
        bar = browser.value("document.getElementById('curvature').textContent.replace(/\\s+/g, ' ').trim()")
        assert bar.startswith("Gaussian curvature of membrane (1/µm²)") and browser.errors == []


def test_a_range_of_each_frame_is_shown_with_it(tmp_path, shown):
    folder = tmp_path / "run"
    folder.mkdir()
    write_run(folder)
    own = content(folder, Selection(span="frame"))
    text = EXPORTERS["html"].write(own, tmp_path / "page.html").read_text(encoding="utf-8")
    ticks = json.loads(re.search(r'id="facts">(.*?)</script>', text, re.S)[1])["colour"]["ticks"]
    assert ticks == [pytest.approx(own.scale(frame).ticks(3).tolist(), rel=1e-6) for frame in range(FRAMES)]
