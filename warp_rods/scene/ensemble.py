"""Common parts of the tables of ensembles."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import is_list
from warp_rods.values import shown

__all__ = ["MOST_NODES", "EnsembleTable", "length_faults", "lookup"]

MOST_RODS, MOST_NODES = 10_000_000, 100_000
"""Upper bounds; larger ensembles do not fit into memory."""


class EnsembleTable(Table):
    """An ensemble of rods; its name is also that of its group in the trajectory."""

    name: str = Field(
        pattern=r"^[A-Za-z][A-Za-z0-9_]{0,63}$",
        description="a name of at most 64 letters, digits and _, that starts with a letter",
    )
    count: int = Field(ge=1, le=MOST_RODS, description="a whole number, 1 or more, at most 10 million")


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
