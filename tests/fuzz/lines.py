"""Files of centre lines, sound ones and others: tables, arrays, WCON, SWC."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from fuzz.hostile import broken_text
from fuzz.scenes import CELLS, FILAMENTS, SPHERE, TIME

SUFFIXES = (".csv", ".tsv", ".txt", ".npy", ".wcon", ".json", ".swc", ".npz")


def line(number: int, folder: Path) -> str:
    """Writes the file of this number; returns the scene with it, in TOML."""
    rng = random.Random(f"line {number}")
    path = folder / f"line{rng.choice(SUFFIXES)}"
    _write(path, _points(rng), rng)
    if rng.random() < 0.1:
        data = path.read_bytes()
        cut = rng.randrange(len(data) + 1)
        path.write_bytes(rng.choice((data[:cut], b"", data[:cut] + b"\xff\x00" + data[cut:])))
    shape: dict[str, Any] = {"points": str(path)}
    for key, values in (
        ("smoothing", (0, 0.1, 5.0, "3 points", "0 points", "x", -1, 1e-30)), ("reverse", (True, False, 1)),
        ("frame", (0, -1, 7, 1.5)), ("time", (0.0, 1e30)), ("worm", (1, "a", 2.5)), ("branch", (3, 0, 10**30)),
        ("perturbation", (1e-3, -1)), ("kind", ("points", "run", "mode")),
    ):  # fmt: skip
        if rng.random() < 0.04:
            shape[key] = rng.choice(values)
    if rng.random() < 0.7:
        return tomli_w.dumps({"swimmers": [CELLS | {"shape": shape}], "time": TIME})
    given = {key: value for key, value in FILAMENTS.items() if key != "length" or rng.random() < 0.2}
    more = {"scale": rng.choice((1.0, 1e-3, 1e30))} if rng.random() < 0.3 else {}
    return tomli_w.dumps({"surface": SPHERE, "filaments": [given | {"shape": shape | more}], "time": TIME})


def _points(rng: random.Random) -> np.ndarray:
    """Points on the unit sphere, spoilt more or less."""
    count = rng.choice((0, 1, 3, 4, 5, 20, 60, 60, 60))
    u = np.sort(np.random.default_rng(rng.randrange(10**6)).uniform(0, 1.2, count))
    points = np.stack([np.cos(u), np.sin(u) * np.cos(0.5), np.sin(u) * np.sin(0.5)], axis=1)
    spoil = rng.randrange(9)
    if spoil == 0 and count:
        points[rng.randrange(count)] = rng.choice((np.nan, np.inf, 1e300, -1e20))
    elif spoil == 1:
        points = np.repeat(points, 3, axis=0)
    elif spoil == 2:
        points = points * rng.choice((1e-300, 1e-30, 1e30, 1e200, 0.0))
    elif spoil == 3:
        points = np.random.default_rng(count).permutation(points)
    elif spoil == 4:
        points = points[:, : rng.choice((1, 2))]
    elif spoil == 5:
        points = points + np.random.default_rng(count).normal(size=points.shape) * rng.choice((1e-3, 1.0))
    return points


def _write(path: Path, points: np.ndarray, rng: random.Random) -> None:
    if path.suffix in (".npy", ".npz"):
        save = np.save if path.suffix == ".npy" else np.savez
        shaped = (points, points[None], points.astype("U8"), points.astype(complex), points[:, 0])
        save(path, rng.choice((points, points, *shaped)))
        return
    if path.suffix == ".swc":
        rows = [f"{i + 1} 3 {' '.join(f'{v:.9g}' for v in row)} 1 {i or -1}" for i, row in enumerate(points)]
        text = "\n".join(rows) + rng.choice(("", "", "\n99 3 0 0 0 1 1", "\n5 3 1 1", "\n1 1 0 0 0 1 2"))
    elif path.suffix in (".wcon", ".json"):
        x, y = (points[:, min(i, points.shape[1] - 1)].tolist() for i in (0, 1))
        rows = rng.choice(([x, y], [[x, x], [y, y]], [x[:-1], y], [[x], [y]], [1.0, 2.0], ["a", None]))
        entry = {
            "id": rng.choice((1, "a", None, [1])),
            "t": rng.choice((0, [0, 1], None, "x")),
            "x": rows[0],
            "y": rows[1],
        }
        content: Any = {"units": rng.choice(({"x": "mm"}, {}, None, 3)), "data": rng.choice((entry, [entry], [], 7))}
        text = json.dumps(content)
    else:
        mark = {".csv": ",", ".tsv": "\t"}.get(path.suffix, " ")
        head = rng.choice(("", "", "x,y,z\n", "frame,x,y\n", "a,b,c\n")).replace(",", mark)
        text = head + "\n".join(mark.join(f"{v:.9g}" for v in row) for row in points)
    path.write_text(broken_text(text, rng) if rng.random() < 0.1 else text, encoding="utf-8")
