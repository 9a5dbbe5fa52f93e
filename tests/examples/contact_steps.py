"""Steps of one ensemble under a force and a stiffness of contact that are given as functions of the places."""

import numpy as np


def take_steps(rods, dt, steps, force, stiffness=None):
    """Equal steps under ``force`` (t, r [rod, node, 3]) and the ``stiffness`` (r) [rod, node, 3, 3] of contact, if any.

    Both are evaluated where and when contact evaluates them: at the extrapolated end of each step.
    """
    _ = rods.force_array if stiffness is None else rods.contact_stiffness_array
    for length in rods.lengths_of_steps(dt, steps):
        try_one(rods, length, force, stiffness)
        rods.accept_step()
        rods.finish_step()
    rods.show()


def try_one(rods, dt, force, stiffness=None):
    """A step without its end."""
    rods.set_step(dt)
    rods.prepare_step(dt)
    rods.predict_step()
    r = rods.position_array.numpy().copy()
    rods.force_array.assign(np.broadcast_to(force(rods.time + dt, r), r.shape))
    if stiffness is not None:
        rods.contact_stiffness_array.assign(np.ascontiguousarray(np.broadcast_to(stiffness(r), (*r.shape, 3))))
    rods.try_step()
