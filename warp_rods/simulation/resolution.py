"""The number of nodes of an ensemble: chosen where it is "auto", and warned of where it is too small.

Both follow the same criteria (``criteria.py``), so that what is chosen is never warned of.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.scene.cosserat import CosseratTable
from warp_rods.scene.ensemble import AUTO
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.criteria import CELLS_PER_HALF_WAVE, Criterion

MOST_CHOSEN = 1001
"""The largest number of nodes that is chosen. More are rarely meant, and a step costs as much as they are many."""
MOST_NEEDED = 1e15
"""No criterion asks for more cells: a spacing may be zero in floating-point numbers."""
FEWEST_PER_HALF_WAVE = 2
"""Cells for each half-wave of a beam mode below which it looks like a lower mode, and is refused."""
ROUND_OFF = 1e-9

EnsembleTable = FilamentsTable | SwimmersTable | CosseratTable


@dataclass(frozen=True)
class Resolution:
    """The nodes of an ensemble, and lines for the user."""

    nodes: int
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def resolution(table: EnsembleTable, criteria: Sequence[Criterion]) -> Resolution:
    """The number of nodes of a table, chosen by the strictest criterion if it is "auto"; otherwise a warning if it
    does not meet it.

    Raises SceneError for a beam mode that the nodes cannot represent.
    """
    strictest = max(criteria, key=lambda criterion: nodes_needed(table, criterion))
    needed = nodes_needed(table, strictest)
    nodes = min(needed, MOST_CHOSEN) if table.nodes == AUTO else table.nodes
    if isinstance(table, SwimmersTable):
        _refuse_unseen_mode(table, nodes)
    apart = largest_length(table) / (nodes - 1)
    if nodes < needed:
        capped = f', the most that "{AUTO}" chooses,' if table.nodes == AUTO else ""
        return Resolution(
            nodes,
            warnings=[
                f"{table.name}: {nodes} nodes{capped} are {apart:.3g} apart, too far for results right to about 1 %: "
                f"{strictest.reason}; use {needed} nodes or more"
            ],
        )
    chosen = [f"{table.name}: {nodes} nodes chosen, {apart:.3g} apart: {strictest.reason}"]
    return Resolution(nodes, notes=chosen if table.nodes == AUTO else [])


def with_nodes(scene: Scene, numbers: Mapping[str, int]) -> Scene:
    """The scene with these numbers of nodes, by the name of the ensemble, where they are "auto"."""

    def filled(table: EnsembleTable) -> EnsembleTable:
        number = numbers.get(table.name)
        return table.model_copy(update={"nodes": number}) if table.nodes == AUTO and number is not None else table

    kinds = ("filaments", "swimmers", "cosserat")
    return scene.model_copy(update={kind: tuple(map(filled, getattr(scene, kind))) for kind in kinds})


def nodes_needed(table: EnsembleTable, criterion: Criterion) -> int:
    """The smallest odd number of nodes of this table that meets a criterion; with it a node is at the middle."""
    length = largest_length(table)
    growth = table.growth if isinstance(table, FilamentsTable) else None
    if growth is not None and growth.largest_spacing <= criterion.spacing:
        length = float(np.max(table.known_length))  # type: ignore[union-attr]  # more nodes are inserted as it grows
    by_spacing = length / criterion.spacing * (1 - ROUND_OFF) if criterion.spacing > 0 else math.inf
    cells = max(criterion.cells, math.ceil(min(by_spacing, MOST_NEEDED)))
    fewest = type(table).FEWEST_NODES
    return max(cells + cells % 2 + 1, fewest)


def largest_length(table: EnsembleTable) -> float:
    """The length of the longest rod, at the end of its growth."""
    if not isinstance(table, FilamentsTable):
        return 1.0
    growth = table.growth
    grown = [] if growth is None else [v for v in (growth.until, growth.length) if v is not None]
    return max(float(np.max(v)) for v in (table.known_length, *grown))


def _refuse_unseen_mode(table: SwimmersTable, nodes: int) -> None:
    mode = table.shape.mode or 0
    waves = mode + 1.5
    if table.shape.kind == "mode" and nodes - 1 < FEWEST_PER_HALF_WAVE * waves:
        raise SceneError(
            f"shape.mode = {mode}: {nodes} nodes for the {waves:g} half-waves of the mode {mode}: use "
            f"{2 * math.ceil(CELLS_PER_HALF_WAVE * waves / 2) + 1} or more"
        )
