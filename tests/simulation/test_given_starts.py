"""Shapes at the start from files: in scenes from another folder, kept in the run folder, resumed, refused if edited."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from examples.lines import helix, on_torus, unequal

import warp_rods as wr
from warp_rods.centrelines.rod import distances
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.rods.free import shapes as free_shapes
from warp_rods.scene.scene import Scene
from warp_rods.scene.shapes import FILAMENT_SHAPES, SHAPES
from warp_rods.simulation import runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.starts import READ

CELL = {"name": "c", "count": 1, "nodes": 33, "bend": 1e-2, "twist": 1e-3}
FILAMENT = {"name": "f", "count": 1, "nodes": 33, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
TORUS = {"kind": "torus", "major": 1.0, "minor": 0.4}
TIME = {"end": 0.02, "save_every": 0.01}
QUIET = {"usd": False}
INTRINSIC = [0.3, 1.0, 0.5]


def scene(folder: Path, text: str, end: float = 0.02) -> Path:
    """A scene file in a folder, with paths relative to it."""
    time = f"[time]\nend = {end}\nsave_every = 0.01\n[output]\nusd = false\n"
    (folder / "scene.toml").write_text(text + time)
    return folder / "scene.toml"


BOTH = """
[surface]
kind = "torus"
major = 1.0
minor = 0.4
[[swimmers]]
name = "c"
count = 2
nodes = 33
bend = 1e-2
twist = 1e-3
shape = { points = ["one.csv", "two.wcon"], smoothing = "6 points", frame = 0, perturbation = 1e-3 }
[[filaments]]
name = "f"
count = 1
nodes = "auto"
stiffness = [1, 1, 1]
drag = [1, 2, 0.1]
shape = { points = "line.npy", scale = 0.01 }
"""


@pytest.fixture
def measured(tmp_path) -> Path:
    """A folder with a scene and the files that it names."""
    folder = tmp_path / "data"
    folder.mkdir()
    points = helix(unequal(60))
    header = "frame,x,y,z"
    np.savetxt(folder / "one.csv", np.c_[0 * points[:, 0], points], delimiter=",", header=header, comments="")
    x, y = (30 * points[:, :2]).T.tolist()
    wcon = {"units": {"t": "s", "x": "um", "y": "um"}, "data": {"id": 1, "t": 0, "x": x, "y": y}}
    (folder / "two.wcon").write_text(json.dumps(wcon))
    np.save(folder / "line.npy", 100 * on_torus(unequal(200)))
    return folder


def test_every_kind_of_shape_has_a_function():
    assert SHAPES.keys() == free_shapes.SHAPES.keys() | READ.keys()
    assert FILAMENT_SHAPES.keys() == READ.keys()
    assert {name for name, row in SHAPES.items() if row.own_rods} == READ.keys()


def test_a_scene_from_another_folder_passes_through_the_points_and_says_how_far(measured, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    simulation = Simulation(Scene.load(scene(measured, BOTH)), "cpu")
    cells, filaments = simulation.ensembles["c"], simulation.ensembles["f"]
    one, two = (wr.from_centreline(measured / name, 33, smoothing="6 points") for name in ("one.csv", "two.wcon"))
    mean = (one.length + two.length) / 2
    for rod, line in enumerate((one, two)):
        middle = line.position * line.length / mean  # places have one unit for all
        np.testing.assert_allclose(cells.position[rod, 16], middle, rtol=1e-12)
        np.testing.assert_allclose(cells.position[rod] - middle, line.line / line.length - line.position, atol=2e-4)
    dense = on_torus(np.linspace(0, 1, 20_001))
    assert distances(filaments.position[0], dense).max() < 2e-3
    assert filaments.length[0] == pytest.approx(np.linalg.norm(np.diff(dense, axis=0), axis=1).sum(), rel=1e-4)
    said = "\n".join(simulation.notes)
    for words in (
        "f: points up to ", "away from the membrane (rms", " nodes chosen, ", "c: the length of the centre line in "
        "the file, ", "it has no twist", "c: worm 1 at time 0", "the rod is within",
    ):  # fmt: skip
        assert words in said, words


def test_a_run_needs_nothing_outside_and_has_the_same_bits_when_moved_and_resumed(measured, tmp_path):
    whole = runner.simulate(scene(measured, BOTH, 0.03), tmp_path / "whole", device="cpu").data
    runner.simulate(scene(measured, BOTH), tmp_path / "run", device="cpu")
    elsewhere = tmp_path / "elsewhere" / "run"
    elsewhere.parent.mkdir()
    shutil.move(tmp_path / "run", elsewhere)
    shutil.rmtree(measured)
    assert "no damage" in check_run(elsewhere)
    origin = open_run(elsewhere).attrs["kept_surfaces"]["starts.npz"]
    assert [Path(path).name for path, _ in origin["sources"]["c"]] == ["one.csv", "two.wcon"]
    assert all(len(sha) == 64 for _, sha in origin["sources"]["f"])
    longer = elsewhere / "scene.toml"
    longer.write_text(longer.read_text().replace("end = 0.02", "end = 0.03"))
    data = runner.simulate(longer, elsewhere, resume=True, device="cpu").data
    again = runner.simulate(elsewhere / "scene.toml", tmp_path / "again", device="cpu").data
    for name in ("c", "f"):
        for other in (data, again):
            np.testing.assert_array_equal(other[name]["position"], whole[name]["position"])
            np.testing.assert_array_equal(other[name]["strain"], whole[name]["strain"])
    assert open_run(tmp_path / "again").attrs["kept_surfaces"]["starts.npz"]["sources"] == origin["sources"]
    (elsewhere / "starts.npz").write_bytes(b"x" + (elsewhere / "starts.npz").read_bytes()[1:])
    with pytest.raises(RunFolderError, match=r"starts.npz is missing or damaged: the start of rods from .*one.csv"):
        check_run(elsewhere)


def test_an_edited_file_or_another_smoothing_is_told_when_a_run_is_resumed(measured, tmp_path):
    path = scene(measured, BOTH)
    runner.simulate(path, tmp_path / "run", device="cpu")
    runner.simulate(scene(measured, BOTH, 0.03), tmp_path / "run", resume=True, device="cpu")
    with pytest.raises(
        RunFolderError, match=r"swimmers\[0\].shape.smoothing: \"6 points\" in the run, 0.3 in the scene"
    ):
        runner.simulate(scene(measured, BOTH.replace('"6 points"', "0.3")), tmp_path / "run", resume=True, device="cpu")
    np.save(measured / "line.npy", 100 * on_torus(unequal(100)))
    with pytest.raises(
        RunFolderError, match=r"filaments\[0\].shape: .*line.npy with SHA-256 .* is not what the run began"
    ):
        runner.simulate(scene(measured, BOTH, 0.03), tmp_path / "run", resume=True, device="cpu")
    changed = (tmp_path / "run" / "scene.toml").read_text().replace("scale = 0.01", "scale = 0.02")
    (tmp_path / "run" / "other.toml").write_text(changed)
    with pytest.raises(SceneError, match=r"read with scale = 0.01, not 0.02: give the original file to read it again"):
        Simulation(Scene.load(tmp_path / "run" / "other.toml"), "cpu")


def test_points_in_micrometres_are_converted_for_a_scene_with_units(tmp_path):
    angle = np.linspace(0, 1.5, 60)
    x, y = 500 * np.cos(angle), 500 * np.sin(angle)
    wcon = {"units": {"t": "s", "x": "nm", "y": "nm"}, "data": {"id": 1, "t": 0, "x": x.tolist(), "y": y.tolist()}}
    (tmp_path / "a.wcon").write_text(json.dumps(wcon))
    tables = {
        "surface": {"kind": "sphere", "radius": 0.5}, "time": TIME, "units": {"length": "1 um"},
        "filaments": [FILAMENT | {"shape": {"points": tmp_path / "a.wcon"}}],
    }  # fmt: skip
    simulation = Simulation(Scene.parse(tables), "cpu")
    assert simulation.ensembles["f"].length[0] == pytest.approx(0.75, rel=1e-4)
    assert "f: one unit of the file is 0.001 of the scene" in simulation.notes
    with pytest.raises(SceneError, match=r"filaments\[0\].shape.points: the line of rod 0 is up to .* away from the"):
        Simulation(Scene.parse({key: value for key, value in tables.items() if key != "units"}), "cpu")


def test_a_given_placement_moves_a_measured_shape(measured):
    table = CELL | {"shape": {"points": measured / "one.csv"}}
    there = table | {"placement": {"position": [[5, 0, 0]], "direction": [[0, 0, 1]]}}
    free, placed = (Simulation(Scene.parse({"swimmers": [one], "time": TIME}), "cpu").ensembles["c"] for one in
                    (table, there))  # fmt: skip
    np.testing.assert_array_equal(placed.strain, free.strain)
    np.testing.assert_allclose(placed.position[0, 16], [5, 0, 0], atol=1e-15)
    assert np.abs(free.position[0, 16]).max() < 2


# --- from a run -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def earlier(tmp_path_factory) -> Path:
    """A run of twisted swimmers and of filaments on a torus."""
    cells = CELL | {
        "count": 3, "bend": 1e-3, "moment": 2e-3, "shape": {"kind": "writhe", "amplitude": 4.0, "perturbation": 1e-2},
        "placement": {"position": [[0, 0, 0], [2, 0, 0], [4, 0, 0]]},
    }  # fmt: skip
    filaments = FILAMENT | {"count": 2, "length": 0.8, "intrinsic": INTRINSIC}
    tables = {"surface": TORUS, "swimmers": [cells], "filaments": [filaments], "time": TIME, "output": QUIET}
    return runner.simulate(Scene.parse(tables), tmp_path_factory.mktemp("runs") / "earlier", device="cpu").folder


def from_run(run: Path, cells=None, filaments=None, surface=TORUS, nodes=33) -> Simulation:
    """Rods that begin as those of a run; None: without shape keys of their own."""
    more = {"nodes": nodes}
    swimmers = CELL | {"count": 3, "bend": 1e-3, "moment": 2e-3, **more, "shape": {"run": run, **(cells or {})}}
    bound = FILAMENT | {"count": 2, "intrinsic": INTRINSIC, **more, "shape": {"run": run, **(filaments or {})}}
    tables = {"surface": surface, "swimmers": [swimmers], "filaments": [bound], "time": TIME}
    return Simulation(Scene.parse(tables), "cpu")


def test_rods_begin_as_those_of_a_run(earlier):
    """Places, strains with twist, and the activity of the last frame."""
    simulation, data = from_run(earlier), open_run(earlier)
    for name, within in (("c", 1e-9), ("f", 1e-7)):  # quaternions are saved with 24 bits
        rods, last = simulation.ensembles[name], data[name].isel(frame=-1)
        np.testing.assert_allclose(rods.position, last["position"], rtol=0, atol=max(within, 1e-7))
        np.testing.assert_allclose(rods.strain, last["strain"], rtol=0, atol=10 * within)
    assert np.abs(data["c"]["strain"][-1, :, :, 0]).max() > 0.1
    np.testing.assert_array_equal(simulation.ensembles["c"].activity, data["c"]["activity"][-1].astype(float))
    np.testing.assert_array_equal(simulation.ensembles["f"].length, data["f"]["length"][-1])
    assert any(note.startswith("f: up to ") and "away from the membrane" in note for note in simulation.notes)
    assert f"c: begins as {earlier}: c at t = 0.02" in simulation.notes


def test_rods_of_a_run_are_resampled_and_chosen_by_index(earlier):
    data = open_run(earlier)
    more = from_run(earlier, nodes=65).ensembles
    for name, within in (("c", 5e-3), ("f", 1e-4)):
        np.testing.assert_allclose(more[name].position[:, ::2], data[name]["position"][-1], rtol=0, atol=within)
        np.testing.assert_allclose(more[name].strain[:, ::2, 2], data[name]["strain"][-1, :, :, 2], rtol=0, atol=1e-6)
    chosen = from_run(earlier, {"rod": [2, 0, 1], "frame": [0, 1, -1]}, {"time": 0.01, "rod": 1}).ensembles
    expected = [data["c"]["strain"][frame, rod] for frame, rod in ((0, 2), (1, 0), (-1, 1))]
    np.testing.assert_allclose(chosen["c"].strain, expected, rtol=0, atol=1e-12)
    for rod in (0, 1):
        np.testing.assert_allclose(chosen["f"].position[rod], data["f"]["position"][1, 1], rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    "cells, filaments, surface, said",
    [
        ({"rod": [0, 1, 7]}, None, TORUS, r"swimmers\[0\].shape.run: .*earlier rod = 7: has 3 rods, 0 to 2"),
        ({"frame": 9}, None, TORUS, "frame = 9: has 3 frames, 0 to 2, or -1 for the last"),
        ({"time": 9.0}, None, TORUS, "time = 9: has the times 0, 0.01, 0.02"),
        ({"ensemble": "x"}, None, TORUS, "has no swimmers named x: give shape.ensemble, one of c"),
        (None, None, {"kind": "sphere", "radius": 1.0}, r"rod \d is .* away from the membrane, more than 0.1 of its"),
    ],
)
def test_what_a_run_does_not_have_is_refused(earlier, cells, filaments, surface, said):
    with pytest.raises(SceneError, match=said):
        from_run(earlier, cells, filaments, surface)


def test_a_damaged_or_missing_run_is_named(earlier, tmp_path):
    shutil.copytree(earlier, tmp_path / "run")
    chunk = next(file for file in (tmp_path / "run/trajectory.zarr/c/strain").rglob("*") if file.suffix != ".json")
    chunk.write_bytes(b"damaged")
    with pytest.raises(SceneError, match=r"swimmers\[0\].shape.run: frame 2 of c/strain is damaged"):
        from_run(tmp_path / "run")
    shutil.rmtree(tmp_path / "run/trajectory.zarr")
    with pytest.raises(SceneError, match=r"shape.run: There is no run in .*trajectory.zarr/zarr.json is missing"):
        from_run(tmp_path / "run")
    shutil.rmtree(tmp_path / "run")
    with pytest.raises(SceneError, match=r"swimmers\[0\].shape.run: there is no run folder .*run \(relative paths"):
        from_run(tmp_path / "run")


def test_a_run_that_saved_positions_only_gives_the_shape_without_twist(tmp_path):
    cells = CELL | {"shape": {"kind": "mode", "amplitude": 3.0}}
    output = {"usd": False, "variables": ["energy"]}
    runner.simulate(Scene.parse({"swimmers": [cells], "time": TIME, "output": output}), tmp_path / "run", device="cpu")
    start = CELL | {"shape": {"run": tmp_path / "run"}}
    simulation = Simulation(Scene.parse({"swimmers": [start], "time": TIME}), "cpu")
    position = open_run(tmp_path / "run")["c"]["position"][-1]
    np.testing.assert_allclose(simulation.ensembles["c"].position, position, atol=2e-3)
    assert "c: strains were not saved: the shape is that of the positions, without twist" in simulation.notes
    assert "c: the activity was not saved: it begins with the profile of the scene" in simulation.notes


# --- formulas ---------------------------------------------------------------------------------------------------------


def test_formulas_of_s_are_the_strains(device):
    s = np.linspace(-0.5, 0.5, 33)
    shape = {"bend": "3*sin(2*pi*s)", "bend1": "cos(pi*s)**2", "twist": "s*cos(pi*s)", "amplitude": [1.0, -2.0]}
    table = CELL | {"count": 2, "shape": shape}
    rods = Simulation(Scene.parse(Scene.parse({"swimmers": [table], "time": TIME}).to_toml()), device).ensembles["c"]
    expected = np.stack([s * np.cos(np.pi * s), np.cos(np.pi * s) ** 2, 3 * np.sin(2 * np.pi * s)], axis=-1)
    np.testing.assert_allclose(rods.strain, np.array([1.0, -2.0])[:, None, None] * expected, atol=1e-14)
    planar = wr.FreeRods(1, 33, bend=1, twist=1, shape={"bend2": "3*sin(2*pi*s)"}, device=device)
    assert not planar.position[..., 2].any() and planar.position[..., 1].any()


def test_a_geodesic_curvature_as_a_formula():
    placed = {"position": [[0, 0, 0]], "direction": [[1, 0, 0]], "geodesic_curvature": "2*cos(pi*s)**2"}
    table = FILAMENT | {"length": 1.0, "placement": placed}
    scene = Scene.parse({"surface": {"kind": "plane"}, "filaments": [table], "time": TIME})
    rods = Simulation(Scene.parse(scene.to_toml()), "cpu").ensembles["f"]
    s = np.linspace(-0.5, 0.5, 33)
    np.testing.assert_allclose(rods.strain[0, :, 2], 2 * np.cos(np.pi * s) ** 2, atol=1e-14)


def test_nodes_are_chosen_for_formulas_as_for_the_mode_that_they_are_like():
    def nodes(shape):
        table = CELL | {"nodes": "auto", "bend": 0.5, "shape": shape}
        return Simulation(Scene.parse({"swimmers": [table], "time": TIME}), "cpu").ensembles["c"].nodes

    assert nodes({"bend": "3*sin(8*pi*s)"}) == pytest.approx(nodes({"mode": 7}), rel=0.1)


@pytest.mark.parametrize(
    "shape, said",
    [
        ({"bend": "3*x"}, r'shape.bend = "3\*x": must be a formula of s in quotes.*; column 3: x is not known here'),
        ({"bend": "1/s"}, r"shape.bend = '1/s': at s = 0, column 1: not a finite real number"),
        ({"twist": "2"}, "s does not occur in it; write a constant without quotes"),
        ({"bend": "s", "bend2": "s"}, "bend and bend2 both give bending in the plane of the modes"),
        ({"kind": "formula"}, "a shape of kind formula needs bend or bend1 or bend2 or twist"),
        ({"bend": "s", "mode": 1}, "a shape of kind formula has no mode; leave it out"),
        ({"points": "a.csv"}, r"shape.points: there is no file a.csv \(relative paths in a scene file"),
        ({"points": "a.xyz"}, r'shape.points = "a.xyz": must end in one of .csv'),
        ({"points": ["a.csv", "b.csv"]}, "needs one entry for each of 1 rods, has 2"),
        ({"points": "a.csv", "smoothing": "some"}, 'shape.smoothing = "some": must be a number, 0 or more'),
        ({"run": "x", "frame": 1, "time": 2.0}, "frame and time both give the frame"),
    ],
)
def test_wrong_shapes_are_refused(shape, said):
    with pytest.raises(SceneError, match=said):
        Simulation(Scene.parse({"swimmers": [CELL | {"shape": shape}], "time": TIME}), "cpu")


def test_filaments_without_a_length_or_with_two_places_are_refused(measured):
    shape = {"shape": {"points": measured / "line.npy"}}
    for given, said in (
        ({}, r"filaments\[0\].length: missing; must be a positive number"),
        (shape | {"placement": "random"}, r'placement = "random": shape says where the filaments are'),
        (shape | {"bodies": [0]}, r"bodies = \[0\]: is for random placement"),
        ({"length": 1.0, "shape": {"run": measured}}, "length = 1.0: filaments of a run have their length"),
    ):
        with pytest.raises(SceneError, match=said):
            Scene.parse({"surface": TORUS, "filaments": [FILAMENT | given], "time": TIME})


def test_a_chosen_number_of_nodes_resolves_a_measured_shape(measured):
    """A curvature of 7.4 per length bends by a radian a cell at most; half of it would not be warned of."""
    table = CELL | {"nodes": 17, "bend": 0.5, "shape": {"points": measured / "one.csv"}}
    sharp = helix(np.linspace(0, 1, 200), turns=6)
    np.savetxt(measured / "one.csv", sharp, delimiter=",")
    warned = Simulation(Scene.parse({"swimmers": [table], "time": TIME}), "cpu").warnings
    assert any("the curvature at the start reaches 37" in line and "use 39 nodes or more" in line for line in warned)
