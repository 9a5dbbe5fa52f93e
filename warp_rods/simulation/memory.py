"""Scenes that cannot fit into memory, or into floating-point numbers, are refused before any memory is taken."""

from __future__ import annotations

import os

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.kernels.contact.cutoff import CUTOFF
from warp_rods.scene.ensemble import AUTO
from warp_rods.scene.scene import Scene

BYTES_OF_A_NODE = 800
"""State, workspace and output of a node; about, and rather less."""
LARGEST_DISTANCE = 1e100
"""Powers of steric distances must be finite numbers."""
BYTES_OF_A_PAIR = 8
"""An entry in the lists of neighbours."""


def memory() -> float:
    """Bytes of memory of the machine; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def check_memory(scene: Scene) -> None:
    """Raises SceneError naming the table whose rods, or whose neighbours along the same rod, need too much memory.

    Also for a steric distance whose powers overflow. Tables whose nodes are not chosen yet are left out.
    """
    available = memory()
    for key in ("range", "core"):
        if scene.steric is not None and (value := getattr(scene.steric, key)) > LARGEST_DISTANCE:
            raise SceneError(f"steric.{key} = {value:g}: must be {LARGEST_DISTANCE:g} at most")
    for kind in ("swimmers", "filaments"):
        for index, table in enumerate(getattr(scene, kind)):
            if table.nodes == AUTO:
                continue
            nodes = float(table.count) * table.nodes
            _check(f"{kind}[{index}].count = {table.count}, nodes = {table.nodes}", nodes * BYTES_OF_A_NODE, available)
            if scene.steric is None or scene.steric.strength == 0:
                continue
            length = float(np.max(getattr(table, "length", 1.0)))
            near = min(table.nodes, 2 * CUTOFF * scene.steric.range * (table.nodes - 1) / length)
            what = (
                f"{kind}[{index}].nodes = {table.nodes}: each has {near:.3g} neighbours within the steric range, which"
            )
            _check(what, nodes * near * BYTES_OF_A_PAIR, available)


def _check(what: str, needed: float, available: float) -> None:
    if needed > available:
        raise SceneError(
            f"{what} need about {needed / 2**30:.3g} GiB of memory, and this machine has {available / 2**30:.3g}: use "
            f"fewer rods or nodes, or divide the scene"
        )
