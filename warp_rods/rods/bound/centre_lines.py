"""Centre lines of filaments at the start, without an ensemble of them: for trying places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.bound import frames
from warp_rods.kernels.layout import to_host
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.arrays import allocate_lines, tracked_node
from warp_rods.rods.tiles import Tiled

__all__ = ["centre_lines"]


def centre_lines(
    surface: Surface,
    position: np.ndarray,
    direction: np.ndarray,
    nodes: int,
    parameters: Mapping[str, np.ndarray],
    clamped: tuple[bool, bool],
    device: Any = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Centre lines [rod, node, 3] of filaments whose middles are at points of the surface, and their ``Status`` [rod].

    position, direction [rod, 3]; parameters: length [rod], stiffness, intrinsic, drag [rod, 3] or [rod, node, 3]. They
    are geodesics but for free ends, which have their intrinsic strain, as those of ``BoundRods`` are without
    ``geodesic_curvature``.
    """
    device, count = device_of(device), len(position)
    middle, field = nodes // 2, frames.on_surface(surface.field)
    geodesic, places = np.zeros((count, nodes)), np.zeros((count, nodes, 3))
    free = [end for end, is_clamped in zip((0, -1), clamped, strict=True) if not is_clamped]
    intrinsic = parameters["intrinsic"][..., 2]
    geodesic[:, free] = intrinsic[:, None] if intrinsic.ndim == 1 else intrinsic[:, free]
    places[:, middle] = position
    with exclusive:
        f, plan = allocate_lines(parameters, nodes, clamped, middle, device)
        f.position.assign(places)
        Tiled(f.geodesic, count).assign(geodesic)
        ways: wp.array = wp.array(direction, dtype=wp.vec3d, device=device)
        on, ends = surface.device_parameters(device), [wp.vec3d(*corner) for corner in ends_of(surface)]
        tiles = f.geodesic.shape[0]
        wp.launch(field.place, dim=tiles, inputs=[f, plan, on, middle, ways], device=device)
        wp.launch(field.lay_out, dim=tiles, inputs=[f, plan, on, middle, *ends], device=device)
        status = plan.unfit.numpy().astype(np.int32)
        if (node := tracked_node(nodes, clamped)) != middle:  # where an ensemble holds a clamped end
            Tiled(plan.place, count).assign(to_host(f.position)[:, node])
            Tiled(plan.tangent, count).assign(Tiled(f.tangent, count).numpy()[:, node])
            wp.launch(field.lay_out, dim=tiles, inputs=[f, plan, on, node, *ends], device=device)
        return to_host(f.position), status
