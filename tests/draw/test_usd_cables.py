"""Rods in the animation as cables of a simulator: thickness, stiffness and natural shape, read by Newton."""

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.draw.usd.export import export_usd

TIME = {"end": 0.02, "save_every": 0.01}
SPRING = {"name": "spring", "count": 2, "nodes": 33, "natural": [9.0, 24.0, 0.0, 1.0, 0.0, 0.0],
          "placement": {"position": [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]}}  # fmt: skip
CELL = {"name": "cell", "count": 1, "nodes": 17, "bend": 5e-3, "twist": 1e-3, "natural_bend": 2.0,
        "placement": {"position": [[3.0, 0.0, 0.0]]}}  # fmt: skip


@pytest.fixture(scope="module")
def animation(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    scene = {"cosserat": [SPRING | {"stiffness": [0.1, 0.1, 0.1, 10.0, 10.0, 10.0]}], "swimmers": [CELL], "time": TIME}
    wr.run(wr.Scene.parse(scene), folder, device="cpu", overwrite=True)
    return export_usd(folder)


def helix(strain: list[float], nodes: int) -> np.ndarray:
    """The curve of a constant strain from the origin along x, of length 1 [node, 3]."""
    s, w = np.linspace(0.0, 1.0, nodes), np.array(strain)
    rate = np.linalg.norm(w)
    axis, x = w / rate, np.array([1.0, 0.0, 0.0])
    along = axis * (axis @ x)
    sine, cosine = np.sin(rate * s) / rate, (1 - np.cos(rate * s)) / rate
    return s[:, None] * along + sine[:, None] * (x - along) + cosine[:, None] * np.cross(axis, x)


def test_rods_have_their_natural_shape_and_stiffness(animation):
    from pxr import Usd, UsdGeom, UsdShade

    stage = Usd.Stage.Open(str(animation))
    spring, cell = (stage.GetPrimAtPath(f"/World/Ensembles/{name}") for name in ("spring", "cell"))
    assert "PhysicsCurvesDeformableSimAPI" in spring.GetPrimTypeInfo().GetAppliedAPISchemas()
    natural = np.array(spring.GetAttribute("physics:restShapePoints").Get()).reshape(2, 33, 3)
    np.testing.assert_allclose(natural[1], helix([9.0, 24.0, 0.0], 33), atol=1e-6)
    natural = np.array(cell.GetAttribute("physics:restShapePoints").Get())
    np.testing.assert_allclose(natural, helix([0.0, 0.0, 2.0], 17), atol=1e-6)
    bound = UsdShade.MaterialBindingAPI(spring).ComputeBoundMaterial(materialPurpose="physics")[0].GetPrim()
    values = {name: bound.GetAttribute(f"physics:curves{name}Stiffness").Get() for name in ("Bend", "Twist", "Stretch")}
    assert values == pytest.approx({"Bend": 0.1, "Twist": 0.1, "Stretch": 10.0})
    points = UsdGeom.BasisCurves(spring).GetPointsAttr()
    np.testing.assert_array_equal(points.Get(), points.Get(0))  # the default value is the first frame
    assert not np.array_equal(points.Get(), points.Get(2))


def test_newton_imports_them(animation):
    newton = pytest.importorskip("newton", reason="Newton is not installed")
    builder = newton.ModelBuilder()
    builder.add_usd(str(animation))
    model = builder.finalize("cpu")
    assert model.body_count == 2 * 32 + 16
