"""Values and changes that make a valid scene a hostile one. The same generator gives the same changes."""

from __future__ import annotations

import datetime
import math
import random
from copy import deepcopy
from typing import Any

VALUES: tuple[Any, ...] = (
    *(True, False, 0, -1, 1, 2, 3, 17, 10**6, 10**9, 10**18, 2**63, 10**30, 10**400, -(10**400)),
    *(0.0, -0.0, 0.5, -1.5, 5e-324, 1e-300, 1e-40, 1e-12, 1e-6, 1e6, 1e12, 1e29, 1e30, 1e39, 1e308, -1e308),
    *(math.nan, math.inf, -math.inf, "", "x", "1.0", "auto", "random", "größe 🧬", "\x00\x1b[31m", "a" * 10_000),
    *("t", "1 - 2*t", "1/t", "exp(exp(exp(9*t)))", "__import__('os')", "../../etc/passwd", "/"),
    *([], [[]], [[[[]]]], {}, {"a": 1}, {"": {}}, [1], [1, 2], [1.0, 2.0, 3.0], [math.nan] * 3, [0, 0, 0], [1, "a"]),
    *([[1, 0, 0]], [[0, 0, 0], [1, 1, 1]], [1e308] * 3, [1e-40] * 3, list(range(1000)), datetime.date(2020, 1, 1)),
)
MOST_CHANGES = 3


def changed(tables: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """The scene, which is changed, with one fault or a few."""
    for _ in range(rng.randint(1, MOST_CHANGES)):
        if not (found := list(places(tables))):
            break
        holder, key = rng.choice(found)
        rng.choice(CHANGES)(holder, key, rng)
    return tables


def places(part: Any) -> Any:
    """Every place in nested tables and lists: the table or list, and the key."""
    for key, value in list(part.items() if isinstance(part, dict) else enumerate(part)):
        yield part, key
        if isinstance(value, (dict, list)):
            yield from places(value)


def _value(holder: Any, key: Any, rng: random.Random) -> None:
    holder[key] = deepcopy(rng.choice(VALUES))


def _scaled(holder: Any, key: Any, rng: random.Random) -> None:
    if isinstance(holder[key], (int, float)) and -1e300 < holder[key] < 1e300:
        holder[key] = abs(float(holder[key])) * 10.0 ** rng.uniform(-8, 8) * rng.choice((1, 1, 1, -1))


def _whole(holder: Any, key: Any, rng: random.Random) -> None:
    if isinstance(holder[key], int):
        holder[key] = int(holder[key] * rng.choice((0.5, 2, 3, 10, 100, 10_000))) + rng.choice((0, 0, 1))


def _removed(holder: Any, key: Any, rng: random.Random) -> None:
    del holder[key]


def _added(holder: Any, key: Any, rng: random.Random) -> None:
    name = rng.choice(
        ("count", "kind", "range", "größe", "", "a.b", "size", "nodes", "file", "phi", "growth", "__class__")
    )
    if isinstance(holder, dict):
        holder[name] = deepcopy(rng.choice(VALUES))
    else:
        holder.append(deepcopy(rng.choice(VALUES)))


def _repeated(holder: Any, key: Any, rng: random.Random) -> None:
    if isinstance(holder[key], list):
        holder[key] = holder[key] * rng.choice((0, 2, 3))
    else:
        holder[key] = [holder[key]] * rng.choice((1, 2, 3))


def _exchanged(holder: Any, key: Any, rng: random.Random) -> None:
    other = rng.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
    holder[key], holder[other] = holder[other], holder[key]


CHANGES = (_value, _value, _value, _scaled, _scaled, _whole, _removed, _added, _repeated, _exchanged)


def broken_text(text: str, rng: random.Random) -> str:
    """A text that ends early, has a character too many, or a part twice."""
    at, to = sorted(rng.randrange(len(text) + 1) for _ in range(2))
    return rng.choice((text[:at], text[:at] + rng.choice("\"'[]{}=#\n\x00é") + text[at:], text[:to] + text[at:]))
