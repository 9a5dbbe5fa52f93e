"""Scenes run whole, in processes of their own, by this version of the package or by that of another folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tomli_w

import warp_rods

DRIVER = """
import json, sys, time
import numpy as np
import warp_rods as wr
scene, out = sys.argv[1:]
run = wr.run(scene, out=out, device="cpu")
seconds = time.process_time()
places = {}
for name in run.order:
    position = run.data[name]["position"].values
    places[name], places[name + " at the start"] = position[-1], position[0]
np.savez(out + "/places.npz", **places)
print(json.dumps({"seconds": seconds, "rod_steps": run.rod_steps, "rods": sum(len(places[n]) for n in run.order)}))
"""
"""What both versions run: names that have been public since the first one."""


class Ended(NamedTuple):
    """A scene that was run: CPU seconds of the whole process, mean steps of a rod, places at start and end."""

    seconds: float
    steps: float
    start: dict[str, np.ndarray]
    end: dict[str, np.ndarray]


def scenes_folder() -> Path | None:
    """The folder with the scenes of this project: here, or beside the package."""
    beside = Path(warp_rods.__file__).parents[1] / "scenes"
    return next((folder for folder in (Path("scenes").absolute(), beside) if folder.is_dir()), None)


def edited(scene: Path, time: Mapping[str, Any], path: Path) -> Path:
    """A copy of a scene with other values in its table ``time``."""
    with scene.open("rb") as file:
        table = tomllib.load(file)
    table["time"] |= time
    path.write_text(tomli_w.dumps(table), encoding="utf-8")
    return path


def importable(checkout: Path, folder: Path) -> Path:
    """A folder from which the package of a clone can be imported; kernels beside it belong inside."""
    shutil.copytree(checkout / "warp_rods", folder / "warp_rods", ignore=shutil.ignore_patterns("__pycache__"))
    if not (folder / "warp_rods" / "kernels").exists():
        shutil.copytree(checkout / "kernels", folder / "warp_rods" / "kernels")
    return folder


def run(scene: Path, out: Path, package: Path) -> Ended:
    """Run a scene by the package in a folder. Raises ArithmeticError with what it printed where that fails."""
    environment = os.environ | {"PYTHONPATH": str(package)}
    command = [sys.executable, "-c", DRIVER, str(scene), str(out)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=out.parent, check=False)
    if done.returncode:
        raise ArithmeticError(f"{scene.name} by {package}: {done.stderr.strip()[-2000:]}")
    told = json.loads(done.stdout.strip().splitlines()[-1])
    with np.load(out / "places.npz") as places:
        end = {name: places[name] for name in places if not name.endswith(" at the start")}
        start = {name: places[name + " at the start"] for name in end}
    shutil.rmtree(out)
    return Ended(told["seconds"], told["rod_steps"] / told["rods"], start, end)


def distances(one: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray]) -> np.ndarray:
    """The largest distance of a node of each rod in two runs, in lengths of the rod [rod]."""
    found = []
    for name, position in one.items():
        length = np.linalg.norm(np.diff(position, axis=1), axis=-1).sum(axis=1)
        found.append(np.linalg.norm(position - other[name], axis=-1).max(axis=1) / length)
    return np.concatenate(found)
