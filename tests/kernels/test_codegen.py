"""CUDA code generation without a GPU: every kernel compiles to PTX, where a tile is one rod (``ptx.py``)."""

import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
import warp as wp

import warp_rods.kernels

SCRIPT = Path(__file__).with_name("ptx.py")
ARCHITECTURE = 80
ROOMS = sorted(found.name for found in pkgutil.iter_modules(warp_rods.kernels.__path__))
MADE = (
    "samplers of every surface",
    "frames on a torus",
    "motion of a torus",
    "walls of a slab and of every surface",
    "an external force",
)

needs_compiler = pytest.mark.skipif(
    ARCHITECTURE not in wp.get_cuda_supported_archs(), reason="this build of Warp cannot generate CUDA code"
)


def compiled(folder: Path, *names: str) -> list[str]:
    """The lines of the script, one for each module."""
    done = subprocess.run([sys.executable, SCRIPT, folder, *names], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@needs_compiler
@pytest.mark.parametrize(
    "name",
    # The compiler takes minutes for steps of swimmers, a minute for those of filaments, and 20 s for those of others.
    [*(pytest.param(name, marks=pytest.mark.long) for name in ("free", "bound", "cosserat")), "others"],
)
def test_written_kernels_compile_to_ptx(name, tmp_path):
    names = [name] if name != "others" else [room for room in ROOMS if room not in ("free", "bound", "cosserat")]
    assert len(compiled(tmp_path, *names)) >= 3


@pytest.mark.long
@needs_compiler
@pytest.mark.parametrize("name", MADE)
def test_made_kernels_compile_to_ptx(name, tmp_path):
    assert compiled(tmp_path, name)
