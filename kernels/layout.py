"""Where an array's words lie in memory: decided here and nowhere else.

Every per-node array of an ensemble is indexed ``[rod, node]``. On the CPU, where one thread walks a rod,
a rod's nodes are neighbours in memory; on a GPU, where neighbouring threads hold neighbouring rods, the
rods are. Kernels never notice: Warp arrays carry their strides.
"""

import warp as wp

real = wp.float64
"""The number type of everything that a derivative or a solve is taken of."""


def per_node(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods, nodes]`` in the memory order that suits the device."""
    if wp.get_device(device).is_cuda:
        return wp.zeros((nodes, rods), dtype=dtype, device=device).transpose()
    return wp.zeros((rods, nodes), dtype=dtype, device=device)


def per_rod(rods: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods]``."""
    return wp.zeros(rods, dtype=dtype, device=device)


def to_host(array: wp.array):
    """A NumPy copy of an array; on the CPU ``array.numpy()`` would be a view of memory that the next step changes."""
    return array.numpy().copy()
