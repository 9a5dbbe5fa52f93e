"""Common parts of the tables of ensembles."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import Discriminator, Field, Tag

from warp_rods.errors import SceneError
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import ONE, WORD, is_list
from warp_rods.values import shown

__all__ = ["AUTO", "MOST_NODES", "EnsembleTable", "OrAuto", "length_faults", "lookup"]

T = TypeVar("T")
AUTO: Literal["auto"] = "auto"
"""``nodes`` where the number is chosen when the scene is laid out."""
OrAuto = Annotated[
    Annotated[Literal["auto"], Tag(WORD)] | Annotated[T, Tag(ONE)],
    Discriminator(lambda value: WORD if value == AUTO else ONE),
]
"""A value of a type, or "auto"."""

MOST_RODS, MOST_NODES = 10_000_000, 100_000
"""Upper bounds; larger ensembles do not fit into memory."""


class EnsembleTable(Table):
    """An ensemble of rods; its name is also that of its group in the trajectory."""

    FEWEST_NODES: ClassVar[int]
    """The smallest number of nodes."""

    name: str = Field(
        pattern=r"^[A-Za-z][A-Za-z0-9_]{0,63}$",
        title="name of the ensemble, and of its group in the trajectory",
        description="a name of at most 64 letters, digits and _, that starts with a letter",
    )
    count: int = Field(
        ge=1, le=MOST_RODS, title="number of rods", description="a whole number, 1 or more, at most 10 million"
    )

    @property
    def node_count(self) -> int:
        """``nodes``, which is a number once the scene is laid out; raises SceneError while it is still to be chosen."""
        nodes: int | str = getattr(self, "nodes")  # noqa: B009 (a field of each kind of ensemble)
        if isinstance(nodes, str):
            raise SceneError(f'nodes = "{nodes}": must be a number here; warp-rods check shows the one that is chosen')
        return nodes


def lookup(raw: Any, path: tuple[str, ...]) -> Any:
    """The value at a path of keys in nested tables; None where there is none."""
    for key in path:
        raw = raw.get(key) if isinstance(raw, dict) else None
    return raw


def length_faults(
    raw: dict[str, Any], good: dict[str, Any], paths: tuple[str, ...], vectors: tuple[str, ...] = ()
) -> Faults:
    """Faults of lists without one entry for each of ``count`` rods; ``vectors`` are lists of lists."""
    count, faults = good.get("count"), []
    for path in paths + vectors:
        loc = tuple(path.split("."))
        value = lookup(raw, loc)
        one_vector = path in vectors and is_list(value) and not any(map(is_list, value))
        if count is not None and is_list(value) and not one_vector and len(value) != count:
            text = f" = {shown(value)}: needs one entry for each of {count} rods, has {len(value)}"
            faults.append(fault(loc, value, text))
    return faults
