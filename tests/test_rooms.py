"""Import rules: which package may import which (declared in pyproject.toml), and lazy imports."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HEAVY = {"pxr", "matplotlib", "dask", "pyvista", "k3d", "numba", "elastica"}
SLOW = HEAVY | {"warp", "scipy", "sympy", "xarray", "pandas", "zarr", "trimesh"}
KERNELS_IMPORT = {"warp", "warp_rods", "ctypes", "functools", "os", "types", "typing"}


def test_imports_obey_the_rules(tmp_path):
    """The contracts of import-linter, on the tree as installed: kernels/ inside warp_rods/, which has a link to it."""
    without_caches = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "warp_rods", tmp_path / "warp_rods", ignore=without_caches)
    assert (tmp_path / "warp_rods" / "kernels" / "lie.py").is_file()
    lint = "import sys; from importlinter.cli import lint_imports_command; sys.exit(lint_imports_command())"
    command = [sys.executable, "-c", lint, "--no-cache", str(ROOT / "pyproject.toml")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("path", sorted((ROOT / "kernels").rglob("*.py")), ids=lambda p: p.stem)
def test_kernels_import_warp_alone(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imports = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imports |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert {name.split(".")[0] for name in imports} <= KERNELS_IMPORT
    assert all(name.startswith("warp_rods.kernels") for name in imports if name.startswith("warp_rods"))


def loaded_by(code: str) -> set[str]:
    """The top-level packages that a new process has loaded after some code."""
    said = f"import sys\n{code}\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    return set(done.stderr.split())


HELP = """from warp_rods.cli import app
try: app(["--help"])
except SystemExit: pass"""
SCENE = """from warp_rods.scene.scene import Scene
from warp_rods.simulation.estimates import check_memory
check_memory(Scene.load("scenes/expression.toml"))"""


@pytest.mark.parametrize("code, unwanted", [
    ("import warp_rods, warp_rods.scene", SLOW | {"numpy", "pydantic", "rich", "typer"}),
    (HELP, SLOW | {"numpy", "pydantic"}),
    (SCENE, SLOW),
    ("import warp_rods.workflow", SLOW - {"warp", "scipy"}),
])  # fmt: skip
def test_slow_packages_are_imported_where_they_are_used(code, unwanted):
    """The package, the help of the command line and the check of a scene need none; a run needs its trajectory's
    readers at its end only."""
    assert not unwanted & loaded_by(code)
