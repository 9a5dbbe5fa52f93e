"""The animation: valid USD with the data of the trajectory, also for independent readers."""

import importlib.util
import re
import subprocess
import sys

import numpy as np
import pytest
from examples.drawn import FRAMES, scene_text, write_run

from warp_rods.draw.colours import COLOURS
from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.scale import Scale, linear
from warp_rods.draw.selection import Selection
from warp_rods.draw.usd.export import export_usd
from warp_rods.errors import RunFolderError
from warp_rods.membranes.mesh import triangulate
from warp_rods.membranes.surfaces import make
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.trajectory import STORE, SWIMMER_VARIABLES, GroupSpec, TrajectoryWriter

STERIC = "[steric]\nstrength = 1.0\nrange = 0.1\ncore = 0.08\n"
MICRONS = '[units]\nlength = "1 um"\n'


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_run(folder)
    export_usd(folder)
    return folder


@pytest.fixture(scope="module")
def stage(run):
    from pxr import Usd

    return Usd.Stage.Open(str(run / "animation.usdc"))


def curves_of(stage, name):
    from pxr import UsdGeom

    return UsdGeom.BasisCurves(stage.GetPrimAtPath(f"/World/Ensembles/{name}"))


def test_every_validator_passes(stage):
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_stage_metadata(stage):
    from pxr import UsdGeom

    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, FRAMES - 1)
    assert stage.GetTimeCodesPerSecond() == 24
    assert stage.GetRootLayer().documentation == "Rods on a ball"
    assert stage.GetRootLayer().customLayerData["scene_hash"] == "abc"


@pytest.mark.parametrize(("name", "rods", "nodes"), [("sensors", 4, 9), ("cell", 2, 17)])
def test_curves_are_the_trajectory(run, stage, name, rods, nodes):
    curves, data = curves_of(stage, name), open_run(run)[name]
    assert curves.GetPointsAttr().GetTimeSamples() == list(range(FRAMES))
    assert list(curves.GetCurveVertexCountsAttr().Get()) == [nodes] * rods
    assert curves.GetWidthsInterpolation() == "constant"
    width = curves.GetWidthsAttr().Get()
    assert len(width) == 1
    assert curves.GetDisplayColorPrimvar().GetInterpolation() == "vertex"
    for frame in range(FRAMES):
        points = np.array(curves.GetPointsAttr().Get(frame))
        assert sum(curves.GetCurveVertexCountsAttr().Get()) == len(points)
        np.testing.assert_array_equal(points, data.position[frame].values.reshape(-1, 3).astype(np.float32))
        assert len(curves.GetDisplayColorAttr().Get(frame)) == len(points)
        low, high = np.array(curves.GetExtentAttr().Get(frame))
        np.testing.assert_allclose(low, points.min(axis=0) - width[0] / 2, rtol=0, atol=1e-6)
        np.testing.assert_allclose(high, points.max(axis=0) + width[0] / 2, rtol=0, atol=1e-6)


def test_colours_have_one_range_for_the_whole_run(run, stage):
    data = open_run(run)
    every = [data[name].energy_density.values for name in ("sensors", "cell")]
    low, high = 0.0, np.quantile(np.concatenate([density.ravel() for density in every]), 0.98)
    stored = stage.GetDefaultPrim().GetCustomDataByKey("colour")
    assert stored["low"] == pytest.approx(low, rel=1e-12) and stored["high"] == pytest.approx(high, rel=1e-12)
    assert (stored["name"], stored["unit"], stored["map"]) == ("energy_density", "force", "viridis")
    assert stored["label"] == "elastic energy per length" and stored["quadratic"] is True
    np.testing.assert_allclose(stage.GetDefaultPrim().GetCustomDataByKey("times"), 0.1 * np.arange(FRAMES))
    for frame in (0, FRAMES - 1):
        drawn = np.array(curves_of(stage, "cell").GetDisplayColorAttr().Get(frame))
        scale = Scale(COLOURS["energy_density"], stored["low"], stored["high"])
        expected = linear(scale.rgb(every[1][frame].ravel())).astype(np.float32)
        np.testing.assert_array_equal(drawn, expected)


def test_the_colour_that_was_chosen_is_described(tmp_path):
    """With its unit in SI, the range of each frame, and the times of the chosen frames."""
    from pxr import Usd

    write_run(tmp_path, MICRONS)
    chosen = Selection(colour="gauss", frames=slice(1, None, 2), span="frame")
    stage = Usd.Stage.Open(str(export_usd(tmp_path, selection=chosen)))
    world = stage.GetDefaultPrim()
    stored, shown = world.GetCustomDataByKey("colour"), content(tmp_path, chosen)
    assert stored["name"] == "gauss" and stored["unit"] == "1000000000000.0 1/m^2" and stored["map"] == "blue_red"
    assert list(stored["high"]) == [shown.scale(frame).high for frame in range(3)]
    np.testing.assert_allclose(world.GetCustomDataByKey("times"), [0.1, 0.3, 0.5])


