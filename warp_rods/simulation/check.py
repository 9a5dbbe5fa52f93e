"""Check a whole run folder for damage: every chunk, every file of metadata, checkpoint, scene and surfaces."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray as xr

from warp_rods.errors import RunFolderError
from warp_rods.rods.status import Status
from warp_rods.simulation.begun import KEPT
from warp_rods.simulation.checkpoint import CHECKPOINT, read_checkpoint
from warp_rods.simulation.document import FRAMES, METADATA, Document, moves
from warp_rods.simulation.files import digest
from warp_rods.simulation.kept_starts import KEPT_STARTS
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.run_folder import SCENE
from warp_rods.simulation.store import STORE

__all__ = ["check_run"]

FRAMES_AT_ONCE = 64


def check_run(path: str | Path) -> str:
    """Read everything in a run folder; returns a line about it.

    Raises RunFolderError with one line for each thing that is missing or damaged. Stores of earlier versions have no
    checksums, and the line says so. ``animation.usdc`` is not looked at: it can be made again.
    """
    path = Path(path)
    document = Document.read(path / STORE)
    data = open_run(path)
    faults = [*_data_faults(data), *_metadata_faults(document), *_folder_faults(path, document)]
    if faults:
        lines = "\n".join(f"  {line}" for line in faults)
        raise RunFolderError(f"{path}: {len(faults)} fault{'s' if len(faults) > 1 else ''}\n{lines}")
    files = sum(file.is_file() for file in (path / STORE).rglob("*"))
    sound = "no damage" if document.checked else "readable; this earlier version wrote no checksums"
    return (
        f"{path}: {document.frames} complete frames of {', '.join(document.groups)}, {files} files: {sound}"
        f"{_lost(data)}"
    )


def _lost(data: xr.DataTree) -> str:
    """How many rods of each ensemble the run has lost, where it has."""
    lost = {
        name: int((group["status"].isel(frame=-1) != Status.OK).sum())
        for name, group in data.children.items()
        if group.sizes.get("frame")
    }
    return "".join(f"; {number} of {name} were lost" for name, number in lost.items() if number)


def _data_faults(data: xr.DataTree) -> Iterator[str]:
    """The first damage of each variable."""
    for name, group in data.children.items():
        variables = group.to_dataset().variables
        for label, variable in variables.items():
            frames = variable.sizes.get("frame", 1)
            try:
                for first in range(0, frames, FRAMES_AT_ONCE):
                    part = slice(first, first + FRAMES_AT_ONCE)
                    _ = variable.isel(frame=part).values if "frame" in variable.dims else variable.values
            except RunFolderError as fault:
                yield str(fault)
            except Exception as fault:
                yield f"{name}/{label} cannot be read: {fault}"


def _metadata_faults(document: Document) -> Iterator[str]:
    """Metadata of groups and arrays that are not those of the root; the number of frames may lag behind."""
    for name, node in document.nodes.items() if document.checked else ():
        file = document.path / name / METADATA
        try:
            own = json.loads(file.read_bytes())
            own.pop("consolidated_metadata", None)
            same = _without_frames(own) == _without_frames(node)
        except (OSError, ValueError, AttributeError, KeyError, IndexError, TypeError):
            same = False
        if not same:
            yield (
                f"{file} is missing or damaged; warp-rods and xarray read the copy in {document.path.name}/{METADATA}, "
                f"other readers may need it"
            )


def _without_frames(node: dict[str, Any]) -> dict[str, Any]:
    return {**node, "shape": node["shape"][1:]} if moves(node) else node


def _folder_faults(path: Path, document: Document) -> Iterator[str]:
    """Faults of the other files of the folder."""
    text = document.attributes.get("scene", "")
    try:
        if (path / SCENE).read_text(encoding="utf-8") != text:
            yield f"{path / SCENE} is damaged or was edited: it is not the scene as run, which the trajectory holds"
    except (OSError, ValueError) as fault:
        yield f"{path / SCENE} cannot be read ({fault}); the trajectory holds the scene as run"
    for name, origin in document.attributes.get(KEPT, {}).items():
        if not (path / name).is_file() or digest(path / name) != origin["sha256"]:
            what = "the start of rods" if name == KEPT_STARTS else "the surface"
            yield f"{path / name} is missing or damaged: {what} from {origin['source']}, kept by the run"
    try:
        frame = int(read_checkpoint(path)["frame"])
        if frame >= document.attributes[FRAMES]:
            yield f"{path / CHECKPOINT} is at frame {frame}, beyond the last complete frame of the trajectory"
    except (RunFolderError, KeyError) as fault:
        yield str(fault)
