"""The animation of a long run in parts (value clips): a folder with animation.usdc, which plays one after the other.

A part holds so many frames that making it takes little memory, and viewers read only the part that they show.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.usd.export import Stage, size

__all__ = ["write_clips"]

PART = 64e6
"""Bytes of a part, about."""


def write_clips(shown: Content, path: Path, fps: float, tubes: bool, activity: bool) -> None:
    """Write the folder: animation.usdc, and the parts in parts/."""
    from pxr import Usd

    (path / "parts").mkdir(parents=True)
    each = max(1, int(PART / (size(shown, tubes, activity) / shown.frames)))
    starts, boxes, names = range(0, shown.frames, each), [], []
    for start in starts:
        part = Stage(shown, fps, tubes, activity)
        boxes.append(part.draw(range(start, min(start + each, shown.frames))))
        names.append(f"./parts/{start:07d}.usdc")
        part.write(path / names[-1])
    whole = Stage(shown, fps, tubes, activity)
    whole.draw(range(0))
    whole.finish(np.concatenate(boxes))
    whole.write(path / "animation.usdc")
    stage = Usd.Stage.Open(str(path / "animation.usdc"))
    clips = Usd.ClipsAPI(stage.GetPrimAtPath("/World"))
    clips.SetClipPrimPath("/World")
    clips.SetClipAssetPaths(names)
    clips.SetClipActive([(start, number) for number, start in enumerate(starts)])
    clips.SetClipTimes([(0, 0), (shown.frames - 1, shown.frames - 1)])
    manifest = clips.GenerateClipManifest()
    manifest.Export(str(path / "parts" / "manifest.usda"))
    clips.SetClipManifestAssetPath("./parts/manifest.usda")
    stage.GetRootLayer().Save()
