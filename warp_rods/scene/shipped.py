"""The scenes that are installed with the package: what they are called and show, and copies of them to edit."""

from __future__ import annotations

import re
import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path

from warp_rods.errors import SceneError, named, nearest

__all__ = ["SCHEMA", "Shipped", "copy_scene", "find_scene", "shipped"]

FOLDER = Path(__file__).parents[1] / "scenes"
SCHEMA = "scene.schema.json"
"""The JSON Schema of scenes beside them, which the first line of each names."""
TIME = re.compile(r"^# About (.+) on one core\.$", re.MULTILINE)


@dataclass(frozen=True)
class Shipped:
    """A scene that is installed with the package."""

    path: Path

    @property
    def title(self) -> str:
        """What it shows."""
        return str(tomllib.loads(self._text)["title"])

    @property
    def time(self) -> str:
        """About how long it takes on one core, as its comment says."""
        found = TIME.search(self._text)
        return found[1] if found else ""

    @property
    def _text(self) -> str:
        return self.path.read_text(encoding="utf-8")


def shipped() -> dict[str, Shipped]:
    """The scenes by name."""
    return {path.stem: Shipped(path) for path in sorted(FOLDER.glob("*.toml"))}


def find_scene(scene: Path) -> Path:
    """The path of a scene: of a file, or, where there is no such file, of the shipped scene with this name.

    Raises SceneError for a mere name that neither has.
    """
    known = shipped()
    if scene.exists() or scene.suffix or len(scene.parts) != 1:
        return scene
    if scene.name not in known:
        raise SceneError(
            f"{scene}: there is no such file, and no shipped scene of this name{nearest(scene.name, known)}; "
            f"warp-rods scenes lists these"
        )
    return known[scene.name].path


def copy_scene(name: str, folder: Path) -> list[Path]:
    """Copy a shipped scene, the files that it reads and the JSON Schema for editors into a folder; returns the copies.

    Raises SceneError for an unknown name and where one of the files is there already; then nothing is copied.
    """
    scene = named(shipped(), "NAME", name).path
    files = [scene, *(file for file in sorted(FOLDER.glob(f"{name}.*")) if file != scene)]
    there = [folder / file.name for file in files if (folder / file.name).exists()]
    if there:
        raise SceneError(f"{there[0]} is there already: rename it, or give another folder: scenes copy {name} FOLDER")
    folder.mkdir(parents=True, exist_ok=True)
    return [Path(shutil.copyfile(file, folder / file.name)) for file in [*files, FOLDER / SCHEMA]]
