"""Other forms of the animation in USD: tubes, packages, parts for long runs, arrows of the activity, a script."""

import ast
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from examples.drawn import FRAMES, write_run

from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.selection import Selection
from warp_rods.draw.tube_mesh import tube_faces, tube_points
from warp_rods.draw.usd import clips
from warp_rods.simulation.reading import open_run


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder)
    return folder


def opened(path):
    from pxr import Usd, UsdValidation

    stage = Usd.Stage.Open(str(path))
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetMessage() for error in context.Validate(stage)] == []
    return stage


def points_of(stage, name, frame):
    from pxr import UsdGeom

    return np.array(UsdGeom.PointBased(stage.GetPrimAtPath(f"/World/{name}")).GetPointsAttr().Get(frame))


def test_tubes_have_their_radius_and_close():
    line = np.stack([np.cos(np.linspace(0, 2, 9)), np.sin(np.linspace(0, 2, 9)), np.linspace(0, 1, 9)], axis=-1)
    points, normals, nodes = tube_points(np.stack([line, line + 1]), 0.1, 8)
    np.testing.assert_allclose(np.linalg.norm(points - np.stack([line, line + 1])[:, nodes, None], axis=-1), 0.1)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)
    corners, counts = tube_faces(2, points.shape[1], 8)
    flat, start, volume = points.reshape(-1, 3), 0, 0.0
    edges = set()
    for count in counts:
        face = corners[start : start + count]
        start += count
        edges |= {(a, b) for a, b in zip(face, np.roll(face, -1), strict=True)}
        for b, c in pairwise(face[1:]):
            volume += np.dot(flat[face[0]], np.cross(flat[b], flat[c])) / 6
    assert start == len(corners) and edges == {(b, a) for a, b in edges}  # watertight
    length = np.linalg.norm(np.diff(line, axis=0), axis=-1).sum()
    assert 0.8 < volume / 2 / (np.pi * 0.01 * (length + 0.13)) < 1.0  # outwards; an octagon has 0.9 of its circle


def test_long_runs_come_in_parts(run, monkeypatch):
    """Value clips of two frames and more: the whole has the points of one file, at every frame."""
    monkeypatch.setattr(clips, "PART", 1.0)
    whole = opened(EXPORTERS["usd"].export(run))
    folder = EXPORTERS["clips"].export(run)
    assert len(list((folder / "parts").glob("*.usdc"))) == FRAMES
    stage = opened(folder / "animation.usdc")
    for frame in (0, 3, FRAMES - 1):
        for name in ("Ensembles/sensors", "Ensembles/cell", "Membrane"):
            np.testing.assert_array_equal(points_of(stage, name, frame), points_of(whole, name, frame))
    moved = folder.rename(folder.with_name("moved"))  # parts are found relative to the animation
    assert len(points_of(opened(moved / "animation.usdc"), "Ensembles/cell", 2)) == 34


def test_packages_have_tubes(run):
    stage = opened(EXPORTERS["usdz"].export(run))
    assert stage.GetPrimAtPath("/World/Ensembles/cell").GetTypeName() == "Mesh"
    points = points_of(stage, "Ensembles/cell", 3).reshape(2, -1, 8, 3)
    middle = points[:, 3:-3].mean(axis=2)  # without the caps
    np.testing.assert_allclose(middle, open_run(run)["cell"].position[3].values, atol=1e-6)


def test_activity_is_drawn_along_the_tangent(tmp_path, monkeypatch):
    from warp_rods.draw.rods import Rods

    write_run(tmp_path)
    saved = Rods.variable
    monkeypatch.setattr(
        Rods, "variable", lambda self, name, frame: saved(self, name, frame) + 2.0 * (name == "activity")
    )
    stage = opened(EXPORTERS["usd"].export(tmp_path, activity=True))
    arrows = points_of(stage, "Loads/cell_activity", 1).reshape(2, -1, 4, 3)
    direction = arrows[:, :, 3] - arrows[:, :, 0]
    position = open_run(tmp_path)["cell"].position[1].values
    tangent = np.gradient(position, axis=1)[:, [0, 8, 16]]
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    length = np.linalg.norm(direction, axis=-1, keepdims=True)
    np.testing.assert_allclose(direction / length, tangent, atol=1e-5)
    np.testing.assert_allclose(length, length.flat[0], rtol=1e-5)


def test_the_script_for_blender_is_python(run):
    text = EXPORTERS["blender"].export(run).read_text()
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    assert "bpy" in names and '"animation.usdc"' in text


def test_the_script_for_blender_has_the_frames_of_the_animation(run, tmp_path):
    """Whichever frames were chosen when the script was made: it reads them from the stage."""
    text = EXPORTERS["blender"].export(run, tmp_path / "blender.py", Selection(frames=slice(0, 2))).read_text()
    EXPORTERS["usd"].export(run, tmp_path / "animation.usdc", fps=12.0)
    parts = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef) and node.name == "timing"]
    known = {"HERE": tmp_path, "ANIMATION": "animation.usdc"}
    exec("from pxr import Usd\n" + ast.unparse(parts), known)
    scene = SimpleNamespace(render=SimpleNamespace())
    known["timing"](scene)
    assert (scene.frame_start, scene.frame_end, scene.render.fps) == (0, FRAMES - 1, 12)
