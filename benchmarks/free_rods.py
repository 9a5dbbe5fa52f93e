"""Rod-steps per second of active rods with 65 nodes, planar and in space: ``python benchmarks/free_rods.py``."""

import time

import numpy as np
import warp as wp

from warp_rods.rods.free.rods import FreeRods

NODES = 65
STEPS = {1: 20_000, 100: 400, 1000: 40}
REPEATS = 5


def ensemble(count: int, spatial: bool, external=None) -> FreeRods:
    """Rods with a range of stiffnesses, and in space also of active moments."""
    share = np.linspace(0.0, 1.0, count)
    kind = {"kind": "writhe", "amplitude": 2.0} if spatial else {"kind": "mode", "amplitude": 2.0}
    moment = 5e-3 * (1.0 + share) if spatial else 0.0
    return FreeRods(count, NODES, bend=1e-3 * (1.0 + share), twist=1e-3, moment=moment, shape=kind, external=external)


@wp.func
def shear(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    """A force per length along x that is proportional to y."""
    return wp.vec3d(wp.float64(0.1) * x[1], wp.float64(0.0), wp.float64(0.0))


def seconds_per_step(rods: FreeRods, steps: int) -> float:
    """The shortest time per step over several repeats."""
    rods.step(1e-3, 10)
    shortest = np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        rods.step(1e-3, steps)
        wp.synchronize()
        shortest = min(shortest, time.perf_counter() - start)
    assert not rods.status.any()
    return shortest / steps


def main() -> None:
    """Print a table."""
    wp.config.log_level = wp.LOG_WARNING
    print(f"{'':14}{'rods':>6}{'µs/step':>10}{'rod-steps/s':>13}{'ns/node':>9}")
    for name, spatial, external in (("planar", False, None), ("space", True, None), ("space, forced", True, shear)):
        for count, steps in STEPS.items():
            seconds = seconds_per_step(ensemble(count, spatial, external), steps)
            print(
                f"{name:14}{count:6}{seconds * 1e6:10.1f}{count / seconds:13.0f}{seconds * 1e9 / count / NODES:9.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
