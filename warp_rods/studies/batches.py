"""Points of a study as the rods of one batch: where that is possible, and the scene of such a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from warp_rods.errors import SceneError
from warp_rods.scene.ensemble import AUTO
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import ENSEMBLES, Path
from warp_rods.simulation.loop import Simulation
from warp_rods.values import plain

__all__ = ["PER_ROD", "batch_tables", "why_not"]

_FLAGELLA = ("flagella.relaxation", "flagella.diffusion")
PER_ROD: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "swimmers": (
        ("bend", "twist", "moment", "couple", "drag_ratio", "drag_along", "rotational_drag", "natural_bend",
         "natural_twist", *_FLAGELLA, "shape.amplitude", "shape.perturbation"),
        ("placement.position", "placement.direction"),
    ),
    "filaments": (
        ("length", "growth.rate", "growth.until", "growth.start"),
        ("stiffness", "intrinsic", "drag", "growth.time", "growth.length", "placement.position",
         "placement.direction"),
    ),
}  # fmt: skip
"""Keys that may have one value a rod, by the kind of rods: those of numbers (or formulas), and those of lists."""


def why_not(scene: Scene, paths: Sequence[Path], simulation: Simulation) -> str:
    """Why the points of a study cannot be rods of batches; empty where they can.

    paths: of the swept keys. simulation: of one point.
    """
    for path in paths:
        if path[0] not in PER_ROD or not _per_rod(str(path[0]), path[2:]):
            return f"{_key(scene, path)} is not a value of single rods"
    tables = [(kind, table) for kind in ENSEMBLES for table in getattr(scene, kind)]
    for kind, table in tables:
        if kind not in PER_ROD:
            return f"rods of [[{kind}]] take their steps together"
        shape, placement = table.shape, getattr(table, "placement", None)
        if table.nodes == AUTO:
            return 'the number of nodes, "auto", depends on the point'
        if shape is not None and shape.from_file:
            return "shapes at the start are from files"
        if getattr(placement, "geodesic_curvature", 0.0) != 0.0:
            return "placement.geodesic_curvature is given"
    if not simulation.own_steps:
        return "rods take their steps together"
    alone = plain(simulation.scene.model_dump(exclude_none=True))
    try:
        Scene.parse(batch_tables([alone, alone]))
    except SceneError as error:
        return f"its rods cannot be told apart in one table: {error}"
    return ""


def _per_rod(kind: str, path: Path) -> bool:
    """Whether a key of an ensemble, or the list that has it as a component, may have a value for each rod."""
    numbers, lists = PER_ROD[kind]
    return _name(path) in numbers or (isinstance(path[-1], int) and _name(path[:-1]) in lists) or _name(path) in lists


def _key(scene: Scene, path: Path) -> str:
    """A path as the key of a sweep, with the name of an ensemble in place of its number."""
    if path[0] in ENSEMBLES:
        path = (path[0], getattr(scene, str(path[0]))[path[1]].name, *path[2:])
    return _name(path)


def _name(path: Path) -> str:
    return ".".join(map(str, path))


def batch_tables(points: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The tables of a scene whose rods are those of several points, in turn; all else is that of the first point."""
    first = points[0]
    merged = {
        kind: tuple(_ensemble(kind, [point[kind][i] for point in points]) for i in range(len(first[kind])))
        for kind in PER_ROD
        if first.get(kind)
    }
    return {key: value for key, value in first.items() if key not in ("on_failure", "output")} | merged


def _ensemble(kind: str, tables: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The table of an ensemble that has the rods of all these tables."""
    numbers, lists = PER_ROD[kind]
    count = tables[0]["count"]
    merged = dict(tables[0]) | {"count": count * len(tables)}
    for name in (*numbers, *lists):
        path = name.split(".")
        given = [_at(table, path) for table in tables]
        if given[0] is None:
            continue
        rows = [_rows(value, count, name in lists) for value in given]
        if rows[0] is None and all(value == given[0] for value in given):
            continue  # the same for all rods
        each = [row or (value,) * count for row, value in zip(rows, given, strict=True)]
        owner = merged
        for key in path[:-1]:
            owner[key] = dict(owner[key])
            owner = owner[key]
        owner[path[-1]] = tuple(value for row in each for value in row)
    return merged


def _at(table: Any, path: Sequence[str]) -> Any:
    for key in path:
        table = table.get(key) if isinstance(table, Mapping) else None
    return table


def _rows(value: Any, count: int, lists: bool) -> tuple | None:
    """The values of the rods where there is one for each; None where one is for all."""
    each = isinstance(value, tuple) and (not lists or any(isinstance(part, tuple) for part in value))
    return value if each and len(value) == count else None
