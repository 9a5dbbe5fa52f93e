"""The animation of a run in USD, made from its trajectory: membrane, rods, camera and lights.

Rods are linear BasisCurves through the nodes. Every reader draws these in the same way, and the points are the data. (A
cubic basis needs phantom ends or the "pinned" wrap, which readers treat differently, and its curves can leave the
extent.) One time code is one frame of the trajectory.

Blender (tested with 5.0) reads the colours of curves but binds no material to them: import with "All Materials" and
assign the material "Energy" to the rods. Where one unit is a micrometre, turn "Apply Unit Conversion Scale" off, as its
renderer loses objects of that size.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from warp_rods import arguments
from warp_rods.draw.usd.box import draw_box, into_box
from warp_rods.draw.usd.camera import add_camera_and_lights
from warp_rods.draw.usd.curves import draw_rods, sampled
from warp_rods.draw.usd.load import draw_loads
from warp_rods.draw.usd.materials import COLOUR_MAP, add_materials
from warp_rods.draw.usd.membrane import draw_membrane
from warp_rods.errors import RunFolderError
from warp_rods.membranes.surfaces import make
from warp_rods.scene.scene import Scene
from warp_rods.simulation.leftovers import remove_partial
from warp_rods.simulation.reading import open_run

_FRAMES_PER_SECOND = 24
_QUANTILES = (0.02, 0.98)
"""Quantiles of the energy density at both ends of the colour map."""
_SLENDERNESS = 60
"""Length over radius of rods that are drawn without a steric core."""


def export_usd(run_dir: str | Path, path: str | Path | None = None) -> Path:
    """Write the animation of a run to ``path`` (default: animation.usdc in its folder); returns the path.

    Colour is elastic energy density, with one range for all rods and the whole run. The file is written under a
    temporary name and then renamed. Raises RunFolderError where there is no run, or no complete frame.
    """
    run = open_run(run_dir)
    if not any(data.sizes["frame"] for data in run.children.values()):
        raise RunFolderError(f"{run_dir} has no complete frame: resume the run, or run the scene again.")
    if lacking := [name for name, data in run.children.items() if "energy_density" not in data]:
        raise RunFolderError(
            f"{run_dir}: the trajectory of {', '.join(lacking)} has no energy_density, which the colours of the rods "
            f"show: run the scene with it among output.variables."
        )
    path = Path(run_dir) / "animation.usdc" if path is None else arguments.path("path", path)
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    remove_partial(path)  # of an export that was killed
    stage = _new_stage(run, Scene.parse(run.attrs["scene"]))
    try:
        _write(stage, temporary, path)
        temporary.replace(path)
    finally:
        remove_partial(path)
    return path


def _write(stage: Any, temporary: Path, path: Path) -> None:
    """Write the stage; raises RunFolderError with the reason, such as a full disk, where that fails."""
    from pxr import Tf

    try:
        why = "" if stage.GetRootLayer().Export(str(temporary)) else "check that the folder exists and is writable"
    except Tf.ErrorException as failure:
        why = failure.args[0].commentary
    if why:
        raise RunFolderError(f"{path} cannot be written: {why}.")


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

    membrane_material, energy_material = add_materials(stage)
    in_view = []
    if scene.surface:
        surface = make(scene.surface.kind, scene.surface.parameters)
        times = next(iter(ensembles.values())).time.values
        in_view.append(draw_membrane(stage, surface, times, membrane_material))
        draw_loads(stage, ensembles, float(np.ptp(in_view[0], axis=0).max()), energy_material)
    if scene.box and len(edges := draw_box(stage, scene, membrane_material)):
        in_view.append(edges)
    displayed = partial(into_box, period=np.array(scene.period))
    for name, data in ensembles.items():
        box = draw_rods(stage, name, data, _radius(scene, data), (low, high), energy_material, displayed)
        in_view += [] if _is_in_view(box, in_view) else [_corners(box)]
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
    """The energy densities at both ends of the colour map, for the whole run."""
    density = np.concatenate([sampled(data.energy_density).values.ravel() for data in ensembles.values()])
    low, high = np.quantile(density[np.isfinite(density)], _QUANTILES)
    return float(low), float(high if high > low else low + 1.0)


def _radius(scene: Scene, data: xr.Dataset) -> float:
    """Half the steric core where there is one, so that rods in contact touch as drawn; else that of a slender rod."""
    if scene.steric:
        return scene.steric.core / 2
    steps = np.diff(data.position.isel(frame=-1).values, axis=1)  # growing rods are longest at the end
    return float(np.nanmean(np.linalg.norm(steps, axis=-1).sum(axis=1)) / _SLENDERNESS)  # without failed rods


def _is_in_view(box: np.ndarray, in_view: list[np.ndarray]) -> bool:
    """Whether points in view already enclose a box, to a tenth of its size, as a membrane encloses its rods."""
    if not in_view:
        return False
    points, slack = np.concatenate(in_view), 0.1 * (box[1] - box[0]).max()
    return bool(np.all(points.min(axis=0) - slack <= box[0]) and np.all(box[1] <= points.max(axis=0) + slack))


def _corners(box: np.ndarray) -> np.ndarray:
    return np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
