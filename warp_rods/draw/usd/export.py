"""The animation of a run in USD, made from its trajectory: membrane, rods, camera and lights.

Rods are linear BasisCurves through the nodes. Every reader draws these in the same way, and the points are the data. (A
cubic basis needs phantom ends or the "pinned" wrap, which readers treat differently, and its curves can leave the
extent.) One time code is one frame of the trajectory.

Blender (tested with 5.0) reads the colours of curves but binds no material to them: import with "All Materials" and
assign the material "Energy" to the rods. Where one unit is a micrometre, turn "Apply Unit Conversion Scale" off, as its
renderer loses objects of that size.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.draw.content import Content
from warp_rods.draw.selection import Selection
from warp_rods.draw.usd.box import draw_box
from warp_rods.draw.usd.camera import add_camera_and_lights
from warp_rods.draw.usd.curves import draw_rods
from warp_rods.draw.usd.load import draw_loads
from warp_rods.draw.usd.materials import add_materials
from warp_rods.draw.usd.membrane import draw_membrane

_FRAMES_PER_SECOND = 24


def export_usd(run_dir: str | Path, path: str | Path | None = None, selection: Selection | None = None) -> Path:
    """Write the animation of a run to ``path`` (default: animation.usdc in its folder); returns the path.

    Colour is elastic energy density unless the selection says otherwise. The file is written under a temporary name
    and then renamed. Raises RunFolderError where there is no run, no complete frame, or the file cannot be written.
    """
    from warp_rods.draw.exporters import EXPORTERS

    path = None if path is None else arguments.path("path", path)
    return EXPORTERS["usd"].export(Path(run_dir), path, selection)


def write_usd(shown: Content, path: Path) -> None:
    """Write the animation of what is shown to a file of USD."""
    _write(_new_stage(shown), path)


def size(shown: Content) -> float:
    """About how many bytes the animation will have: a node has a place and a colour at each frame."""
    return 1e5 + 24.0 * shown.frames * sum(rods.count * rods.nodes for rods in shown.rods)


def _write(stage: Any, path: Path) -> None:
    """Write the stage; raises OSError with the reason, such as a full disk, where that fails."""
    from pxr import Tf

    try:
        why = "" if stage.GetRootLayer().Export(str(path)) else "check that the folder exists and is writable"
    except Tf.ErrorException as failure:
        why = failure.args[0].commentary
    if why:
        raise OSError(why)


def _new_stage(shown: Content) -> Any:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(world)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, shown.metres)
    stage.SetTimeCodesPerSecond(_FRAMES_PER_SECOND)
    stage.SetFramesPerSecond(_FRAMES_PER_SECOND)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(shown.frames - 1)
    _describe(stage, world, shown)

    membrane_material, energy_material = add_materials(stage)
    in_view = []
    if shown.membrane:
        in_view.append(draw_membrane(stage, shown.membrane, shown.frames, membrane_material))
        draw_loads(stage, shown, float(np.ptp(in_view[0], axis=0).max()), energy_material)
    if len(edges := draw_box(stage, shown, membrane_material)):
        in_view.append(edges)
    for rods in shown.rods:
        box = draw_rods(stage, rods, shown, energy_material)
        in_view += [] if _is_in_view(box, in_view) else [_corners(box)]
    add_camera_and_lights(stage, np.concatenate(in_view))
    return stage


def _describe(stage: Any, world: Any, shown: Content) -> None:
    scale = shown.scale(0)
    stage.GetRootLayer().documentation = shown.title
    kept = {key: str(value) for key, value in shown.attributes.items() if key != "scene"}
    stage.GetRootLayer().customLayerData = {**kept, "creator": "warp-rods"}
    world.SetDisplayName(shown.title)
    colours = {"low": scale.low, "high": scale.high, "colourMap": scale.colour.map_name}
    world.SetCustomDataByKey("elasticEnergyDensity", colours)


def _is_in_view(box: np.ndarray, in_view: list[np.ndarray]) -> bool:
    """Whether points in view already enclose a box, to a tenth of its size, as a membrane encloses its rods."""
    if not in_view:
        return False
    points, slack = np.concatenate(in_view), 0.1 * (box[1] - box[0]).max()
    return bool(np.all(points.min(axis=0) - slack <= box[0]) and np.all(box[1] <= points.max(axis=0) + slack))


def _corners(box: np.ndarray) -> np.ndarray:
    return np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