def test_colours_brighten_with_energy_in_equal_steps():
    """Perceptually uniform in the root: lightness L* increases along the map, with no step above twice the mean."""
    colours = Scale(COLOURS["energy_density"], 0.0, 1.0).rgb(np.linspace(0, 1, 33) ** 2)
    luminance = linear(colours) @ [0.2126, 0.7152, 0.0722]
    steps = np.diff(116 * np.cbrt(luminance) - 16)
    assert steps.min() > 0 and steps.max() < 2 * steps.mean()


def test_a_material_shows_the_colours(stage):
    from pxr import UsdShade

    binding = UsdShade.MaterialBindingAPI(curves_of(stage, "sensors").GetPrim())
    material, _ = binding.ComputeBoundMaterial()
    shader, _, _ = material.ComputeSurfaceSource()
    colour, _, _ = shader.GetInput("diffuseColor").GetConnectedSource()
    reader = UsdShade.Shader(colour.GetPrim())
    assert reader.GetIdAttr().Get() == "UsdPrimvarReader_float3"
    assert reader.GetInput("varname").Get() == "displayColor"


def test_camera_sees_everything_at_every_time(stage):
    from pxr import UsdGeom

    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).GetCamera(0)
    to_picture = np.array(camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix())
    seen = [np.array(UsdGeom.Mesh(stage.GetPrimAtPath("/World/Membrane")).GetPointsAttr().Get())]
    for frame in range(FRAMES):
        seen += [np.array(curves_of(stage, name).GetPointsAttr().Get(frame)) for name in ("sensors", "cell")]
    points = np.concatenate(seen)
    clip = np.c_[points, np.ones(len(points))] @ to_picture
    picture = np.abs(clip[:, :3] / clip[:, 3:])
    assert picture.max() < 1.0
    assert picture[:, :2].max() > 0.75  # and is not too far away


def test_lights(stage):
    lights = stage.GetPrimAtPath("/World/Lights").GetChildren()
    assert sorted(light.GetTypeName() for light in lights) == ["DistantLight", "DistantLight", "DomeLight"]


def test_membrane_mesh(stage):
    from pxr import UsdGeom

    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Membrane"))
    points = np.array(mesh.GetPointsAttr().Get())
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
    assert mesh.GetDoubleSidedAttr().Get()
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, rtol=0, atol=2e-7)
    np.testing.assert_allclose(np.array(mesh.GetNormalsAttr().Get()), points, rtol=0, atol=1e-6)
    assert not mesh.GetDisplayColorPrimvar().HasValue()  # the curvature of a sphere does not vary: it is grey
    assert len(mesh.GetFaceVertexIndicesAttr().Get()) == 3 * len(mesh.GetFaceVertexCountsAttr().Get())
    np.testing.assert_allclose(np.array(mesh.GetExtentAttr().Get()), [[-1] * 3, [1] * 3], rtol=0, atol=1e-3)


CLOSED = {
    "sphere": {"radius": 0.7},
    "ellipsoid": {"radii": [0.5, 1.0, 1.4]},
    "torus": {"major": 1.0, "minor": 0.3},
    "cassini": {"a": 1.0, "b": 1.1},
    "undulated": {},
}
HOLES = {"torus": 1}


@pytest.mark.parametrize("kind", CLOSED)
def test_closed_membranes_are_watertight(kind):
    """Each edge is shared by two triangles in opposite directions, and the Euler characteristic counts the holes."""
    surface = make(kind, CLOSED[kind])
    points, normals, triangles = triangulate(surface, cells=32)
    assert np.max(np.abs(surface.phi(points)) / np.linalg.norm(surface.gradient(points), axis=1)) < 1e-12
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    euler = len(np.unique(triangles)) - len(edges) // 2 + len(triangles)
    assert euler == 2 - 2 * HOLES.get(kind, 0)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    assert np.sum(a * np.cross(b, c)) > 0  # encloses a positive volume: faces outwards


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("plane", {"size": 4.0}),
        ("cylinder", {"radius": 0.5, "length": 3.0}),
        ("bridge", {"neck": 0.4, "body": 1.0, "width": 1.0}),
    ],
)
def test_open_membranes_end_at_their_box(kind, values):
    surface = make(kind, values)
    points, _, triangles = triangulate(surface, cells=32)
    low, high = surface.box
    assert len(triangles) > 500
    assert np.all(points >= low) and np.all(points <= high)
    end = 0 if kind == "plane" else 2
    assert points[:, end].min() == pytest.approx(low[end]) and points[:, end].max() == pytest.approx(high[end])


def test_width_is_the_steric_core_and_units_are_stored(tmp_path):
    from pxr import Usd, UsdGeom

    write_run(tmp_path, STERIC + MICRONS)
    stage = Usd.Stage.Open(str(export_usd(tmp_path)))
    assert list(curves_of(stage, "sensors").GetWidthsAttr().Get()) == pytest.approx([0.08])
    assert UsdGeom.GetStageMetersPerUnit(stage) == pytest.approx(1e-6)


def test_rods_without_a_core_are_slender(stage):
    assert list(curves_of(stage, "sensors").GetWidthsAttr().Get()) == pytest.approx([0.6 / 30], rel=1e-3)


