"""Packages that benchmarks use and the simulation does not."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

INSTALL = "pip install 'warp-rods[bench]'"
PACKAGES = {"numba": "Numba", "elastica": "PyElastica"}
"""Name of the module → name of the package."""


def missing(*modules: str) -> str:
    """A line about those of ``modules`` that are not installed, or an empty text."""
    absent = [PACKAGES[module] for module in modules if find_spec(module) is None]
    return f"left out, as {' and '.join(absent)} is not installed: {INSTALL}" if absent else ""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function compiled by Numba, at its first call; where Numba is missing, as it is in Python."""
    if find_spec("numba") is None:
        return function
    import numba

    return numba.njit(cache=True)(function)  # type: ignore[no-any-return]
