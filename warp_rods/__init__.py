"""warp_rods: geometrically exact Kirchhoff rods at low Reynolds number, in batches, on NVIDIA Warp.

Names are imported when they are first used: importing the kernels costs nothing else.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "BoundRods": "warp_rods.bound_rods",
    "FreeRods": "warp_rods.free_rods",
    "Scene": "warp_rods.scene",
    "Simulation": "warp_rods.simulation",
    "export_usd": "warp_rods.usd",
    "open_run": "warp_rods.trajectory",
    "run": "warp_rods.runner",
    "buckling": "",
    "continuation": "",
    "diagnostics": "",
    "errors": "",
    "kymograph": "",
    "modes": "",
    "plots": "",
    "reproduce": "",
    "sensing": "",
    "stability": "",
    "steady": "",
    "surfaces": "",
    "swarm": "",
}
"""Public name → module that has it; "" for a module itself."""

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'warp_rods' has no attribute {name!r}")
    home = _HOME[name]
    found = getattr(import_module(home), name) if home else import_module(f"warp_rods.{name}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
