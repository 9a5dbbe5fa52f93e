"""The JSON Schema of a scene, made from its tables: with it editors complete the keys of a scene, and check them.

What tables check together, as a list with one value for each rod, is left to ``warp-rods check``.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from inspect import cleandoc
from typing import Any

from warp_rods.membranes.catalogue import KINDS
from warp_rods.scene.behaviour import BEHAVIOURS, BehaviourTable
from warp_rods.scene.checks import Table
from warp_rods.scene.dimensions import DIMENSIONS
from warp_rods.scene.flagella import ALLOWED, LAWS, FlagellaTable
from warp_rods.scene.flows import FLOWS, FlowTable
from warp_rods.scene.per_rod import OR_EACH
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import SweepTable
from warp_rods.scene.tables import SurfaceTable

__all__ = ["DRAFT", "schema", "schema_text"]

DRAFT = "http://json-schema.org/draft-04/schema#"
"""The last draft that taplo knows, which completes and checks TOML in most editors."""
PLACE = "#/definitions/"
QUANTITY = {"type": "string", "pattern": "^[-+0-9.].*[A-Za-zµ]", "description": "a number with a unit"}
"""``"500 nm"``, where a number has a dimension."""
WITH_UNITS = {path.rpartition(".")[2] for path in DIMENSIONS}
WORDS = {"prefixItems": "items", "oneOf": "anyOf"}
"""Words of later drafts in those of this one. An empty list is one of many things, hence ``anyOf``."""


def schema_text() -> str:
    """The schema as the text of ``scenes/scene.schema.json``."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def schema() -> dict[str, Any]:
    """The JSON Schema of a scene in TOML."""
    found = Scene.model_json_schema(ref_template=PLACE + "{model}")
    parts = found.pop("$defs")
    tables = {table.__name__: table for table in _tables(Table)}
    whole = {name: _table(tables[name], part) for name, part in {**parts, Scene.__name__: found}.items()}
    scene = whole.pop(Scene.__name__)
    return {"$schema": DRAFT, "title": "A scene of warp-rods", **scene, "definitions": whole}


def _tables(table: type[Table]) -> Iterable[type[Table]]:
    """All tables derived from one, itself included."""
    yield table
    for derived in table.__subclasses__():
        yield from _tables(derived)


def _table(table: type[Table], part: Mapping[str, Any]) -> dict[str, Any]:
    """The schema of a table: without keys that ``filled`` fills in among those required, with those of its kinds."""
    made = _older(part)
    made.pop("title")
    made["description"] = cleandoc(table.__doc__ or "").partition("\n\n")[0].replace("\n", " ")
    made["properties"] = {key: _key(key, value) for key, value in made["properties"].items()}
    required = [key for key in made.pop("required", []) if key not in table.filled({})]
    if required:
        made["required"] = required
    own, kinds = _own_keys(table)
    made["properties"] |= {key: {"description": words} for key, words in own.items() if key not in made["properties"]}
    made["properties"] |= {key: {**made["properties"][key], "enum": names} for key, names in kinds.items()}
    return made | {"additionalProperties": table is SweepTable}


def _own_keys(table: type[Table]) -> tuple[dict[str, str], dict[str, list[str]]]:
    """Keys with descriptions that come from the table of the kinds of a thing, and the names of these kinds by key."""
    rows: list[tuple[str, str]] = []
    kinds: dict[str, list[str]] = {}
    if table is SurfaceTable:
        rows, kinds = [(key, f"of {kind}") for kind, row in KINDS.items() for key in row.keys], {"kind": list(KINDS)}
    elif table is FlowTable:
        rows = [(key, f"{kind}: {one.words}") for kind, row in FLOWS.items() for key, one in row.keys.items()]
        kinds = {"kind": list(FLOWS)}
    elif table is FlagellaTable:
        own = [(key, law, one) for law, row in LAWS.items() for key, one in row.parameters.items()]
        rows = [(key, f"{law}: {ALLOWED[one.allowed][1]}{OR_EACH}") for key, law, one in own]
    elif table is BehaviourTable:
        rows = [(name, f"a table {{ {', '.join(row.parameters)} }}") for name, row in BEHAVIOURS.items()]
    keys: dict[str, list[str]] = {}
    for key, words in rows:
        keys.setdefault(key, []).append(words)
    return {key: "; ".join(words) for key, words in keys.items()}, kinds


def _key(key: str, value: dict[str, Any]) -> dict[str, Any]:
    """The schema of a key: a reference beside a description would hide it."""
    value.pop("title", None)
    if key in WITH_UNITS:
        value = _or_quantity(value)
    reference = value.pop("$ref", None)
    return value if reference is None else {"allOf": [{"$ref": reference}], **value}


def _or_quantity(part: Any) -> Any:
    """A part of a schema, with a quantity with a unit as another choice for each of its numbers."""
    if isinstance(part, list):
        return [_or_quantity(item) for item in part]
    if not isinstance(part, Mapping):
        return part
    if part.get("type") != "number":
        return {key: _or_quantity(value) for key, value in part.items()}
    own = {key: value for key, value in part.items() if key in ("description", "default")}
    return {"anyOf": [{key: value for key, value in part.items() if key not in own}, QUANTITY], **own}


def _older(part: Any) -> Any:
    """A part of a schema of pydantic in the words of the older draft, without null, which TOML does not have."""
    if isinstance(part, list):
        return [_older(item) for item in part]
    if not isinstance(part, Mapping):
        return part
    made = {WORDS.get(key, key): _older(value) for key, value in part.items()}
    if "const" in made:
        made["enum"] = [made.pop("const")]
    if "exclusiveMaximum" in made:
        made |= {"maximum": made["exclusiveMaximum"], "exclusiveMaximum": True}
    if made.get("default", "") is None:
        del made["default"]
    if "anyOf" in made:
        made["anyOf"] = [one for one in made["anyOf"] if one != {"type": "null"}]
        if len(made["anyOf"]) == 1:
            made = {**made.pop("anyOf")[0], **made}
    return made
