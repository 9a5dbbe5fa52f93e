"""Shipped scenes end to end: CPU time, steps, and error against a run of a tighter tolerance."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import warp_rods
from warp_rods.bench import end_to_end
from warp_rods.bench.end_to_end import Ended
from warp_rods.bench.machine import commit_of
from warp_rods.bench.result import Cell, Section, Settings, Table

REPEATS, LONG = 3, 20.0
"""Runs that take longer than this many seconds are measured once, others so often, in turns."""
SAME_START = 1e-6
BRIEF = 1e-3
"""The end of the run whose time is that of the start."""


@dataclass(frozen=True)
class Part:
    """A scene, the time at which it is ended early, if it is, and the tolerance of the run that counts as exact."""

    scene: str
    tight: float
    end: float | None = None


FULL = (Part("proteins", 1e-3), Part("swarm_2d", 0.02, end=0.3))
QUICK = (Part("proteins", 5e-3, end=0.05),)


def run(settings: Settings) -> Section:
    """A table for each scene."""
    folder, parts = end_to_end.scenes_folder(), QUICK if settings.quick else FULL
    if folder is None:
        return Section([], {}, ["left out: there is no folder scenes/ here; run it in a clone of the project"])
    with tempfile.TemporaryDirectory() as temporary:
        packages = {"ours": Path(warp_rods.__file__).parents[1]}
        scenes = {"ours": folder}
        if settings.against is not None:
            name = f"commit {commit_of(settings.against)}"
            packages[name] = end_to_end.importable(settings.against, Path(temporary) / "other")
            scenes[name] = settings.against / "scenes"
        tables = [measured(part, packages, scenes, Path(temporary), settings) for part in parts]
    return Section(tables, {}, NOTES)


NOTES = (
    "CPU time of the whole process on one core: start of Python, reading and placing, steps, frames, animation. "
    "Kernels are compiled before. Start: the same run, ended at t = 0.001.",
    "Error: the largest distance of a node, in lengths of the rod, at the end from our run at the tighter tolerance, "
    "over the rods. Where collisions amplify errors the largest says little. Steps: taken and repeated, of a rod on "
    "the average; of versions before steps by error the planned ones.",
    "--against FOLDER compares with the version in a clone at another commit, with its own scene.",
)


def measured(
    part: Part, packages: dict[str, Path], scenes: dict[str, Path], temporary: Path, settings: Settings
) -> Table:
    """One scene by every version, in turns, and once more by ours with a tighter tolerance."""
    end = {} if part.end is None else {"end": part.end}

    def run(version: str, time: dict[str, Any]) -> Ended:
        settings.tell(f"{part.scene}, {version}, {time or 'whole'}")
        scene = end_to_end.edited(scenes[version] / f"{part.scene}.toml", time, temporary / f"{part.scene}.toml")
        return end_to_end.run(scene, temporary / "run", packages[version])

    first = {"end": BRIEF, "save_every": BRIEF}
    starts = {}
    for version in packages:
        run(version, first)  # compiles
        starts[version] = run(version, first).seconds
    runs: dict[str, list[Ended]] = {version: [run(version, end)] for version in packages}
    for _ in range(REPEATS - 1):
        for version, ended in runs.items():
            if ended[0].seconds < LONG and not settings.quick:
                ended.append(run(version, end))
    exact = run("ours", {**end, "tolerance": part.tight})
    until = "whole" if part.end is None else f"until t = {part.end:g}"
    rows = [row(version, ended, starts[version], exact, runs["ours"]) for version, ended in runs.items()]
    rows.append([f"ours, tolerance {part.tight:g}", exact.seconds, None, exact.steps, None, None, None, None])
    columns = ["", "CPU s", "of it start", "steps", "error: median", "95 %", "largest", "over ours"]
    return Table(f"{part.scene}.toml, {until}", columns, rows)


def row(version: str, ended: Sequence[Ended], start: float, exact: Ended, ours: Sequence[Ended]) -> list[Cell]:
    """A version's times, and its errors where it starts from the same places."""
    seconds = float(np.median([run.seconds for run in ended]))
    errors: list[Cell] = ["another start", None, None]
    if end_to_end.distances(exact.start, ended[0].start).max() < SAME_START:
        errors = np.quantile(end_to_end.distances(exact.end, ended[0].end), [0.5, 0.95, 1.0]).tolist()
    return [version, seconds, start, ended[0].steps, *errors, seconds / float(np.median([r.seconds for r in ours]))]
