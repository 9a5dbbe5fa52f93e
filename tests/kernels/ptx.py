"""Compiles every kernel to PTX as on a machine with a GPU, where a tile is one rod: ``python ptx.py FOLDER [NAME...]``.

Modules that contain Warp functions only are compiled with the kernels that call them. A kernel made by a factory has a
Warp module of its own: add a row to ``MADE`` that makes a typical one. A name is one of ``MADE``, or the beginning of
the names of modules in ``warp_rods.kernels``, such as ``free``.
"""

import ctypes
import importlib
import pkgutil
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from unittest import mock

import warp as wp

with mock.patch.object(ctypes, "CDLL"):  # the answer of a machine with a CUDA driver
    import warp_rods.kernels.lanes

import warp_rods.kernels
from warp_rods.kernels.bound import frames as bound_frames
from warp_rods.kernels.contact import box
from warp_rods.kernels.free import load
from warp_rods.kernels.surface import geometry as surface
from warp_rods.membranes.surfaces import SURFACES

ARCHITECTURE = 80
CPU_ONLY = {"warp_rods.kernels.contact.pair_lanes"}
"""Written for vector instructions of CPUs; on a GPU ``steric.py`` does the same."""


@wp.func
def weight(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64) -> wp.vec3d:
    """A force density that depends on all three arguments."""
    return -t * x + tangent


MADE: dict[str, Callable[[], list[wp.Module | ModuleType]]] = {
    # Name for the report → function that returns the modules.
    "samplers of every surface": lambda: [
        kernel.module for row in SURFACES.values() for kernel in vars(surface.sampler(row.field)).values()
    ],
    "frames on a torus": lambda: [
        kernel.module for kernel in vars(bound_frames.on_surface(SURFACES["torus"].field)).values()
    ],
    "motion of a torus": lambda: [
        bound_frames.motion_of(SURFACES["torus"].field, SURFACES["torus"].rate({})).module,
    ],
    "walls of a slab and of every surface": lambda: [
        box.walls_of(field).module for field in (box.slab, *(row.field for row in SURFACES.values()))
    ],
    "an external force": lambda: [load.force_field(weight).module],
}


def kernel_keys(module: wp.Module | ModuleType) -> set[str]:
    """Names of the kernels of a module."""
    return set((wp.get_module(module.__name__) if isinstance(module, ModuleType) else module).kernels)


def written_modules() -> list[ModuleType]:
    """Modules of the package that define kernels."""
    names = [found.name for found in pkgutil.walk_packages(warp_rods.kernels.__path__, "warp_rods.kernels.")]
    modules = [importlib.import_module(name) for name in names]
    return [module for module in modules if kernel_keys(module) and module.__name__ not in CPU_ONLY]


def compiled_keys(module: wp.Module | ModuleType, folder) -> set[str]:
    """Names of the kernels that are entry points of the module's PTX, less Warp's hash and suffix."""
    paths = wp.compile_aot_module(module, arch=ARCHITECTURE, module_dir=folder, use_ptx=True)
    assert [path.suffix for path in paths] == [".ptx"]
    return set(re.findall(r"\.entry (\w+)_[0-9a-f]+_cuda_kernel_forward", paths[0].read_text()))


def check_every_kernel(module: wp.Module | ModuleType, folder) -> None:
    # Warp omits a generic kernel without overloads, and only warns of it: such a kernel would be missing here.
    assert compiled_keys(module, folder) == kernel_keys(module)


def main(folder: str, *names: str) -> None:
    assert warp_rods.kernels.lanes.WIDTH == 1
    modules: list[wp.Module | ModuleType] = []
    for name in names:
        here = f"warp_rods.kernels.{name}"
        modules += MADE[name]() if name in MADE else [m for m in written_modules() if m.__name__.startswith(here)]
    for module in modules:
        check_every_kernel(module, Path(folder))
        print(len(kernel_keys(module)), "kernels in", getattr(module, "__name__", module))


if __name__ == "__main__":
    main(*sys.argv[1:])
