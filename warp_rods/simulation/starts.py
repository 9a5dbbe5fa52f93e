"""Shapes of rods at the start that files have: measured centre lines, a frame of a run, or a start that was kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from warp_rods.centrelines.track import TrackError
from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.shapes import KEPT
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.kept_starts import from_kept
from warp_rods.simulation.measured_starts import from_points, sources_of_points
from warp_rods.simulation.run_starts import from_run
from warp_rods.simulation.start_arrays import Given, Source

__all__ = ["READ", "kept_path", "read_start", "sources_of"]

Table = SwimmersTable | FilamentsTable
READ: dict[str, Callable[[Table, Scene, Surface | None], Given]] = {"points": from_points, "run": from_run}
"""Kinds of shape that are read from files, with the functions that read them."""


def read_start(table: Table, scene: Scene, surface: Surface | None) -> Given:
    """The rods of a table whose shape is from a file; raises SceneError naming the key in its table."""
    if (path := kept_path(table)) is None:
        assert table.shape is not None
        return READ[table.shape.kind](table, scene, surface)
    try:
        return from_kept(table, path)
    except TrackError as fault:
        assert table.shape is not None
        raise SceneError(f"shape.{table.shape.kind}: {path} {fault}") from None


def sources_of(table: Table, scene: Scene) -> tuple[Source, ...]:
    """Where the shape of a table is from, with hashes as they are now; raises SceneError where it cannot be read."""
    assert table.shape is not None
    if kept_path(table) is None and table.shape.points is not None:
        return sources_of_points(table)
    return read_start(table, scene, None).sources


def kept_path(table: Table) -> Path | None:
    """The path of the kept start that a table names, or None."""
    assert table.shape is not None
    path = table.shape.run if table.shape.run is not None else table.shape.points
    return Path(path) if isinstance(path, str) and Path(path).suffix == KEPT else None
