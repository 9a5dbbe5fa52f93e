"""A fixed shape of a swimmer as a scene: the shape in a file of its own, from which the scene starts."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.scene.shapes import KEPT
from warp_rods.simulation.files import replace_file
from warp_rods.simulation.kept_starts import archive, stored

if TYPE_CHECKING:
    from warp_rods.theory.steady import FixedShape

__all__ = ["write_scene"]

OF_FLAGELLA = ("relaxation", "diffusion")


def write_scene(shape: FixedShape, path: Any, end: float, name: str) -> Path:
    """As ``FixedShape.write_scene``."""
    path = arguments.path("path", path)
    if path.suffix != ".toml":
        raise SceneError(f"path = {path}: must end in .toml")
    if not path.parent.is_dir():
        raise SceneError(f"path = {path}: there is no folder {path.parent}")
    rods = shape.rods()
    start = {
        "strain": rods.strain,
        "activity": shape.activity[None],
        "position": np.zeros((1, 3)),
        "rotation": np.eye(3)[None],
    }
    tables = _tables(shape, path.with_suffix(KEPT), end, name)
    digest = hashlib.sha256(shape.fields.tobytes()).hexdigest()
    source = (f"fixed shape by wr.steady, spin {shape.spin:.9g}", digest)
    try:
        (table,) = Scene.parse(
            {**tables, "swimmers": [{**tables["swimmers"][0], "shape": {"kind": "straight"}}]}
        ).swimmers
        table = table.model_copy(update={"shape": table.shape.model_construct(kind="run", run=path.stem + KEPT)})
        replace_file(path.with_suffix(KEPT), archive(stored(table, start, (source,))))
        replace_file(path, tomli_w.dumps(tables).encode())
    except OSError as fault:
        raise SceneError(f"path = {path}: cannot be written: {fault}") from None
    return path


def _tables(shape: FixedShape, start: Path, end: float, name: str) -> dict[str, Any]:
    swimmer = shape.swimmer
    parameters = dict(swimmer.parameters)
    flagella = {key: parameters.pop(key) for key in OF_FLAGELLA}
    return {
        "title": f"A fixed shape at β⊥ = {swimmer.parameters['bend']:g}",
        "swimmers": [
            {
                "name": name,
                "count": 1,
                "nodes": swimmer.nodes,
                **parameters,
                "symmetric": swimmer.symmetric,
                "flagella": {**flagella, "law": swimmer.law},
                "shape": {"run": start.name},
            }
        ],
        "time": {"end": end},
    }
