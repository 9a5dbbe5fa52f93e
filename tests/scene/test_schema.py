"""The JSON Schema of scenes: it is current, describes every key, and accepts what the tables accept."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest
from examples.scene import DESIGN, scenes, small
from hypothesis import given, settings

from warp_rods.membranes.catalogue import KINDS
from warp_rods.scene.checks import Table
from warp_rods.scene.flows import FLOWS
from warp_rods.scene.schema import meanings, schema, schema_text
from warp_rods.scene.shipped import SCHEMA, shipped
from warp_rods.values import plain

FILE = Path(__file__).parents[2] / "scenes" / SCHEMA
SCENES = shipped()


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft4Validator:
    jsonschema.Draft4Validator.check_schema(schema())
    return jsonschema.Draft4Validator(schema())


def described() -> dict[str, tuple[type[Table], dict]]:
    """Every table with its part of the schema, by name."""

    def tables(table):
        return {table, *(found for derived in table.__subclasses__() for found in tables(derived))}

    whole = schema()
    parts = {"Scene": whole, **whole["definitions"]}
    return {table.__name__: (table, parts[table.__name__]) for table in tables(Table) if table.__name__ in parts}


def faults(validator, scene: str | dict) -> list[str]:
    scene = tomllib.loads(scene) if isinstance(scene, str) else json.loads(json.dumps(scene))
    return [".".join(map(str, fault.absolute_path)) or fault.message for fault in validator.iter_errors(scene)]


def test_the_file_is_current():
    assert FILE.read_text(encoding="utf-8") == schema_text(), f"warp-rods schema > scenes/{SCHEMA}"


@pytest.mark.parametrize("name", SCENES)
def test_shipped_scenes_are_valid_and_name_the_schema(validator, name):
    text = SCENES[name].path.read_text(encoding="utf-8")
    assert faults(validator, text) == []
    assert text.startswith(f"#:schema ./{SCHEMA}\n")


def test_every_key_is_described(validator):
    whole = schema()
    parts = {"Scene": whole, **whole["definitions"]}
    assert len(described()) == len(parts) > 20
    for name, (table, part) in described().items():
        fields = table.model_fields
        assert set(fields) <= set(part["properties"]) and part["description"]
        assert all(value.get("description") for value in part["properties"].values())
        assert set(part.get("required", ())) <= set(fields)
        assert part["additionalProperties"] is (name == "SweepTable")  # its keys are those of other tables
    assert whole["required"] == ["time"] and parts["Time"]["required"] == ["end"]
    assert parts["SurfaceTable"]["properties"]["kind"]["enum"] == list(KINDS)
    assert {key for row in KINDS.values() for key in row.keys} <= set(parts["SurfaceTable"]["properties"])
    assert {key for row in FLOWS.values() for key in row.keys} <= set(parts["FlowTable"]["properties"])


def test_every_key_has_a_meaning_before_what_is_allowed():
    for name, (table, part) in described().items():
        found = meanings(table)
        assert set(found) == set(part["properties"])
        for key, texts in found.items():
            assert texts
            for text in texts:
                assert 5 < len(text) <= 90 and ":" not in text and not text.endswith("."), f"{name}.{key}: {text}"
                assert text.lower() != key.replace("_", " "), f"{name}.{key}"
                assert f"{text}: " in part["properties"][key]["description"]
    bend = "bending stiffness β⊥ = B⊥/(f*L³): a positive number, a formula in s, or a list with one for each rod"
    assert schema()["definitions"]["SwimmersTable"]["properties"]["bend"]["description"].startswith(bend)
    radius = schema()["definitions"]["SurfaceTable"]["properties"]["radius"]["description"].split("; ")
    assert radius[0] == "radius of the sphere (length): a positive number, or a formula in t (sphere)"


def test_every_default_is_shown():
    for name, (table, part) in described().items():
        for key, field in table.model_fields.items():
            value = plain(field.get_default(call_default_factory=True))
            shown = None if field.is_required() or value is None else json.loads(json.dumps(value))
            assert part["properties"][key].get("default") == shown, f"{name}.{key}"
    assert schema()["definitions"]["FlowTable"]["properties"]["gradient"]["default"] == (0.0, 1.0, 0.0)
    assert "default" not in schema()["definitions"]["SurfaceTable"]["properties"]["radius"]  # one for each kind


def test_no_title_is_made_of_a_key():
    def titles(part):
        parts = part if isinstance(part, list) else part.values() if isinstance(part, dict) else ()
        own = [part["title"]] if isinstance(part, dict) and isinstance(part.get("title"), str) else []
        return own + [title for inner in parts for title in titles(inner)]

    assert titles(json.loads(schema_text())) == ["A scene of warp-rods"]


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"swimmers__bend": -1.0}, "swimmers.0.bend"),
        ({"swimmers__cuont": 1}, "swimmers.0"),
        ({"swimmers__nodes": "many"}, "swimmers.0.nodes"),
        ({"surface__kind": "cube"}, "surface.kind"),
        ({"filaments__intrinsic": [0.0, 1.0]}, "filaments.0.intrinsic"),
        ({"seed": 2**63}, "seed"),
        ({"time": {"save_every": 1.0}}, "time"),
    ],
)
def test_faults_are_found(validator, changes, where):
    assert faults(validator, small()) == []
    assert faults(validator, small(**changes)) == [where]


@settings(max_examples=30, deadline=None)
@given(scene=scenes())
def test_what_the_tables_accept_is_valid(validator, scene):
    assert faults(validator, scene) == []


def test_the_scene_of_the_design_is_valid(validator):
    assert faults(validator, DESIGN) == []
