"""The box of swimmers in the animation: rods with their middles inside, edges, visible walls."""

import numpy as np
import pytest

from warp_rods import workflow
from warp_rods.draw.rods import into_box
from warp_rods.draw.room import edges_of, sides_of
from warp_rods.scene.scene import Scene

CELLS = {
    "name": "cells", "count": 4, "nodes": 17, "bend": 1e-2, "twist": 1e-3, "flagella": {"profile": "uniform"},
    "shape": {"kind": "straight"},
}  # fmt: skip
STERIC = {"strength": 100.0, "range": 0.02, "core": 0.08}
BOXES = {
    "periodic": {"kind": "periodic", "size": [1.5, 1.6, 1.7]},
    "slab": {"kind": "slab", "size": [1.5, 1.6], "height": 0.3},
    "container": {"kind": "container", "surface": {"kind": "sphere", "radius": 1.2}},
}


def stage_of(kind: str, folder):
    from pxr import Usd

    scene = Scene(swimmers=[CELLS], box=BOXES[kind], steric=STERIC, time={"end": 1.5, "save_every": 0.5, "step": 1e-3})
    run = workflow.run(scene, folder, device="cpu")
    return run.data["cells"].to_dataset(), Usd.Stage.Open(str(folder / "animation.usdc"))


@pytest.mark.parametrize("kind", ["periodic", "slab"])
def test_rods_are_drawn_in_their_periodic_box(kind, tmp_path):
    from pxr import UsdGeom

    data, stage = stage_of(kind, tmp_path / "run")
    size = np.array([1.5, 1.6, 1.7 if kind == "periodic" else np.inf])
    points = UsdGeom.BasisCurves.Get(stage, "/World/Ensembles/cells").GetPointsAttr()
    left = 0
    for frame in range(data.sizes["frame"]):
        drawn = np.array(points.Get(frame)).reshape(4, 17, 3)
        saved = data.position[frame].to_numpy()
        shift = (drawn - saved) / np.where(np.isfinite(size), size, 1)
        np.testing.assert_allclose(
            shift, np.rint(shift[:, :1]) + 0 * shift, atol=1e-5
        )  # whole periods, the same for all nodes of a rod
        assert (np.abs(drawn[:, 8]) <= size / 2 + 1e-6).all()
        left += np.abs(np.rint(shift)).sum()
    assert left > 0  # swimmers do leave the box: at speed 1 they cross it in 1.5
    edges = UsdGeom.BasisCurves.Get(stage, "/World/Box")
    corners = np.array(edges.GetPointsAttr().Get())
    assert len(edges.GetCurveVertexCountsAttr().Get()) == 12
    expected = [1.5, 1.6, 1.7 if kind == "periodic" else 0.3]
    np.testing.assert_allclose(np.ptp(corners, axis=0), expected, rtol=1e-6)


def test_the_container_is_drawn(tmp_path):
    from pxr import UsdGeom, UsdValidation

    _, stage = stage_of("container", tmp_path / "run")
    points = np.array(UsdGeom.Mesh.Get(stage, "/World/Container").GetPointsAttr().Get())
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.2, rtol=1e-6)
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert not context.Validate(stage)


@pytest.mark.parametrize("axis", "xyz")
def test_pores_and_ducts_are_drawn_along_their_axis(axis):
    """A pore as two circles and four lines, a duct as the edges of a box; an endless one not at all."""
    cells = {"name": "c", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
    pore = {"kind": "pore", "radius": 0.4, "length": 3.0, "axis": axis}
    duct = {"kind": "duct", "sides": [0.6, 0.9], "length": 3.0, "axis": axis, "ends": "closed"}
    for box, sides, lines in ((pore, [3.0, 0.8, 0.8], 100), (duct, [3.0, 0.6, 0.9], 12)):
        scene = Scene(swimmers=[cells], box=box, time={"end": 1.0})
        edges = edges_of(scene)
        assert edges.shape == (lines, 2, 3)
        points = edges.reshape(-1, 3)
        np.testing.assert_allclose(np.ptp(points, axis=0), np.roll(sides, "xyz".index(axis)))
        np.testing.assert_allclose(sides_of(scene), np.roll(sides, "xyz".index(axis)))
        if box is pore:
            radii = np.delete(points, "xyz".index(axis), axis=1)
            np.testing.assert_allclose(np.linalg.norm(radii, axis=1), 0.4)
    endless = Scene(swimmers=[cells], box={"kind": "duct", "sides": [0.6, 0.9]}, time={"end": 1.0})
    assert sides_of(endless) is None and not len(edges_of(endless))


def test_into_box_keeps_rods_whole():
    rods = np.array([[[0.9, 0, 0], [1.1, 0, 0], [1.3, 0, 7]], [[-2.9, 0, 0], [-3.2, 0, 0], [-3.4, 0, 0]]])
    inside = into_box(rods, np.array([2.0, 0.0, 0.0]))
    np.testing.assert_allclose(inside[0, :, 0], [-1.1, -0.9, -0.7], atol=1e-15)
    np.testing.assert_allclose(inside[1, :, 0], [1.1, 0.8, 0.6], atol=1e-15)
    assert inside[0, 2, 2] == 7
