"""Error against the number of steps, in steps of equal length and by error, and against nodes: docs/steps.png.

Run as ``python benchmarks/steps.py`` from the root of the project; ``python benchmarks/steps.py random`` prints errors
over tolerances of 200 random rods. Errors are the largest of any node at the end, in lengths of a rod, against a run
with a hundredth of the tolerance.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods import BoundRods, FreeRods, plots, surfaces
from warp_rods.membranes import sampling
from warp_rods.rods.modes import beam_mode

TOLERANCES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
STEPS = (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
NODES = (17, 25, 33, 49, 65, 97, 129)
FINEST = 257
PAGE: Path | None = Path(__file__).parent.parent / "docs" / "steps.png"
"""Where the figure is saved, unless None."""
BENT = {"kind": "mode", "amplitude": 3.0}


def swimmer(bend: float) -> Callable[[int], FreeRods]:
    return lambda nodes: FreeRods(1, nodes, bend=bend, twist=1e-3, shape=BENT, symmetric=True)


def sensors(nodes: int) -> BoundRods:
    """Sixteen sensors of ``proteins.toml`` without contact."""
    rng = np.random.default_rng(1)
    cell = surfaces.make("cassini", {"a": 1.0, "b": 1.1})
    position = sampling.uniform_points(cell, 16, rng)
    direction = sampling.isotropic_directions(cell, position, rng)
    return BoundRods(cell, position, direction, nodes=nodes, length=0.5, intrinsic=(0, 1.5, 0), drag=(1, 2, 0.1))


CASES: dict[str, tuple[Callable[[int], Any], int, float]] = {
    "U swimmer, bend 5e-3": (swimmer(5e-3), 65, 8.0),
    "waving swimmer, bend 1.3e-4": (swimmer(1.3e-4), 141, 10.0),
    "sensors on a neck": (sensors, 33, 6.0),
}
"""Name → rods with this many nodes, the number, and the time at the end."""


def error(rods: Any, exact: Any) -> float:
    """The largest distance of a node, in lengths of a rod; nodes of the finer rods that both have."""
    stride = (exact.nodes - 1) // (rods.nodes - 1)
    length = getattr(rods, "length", np.ones(rods.count))
    distance = np.linalg.norm(rods.position - exact.position[:, ::stride], axis=-1).max(axis=1)
    return float((distance / length).max())


def by_error(make: Callable[[int], Any], nodes: int, end: float, tolerance: float) -> tuple[Any, float, float]:
    """Rods, mean number of steps, and seconds."""
    rods, start = make(nodes), time.process_time()
    rods.advance_to(end, tolerance)
    return rods, float((rods.steps_taken + rods.steps_rejected).mean()), time.process_time() - start


def equal(make: Callable[[int], Any], nodes: int, end: float, step: float) -> tuple[Any, float, float]:
    """The same in steps of equal length."""
    rods, start = make(nodes), time.process_time()
    rods.step(step, round(end / step))
    return rods, float((rods.steps_taken + rods.steps_rejected).mean()), time.process_time() - start


def figure() -> None:
    page = plots.figure(plots.PAGE, 75)
    axes = page.subplots(1, 3)
    for colour, (name, (make, nodes, end)) in zip(plots.OKABE_ITO, CASES.items(), strict=False):
        exact, _, _ = by_error(make, nodes, end, TOLERANCES[-1] / 10)
        for label, run, values, marker in (("by error", by_error, TOLERANCES, "o-"), ("equal", equal, STEPS, "s--")):
            print(f"{name}, {label}: value, steps, error, seconds")
            found = []
            for value in values:
                rods, steps, seconds = run(make, nodes, end, value)
                if not rods.status.any():
                    found.append((value, steps, error(rods, exact), seconds))
                    print("   {:g} {:.0f} {:.2g} {:.3f}".format(*found[-1]))
            column = np.array(found).T
            axes[0].loglog(column[1], column[2], marker, color=colour, ms=3, label=f"{name}, {label}")
            if label == "by error":
                axes[1].loglog(column[0], column[2], marker, color=colour, ms=3)
        finest, _, _ = by_error(make, FINEST, end, 1e-3)
        in_space = [(n, error(by_error(make, n, end, 1e-3)[0], finest)) for n in NODES if (FINEST - 1) % (n - 1) == 0]
        print(f"{name}: nodes, error: {in_space}")
        axes[2].loglog(*np.array(in_space).T, "o-", color=colour, ms=3)
    axes[1].loglog(TOLERANCES, TOLERANCES, color="0.6", linewidth=0.8)
    for panel, label in zip(axes, ("steps of a rod", "tolerance", "nodes"), strict=True):
        panel.set_xlabel(label)
    axes[2].set_xticks([17, 33, 65, 129], ["17", "33", "65", "129"])
    axes[2].minorticks_off()
    axes[0].set_ylabel("error at the end ($L$)")
    page.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize=6)
    if PAGE is not None:
        page.savefig(PAGE, dpi=150)


def random_swimmers(rng: np.random.Generator, count: int = 120, nodes: int = 65) -> Callable[[], FreeRods]:
    bend = 10 ** rng.uniform(-4, np.log10(2e-2), count)
    twist = bend * 10 ** rng.uniform(-1, 2, count)
    moment = np.where(rng.random(count) < 0.5, 0, 10 ** rng.uniform(-4, -2, count))
    modes = np.array([beam_mode(j, np.linspace(-0.5, 0.5, nodes)) for j in range(4)])
    shape = np.zeros((count, nodes, 3))
    shape[..., 2] = 2 * rng.normal(size=(count, 4)) @ modes
    shape[..., 1] = np.where(moment[:, None] != 0, rng.normal(size=(count, 4)) @ modes, 0)
    return lambda: FreeRods(count, nodes, bend=bend, twist=twist, moment=moment, shape=shape)


def random_filaments(
    rng: np.random.Generator, kind: str, values: dict, ends: tuple[str, str] = ("free", "free"), grows: bool = False
) -> Callable[[], BoundRods]:
    surface, count = surfaces.make(kind, values), 16
    position = sampling.uniform_points(surface, count, rng)
    direction = sampling.isotropic_directions(surface, position, rng)
    given = {
        "stiffness": 10 ** rng.uniform(-1, 1.5, (count, 3)), "intrinsic": rng.normal(size=(count, 3)) * [0.7, 1, 0.7],
        "drag": np.c_[np.ones(count), rng.uniform(1, 3, count), 10 ** rng.uniform(-1.5, 0, count)],
        "length": rng.uniform(0.3, 0.9, count), "growth": {"rate": 0.5, "until": 1.2} if grows else None,
        "ends": ends, "at": "start" if "clamped" in ends else "middle",
    }  # fmt: skip
    return lambda: BoundRods(surface, position, direction, nodes=33, **given)


def random_errors(tolerance: float = 0.01) -> None:
    rng = np.random.default_rng(13)
    torus, clamped = ("torus", {"major": 1.0, "minor": 0.4}), ("clamped", "free")
    makers = {
        "swimmers": (random_swimmers(rng), 2.0),
        "torus": (random_filaments(rng, *torus), 1.0),
        "dividing cell": (random_filaments(rng, "cassini", {"a": 1.0, "b": 1.1}), 1.0),
        "undulated": (random_filaments(rng, "undulated", {"radius": 1.0, "amplitude": 0.16, "wavenumber": 5.0}), 1.0),
        "clamped": (random_filaments(rng, *torus, clamped), 1.0),
        "growing": (random_filaments(rng, "ellipsoid", {"radii": [1.0, 0.8, 0.6]}, clamped, True), 1.0),
    }
    every = []
    for name, (make, end) in makers.items():
        found, exact = make(), make()
        found.advance_to(end, tolerance)
        exact.advance_to(end, tolerance / 100)
        well = (found.status == 0) & (exact.status == 0)
        length = getattr(found, "length", np.ones(found.count))
        share = np.linalg.norm(found.position - exact.position, axis=-1).max(axis=1)[well] / length[well] / tolerance
        every.append(share)
        taken, (half, most, worst) = found.steps_taken, np.quantile(share, [0.5, 0.95, 1])
        print(f"{name}, {well.sum()} of {len(well)}: {np.median(taken):.0f} steps, {taken.max()} at most")
        print(f"    error over tolerance: {half:.2g} median, {most:.2g} in 95 %, {worst:.2g} at most")
    share = np.concatenate(every)
    below, below_three = (share <= 1).mean(), (share <= 3).mean()
    print(f"{len(share)} rods: {below:.3f} below the tolerance, {below_three:.3f} below three times that")


def main() -> None:
    logging.getLogger("warp_rods").setLevel(logging.ERROR)  # equal steps that are too long are meant to be
    if "random" in sys.argv[1:]:
        random_errors()
    else:
        figure()


if __name__ == "__main__":
    main()
