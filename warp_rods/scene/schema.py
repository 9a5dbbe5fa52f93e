"""The JSON Schema of a scene, made from its tables: with it editors complete, check and explain its keys.

What tables check together, as a list with one value for each rod, is left to ``warp-rods check``.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from inspect import cleandoc
from typing import Any, NamedTuple

from warp_rods.membranes.catalogue import KINDS
from warp_rods.scene.behaviour import BEHAVIOURS, BehaviourTable
from warp_rods.scene.checks import Table, meant
from warp_rods.scene.dimensions import DIMENSIONS
from warp_rods.scene.flagella import LAWS, FlagellaTable
from warp_rods.scene.flows import FLOWS, FlowTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import SweepTable
from warp_rods.scene.tables import SurfaceTable
from warp_rods.values import plain

__all__ = ["DRAFT", "meanings", "schema", "schema_text"]

DRAFT = "http://json-schema.org/draft-04/schema#"
"""The last draft that taplo knows, which completes and checks TOML in most editors."""
PLACE = "#/definitions/"
QUANTITY = {"type": "string", "pattern": "^[-+0-9.].*[A-Za-zµ]", "description": "a number with a unit"}
"""``"500 nm"``, where a number has a dimension."""
WITH_UNITS = {path.rpartition(".")[2] for path in DIMENSIONS}
KINDS_OF: Mapping[type[Table], Iterable[str]] = {SurfaceTable: KINDS, FlowTable: FLOWS}
"""Tables whose ``kind`` is the name of a row of another table, and those names."""
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
    made["properties"] = {key: _key(key, value, table) for key, value in made["properties"].items()}
    required = [key for key in made.pop("required", []) if key not in table.filled({})]
    if required:
        made["required"] = required
    made["properties"] |= {key: _of_rows(rows) for key, rows in _own_keys(table).items()}
    if table in KINDS_OF:
        made["properties"]["kind"]["enum"] = list(KINDS_OF[table])
    return made | {"additionalProperties": table is SweepTable}


def meanings(table: type[Table]) -> dict[str, list[str]]:
    """What each key of a table means, in words: of keys that depend on its kind one text or more."""
    own = {key: list(dict.fromkeys(row.meaning for row in rows)) for key, rows in _own_keys(table).items()}
    return {key: [field.title or ""] for key, field in table.model_fields.items()} | own


class _Row(NamedTuple):
    """A key that things of one kind have: the kind, empty for a key of all; meaning, what is allowed, default."""

    kind: str
    meaning: str
    words: str
    default: Any = None


def _own_keys(table: type[Table]) -> dict[str, list[_Row]]:
    """The keys that come from the table of the kinds of a thing."""
    rows: list[tuple[str, _Row]] = []
    if table is SurfaceTable:
        rows = [(key, _Row(kind, *one)) for kind, row in KINDS.items() for key, one in row.described.items()]
    elif table is FlowTable:
        keys = [(kind, key, one) for kind, row in FLOWS.items() for key, one in row.keys.items()]
        rows = [(key, _Row(kind, one.meaning, one.words, one.default or None)) for kind, key, one in keys]
    elif table is FlagellaTable:
        own = [(key, law, one) for law, row in LAWS.items() for key, one in row.parameters.items()]
        rows = [(key, _Row(law, one.meaning, one.words, one.default)) for key, law, one in own]
    elif table is BehaviourTable:
        tables = {name: f"a table {{ {', '.join(row.parameters)} }}" for name, row in BEHAVIOURS.items()}
        rows = [(name, _Row("", row.meaning, tables[name])) for name, row in BEHAVIOURS.items()]
    found: dict[str, list[_Row]] = {}
    for key, row in rows:
        found.setdefault(key, []).append(row)
    return found


def _of_rows(rows: Iterable[_Row]) -> dict[str, Any]:
    """The schema of a key that things of some kinds have: each meaning with its kinds, and a default if all have it."""
    kinds: dict[str, list[str]] = {}
    for row in rows:
        kinds.setdefault(f"{row.meaning}: {row.words}", []).append(row.kind)
    texts = [f"{text} ({', '.join(names)})" if any(names) else text for text, names in kinds.items()]
    made: dict[str, Any] = {"description": "; ".join(texts)}
    first, *others = [row.default for row in rows]
    return made if first is None or any(other != first for other in others) else {"default": first, **made}


def _key(key: str, value: dict[str, Any], table: type[Table]) -> dict[str, Any]:
    """The schema of a key, with its meaning before what is allowed: a reference beside a description would hide it."""
    field = table.model_fields[key]
    value.pop("title")
    value["description"] = meant(field)
    if field.default_factory is not None:
        value["default"] = plain(field.get_default(call_default_factory=True))
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
