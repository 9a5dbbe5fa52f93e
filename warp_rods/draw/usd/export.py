"""The animation of a run in USD, made from its trajectory: membrane, rods, camera and lights.

Rods are linear BasisCurves through the nodes. Every reader draws these in the same way, and the points are the data. (A
cubic basis needs phantom ends or the "pinned" wrap, which readers treat differently, and its curves can leave the
extent.) For viewers that draw no curves they can be tubes instead. One time code is one frame of the trajectory.

Blender reads the colours of curves but binds no material to them, and has no world: the script of ``blender.py`` opens
the animation with both.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.draw.content import Content
from warp_rods.draw.selection import Selection
from warp_rods.draw.usd.box import draw_box
from warp_rods.draw.usd.cables import describe_cables
from warp_rods.draw.usd.camera import add_camera_and_lights
from warp_rods.draw.usd.curves import draw_rods
from warp_rods.draw.usd.load import ACTIVITY, LOADS, draw_forces
from warp_rods.draw.usd.materials import MEMBRANE_OPACITY, add_materials
from warp_rods.draw.usd.membrane import draw_membrane
from warp_rods.draw.usd.tubes import SIDES, draw_tubes
from warp_rods.draw.view import fixed_corners, view_of

__all__ = ["Stage", "export_usd", "size", "write_usd", "write_usdz"]


def export_usd(run_dir: str | Path, path: str | Path | None = None, selection: Selection | None = None) -> Path:
    """Write the animation of a run to ``path`` (default: animation.usdc in its folder); returns the path.

    path: a file with the suffix .usdc, .usd or .usda, or a folder for animation.usdc. Colour is elastic energy density,
    where the run has it, unless the selection says otherwise. The file is written under a temporary name and then
    renamed. Raises RunFolderError where there is no run, no complete frame, or the file cannot be written; SceneError
    for another path.
    """
    from warp_rods.draw.exporters import EXPORTERS

    path = None if path is None else arguments.path("path", path)
    return EXPORTERS["usd"].export(Path(run_dir), path, selection)


def write_usd(shown: Content, path: Path, fps: float = 24.0, tubes: bool = False, activity: bool = False) -> None:
    """Write the animation of what is shown to a file of USD."""
    stage = Stage(shown, fps, tubes, activity)
    stage.draw(range(shown.frames))
    stage.finish()
    if not tubes:  # a default value would hide the values in parts of a long run, which have none therefore
        describe_cables(stage.stage, shown)
    stage.write(path)


def write_usdz(shown: Content, path: Path, fps: float, activity: bool) -> None:
    """Write a package of USD, with tubes, as viewers of packages draw no curves."""
    from pxr import UsdUtils

    inner = path.with_suffix(".usdc")
    try:
        write_usd(shown, inner, fps, True, activity)
        if not UsdUtils.CreateNewUsdzPackage(str(inner), str(path), "animation.usdc"):
            raise OSError("the package cannot be made")
    finally:
        inner.unlink(missing_ok=True)


def size(shown: Content, tubes: bool = False, activity: bool = False) -> float:
    """About how many bytes the animation has: a node, or each point of a tube there, has a place and a colour."""
    nodes = sum(rods.count * rods.nodes for rods in shown.rods)
    of_node = 36.0 * SIDES if tubes else 24.0 + 30.0 * (shown.membrane is not None) + 16.0 * activity
    of_sheet = 1.7e6 if shown.membrane or shown.container else 0.0
    moving = shown.membrane is not None and shown.membrane.moving
    return 2e4 + of_node * nodes * shown.frames + of_sheet * (0.25 * shown.frames if moving else 1.0)


class Stage:
    """A stage of USD: ``draw`` what it has at some frames, ``finish`` with what it has at all, then ``write``."""

    def __init__(self, shown: Content, fps: float, tubes: bool, activity: bool) -> None:
        from pxr import Usd, UsdGeom

        self.shown, self._tubes, self._activity = shown, tubes, activity
        self.stage = stage = Usd.Stage.CreateInMemory()
        world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        stage.SetDefaultPrim(world)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, shown.metres)
        stage.SetTimeCodesPerSecond(fps)
        stage.SetFramesPerSecond(fps)
        stage.SetStartTimeCode(0)
        stage.SetEndTimeCode(shown.frames - 1)
        _describe(stage, world, shown)
        self._membrane, self._energy = add_materials(stage)
        self._boxes: list[np.ndarray] = []

    def draw(self, frames: range) -> np.ndarray:
        """Draw rods and forces, and a membrane, at these frames; returns the boxes [n, 2, 3] of the rods."""
        stage, shown = self.stage, self.shown
        draw = draw_tubes if self._tubes else draw_rods
        boxes = [draw(stage, rods, shown, frames, self._energy) for rods in shown.rods]
        if shown.membrane:
            size = shown.membrane.size
            draw_membrane(stage, shown.membrane, frames, self._membrane, opacity=MEMBRANE_OPACITY)
            draw_forces(stage, shown, LOADS, frames, size, self._energy)
        if self._activity:
            length = max(float(rods.data["length"].max()) if "length" in rods.data else 1.0 for rods in shown.rods)
            draw_forces(stage, shown, (ACTIVITY,), frames, 2 * length, self._energy)
        self._boxes += boxes
        return np.concatenate(boxes)

    def finish(self, boxes: np.ndarray | None = None) -> None:
        """Draw the box, and add lights and a camera that sees rods in ``boxes`` (default: all that were drawn)."""
        draw_box(self.stage, self.shown, self._membrane)
        boxes = np.concatenate(self._boxes) if boxes is None else boxes
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        view, every = view_of(self.shown), self.shown.sample()
        if not view.follows:
            fixed = fixed_corners(self.shown, low, high, every)
            rods = [] if _enclosed(low, high, fixed) else [_corners(np.stack([low, high]))]
            add_camera_and_lights(self.stage, view, np.concatenate([*rods, fixed]))
            return
        path = np.array([view.at(self.shown, frame).centre for frame in range(self.shown.frames)])
        half = np.max(np.ptp(boxes, axis=1), axis=0) / 2
        add_camera_and_lights(self.stage, view, _corners(np.stack([-half, half])), path)

    def write(self, path: Path) -> None:
        """Write the stage; raises OSError with the reason, such as a full disk, where that fails."""
        from pxr import Tf

        try:
            why = "" if self.stage.GetRootLayer().Export(str(path)) else "check that the folder exists and is writable"
        except Tf.ErrorException as failure:
            why = failure.args[0].commentary
        if why:
            raise OSError(why)


def _describe(stage: Any, world: Any, shown: Content) -> None:
    """Title and attributes of the run; the colours and the times of the frames as custom data of the world."""
    from pxr import Vt

    stage.GetRootLayer().documentation = shown.title
    kept = {key: str(value) for key, value in shown.attributes.items() if key != "scene"}
    stage.GetRootLayer().customLayerData = {**kept, "creator": "warp-rods"}
    world.SetDisplayName(shown.title)
    for key, value in _colour(shown).items():
        world.SetCustomDataByKey(f"colour:{key}", value)
    world.SetCustomDataByKey("times", Vt.DoubleArray.FromNumpy(shown.times))


def _colour(shown: Content) -> dict[str, Any]:
    """What the colours of the rods mean; ``low`` and ``high`` have a value for each frame where ranges differ."""
    from pxr import Vt

    colour, each = shown.colour, shown.selection.span == "frame"
    scales = [shown.scale(frame) for frame in (range(shown.frames) if each else [0])]
    ends = {end: np.array([getattr(scale, end) for scale in scales]) for end in ("low", "high")}
    words = {"name": shown.selection.colour, "label": colour.label, "unit": shown.in_si(colour.unit)}
    limits = {end: Vt.DoubleArray.FromNumpy(of) if each else float(of[0]) for end, of in ends.items()}
    return words | limits | {"map": colour.map_name, "quadratic": colour.quadratic}


def _enclosed(low: np.ndarray, high: np.ndarray, points: np.ndarray) -> bool:
    """Whether points [n, 3] enclose a box to a tenth of its size, as a membrane encloses its rods."""
    slack = 0.1 * (high - low).max()
    return bool(
        len(points) and np.all(points.min(axis=0) - slack <= low) and np.all(high <= points.max(axis=0) + slack)
    )


def _corners(box: np.ndarray) -> np.ndarray:
    return np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
