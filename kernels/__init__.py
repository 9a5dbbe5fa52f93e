"""The equations on the device: Warp functions that read like the equations, and kernels that index, call and store.

Kernels import Warp and each other, nothing else. The order in which they are launched is decided by ``warp_rods.rods``
and ``warp_rods.contact``.
"""
