"""Parameters of filaments with three components, each uniform, given at nodes, or by a formula in s and t."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.membranes.motion import rate
from warp_rods.rods.along import Along
from warp_rods.rods.per_rod import parameter, with_named
from warp_rods.values import plain

COMPONENTS = 3
FEWEST_NODES = 9
"""A list of fewer numbers is not one for each node of a filament."""
ALLOWED = (
    "three components, each a number, a list with a number for each node, or a formula in s and t; or such three for "
    "each rod; or numbers [rod, node, 3]"
)


class Components:
    """A parameter with three components: ``values`` [rod, 3], or [rod, node, 3] where it is not uniform and constant.

    given: numbers [3], [rod, 3] or [rod, node, 3]; or ``ALLOWED``. rules: of each component (``arguments.RULES``). In
    formulas s is the share of the length from −1/2 to 1/2, t the time. Raises SceneError naming the value.
    """

    def __init__(self, name: str, given: Any, count: int, nodes: int, rules: tuple[str, ...]):
        self.name, self._count, self._rules = name, count, rules
        self._parts: list[tuple[Along, str, np.ndarray, int]] = []
        """Formulas with t: their values, text, rods and component."""
        self.along = False
        """Whether it changes along the rods."""
        self.values = np.empty((count, nodes, COMPONENTS))
        if not isinstance(given, np.ndarray) and _any_along(parts := plain(given)):
            self._read(self._rows(parts, given), nodes)
        else:
            self.values = self._of_numbers(given, nodes)

    @property
    def varies(self) -> bool:
        """Whether it changes in time."""
        return bool(self._parts)

    def at(self, time: float, nodes: int) -> np.ndarray:
        """Values [rod, node, 3] at a time; raises SceneError where a formula has none, or one that is not allowed.

        nodes: those of the rods now, which differ from those at the start for filaments that were refined.
        """
        found = self.values.copy()
        for part, _text, rods, k in self._parts:
            found[rods, :, k] = row = part.at(time)[0]
            arguments.check(f"{part.name} at t = {time:g}", row, self._rules[k])
        return found if nodes == found.shape[1] else np.repeat(found[:, :1], nodes, axis=1)

    def sampled(self, times: np.ndarray) -> Iterator[np.ndarray]:
        """Values [time, place] of its formulas, at a few places along the rod."""
        for part, *_ in self._parts:
            yield from part.sampled(times)

    def rates(self, time: float, nodes: int) -> np.ndarray:
        """Time derivatives [rod, node, 3] at a time, exact; raises SceneError where a formula has none."""
        found = np.zeros((self._count, nodes, COMPONENTS))
        for part, text, rods, k in self._parts:
            try:
                found[rods, :, k] = [rate(text, time, s=s) for s in np.linspace(-0.5, 0.5, nodes).tolist()]
            except FormulaError as error:
                raise SceneError(f"{part.name} at t = {time:g}: {error}") from None
        return found

    def _of_numbers(self, given: Any, nodes: int) -> np.ndarray:
        """Values from numbers."""
        numbers = arguments.reals(self.name, given)
        if numbers.ndim < 3:
            return parameter(self.name, given, self._count, self._rules)
        if numbers.shape not in ((self._count, nodes, COMPONENTS), (1, nodes, COMPONENTS)):
            shape = numbers.shape
            text = f"must be {ALLOWED}; has shape {shape}, for {self._count} rods of {nodes} nodes"
            raise SceneError(f"{self.name}: {text}")
        for k, rule in enumerate(self._rules):
            arguments.check(f"{self.name}[…, {k}]", numbers[..., k], rule)
        self.along = bool((numbers != numbers[:, :1]).any())
        return np.array(np.broadcast_to(numbers, (self._count, nodes, COMPONENTS)))

    def _rows(self, parts: Any, given: Any) -> tuple[Any, ...]:
        """The three components of each rod, or once those of all."""
        rows = _triples(parts)
        if not all(map(_is_triple, rows)):
            raise arguments.wrong(self.name, given, ALLOWED)
        if len(rows) not in (1, self._count):
            raise SceneError(f"{self.name}: has entries for {len(rows)} rods; give one, or {self._count}")
        return rows

    def _read(self, rows: tuple[Any, ...], nodes: int) -> None:
        """Set the values, each different component once."""
        rods: dict[tuple[int, Any], list[int]] = {}
        for rod, row in enumerate(rows):
            for k, entry in enumerate(row):
                rods.setdefault((k, entry), []).append(rod)
        for (k, entry), where in rods.items():
            name = f"{self.name}[{k}]" if len(rows) == 1 else f"{self.name}[{where[0]}][{k}]"
            index = np.arange(self._count) if len(rows) == 1 else np.array(where)
            self._read_component(name, entry, nodes, index, k)

    def _read_component(self, name: str, entry: Any, nodes: int, rods: np.ndarray, k: int) -> None:
        given = entry if isinstance(entry, str) else [list(entry)] if isinstance(entry, tuple) else entry
        part = Along(name, given, 1, nodes, self._rules[k], in_time=True)
        self.values[rods, :, k] = part.values[0]
        if isinstance(entry, str):
            self.along |= "s" in function_of_arrays(entry, ("s", "t")).names  # type: ignore[attr-defined]
        else:
            self.along |= bool((part.values != part.values.flat[0]).any())
        if part.varies:
            self._parts.append((part, entry, rods, k))


def for_each_rod(given: Any, count: int, named: Mapping[str, np.ndarray]) -> Any:
    """What ``Components`` takes, with the numbers of parameters [rod] in its formulas: of each rod if they differ."""
    if not named or isinstance(given, np.ndarray) or not _any_along(parts := plain(given)):
        return given
    rows = _triples(parts)
    if len(rows) not in (1, count):
        return given  # its fault is named where it is read
    found = with_named(rows, named)
    if len(found) == 1:
        return found[0][0] if len(rows) == 1 else found[0]
    return tuple(found[rod][rod if len(rows) == count else 0] for rod in range(count))


def _is_triple(value: Any) -> bool:
    """Whether a value is three components, and not such three for each rod."""
    if not isinstance(value, tuple) or len(value) != COMPONENTS:
        return False
    lists = [part for part in value if isinstance(part, tuple)]
    return len(lists) < COMPONENTS or any(len(part) >= FEWEST_NODES for part in lists)


def _triples(value: Any) -> tuple[Any, ...]:
    """The three components of each rod, or once those of all, from tuples."""
    return (value,) if _is_triple(value) or not isinstance(value, tuple) else value


def _any_along(value: Any) -> bool:
    """Whether a value of three components, or of three for each rod, has text or lists of numbers among them."""
    return any(isinstance(part, (str, tuple)) for row in _triples(value) if _is_triple(row) for part in row)
