"""What ``warp-rods`` alone says: what one can do next, here."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

__all__ = ["front_page"]

FIRST = "swimmer"
"""The scene to begin with: the shortest."""


def front_page(folder: Path) -> list[tuple[str, str]]:
    """Commands to go on with in a folder, each with what it does; those that concern the runs in it first."""
    return [*_of_runs(folder), *_of_scenes(folder), ("warp-rods --help", "all commands; --help after one explains it")]


def _of_runs(folder: Path) -> Iterator[tuple[str, str]]:
    runs = [path.parent for path in (folder / "runs").glob("*/trajectory.zarr")]
    if not runs:
        return
    last = max(runs, key=lambda run: run.stat().st_mtime).relative_to(folder)
    yield "warp-rods status", "how far the runs in runs/ are"
    yield f"warp-rods watch {last}", "a run while it runs"
    yield f"warp-rods plot {last}", "what can be drawn of it"
    yield f"warp-rods export {last}", "files for other programs"


def _of_scenes(folder: Path) -> Iterator[tuple[str, str]]:
    own = sorted(path for path in folder.glob("*.toml") if path.name != "pyproject.toml")
    if own:
        yield f"warp-rods check {own[0].name}", "read a scene, list its faults, tell what a run needs"
        yield f"warp-rods run {own[0].name}", f"simulate it: results in runs/{own[0].stem}"
    yield "warp-rods scenes", "the scenes that come with the program"
    if not own and not (folder / "runs" / FIRST).exists():
        yield f"warp-rods run {FIRST}", f"simulate one of them: results in runs/{FIRST}"
    yield f"warp-rods scenes copy {FIRST}", "a copy to edit"
