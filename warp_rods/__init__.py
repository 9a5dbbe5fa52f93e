"""warp_rods: geometrically exact Kirchhoff rods at low Reynolds number, in batches, on NVIDIA Warp.

Names are imported when they are first used: importing the kernels costs nothing else.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "BoundRods": "warp_rods.rods.bound.rods",
    "FreeRods": "warp_rods.rods.free.rods",
    "Scene": "warp_rods.scene.scene",
    "Simulation": "warp_rods.simulation.loop",
    "export_usd": "warp_rods.draw.usd.export",
    "open_run": "warp_rods.simulation.trajectory",
    "every": "warp_rods.simulation.hooks",
    "run": "warp_rods.workflow",
    "buckling": "warp_rods.theory.buckling",
    "continuation": "warp_rods.theory.continuation",
    "diagnostics": "warp_rods.analysis.diagnostics",
    "errors": "warp_rods.errors",
    "kymograph": "warp_rods.analysis.kymograph",
    "measure": "warp_rods.analysis.registry",
    "measures": "warp_rods.analysis.registry",
    "modes": "warp_rods.rods.modes",
    "plot": "warp_rods.draw.measured",
    "plots": "warp_rods.draw.plots",
    "reproduce": "warp_rods.reproductions.reproduce",
    "sensing": "warp_rods.analysis.sensing",
    "stability": "warp_rods.theory.stability",
    "steady": "warp_rods.theory.steady",
    "surfaces": "warp_rods.membranes.surfaces",
    "swarm": "warp_rods.draw.swarm",
}
"""Public name → module that has it, or is it."""

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'warp_rods' has no attribute {name!r}")
    module = import_module(_HOME[name])
    found = getattr(module, name, module)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
