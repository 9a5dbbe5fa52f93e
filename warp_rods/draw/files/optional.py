"""Packages that only some exporters need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from warp_rods.errors import WarpRodsError

__all__ = ["needed"]


def needed(module: str, option: str, extra: str = "files") -> Any:
    """The module of a package; raises WarpRodsError with the extra to install where it is missing."""
    try:
        return import_module(module)
    except ModuleNotFoundError:
        package = module.split(".")[0]
        raise WarpRodsError(
            f"{option} needs the package {package}, which is not installed: pip install -e '.[{extra}]'"
        ) from None
