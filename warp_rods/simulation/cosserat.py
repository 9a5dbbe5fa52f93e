"""Extensible and shearable rods of a scene on a device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.contact.arrangements import given_poses
from warp_rods.errors import SceneError
from warp_rods.rods.cosserat.rods import CosseratRods
from warp_rods.rods.per_rod import each_rod
from warp_rods.scene.cosserat import CosseratTable
from warp_rods.simulation.criteria import criteria_of_cosserat
from warp_rods.simulation.resolution import Resolution, resolution

if TYPE_CHECKING:
    from warp_rods.simulation.layout import Layout


def nodes_of(layout: Layout, table: CosseratTable) -> Resolution:
    """The number of nodes of a table, with a warning where it is small."""
    return resolution(table, criteria_of_cosserat(table, layout.scene.steric))


def build(layout: Layout, table: CosseratTable) -> None:
    """Add an ensemble of extensible and shearable rods to the layout."""
    placed: dict[str, Any] = {}
    if table.placement is not None:
        placed = given_poses(table.placement.position, table.placement.direction) | {"at": table.placement.at}
    rods = CosseratRods(
        table.count,
        table.node_count,
        stiffness=_matrices(table),
        natural=each_rod(table.natural, table.count, 6)[:, None],
        drag_ratio=table.drag_ratio,
        rotational_drag=table.rotational_drag,
        shape=table.shape.model_dump(exclude_none=True),
        ends=table.ends,
        device=layout.device,
        **placed,
    )
    if table.force is not None:
        if layout.scene.steric:
            raise SceneError(f"force = {list(table.force)}: not possible with [steric], which gives the force")
        rods.force = table.force
    if table.couple is not None:
        rods.couple = table.couple
    layout.ensembles[table.name] = rods


def _matrices(table: CosseratTable) -> np.ndarray:
    """K [rod, 6, 6]; raises SceneError where the coupling leaves it without a positive smallest eigenvalue."""
    K = np.einsum("ri,ij->rij", each_rod(table.stiffness, table.count, 6), np.eye(6))
    if table.coupling is not None:
        K[:, :3, 3:] = np.array(table.coupling)
        K[:, 3:, :3] = np.array(table.coupling).T
        if (least := float(np.linalg.eigvalsh(K).min())) <= 0:
            raise SceneError(
                f"coupling: the stiffness must be positive definite; its smallest eigenvalue is {least:.3g}"
            )
    return K
