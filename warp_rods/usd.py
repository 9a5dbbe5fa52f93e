"""The animation of a run in USD, made from its trajectory: the membrane, the rods, a camera and lights.

Rods are linear BasisCurves through the nodes: every reader draws those alike, and the points are the data.
(A cubic basis needs phantom ends or the "pinned" wrap, which readers treat differently, and can leave the
extent.) One time code is one frame of the trajectory.

Blender (seen in 5.0) reads the colours of curves but binds no material to them: import with "All Materials"
and give the rods "Energy". Where a unit is a micrometre, turn "Apply Unit Conversion Scale" off: things that
small are lost in its renderer.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .errors import RunFolderError
from .membrane import triangulate
from .scene import Scene
from .surfaces import make
from .trajectory import open_run
from .usd_look import COLOUR_MAP, add_camera_and_lights, add_materials, energy_colours

_FRAMES_PER_SECOND = 24
_QUANTILES = (0.02, 0.98)
_SAMPLED_FRAMES = 100
_SECONDS_BEFORE_PROGRESS = 2.0


def export_usd(run_dir: str | Path, path: str | Path | None = None) -> Path:
    """Writes the animation of a run to ``path`` (default: animation.usdc in its folder); returns the path.

    Colour is elastic energy density, on one range for all rods and the whole run. The file is written to
    a temporary name first. Raises RunFolderError where there is no run, or none of its frames is complete.
    """
    run = open_run(run_dir)
    if not any(data.sizes["frame"] for data in run.children.values()):
        raise RunFolderError(f"{run_dir} has no complete frame yet: resume the run, or run the scene again.")
    path = Path(run_dir) / "animation.usdc" if path is None else Path(path)
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")
    stage = _new_stage(run, Scene.parse(run.attrs["scene"]))
    try:
        if not stage.GetRootLayer().Export(str(partial)):
            raise RunFolderError(f"{path} cannot be written.")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return path


def _new_stage(run: xr.DataTree, scene: Scene) -> Any:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(world)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, scene.units.metres if scene.units else 1.0)
    stage.SetTimeCodesPerSecond(_FRAMES_PER_SECOND)
    stage.SetFramesPerSecond(_FRAMES_PER_SECOND)
    ensembles = {name: child.to_dataset() for name, child in run.children.items()}
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(next(iter(ensembles.values())).sizes["frame"] - 1)
    low, high = _colour_range(ensembles)
    _describe(stage, world, run, {"low": low, "high": high, "colourMap": COLOUR_MAP})

    membrane_look, energy_look = add_materials(stage)
    in_view = []
    if scene.surface:
        in_view.append(_draw_membrane(stage, scene, membrane_look))
    for name, data in ensembles.items():
        box = _draw_rods(stage, name, data, _radius(scene, data), (low, high), energy_look)
        in_view += [] if _within(box, in_view) else [_corners(box)]
    add_camera_and_lights(stage, np.concatenate(in_view))
    return stage


def _describe(stage: Any, world: Any, run: xr.DataTree, colours: dict[str, Any]) -> None:
    title = str(run.attrs.get("title", ""))
    stage.GetRootLayer().documentation = title
    kept = {key: str(value) for key, value in run.attrs.items() if key != "scene"}
    stage.GetRootLayer().customLayerData = {**kept, "creator": "warp-rods"}
    world.SetDisplayName(title)
    world.SetCustomDataByKey("elasticEnergyDensity", colours)


def _colour_range(ensembles: dict[str, xr.Dataset]) -> tuple[float, float]:
    """Robust quantiles of the energy density over the whole run, from at most so many frames of it."""
    samples = []
    for data in ensembles.values():
        stride = -(-data.sizes["frame"] // _SAMPLED_FRAMES)
        samples.append(data.energy_density.isel(frame=slice(None, None, stride)).values.ravel())
    density = np.concatenate(samples)
    low, high = np.quantile(density[np.isfinite(density)], _QUANTILES)
    return float(low), float(high if high > low else low + 1.0)


def _radius(scene: Scene, data: xr.Dataset) -> float:
    """Half the steric core where there is one: so rods touch as drawn where they do. Else a slender rod."""
    if scene.steric:
        return scene.steric.core / 2
    steps = np.diff(data.position.isel(frame=0).values, axis=1)
    return float(np.linalg.norm(steps, axis=-1).sum(axis=1).mean() / 60)


def _draw_membrane(stage: Any, scene: Scene, look: Any) -> np.ndarray:
    """The mesh of the scene's surface; its points."""
    from pxr import UsdGeom, Vt

    assert scene.surface
    points, normals, triangles = triangulate(make(scene.surface.kind, scene.surface.parameters))
    mesh = UsdGeom.Mesh.Define(stage, "/World/Membrane")
    points = points.astype(np.float32)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.ravel().astype(np.int32)))
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
    _bind(mesh, look)
    return points.astype(float)


def _draw_rods(
    stage: Any, name: str, data: xr.Dataset, radius: float, colours: tuple[float, float], look: Any
) -> np.ndarray:
    """One ensemble as curves, every frame; returns the box [2, 3] that holds them all the time."""
    from pxr import Tf, UsdGeom, Vt

    curves = UsdGeom.BasisCurves.Define(stage, f"/World/Ensembles/{Tf.MakeValidIdentifier(name)}")
    curves.CreateTypeAttr(UsdGeom.Tokens.linear)
    curves.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    rods, nodes = data.sizes["rod"], data.sizes["node"]
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(rods, nodes, np.int32)))
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    shown, extent = curves.CreatePointsAttr(), curves.CreateExtentAttr()
    colour = curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    _bind(curves, look)
    boxes, points = [], np.zeros((rods, nodes, 3), np.float32)
    for frame in _with_progress(data.sizes["frame"], f"USD: {name}"):
        now = data.isel(frame=frame)
        position, density = now.position.values, now.energy_density.values
        sound = np.isfinite(position).all(axis=(1, 2), keepdims=True)
        points = np.where(sound, position, points).astype(np.float32)  # a failed rod stays where it was
        box = np.stack([points.min(axis=(0, 1)) - radius, points.max(axis=(0, 1)) + radius])
        shown.Set(Vt.Vec3fArray.FromNumpy(points.reshape(-1, 3)), frame)
        rgb = energy_colours(np.nan_to_num(density), *colours)
        colour.Set(Vt.Vec3fArray.FromNumpy(rgb.reshape(-1, 3)), frame)
        extent.Set(Vt.Vec3fArray.FromNumpy(box.astype(np.float32)), frame)
        boxes.append(box)
    return np.stack([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])


def _bind(prim: Any, look: Any) -> None:
    from pxr import UsdShade

    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(look)


def _within(box: np.ndarray, seen: list[np.ndarray]) -> bool:
    """Whether a box is in view already, to a tenth of its size: rods on a membrane need no room."""
    if not seen:
        return False
    points, slack = np.concatenate(seen), 0.1 * (box[1] - box[0]).max()
    return bool(np.all(points.min(axis=0) - slack <= box[0]) and np.all(box[1] <= points.max(axis=0) + slack))


def _corners(box: np.ndarray) -> np.ndarray:
    return np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)


def _with_progress(count: int, label: str) -> Iterator[int]:
    """Counts, and shows a bar once it has taken long enough to wonder."""
    from rich.progress import Progress

    progress, started = Progress(transient=True), time.monotonic()
    task = progress.add_task(label, total=count)
    try:
        for item in range(count):
            yield item
            progress.advance(task)
            if time.monotonic() - started > _SECONDS_BEFORE_PROGRESS:
                progress.start()
    finally:
        progress.stop()
