"""The file of a run folder from which a run is continued: the whole state of a simulation."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from warp_rods.archive import read_archive
from warp_rods.errors import RunFolderError
from warp_rods.simulation.files import replace_file

__all__ = ["CHECKPOINT", "FORMAT", "State", "read_checkpoint", "write_checkpoint"]

CHECKPOINT = "checkpoint.npz"
FORMAT = 4
"""Which arrays make up a state, and which variables its trajectory has."""

State = dict[str, np.ndarray]


def write_checkpoint(path: Path, state: State) -> None:
    """Replace the checkpoint in a folder as a whole; raises OSError."""
    buffer = io.BytesIO()
    np.savez(buffer, format=np.array(FORMAT), **state)  # type: ignore[arg-type]
    replace_file(path / CHECKPOINT, buffer.getbuffer(), durable=True)


def read_checkpoint(path: Path) -> State:
    """The last checkpoint in a folder; raises RunFolderError where there is none, or it is damaged."""
    file = path / CHECKPOINT
    if not file.is_file():
        raise RunFolderError(f"{path} has no {CHECKPOINT} to continue from: run the scene again with --overwrite")
    try:
        state = read_archive(file)
        version = int(state.pop("format", 1))
    except (ValueError, TypeError) as fault:
        raise RunFolderError(f"{file} is damaged ({fault}): run the scene again with --overwrite") from None
    if version != FORMAT:
        raise RunFolderError(f"{file} is of another version of warp-rods: run the scene again with --overwrite")
    return state