def test_a_failed_rod_stays_at_its_last_position(tmp_path):
    from pxr import Usd

    write_run(tmp_path, fail_at=3)
    stage = Usd.Stage.Open(str(export_usd(tmp_path)))
    curves = curves_of(stage, "sensors")
    shown = [np.array(curves.GetPointsAttr().Get(frame)).reshape(4, 9, 3) for frame in range(FRAMES)]
    np.testing.assert_array_equal(shown[5][1], shown[2][1])
    assert not np.array_equal(shown[5][0], shown[2][0])
    assert np.isfinite(np.array(curves.GetExtentAttr().Get(5))).all()
    assert np.isfinite(np.array(curves.GetDisplayColorAttr().Get(5))).all()


def test_equal_trajectories_give_equal_bytes_and_no_temporary_files(run, tmp_path):
    first = (run / "animation.usdc").read_bytes()
    assert export_usd(run, tmp_path / "again.usdc") == tmp_path / "again.usdc"
    assert (tmp_path / "again.usdc").read_bytes() == first
    assert [path.name for path in tmp_path.iterdir()] == ["again.usdc"]


def test_a_file_that_cannot_be_written_is_told_with_the_reason(run, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(RunFolderError, match=r"file is a file: give another folder") as refused:
        export_usd(run, tmp_path / "file" / "animation.usdc")
    assert "\n" not in str(refused.value)


def test_runs_with_nothing_to_show(tmp_path):
    with pytest.raises(RunFolderError, match="no run"):
        export_usd(tmp_path)
    attributes = {"scene": scene_text()}
    TrajectoryWriter.create(tmp_path / STORE, {"cell": GroupSpec(2, 17, SWIMMER_VARIABLES)}, attributes)
    with pytest.raises(RunFolderError, match="no complete frame"):
        export_usd(tmp_path)
    assert not (tmp_path / "animation.usdc").exists()


def test_an_independent_reader_sees_the_same(run):
    """tinyusdz has no typed access to samples of curves, but prints what it has read."""
    tinyusdz = pytest.importorskip("tinyusdz")
    stage, data = tinyusdz.load(str(run / "animation.usdc")), open_run(run)
    metadata = [stage.get_metadata(key) for key in ("startTimeCode", "endTimeCode", "upAxis", "defaultPrim")]
    assert metadata == [0.0, FRAMES - 1.0, "Z", "World"]
    for name in ("sensors", "cell"):
        text = stage.get_prim_at_path(f"/World/Ensembles/{name}").to_string()
        samples = re.search(r"point3f\[\] points\.timeSamples = \{(.*?)\}", text, re.DOTALL).group(1)
        frames = dict(re.findall(r"(\d+): \[(.*?)\]", samples))
        assert list(map(int, frames)) == list(range(FRAMES))
        for number, points in frames.items():
            read = np.array(re.findall(r"[-+.\de]+", points), dtype=float).reshape(-1, 3)
            expected = data[name].position[int(number)].values.reshape(-1, 3)
            np.testing.assert_allclose(read, expected, rtol=1e-6, atol=1e-6)


IN_BLENDER = """
import sys, bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
scene, kinds = bpy.context.scene, sorted(o.type for o in bpy.data.objects)
counts = sorted((len(c.curves), len(c.points)) for c in bpy.data.hair_curves)
print("SAW", scene.frame_start, scene.frame_end, kinds.count("CAMERA"), kinds.count("MESH"), counts)
"""


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="Blender (bpy) is not installed")
def test_opens_in_blender(run):
    """In a separate process, as Blender has its own build of USD."""
    command = [sys.executable, "-c", IN_BLENDER, str(run / "animation.usdc")]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert f"SAW 0 {FRAMES - 1} 1 1 [(2, 34), (4, 36)]" in output


IN_ITS_SCRIPT = """
import runpy, sys
sys.argv = [sys.argv[1], "--", "--frame", "2"]
known = runpy.run_path(sys.argv[0], run_name="__main__")
import bpy
scene = bpy.context.scene
materials = sorted((o.name.split("_")[0], o.data.materials[0].name) for o in bpy.data.objects if o.type in ("CURVES", "MESH"))
print("SAW", scene.frame_start, scene.frame_end, scene.frame_current, scene.render.fps, scene.camera is not None)
print(materials)
"""  # noqa: E501


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="Blender (bpy) is not installed")
def test_the_script_for_blender_sets_materials_camera_and_frames(run):
    """In Blender 4.2 and 5, whose imports take other options; with a Python of its own, which may lack USD."""
    script = EXPORTERS["blender"].export(run)
    done = subprocess.run([sys.executable, "-c", IN_ITS_SCRIPT, str(script)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"SAW 0 {FRAMES - 1} 2 24 True" in done.stdout
    assert "('cell', 'Colours of the rods'), ('sensors', 'Colours of the rods')" in done.stdout
    assert "('Membrane', 'Membrane')" in done.stdout  # a sphere has one colour, that of the animation
