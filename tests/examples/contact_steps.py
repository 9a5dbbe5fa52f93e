"""Steps of one ensemble under a force and a stiffness of contact that are given as functions of the places."""

import numpy as np

from warp_rods.rods.together import Together, exhaust


def take_steps(rods, dt, steps, force, stiffness=None):
    """Equal steps under ``force`` (t, r [rod, node, 3]) and the ``stiffness`` (r) [rod, node, 3, 3] of contact, if any.

    Both are evaluated where and when contact evaluates them: at the extrapolated end of each step.
    """
    _ = rods.force_array if stiffness is None else rods.contact_stiffness_array
    exhaust(Together([rods], Given(rods, force, stiffness)).advance(dt, steps))
    rods.show()


class Given:
    """Forces of ``Together`` from functions."""

    def __init__(self, rods, force, stiffness):
        self._rods, self._force, self._stiffness = rods, force, stiffness

    def apply(self):
        rods = self._rods
        r = rods.position_array.numpy().copy()
        rods.force_array.assign(np.broadcast_to(self._force(rods.reached + rods._clock.step, r), r.shape))
        if self._stiffness is not None:
            K = np.broadcast_to(self._stiffness(r), (*r.shape, 3))
            rods.contact_stiffness_array.assign(np.ascontiguousarray(K))
        return 0.0

    def keep(self):
        pass


def try_one(rods, dt, force, stiffness=None):
    """A step without its end."""
    rods.set_step(dt)
    rods.prepare_step(dt)
    rods.predict_step()
    Given(rods, force, stiffness).apply()
    rods.try_step()
