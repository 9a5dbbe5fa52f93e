"""The house: which room may know which (design), and what is imported only where it is used."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import warp_rods
from warp_rods import kernels

ROOMS = [
    {"kernels"},
    {"errors", "quiet", "recorded", "per_rod", "variables", "growth"},
    {"surfaces", "membrane", "surface_kinds", "enclosure", "in_time"}
    | {"expression", "formula", "field_source", "level_set", "distance"},
    {"modes", "elements", "airy", "symmetry", "tension", "stability", "flagella", "swimmer_shapes"},
    {"bound_rods", "bound_checks", "bound_arrays", "bound_launches", "placement", "overlap", "barrier", "step_limits"},
    {"free_rods", "free_arrays", "free_launches", "free_readings"},
    {"buckling", "twisted_stability"},
    {"neighbours", "walls"},
    {"scene_toml", "scene_checks", "scene_tables", "scene_box", "scene_ensembles", "scene"},
    {"steady_equations", "steady", "continuation"},
    {"store", "trajectory"},
    {"writhe", "measures", "motion_class", "diagnostics", "sensing", "kymograph"}
    | {"swarm_data", "swarm_order", "swarm_motion", "swarm_space", "swarm_shapes", "segment_sweeps", "crossings"},
    {"usd", "usd_box", "usd_curves", "usd_load", "usd_look", "usd_membrane", "summary", "plots"}
    | {"swarm", "swarm_plots"},
    {"crowd", "ensembles"},
    {"surroundings", "contact"},
    {"simulation"},
    {"run_folder"},
    {"runner"},
    {"reproductions"},
    {"reproduce"},
    {"cli", "__main__"},
]
"""Lowest first: a module imports from its own room or a lower one. reproductions is a package, one room as a whole."""

SIMULATION_SIDE = {"simulation", "ensembles", "bound_rods", "free_rods", "neighbours", "contact"}
EXPORTERS = {"usd", "usd_box", "usd_curves", "usd_load", "usd_look", "usd_membrane", "summary", "plots"}
PACKAGES = {"kernels", "reproductions"}
HEAVY = {"pxr", "matplotlib", "dask", "pyvista", "k3d"}


def modules() -> dict[str, Path]:
    return {path.stem: path for path in Path(warp_rods.__file__).parent.glob("*.py") if path.stem != "__init__"}


def imports(path: Path) -> set[str]:
    """Modules of this package that a file imports, anywhere in it; a subpackage counts as one."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {a.name.split(".")[1] for a in node.names if a.name.startswith("warp_rods.")}
        elif isinstance(node, ast.ImportFrom):
            here = path.parent.name if node.level == 1 else "warp_rods"
            base = (f"{here}." if node.level else "") + (node.module or "")
            if base.rstrip(".") == "warp_rods":
                found |= {a.name for a in node.names}
            elif base.startswith("warp_rods."):
                found.add(base.split(".")[1])
    return found & (modules().keys() | PACKAGES)


def imports_of(name: str) -> set[str]:
    """Those of a module, or of every file of a subpackage."""
    package = Path(warp_rods.__file__).parent / name
    files = package.glob("*.py") if name in PACKAGES else [modules()[name]]
    return set().union(*map(imports, files))


def floor(name: str) -> int:
    return next(level for level, room in enumerate(ROOMS) if name in room)


def test_every_module_has_a_room():
    assert modules().keys() | PACKAGES == set().union(*ROOMS)


@pytest.mark.parametrize("name", [*sorted(modules()), "reproductions"])
def test_arrows_go_one_way(name):
    upwards = {other for other in imports_of(name) if floor(other) > floor(name)}
    assert not upwards


def test_the_simulation_imports_no_exporter():
    reached, new = set(), set(SIMULATION_SIDE)
    while new:
        reached |= new
        new = set().union(*map(imports_of, new)) - {"kernels"} - reached
    assert not reached & EXPORTERS


@pytest.mark.parametrize("path", sorted(Path(kernels.__file__).parent.glob("*.py")), ids=lambda p: p.stem)
def test_kernels_import_warp_alone(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    outside = {a.name.split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    outside |= {
        n.module.split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and not n.level and n.module
    }
    assert outside <= {"warp", "functools", "types", "typing"}


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, warp_rods, warp_rods.cli; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not HEAVY & set(loaded)
