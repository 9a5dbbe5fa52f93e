"""Small valid scenes with every table and key, and hostile ones made from them."""

from __future__ import annotations

import random
from copy import deepcopy
from typing import Any

import tomli_w

from fuzz.hostile import broken_text, changed

FILAMENTS = {"name": "f", "count": 2, "nodes": 17, "length": 0.5, "stiffness": [1.0, 1.0, 1.0], "drag": [1.0, 2.0, 0.1]}
CELLS = {"name": "c", "count": 3, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
STERIC = {"strength": 5.0, "range": 0.02, "core": 0.08}
SPHERE = {"kind": "sphere", "radius": 1.0}
TIME = {"end": 1.0}
PLACED = {"at": "start", "position": [[1.0, 0, 0], [0, 1.0, 0]], "direction": [[0, 0, 1.0], [0, 0, 1.0]]}
FULL = {
    "moment": 0.1, "drag_ratio": 2.0, "rotational_drag": 3e-3, "symmetric": False,
    "flagella": {"relaxation": 1e-2, "diffusion": 1e-3, "profile": "tanh", "sharpness": 10.0, "law": "relaxing"},
    "shape": {"kind": "mode", "mode": 0, "amplitude": 1.0, "perturbation": 1e-3},
}  # fmt: skip
FORMULAS = {"bend": "3*sin(2*pi*s)", "bend1": 0.5, "twist": "cos(pi*s)**2", "amplitude": 2.0}
BEHAVIOUR = {"reversal": {"rate": 0.5}, "tumble": {"rate": [1.0, 2.0, 3.0], "duration": 0.1, "turn": 1.0}}
BODY = {"length": "20 um", "diameter": "0.8 um", "viscosity": "1 mPa s", "speed": "25 um/s", "drag": "cylinder"}
TRACK = {"times": [0.0, 0.3, 0.6, 1.0], "points": [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0, 0]], "periodic": True}
MOVED = [{"kind": "clamped", "motion": TRACK, "rotation": [0, "k*t", 0]}, {"kind": "hinged", "motion": ["0.1*t", 0, 0]}]
WALL = {"strength": 2000.0, "range": 0.05}

SPRINGS = {"name": "k", "count": 2, "nodes": 9, "stiffness": [1.0, 1.0, 1.0, 100.0, 50.0, 50.0]}
FULL_SPRINGS = {
    "natural": [1.0, 2.0, 0.0, 1.0, 0.0, 0.0], "drag_ratio": 2.0, "rotational_drag": 3e-3, "ends": ["clamped", "free"],
    "coupling": [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]], "shape": {"kind": "mode", "mode": 0, "stretch": 1.1},
    "force": [0.0, 0.0, -1.0], "couple": [0.1, 0.0, 0.0],
    "placement": {"at": "start", "position": [[0, 0, 0], [3.0, 0, 0]], "direction": [[0, 0, 1.0], [0, 1.0, 0]]},
}  # fmt: skip

