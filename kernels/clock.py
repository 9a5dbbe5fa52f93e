"""The clock of an ensemble: the length of the step, and the time.

It is an array on the device, because a captured graph keeps the scalar arguments of its kernels fixed.
"""

import warp as wp

wp.set_module_options({"enable_backward": False})

STEP = wp.constant(0)
"""Index of Δt in the clock array; the time that the steps have reached follows it."""
