"""Files that are replaced as a whole: whenever a process ends, the old content or the new one is there."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from warp_rods.errors import RunFolderError

__all__ = [
    "RUNS", "STUDY", "TRAJECTORIES", "TRAJECTORY", "beside", "check_writable", "default_folder", "digest",
    "nearest_existing", "no_run", "replace_file", "sync",
]  # fmt: skip

RUNS = Path("runs")
"""The folder of runs for which none is given."""
STUDY, TRAJECTORY = "study.zarr", "trajectory.zarr"
"""The results of a parameter study, and of a run, in its folder."""
TRAJECTORIES = "trajectories"
"""In the folder of a study the folders of runs of its points."""


def replace_file(
    path: Path, data: bytes | memoryview, partial: Path | None = None, *, durable: bool = False,
    before: Callable[[], None] = lambda: None,
) -> None:  # fmt: skip
    """Write ``data`` under the temporary name ``partial`` (default: beside the file) and rename it to ``path``.

    durable: also after a loss of power. before: called when only the name is left to be changed; if it raises, the old
    file stays. The folder of ``path`` must exist; otherwise raises OSError and leaves nothing.
    """
    partial = partial or path.with_name(f".{path.name}.partial")
    try:
        with partial.open("wb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        before()
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    if durable:
        sync(path.parent)


def beside(folder: Path, *stores: str) -> str:
    """A hint where the default folder of runs has what a folder lacks: " (did you mean runs/mine?)"; else empty."""
    inside = RUNS / folder
    there = not folder.is_absolute() and any((inside / store).exists() for store in stores)
    return f" (did you mean {inside}?)" if there else ""


def default_folder(scene: object) -> Path:
    """The folder of a run for which none is given: ``runs/NAME`` of a scene in NAME.toml."""
    return RUNS / (Path(scene).stem if isinstance(scene, (str, Path)) else "scene")


def no_run(folder: Path) -> str:
    """Why a folder in which there is no run cannot be looked at as one, and what to try."""
    if not (folder / STUDY).exists():
        hint = beside(folder, TRAJECTORY, STUDY)
        return f"There is no run in {folder}{hint}: give the folder that `warp-rods run SCENE --out DIR` wrote"
    kept = folder / TRAJECTORIES
    runs = f"; the runs of its points are in {kept}" if kept.is_dir() else ""
    return (
        f"{folder} holds a study, which is not one run: `warp-rods sweep SCENE --out {folder} --status` says how far "
        f'it is, `warp-rods plot {folder}` draws it, xarray.open_zarr("{folder / STUDY}") reads it{runs}'
    )


def nearest_existing(folder: Path) -> Path:
    """The folder, or the nearest of those around it that exists."""
    return next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())


def check_writable(folder: Path, key: str) -> None:
    """Raises RunFolderError naming ``key`` where ``folder`` cannot be made or written to; makes nothing."""
    there = nearest_existing(folder)
    if not there.is_dir():
        raise RunFolderError(f"{key} = {folder}: {there} is a file: give another folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise RunFolderError(f"{key} = {folder}: {there} cannot be written to: give another folder")


def sync(folder: Path) -> None:
    """Make renames in a folder last through a loss of power, where the system can."""
    if os.name == "posix":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def digest(path: Path) -> str:
    """SHA-256 (hex) of the content of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