BASES: tuple[dict[str, Any], ...] = (
    {"swimmers": [CELLS], "time": TIME},
    {"title": "t", "seed": 7, "swimmers": [CELLS | FULL], "time": TIME | {"step": 1e-3, "save_every": 0.1}},
    {"swimmers": [CELLS | {"nodes": "auto", "shape": {"kind": "writhe", "balanced": True}}], "time": TIME},
    {"swimmers": [CELLS | {"nodes": "auto", "shape": FORMULAS}], "time": TIME},
    {
        "swimmers": [CELLS | {"placement": {"position": [[0, 0, 0], [3, 0, 0], [6, 0, 0]]}}],
        "steric": STERIC, "time": TIME,
    },
    {"swimmers": [CELLS], "box": {"kind": "periodic", "size": [5.0, 5.0, 5.0]}, "steric": STERIC, "time": TIME},
    {
        "swimmers": [CELLS | {"placement": "polar lanes"}], "steric": STERIC, "time": TIME,
        "box": {"kind": "slab", "fraction": 0.05, "height": 0.2, "wall": WALL},
    },
    {
        "swimmers": [CELLS], "time": TIME,
        "box": {"kind": "container", "surface": SPHERE | {"radius": 2.0}, "side": "inside", "wall": WALL},
    },
    {
        "swimmers": [CELLS | {"flagella": {"law": "driven", "front": 0.5}, "behaviour": BEHAVIOUR}], "time": TIME,
        "box": {"kind": "pore", "radius": 1.0, "length": 4.0, "axis": "y", "ends": "closed", "wall": WALL},
    },
    {"swimmers": [CELLS], "box": {"kind": "duct", "sides": [1.0, 2.0], "length": 4.0}, "steric": STERIC, "time": TIME},
    {"surface": SPHERE, "filaments": [FILAMENTS], "time": TIME},
    {"surface": SPHERE, "filaments": [FILAMENTS | {"placement": PLACED, "ends": ["clamped", "free"]}], "time": TIME},
    {
        "surface": {"kind": "cassini", "a": 1.0, "b": 1.1}, "steric": STERIC | {"core": 0.04},
        "filaments": [FILAMENTS | {"intrinsic": [0.0, 1.5, 0.0], "growth": {"rate": 0.05, "until": 0.7}}],
        "time": TIME | {"tolerance": 0.01}, "units": {"length": "1 um"},
    },
    {
        "surface": {"kind": "plane", "size": 10.0},
        "filaments": [FILAMENTS | {"growth": {"time": [0.0, 1.0], "length": [0.5, 0.8], "spacing": 0.04}}],
        "time": TIME, "output": {"usd": False, "variables": ["energy", "gauss"], "frames_per_file": 10},
    },
    {
        "swimmers": [CELLS], "time": TIME,
        "sweep": {
            "swimmers.c.bend": {"from": 1e-3, "to": 1e-2, "num": 3, "scale": "log"}, "seeds": 2, "refine": 1,
            "swimmers.c.flagella.diffusion": [1e-3, 2e-3], "measure": ["speed", "class"], "keep": "summary",
        },
    },
    {
        "swimmers": [
            CELLS | {"parameters": {"k": [1.0, 2.0, 3.0], "w": 2.0}, "natural_bend": "k*sin(w*t - s)", "ends": MOVED}
        ],
        "time": TIME,
    },
    {
        "swimmers": [
            CELLS | {"body": BODY, "bend": "1e-24 N m^2", "ends": [{"kind": "clamped", "turning": "60 rpm"}, "free"]}
        ],
        "time": {"end": "2 s", "save_every": "0.5 s"}, "gravity": {"force": ["1 pN/um", 0.0, 0.0]},
    },
    {
        "surface": SPHERE | {"radius": "1000 nm"}, "units": {"length": "1 um", "time": "1 s", "force": "1 pN"},
        "filaments": [
            FILAMENTS
            | {"length": ["0.5 um", 0.4], "intrinsic": [0.0, "k*s", 0.0], "parameters": {"k": ["1 um^-1", 2.0]}}
        ],
        "time": TIME | {"end": "2 s"},
    },
    {"cosserat": [SPRINGS], "time": TIME},
    {"cosserat": [SPRINGS | FULL_SPRINGS], "time": TIME | {"step": 1e-2}},
    {
        "surface": {"kind": "cylinder", "radius": 1.0, "length": 6.0},
        "filaments": [
            FILAMENTS
            | {"intrinsic": [[0.0, "s - t", {"nodes": [0.1] * 17}], [0, 0, 0]], "stiffness": [1.0, "2 + s", 1.0]}
        ],
        "swimmers": [CELLS], "time": TIME,
    },
    {
        "swimmers": [CELLS | {"couple": "1e-3*s"}], "time": TIME, "gravity": {"force": [0.0, 0.0, -1.0]},
        "flow": {"kind": "shear", "rate": 1.0, "direction": [1.0, 0.0, 0.0], "gradient": [0.0, 1.0, 0.0]},
        "forces": [{"force": ["sin(x)", 0.0, "s*t"], "couple": [0.0, 0.0, 0.1], "on": ["c"]}],
    },
    {
        "surface": SPHERE, "filaments": [FILAMENTS], "time": TIME,
        "flow": {"kind": "formula", "velocity": ["sin(y)", "0", 1.0]},
    },
)  # fmt: skip


def text(number: int) -> str:
    """The hostile scene of this number, in TOML."""
    rng = random.Random(f"scene {number}")
    tables = changed(deepcopy(rng.choice(BASES)), rng)
    written = tomli_w.dumps(tables)
    return broken_text(written, rng) if rng.random() < 0.05 else written
