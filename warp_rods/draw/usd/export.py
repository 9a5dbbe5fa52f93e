"""The animation of a run in USD, made from its trajectory: the membrane, the rods, a camera and lights.

Rods are linear BasisCurves through the nodes: every reader draws those alike, and the points are the data.
(A cubic basis needs phantom ends or the "pinned" wrap, which readers treat differently, and can leave the
extent.) One time code is one frame of the trajectory.

Blender (seen in 5.0) reads the colours of curves but binds no material to them: import with "All Materials"
and give the rods "Energy". Where a unit is a micrometre, turn "Apply Unit Conversion Scale" off: things that
small are lost in its renderer.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.usd.box import draw_box, into_box
from warp_rods.draw.usd.curves import draw_rods, sampled
from warp_rods.draw.usd.load import draw_loads
from warp_rods.draw.usd.look import COLOUR_MAP, add_camera_and_lights, add_materials
from warp_rods.draw.usd.membrane import draw_membrane
from warp_rods.errors import RunFolderError
from warp_rods.membranes.surfaces import make
from warp_rods.scene.scene import Scene
from warp_rods.simulation.trajectory import open_run

_FRAMES_PER_SECOND = 24
_QUANTILES = (0.02, 0.98)


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
        surface = make(scene.surface.kind, scene.surface.parameters)
        times = next(iter(ensembles.values())).time.values
        in_view.append(draw_membrane(stage, surface, times, membrane_look))
        draw_loads(stage, ensembles, float(np.ptp(in_view[0], axis=0).max()), energy_look)
    if scene.box and len(edges := draw_box(stage, scene, membrane_look)):
        in_view.append(edges)
    seen = partial(into_box, period=np.array(scene.period))
    for name, data in ensembles.items():
        box = draw_rods(stage, name, data, _radius(scene, data), (low, high), energy_look, seen)
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
    """Robust quantiles of the energy density over the whole run."""
    density = np.concatenate([sampled(data.energy_density).values.ravel() for data in ensembles.values()])
    low, high = np.quantile(density[np.isfinite(density)], _QUANTILES)
    return float(low), float(high if high > low else low + 1.0)


def _radius(scene: Scene, data: xr.Dataset) -> float:
    """Half the steric core where there is one: so rods touch as drawn where they do. Else a slender rod."""
    if scene.steric:
        return scene.steric.core / 2
    steps = np.diff(data.position.isel(frame=-1).values, axis=1)  # a growing one is longest at the end
    return float(np.nanmean(np.linalg.norm(steps, axis=-1).sum(axis=1)) / 60)  # of those that did not fail


def _within(box: np.ndarray, seen: list[np.ndarray]) -> bool:
    """Whether a box is in view already, to a tenth of its size: rods on a membrane need no room."""
    if not seen:
        return False
    points, slack = np.concatenate(seen), 0.1 * (box[1] - box[0]).max()
    return bool(np.all(points.min(axis=0) - slack <= box[0]) and np.all(box[1] <= points.max(axis=0) + slack))


def _corners(box: np.ndarray) -> np.ndarray:
    return np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
