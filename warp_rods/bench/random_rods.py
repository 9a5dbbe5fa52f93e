"""Errors over tolerances of rods with random parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from warp_rods.bench.result import Cell, Settings, Table
from warp_rods.membranes import sampling, surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode

Make = Callable[[], Any]
TOLERANCE = 0.01


def random_swimmers(rng: np.random.Generator, count: int, nodes: int = 65) -> Make:
    bend = 10 ** rng.uniform(-4, np.log10(2e-2), count)
    twist = bend * 10 ** rng.uniform(-1, 2, count)
    moment = np.where(rng.random(count) < 0.5, 0, 10 ** rng.uniform(-4, -2, count))
    modes = np.array([beam_mode(j, np.linspace(-0.5, 0.5, nodes)) for j in range(4)])
    shape = np.zeros((count, nodes, 3))
    shape[..., 2] = 2 * rng.normal(size=(count, 4)) @ modes
    shape[..., 1] = np.where(moment[:, None] != 0, rng.normal(size=(count, 4)) @ modes, 0)
    return lambda: FreeRods(count, nodes, bend=bend, twist=twist, moment=moment, shape=shape)


def random_filaments(
    rng: np.random.Generator,
    count: int,
    kind: str,
    values: dict[str, Any],
    ends: tuple[str, str] = ("free", "free"),
    grows: bool = False,
) -> Make:
    surface = surfaces.make(kind, values)
    position = sampling.uniform_points(surface, count, rng)
    direction = sampling.isotropic_directions(surface, position, rng)
    given: dict[str, Any] = {
        "stiffness": 10 ** rng.uniform(-1, 1.5, (count, 3)), "intrinsic": rng.normal(size=(count, 3)) * [0.7, 1, 0.7],
        "drag": np.c_[np.ones(count), rng.uniform(1, 3, count), 10 ** rng.uniform(-1.5, 0, count)],
        "length": rng.uniform(0.3, 0.9, count), "growth": {"rate": 0.5, "until": 1.2} if grows else None,
        "ends": ends, "at": "start" if "clamped" in ends else "middle",
    }  # fmt: skip
    return lambda: BoundRods(surface, position, direction, nodes=33, **given)


def random_errors(swimmers: int, filaments: int, settings: Settings, tolerance: float = TOLERANCE) -> Table:
    """Steps, and errors at the end over the tolerance, of each kind and of all."""
    rng = np.random.default_rng(13)
    torus, clamped = ("torus", {"major": 1.0, "minor": 0.4}), ("clamped", "free")
    bumpy, ellipsoid = {"radius": 1.0, "amplitude": 0.16, "wavenumber": 5.0}, {"radii": [1.0, 0.8, 0.6]}
    makers = {
        "swimmers": (random_swimmers(rng, swimmers), 2.0),
        "torus": (random_filaments(rng, filaments, *torus), 1.0),
        "dividing cell": (random_filaments(rng, filaments, "cassini", {"a": 1.0, "b": 1.1}), 1.0),
        "undulated": (random_filaments(rng, filaments, "undulated", bumpy), 1.0),
        "clamped": (random_filaments(rng, filaments, *torus, clamped), 1.0),
        "growing": (random_filaments(rng, filaments, "ellipsoid", ellipsoid, clamped, True), 1.0),
    }
    every, rows = [], list[list[Cell]]()
    for name, (make, end) in makers.items():
        settings.tell(f"random {name}")
        found, exact = make(), make()
        found.advance_to(end, tolerance)
        exact.advance_to(end, tolerance / 100)
        well = (found.status == 0) & (exact.status == 0)
        length = getattr(found, "length", np.ones(found.count))
        share = np.linalg.norm(found.position - exact.position, axis=-1).max(axis=1)[well] / length[well] / tolerance
        every.append(share)
        steps = [float(np.median(found.steps_taken)), float(found.steps_taken.max())]
        rows.append([f"{well.sum()} of {len(well)} {name}", *steps, *np.quantile(share, [0.5, 0.95, 1])])
    share = np.concatenate(every)
    rows.append(["all", None, None, *np.quantile(share, [0.5, 0.95, 1])])
    below, below_three = 100 * (share <= 1).mean(), 100 * (share <= 3).mean()
    title = (
        f"{len(share)} random rods, tolerance {tolerance:g}: {below:.1f} % below it, {below_three:.1f} % below 3 of it"
    )
    columns = ["", "steps, median", "most", "error over tolerance: median", "95 %", "most"]
    return Table(title, columns, rows)
