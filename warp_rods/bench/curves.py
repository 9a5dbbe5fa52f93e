"""Curves of work against precision: their runs, the table and the figure that compare them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_rods.bench.precision import front, time_at
from warp_rods.bench.result import Cell, Table
from warp_rods.bench.timing import Times
from warp_rods.draw import plots

MARKERS = "osd^vx+*<>PX"
STYLES = dict[str, tuple[str, str]]()
"""Name of a method → colour and marker: the same in every panel."""


@dataclass
class Curve:
    """The runs of one method: key of a work → its error, a function that is called when all works are done.

    share: rods that one work is for.
    """

    name: str
    errors: dict[str, Callable[[], float]] = field(default_factory=dict)
    share: float = 1.0
    found: list[tuple[float, float]] = field(default_factory=list)
    """Errors, and seconds a rod."""

    def take(self, times: Mapping[str, Times]) -> None:
        """Keep what was measured."""
        self.found = [(error(), times[key].median / self.share) for key, error in self.errors.items()]

    @property
    def columns(self) -> tuple[list[float], list[float]]:
        """Errors, and seconds a rod, of all runs."""
        return [error for error, _ in self.found], [seconds for _, seconds in self.found]

    @property
    def least(self) -> float:
        """The least error of any run."""
        return min((error for error, _ in self.found), default=np.nan)

    def time_at(self, target: float) -> float | None:
        """Seconds a rod in which the method reaches an error."""
        errors, seconds = self.columns
        return time_at(errors, seconds, target)


def compared(
    title: str,
    curves: Sequence[Curve],
    targets: Sequence[float],
    over: Sequence[str],
    extra: Sequence[Sequence[Any]] = (),
) -> Table:
    """Milliseconds a rod at each error asked for, and over those of the methods ``over``; then ``extra`` rows.

    An extra row is a name, an error, and milliseconds; it is compared at the first error asked for.
    """
    columns = ["", "least error"]
    for target in targets:
        columns += [f"ms a rod at {target:g}", *(f"over {name}" for name in over)]
    base = {target: [c.time_at(target) for name in over for c in curves if c.name == name] for target in targets}
    rows = list[list[Cell]]()
    for curve in curves:
        row: list[Cell] = [curve.name, curve.least]
        for target in targets:
            time = curve.time_at(target)
            row += [time and 1e3 * time, *(time and one and time / one for one in base[target])]
        rows.append(row)
    for name, *rest in extra:
        row = [name, *rest[:1]]
        if len(rest) > 1:
            row += [f"{rest[1]:.3g} (never)", *(one and rest[1] / one / 1e3 for one in base[targets[0]])]
        rows.append(row + [None] * (len(columns) - len(row)))
    return Table(title, columns, rows)


def draw(axes: Any, curves: Sequence[Curve], title: str, label: str) -> None:
    """Time against error of the runs of each method that no other run of it beats."""
    for curve in curves:
        if not curve.found:
            continue
        errors, seconds = front(*curve.columns)
        colour, marker = style_of(curve.name)
        line = "-" if curve.name.startswith("ours") else "--"
        axes.loglog(
            errors, 1e3 * seconds, marker=marker, ls=line, lw=0.8, ms=2.5, color=colour, label=curve.name
        )  # fmt: skip
    axes.set_title(title)
    axes.set_xlabel(label)
    axes.grid(True)


def style_of(name: str) -> tuple[str, str]:
    """Colour and marker of a method; ours are blue."""
    if name not in STYLES:
        others = sum(not known.startswith("ours") for known in STYLES)
        colour = plots.OKABE_ITO[0 if name.startswith("ours") else 1 + others % 6]
        STYLES[name] = colour, MARKERS[len(STYLES) % len(MARKERS)]
    return STYLES[name]
