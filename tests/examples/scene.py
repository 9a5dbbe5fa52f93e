"""Scenes for tests: one with all tables, small ones with changes, and random valid ones."""

from copy import deepcopy

from hypothesis import strategies as st

from warp_rods.membranes.surfaces import SURFACES
from warp_rods.values import LARGEST, SMALLEST

DESIGN = """
title = "100 curvature sensors on a dividing cell"
seed = 7

[surface]                      # needed by [[filaments]] only
kind = "cassini"               # plane sphere ellipsoid cylinder torus cassini bridge undulated expression grid
a = 1.0                        # each kind's own parameters
b = 1.1

[[filaments]]                  # one ensemble; its name is its group in the trajectory
name = "sensors"
count = 100
nodes = 33
length = 0.5
stiffness = [1.0, 1.0, 1.0]    # B: twist, normal bending, geodesic bending
intrinsic = [0.0, 1.5, 0.0]    # σ
drag = [1.0, 2.0, 0.1]         # ζ∥, ζ⊥, ζr
ends = ["free", "free"]        # or "clamped"
placement = "random"           # uniform in area, isotropic in angle; or, one row a rod:

[[swimmers]]
name = "cell"
count = 1
nodes = 65
bend = 5e-3                    # β⊥ ; a list gives one value a rod
twist = 1e-3                   # β∥
moment = 0.0                   # M ; with 0 and a planar start the motion stays planar
drag_ratio = 2.0               # η
rotational_drag = 3e-3         # ηr
flagella = { relaxation = 1e-2, diffusion = 1e-3, profile = "tanh", sharpness = 10.0 }
shape = { kind = "mode", mode = 0, amplitude = 1.0 }
symmetric = false              # keep the π-rotation symmetry of appendix C.4 exactly

[steric]                       # absent: no steric forces
strength = 1.0                 # g0
range = 0.1                    # a
core = 0.05                    # ε

[time]
end = 1.0
step = 1e-3                    # absent: chosen and controlled
save_every = 0.01

[units]                        # optional: what one unit means, for reports and USD
length = "1 um"
"""

FILAMENTS = {"name": "f", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0]}
SWIMMERS = {"name": "s", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
PLACEMENT = {"position": [[1, 0, 0], [0, 1, 0]], "direction": [[0, 0, 1], [0, 0, 1]]}


def small(**changes) -> dict:
    """A valid scene with both kinds of rods and with changed keys, or keys of tables (table__key)."""
    tables = {
        "surface": {"kind": "sphere", "radius": 1},
        "filaments": [FILAMENTS],
        "swimmers": [SWIMMERS],
        "time": {"end": 2},
    }
    tables = deepcopy(tables)
    for path, value in changes.items():
        *table, key = path.split("__")
        owner = tables[table[0]] if table else tables
        owner = owner[0] if isinstance(owner, list) else owner
        owner[key] = value
    return tables


numbers = st.floats(-LARGEST, LARGEST) | st.integers(-(10**6), 10**6)
positive = st.floats(SMALLEST, LARGEST) | st.integers(1, 10**6)
alike = st.floats(1e-3, 1e6) | st.integers(1, 10**6)
"""Stiffnesses that are not too different."""
vectors = st.tuples(numbers, numbers, numbers)


def each(values, count):
    """One value, or a list with one for each rod."""
    return values | st.lists(values, min_size=count, max_size=count)


@st.composite
def placements(draw, count, nodes):
    rows = st.lists(vectors, min_size=count, max_size=count)
    some = vectors.filter(any)
    a_row = numbers | st.lists(numbers, min_size=nodes, max_size=nodes)
    table = {
        "at": draw(st.sampled_from(["middle", "start"])),
        "position": draw(rows),
        "direction": draw(st.lists(some, min_size=count, max_size=count)),
        "geodesic_curvature": draw(numbers | st.lists(a_row, min_size=count, max_size=count)),
    }
    return draw(st.sampled_from(["random", table]))


@st.composite
def scenes(draw):
    """Valid scenes as a user could write them."""
    count, nodes = draw(st.integers(1, 4)), draw(st.sampled_from([17, 19]))
    ensemble = {"count": count, "nodes": nodes}
    filaments = {
        **ensemble,
        "name": "f",
        "length": draw(each(positive, count)),
        "stiffness": draw(each(st.tuples(alike, alike, alike), count)),
        "intrinsic": draw(each(vectors, count)),
        "drag": draw(each(st.tuples(positive, positive, st.just(0) | positive), count)),
        "placement": draw(placements(count, nodes)),
    }
    swimmers = {
        **ensemble,
        "name": "s",
        "bend": draw(each(positive, count)),
        "twist": draw(each(positive, count)),
        "moment": draw(each(numbers, count)),
        "flagella": {
            "relaxation": draw(each(positive, count)),
            "profile": draw(st.sampled_from(["tanh", "uniform"])),
        },
        "shape": {
            "kind": draw(st.sampled_from(["mode", "writhe", "straight"])),
            "amplitude": draw(each(numbers, count)),
        },
        "symmetric": draw(st.booleans()),
    }
    characters = st.characters(codec="utf-8")
    kind = draw(st.sampled_from([k for k, row in SURFACES.items() if all(p.default for p in row.parameters.values())]))
    tables = {
        "title": draw(st.text(characters)),
        "seed": draw(st.integers(0, 2**63 - 1)),
        "surface": {"kind": kind},
        "filaments": [filaments],
        "swimmers": [swimmers],
        "time": {"end": draw(positive)},
        "steric": {"strength": 0, "range": draw(positive), "core": draw(positive)},
        "units": {"length": "1 um"},
    }
    for optional in draw(st.sets(st.sampled_from(["title", "swimmers", "steric", "units"]))):
        del tables[optional]
    return tables
