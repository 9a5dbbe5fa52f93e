"""Curvatures of the membrane and the load on it in the animation."""

import re

import numpy as np
import pytest
from examples.drawn import freeze

from warp_rods.draw.content import content
from warp_rods.draw.picture import Painter
from warp_rods.draw.scale import linear
from warp_rods.draw.sheet import curvature_colours
from warp_rods.draw.usd.export import export_usd
from warp_rods.draw.view import view_of
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.trajectory import FILAMENT_VARIABLES, STORE, GroupSpec, TrajectoryWriter

FRAMES, RODS, NODES = 4, 3, 33
MAJOR, MINOR = 1.0, 0.4
SIZE = 2 * (MAJOR + MINOR)
FILAMENTS = """
[[filaments]]
name = "{name}"
count = 3
nodes = 33
length = 0.6
stiffness = [1.0, 1.0, 1.0]
drag = [1.0, 2.0, 0.1]
"""
SCENE = f"""
[surface]
kind = "torus"
major = {MAJOR}
minor = {MINOR}
[time]
end = 1.0
""" + "".join(FILAMENTS.format(name=name) for name in ("idle", "pushing", "pulling"))


def write_run(folder, fail_at: int | None = None) -> None:
    """Three ensembles with random positions: one without load, one with ten times the load of the other."""
    rng = np.random.default_rng(3)
    groups = {name: GroupSpec(RODS, NODES, FILAMENT_VARIABLES) for name in ("idle", "pushing", "pulling")}
    writer = TrajectoryWriter.create(folder / STORE, groups, {"scene": SCENE})
    before: dict = {}
    for number in range(FRAMES):
        saved = {}
        for name, load in (("idle", 0.0), ("pushing", 1.0), ("pulling", 10.0)):
            spec = groups[name]
            saved[name] = {label: np.zeros(spec.shape(v)) for label, v in spec.variables.items()}
            saved[name]["length"][:] = 1.0
            saved[name]["position"] = rng.normal(size=(RODS, NODES, 3))
            saved[name]["load"] = load * rng.normal(size=(RODS, NODES, 3))
            if name == "pulling":
                saved[name]["end_load"] = 3.0 + np.arange(6.0 * RODS).reshape(RODS, 2, 3) + number
            if fail_at is not None and number >= fail_at:
                freeze(saved[name], before[name], 1)
        writer.append(0.1 * number, saved)
        before = saved
    writer.close()


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


def arrows_of(stage, name):
    """Curves of the load of one ensemble, and their points [frame, arrow, 4, 3]."""
    from pxr import UsdGeom

    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath(f"/World/Loads/{name}_load"))
    points = [np.array(curves.GetPointsAttr().Get(frame)).reshape(-1, 4, 3) for frame in range(FRAMES)]
    return curves, np.stack(points)


def test_mesh_has_its_curvatures(stage):
    """Principal curvatures of the torus: −1/r and −cos θ/(R + r cos θ)."""
    from pxr import UsdGeom

    mesh = stage.GetPrimAtPath("/World/Membrane")
    points = np.array(UsdGeom.Mesh(mesh).GetPointsAttr().Get())
    rho = np.hypot(points[:, 0], points[:, 1])
    around, along = np.full(len(points), -1 / MINOR), -(rho - MAJOR) / MINOR / rho
    exact = {
        "principalCurvatures": np.stack([around, along], axis=-1),
        "gaussianCurvature": around * along,
        "meanCurvature": (around + along) / 2,
    }
    for name, values in exact.items():
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name)
        assert primvar.GetInterpolation() == "vertex"
        assert primvar.GetTypeName() == ("float2[]" if values.ndim == 2 else "float[]")
        assert "1/length" in primvar.GetAttr().GetDocumentation()
        np.testing.assert_allclose(np.array(primvar.Get()), values, rtol=0, atol=1e-5)


def test_mesh_has_the_colours_of_the_poster(run, stage):
    """Red outside of the torus, blue inside; with the opacity of its material, which reads the colours."""
    from pxr import UsdGeom, UsdShade

    shown, mesh = content(run), UsdGeom.Mesh(stage.GetPrimAtPath("/World/Membrane"))
    colour, opacity = mesh.GetDisplayColorPrimvar(), mesh.GetDisplayOpacityPrimvar()
    assert (colour.GetInterpolation(), opacity.GetInterpolation()) == ("vertex", "constant")
    rgb, points = np.array(colour.Get()), np.array(mesh.GetPointsAttr().Get())
    largest = Painter(shown, view_of(shown), 60, 40).curvature
    expected = linear(curvature_colours(np.clip(shown.membrane.curvatures(0).gaussian / largest, -1, 1)))
    np.testing.assert_allclose(rgb, expected, atol=1e-6)
    outside = np.hypot(points[:, 0], points[:, 1]) > MAJOR + 0.1
    assert (rgb[outside, 0] > rgb[outside, 2]).all()
    material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()
    shader, _, _ = material.ComputeSurfaceSource()
    source, _, _ = shader.GetInput("diffuseColor").GetConnectedSource()
    assert UsdShade.Shader(source.GetPrim()).GetInput("varname").Get() == "displayColor"
    assert list(opacity.Get()) == [pytest.approx(shader.GetInput("opacity").Get())]
    assert mesh.GetPrim().GetCustomDataByKey("colour")["high"] == pytest.approx(largest)


