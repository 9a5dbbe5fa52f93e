"""A run continues only with its own scene: every key but those that may change is compared, and named."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_rods.errors import RunFolderError, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.begun import Begun

FILAMENT = {
    "name": "f", "count": 2, "nodes": 33, "length": [0.5, 0.6], "stiffness": [[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]],
    "intrinsic": [0.1, 1.5, 0.2], "drag": [1.0, 2.0, 0.1], "ends": ["clamped", "free"],
    "growth": {"rate": 0.05, "until": 2.0, "start": 0.5, "spacing": 0.05},
    "placement": {"at": "start", "position": [[1.0, 0, 0], [0, 1.0, 0]], "direction": [[0, 1.0, 0], [1.0, 0, 0]],
                  "geodesic_curvature": 0.5},
}  # fmt: skip
GROWN = {
    "name": "g", "count": 1, "nodes": 33, "length": 0.5, "stiffness": [1.0, 1.0, 1.0], "drag": [1.0, 2.0, 0.1],
    "growth": {"time": [0.0, 1.0], "length": [0.5, 0.7]}, "bodies": [0, 1],
}  # fmt: skip
SWIMMER = {
    "name": "c", "count": 2, "nodes": 65, "bend": 5e-3, "twist": 1e-3, "moment": 0.1, "drag_ratio": 2.0,
    "rotational_drag": 3e-3, "symmetric": False,
    "flagella": {"relaxation": 1e-2, "diffusion": 1e-3, "profile": "tanh", "sharpness": 10.0, "law": "relaxing"},
    "shape": {"kind": "mode", "mode": 0, "amplitude": 1.0, "perturbation": 1e-3},
    "placement": {"position": [[0, 0, 0.0], [1.0, 0, 0]], "direction": [[1.0, 0, 0], [0, 1.0, 0]]},
}  # fmt: skip
EXPRESSION = {
    "kind": "expression", "phi": "x**2 + y**2 + z**2 - R**2", "box": [[-2, 2], [-2, 2], [-2, 2]],
    "parameters": {"R": 1.0},
}  # fmt: skip
COMMON = {"title": "a run", "seed": 3, "units": {"length": "1 um"}, "on_failure": "stop"}
TIME = {"end": 1.0, "step": 1e-3, "save_every": 0.1}
STERIC = {"strength": 40.0, "range": 0.05, "core": 0.07}
RICH = {
    "filaments": {
        **COMMON, "surface": EXPRESSION, "filaments": [FILAMENT, GROWN], "steric": STERIC, "time": TIME,
        "output": {"usd": True, "variables": ["energy", "energy_density"], "frames_per_file": 10},
    },
    "swimmers in a container": {
        **COMMON, "swimmers": [SWIMMER], "steric": STERIC, "time": {"end": 1.0, "tolerance": 0.01, "save_every": 0.1},
        "box": {"kind": "container", "wall": {"strength": 2000.0, "range": 0.05},
                "surface": {"kind": "ellipsoid", "radii": [3.0, 3.0, 2.0]}, "side": "inside"},
    },
    "swimmers in a slab": {
        "swimmers": [{**SWIMMER, "shape": {"kind": "straight"}, "placement": "random"}], "time": {"end": 1.0},
        "box": {"kind": "slab", "size": [12.0, 12.0], "height": 0.2, "wall": {"strength": 2000.0, "range": 0.05}},
    },
    "free swimmers": {
        "swimmers": [{**SWIMMER, "symmetric": True, "shape": {"kind": "mode", "mode": 0, "amplitude": 1.0}}],
        "time": {"end": 1.0},
    },
    "swimmers by fraction": {
        "swimmers": [{**SWIMMER, "shape": {}, "placement": "polar lanes"}], "time": {"end": 1.0}, "steric": STERIC,
        "box": {"kind": "periodic", "fraction": 0.01},
    },
}  # fmt: skip
OTHER_WORDS = {
    "a run": "another", "f": "other", "g": "other", "c": "other", "clamped": "free", "1 um": "1 nm", "tanh": "uniform",
    "relaxing": "held", "mode": "straight", "start": "middle", "energy": "tension", "energy_density": "status",
    "inside": "outside", "random": "aligned", "polar lanes": "bands", "slab": "periodic", "container": "slab",
    "periodic": "slab", "ellipsoid": "sphere", "expression": "sphere", "stop": "continue",
    "x**2 + y**2 + z**2 - R**2": "x**2 + y**2 + 2*z**2 - R**2",
}  # fmt: skip
MAY_CHANGE = {"time.end", "output.usd", "on_failure"}
WHOLE = {
    "shape.kind": {"kind": "straight"}, "box.kind": {"kind": "periodic", "size": [4.0, 4.0, 4.0]},
    "surface.kind": {"kind": "sphere", "radius": 2.5}, "flagella.profile": {"profile": "uniform"},
}  # fmt: skip
"""Tables in place of those in which one key cannot change alone."""


def leaves(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Paths to the values of a scene; a list of numbers is one value."""
    if isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(item, (*path, key))
    else:
        yield path


