"""The clock of an ensemble: the length of the step, its ratio to the previous step, and the time.

It is an array on the device, because a captured graph keeps the scalar arguments of its kernels fixed.
"""

import warp as wp

from warp_rods.kernels.layout import Scalars1D, real

wp.set_module_options({"enable_backward": False})

STEP = wp.constant(0)
"""Index of Δt in the clock array."""
RATIO = wp.constant(1)
"""Index of ρ, the ratio of this step to the previous one; 0 in the first step."""
TIME = wp.constant(2)
"""Index of the time t."""


@wp.kernel
def tick(clock: Scalars1D):
    """Advance the time by one step. The next step has the same length unless the host changes it; ``dim = 1``."""
    clock[TIME] += clock[STEP]
    clock[RATIO] = real(1.0)