def test_arrows_show_all_loads_on_one_scale(run, stage):
    data = open_run(run)
    loads = {name: data[name]["load"].values for name in ("pushing", "pulling")}
    sizes = np.concatenate([np.linalg.norm(load, axis=-1).ravel() for load in loads.values()])
    factor = 0.08 * SIZE / np.quantile(sizes, 0.95)
    nodes = [0, 8, 16, 24, 32]
    for name, load in loads.items():
        curves, points = arrows_of(stage, name)
        assert curves.GetPrim().GetCustomDataByKey("lengthPerLoad") == pytest.approx(factor, rel=1e-3)
        base = data[name].position.values[:, :, nodes].reshape(FRAMES, -1, 3)
        arrow = factor * load[:, :, nodes].reshape(FRAMES, -1, 3)
        np.testing.assert_allclose(points[:, :, 0], base, rtol=0, atol=1e-6)
        np.testing.assert_allclose(points[:, :, 3] - points[:, :, 0], arrow, rtol=1e-3, atol=2e-6)
        np.testing.assert_allclose(points[:, :, 1] - points[:, :, 0], 0.7 * arrow, rtol=1e-3, atol=2e-6)


def test_no_arrows_without_load(stage):
    names = [prim.GetName() for prim in stage.GetPrimAtPath("/World/Loads").GetChildren()]
    assert sorted(names) == ["pulling_end_load", "pulling_load", "pushing_load"]


def test_forces_of_the_ends_are_drawn_at_the_ends_on_a_scale_of_their_own(run, stage):
    from pxr import UsdGeom

    data = open_run(run)["pulling"]
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/World/Loads/pulling_end_load"))
    factor = 0.08 * SIZE / np.quantile(np.linalg.norm(data.end_load, axis=-1), 0.95)
    assert curves.GetPrim().GetCustomDataByKey("lengthPerLoad") == pytest.approx(factor, rel=1e-6)
    assert "end sections" in curves.GetPrim().GetDocumentation() and curves.ComputePurpose() == "guide"
    for frame in range(FRAMES):
        points = np.array(curves.GetPointsAttr().Get(frame)).reshape(RODS, 2, 4, 3)
        np.testing.assert_allclose(points[:, :, 0], data.position[frame, :, [0, -1]], rtol=0, atol=1e-6)
        np.testing.assert_allclose(points[:, :, 3] - points[:, :, 0], factor * data.end_load[frame], rtol=0, atol=1e-6)


def test_arrows_are_guides_with_an_extent(stage):
    curves, points = arrows_of(stage, "pulling")
    assert curves.ComputePurpose() == "guide"
    assert curves.GetPointsAttr().GetTimeSamples() == list(range(FRAMES))
    assert list(curves.GetCurveVertexCountsAttr().Get()) == [4] * points.shape[1]
    assert curves.GetWidthsInterpolation() == "vertex"
    for frame in range(FRAMES):
        widths = np.array(curves.GetWidthsAttr().Get(frame)).reshape(-1, 4)
        np.testing.assert_allclose(widths[:, 2], 3 * widths[:, 0], rtol=1e-6)
        assert widths.shape == points.shape[1:3] and np.all(widths[:, 3] == 0)
        low, high = np.array(curves.GetExtentAttr().Get(frame))
        half = widths[:, :, None] / 2
        assert np.all(low <= (points[frame] - half).min(axis=(0, 1)) + 1e-6)
        assert np.all(high >= (points[frame] + half).max(axis=(0, 1)) - 1e-6)
        assert np.all(high - low < np.ptp(points[frame], axis=(0, 1)) + 0.2 * 0.08 * SIZE)


def test_every_validator_passes(stage):
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_a_lost_rod_has_no_arrows(tmp_path):
    from pxr import Usd

    write_run(tmp_path, fail_at=2)
    _, points = arrows_of(Usd.Stage.Open(str(export_usd(tmp_path))), "pushing")
    rods = points.reshape(FRAMES, RODS, -1, 4, 3)
    length = np.linalg.norm(rods[..., 0, :] - rods[..., -1, :], axis=-1)
    assert (length[2:, 1] == 0).all() and (length[:2] > 0).all() and (length[:, [0, 2]] > 0).all()


def test_an_independent_reader_sees_the_arrows(run, stage):
    tinyusdz = pytest.importorskip("tinyusdz")
    read = tinyusdz.load(str(run / "animation.usdc"))
    text = read.get_prim_at_path("/World/Loads/pushing_load").to_string()
    assert re.search(r'purpose = "guide"', text)
    samples = re.search(r"point3f\[\] points\.timeSamples = \{(.*?)\}", text, re.DOTALL).group(1)
    frames = dict(re.findall(r"(\d+): \[(.*?)\]", samples))
    _, points = arrows_of(stage, "pushing")
    assert list(map(int, frames)) == list(range(FRAMES))
    for number, listed in frames.items():
        seen = np.array(re.findall(r"[-+.\de]+", listed), dtype=float).reshape(-1, 4, 3)
        np.testing.assert_allclose(seen, points[int(number)], rtol=1e-6, atol=1e-6)