def key_of(path: tuple) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def others(value: Any) -> Iterator[Any]:
    """Other values than this one, at least one of which should be valid in its place."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from (value + 2, value + 1, 0)
    elif isinstance(value, float):
        yield from (value * 2, value / 2, value + 0.01)
    elif isinstance(value, str):
        yield from ([OTHER_WORDS[value]] if value in OTHER_WORDS else [])
    else:
        for other in others(value[-1]):
            yield [*value[:-1], other]
        yield value[:-1]


def changed(scene: Any, path: tuple, value: Any) -> Any:
    """A copy of a scene with another value; None: without it."""
    if not path:
        return value
    copy = dict(scene) if isinstance(scene, dict) else list(scene)
    copy[path[0]] = changed(copy[path[0]], path[1:], value)
    return {key: item for key, item in copy.items() if item is not None} if isinstance(copy, dict) else copy


def scenes_with_another(scene: dict, path: tuple) -> Iterator[Scene]:
    """Valid scenes that differ in one key; the key is left out as well."""
    value = scene
    for part in path:
        value = value[part]
    out = [None] if path != ("time", "save_every") else []  # left out, frames are those of the run
    tables = [changed(scene, path, other) for other in (*others(value), *out)]
    whole = [table for end, table in WHOLE.items() if key_of(path).endswith(end) and table[path[-1]] != value]
    tables += [changed(scene, path[:-1], table) for table in whole]
    for table in tables:
        try:
            yield Scene.parse(table)
        except SceneError:
            continue


def begun(scene: Scene, folder: Path) -> Begun:
    text = scene.to_toml()
    return Begun(folder, Scene.parse(text), text, {})


def compared(name: str, folder: Path) -> set[str]:
    """The keys of a scene of which another value is refused, and named in the list and in its heading."""
    given, tried = Scene.parse(RICH[name]), set()
    run = begun(given, folder)
    for path in leaves(RICH[name]):
        key = key_of(path)
        for other in scenes_with_another(RICH[name], path):
            if other == given:  # the value is the default
                continue
            tried.add(key)
            if key in MAY_CHANGE:
                assert run.continued(other).time.end == other.time.end
                continue
            with pytest.raises(RunFolderError) as refused:
                run.continued(other)
            first, *lines = str(refused.value).splitlines()
            assert any(line.strip().startswith(key) for line in lines) and key in first, (key, refused.value)
    return tried


def test_every_key_that_changes_is_named(tmp_path):
    """Each in one scene at least: where values depend on each other, no other value of one may be valid."""
    tried = {name: compared(name, tmp_path) for name in RICH}
    keys = {name: {key_of(path) for path in leaves(RICH[name])} for name in RICH}
    of_kind = {key.replace("[1]", "[0]") for found in tried.values() for key in found}
    lacking = {key for found in keys.values() for key in found} - of_kind
    assert {key for key in lacking if key.replace("[1]", "[0]") not in of_kind} == set()
    assert of_kind >= MAY_CHANGE and sum(map(len, tried.values())) > 90


@pytest.mark.parametrize("name", RICH)
def test_an_added_or_removed_table_is_named(name, tmp_path):
    for table in ("steric", "units", "output", "box"):
        run = begun(Scene.parse(RICH[name]), tmp_path)
        without = {key: value for key, value in RICH[name].items() if key != table}
        if table not in RICH[name]:
            continue
        try:
            one = Scene.parse(without)
        except SceneError:
            continue
        with pytest.raises(RunFolderError, match=rf"{table}\..* in the run, not given in the scene"):
            run.continued(one)
        with pytest.raises(RunFolderError, match=rf"{table}\..*: not given in the run"):
            begun(one, tmp_path).continued(Scene.parse(RICH[name]))


def test_a_scene_with_its_defaults_or_their_values_is_the_same(tmp_path):
    """What a scene leaves out, the run has filled in: steps as they are taken, frames, animation."""
    tables = {"swimmers": [{"name": "c", "count": 1, "nodes": 33, "bend": 5e-3, "twist": 1e-3}]}
    given = Scene.parse({**tables, "time": {"end": 1.0, "step": 0.003}})
    run = begun(given.model_copy(update={"time": given.time.model_copy(update={"step": 0.0025})}), tmp_path)
    assert run.continued(Scene.parse({**tables, "time": {"end": 2.0, "step": 0.003}})).time.save_every == 0.01
    run.continued(Scene.parse({**tables, "time": {"end": 2.0, "step": 0.003}, "output": {"usd": False}}))
    run.continued(Scene.parse(run.text))
    with pytest.raises(RunFolderError, match=r"time\.save_every: 0\.01 in the run, 0\.02"):
        run.continued(Scene.parse({**tables, "time": {"end": 1.0, "step": 0.003, "save_every": 0.02}}))
    assert np.isclose(run.scene.time.step, 0.0025)
