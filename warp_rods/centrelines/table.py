"""Points in tables of text (``.csv``, ``.tsv``, ``.txt``, ``.dat``) and in arrays of NumPy (``.npy``)."""

from __future__ import annotations

import csv
import math
import re
import zipfile
from pathlib import Path

import numpy as np

from warp_rods.centrelines.track import Track, TrackError, chosen_frame, listed, metres_of
from warp_rods.quantities import QuantityError, parse

__all__ = ["read_array", "read_motion", "read_table"]

AXES = ("t", "time", "x", "y", "z")
MISSING = {"", "nan", "na", "n/a", "null", "none", "-"}
FRAMES = ("frame", "time", "t")
"""Words in the header of a column that says to which frame a point belongs."""


def read_table(path: Path, frame: int | None = None, time: float | None = None) -> Track:
    """Columns x, y and perhaps z, by their names in a header, or 2 or 3 columns without one; # begins a comment.

    The delimiter is a semicolon, tab, comma or white space; empty cells are missing points. Of a column named frame or
    time, ``frame`` chooses the rows of one value by its number, ``time`` by the value.
    """
    rows = _rows(path.read_text(encoding="utf-8-sig"))
    header = [cell.lower() for cell in rows[0]] if any(_number(cell) is None for cell in rows[0]) else []
    columns, metres = _columns(header, len(rows[0]))
    marks = [i for i, name in enumerate(header) if set(_tokens(name)) & set(FRAMES)]
    values = _numbers(rows[1:] if header else rows, [*columns, *marks[:1]])
    points = values[:, : len(columns)]
    if not marks:
        if frame is not None or time is not None:
            raise TrackError(f"has no column named {', '.join(FRAMES)}: leave frame and time out")
        return Track(points, metres)
    of_row = values[:, -1]
    times = np.unique(of_row[np.isfinite(of_row)])
    if not len(times):
        raise TrackError(f"has no numbers in the column {header[marks[0]]}")
    index = chosen_frame(times.tolist(), frame, time)
    chosen = f"{header[marks[0]]} {times[index]:g}" if len(times) > 1 else ""
    return Track(points[of_row == times[index]], metres, chosen)


def read_motion(path: Path) -> dict[str, np.ndarray]:
    """Times [time] and points [time, 3] of a motion: columns t, x, y and perhaps z, or an array [time, 3 or 4].

    By their names in a header, t or time, x, y, z, or in this order. Raises TrackError, and OSError.
    """
    if path.suffix == ".npy":
        values = _array(path)
    else:
        rows = _rows(path.read_text(encoding="utf-8-sig"))
        header = [cell.lower() for cell in rows[0]] if any(_number(cell) is None for cell in rows[0]) else []
        columns = _columns_of_motion(header) if header else list(range(len(rows[0])))
        values = _numbers(rows[1:] if header else rows, columns)
    if not isinstance(values, np.ndarray):
        raise TrackError("must be one array [time, 3 or 4]; has several")
    if values.ndim != 2 or values.shape[1] not in (3, 4) or not len(values) or values.dtype.kind not in "fiu":
        raise TrackError(f"must have columns t, x, y and perhaps z; has the shape {values.shape}")
    if not np.isfinite(values).all():
        raise TrackError(f"has no number in row {int((~np.isfinite(values)).any(axis=1).argmax())}")
    points = np.zeros((len(values), 3))
    points[:, : values.shape[1] - 1] = values[:, 1:]
    return {"times": values[:, 0].astype(float), "points": points}


def _columns_of_motion(header: list[str]) -> list[int]:
    """The columns of t, x, y and perhaps z."""
    found = []
    for names in (("t", "time"), ("x",), ("y",), ("z",)):
        named = [i for i, name in enumerate(header) if name in names]
        named = named or [i for i, name in enumerate(header) if set(_tokens(name)) & set(names)]
        if len(named) > 1 or (not named and names != ("z",)):
            what = "two columns" if named else "no column"
            raise TrackError(
                f"has {what} for {names[0]}: its header is {listed(header)}; name the columns t, x, y and z"
            )
        found += named
    for i in found:
        if unit := next((word for word in _tokens(header[i]) if word not in AXES and _is_unit(word)), None):
            raise TrackError(
                f"has the unit {unit} in the header of the column {header[i]}: numbers of a motion are in units of the "
                f"scene; convert them, and name the columns t, x, y and z"
            )
    return found


def _is_unit(word: str) -> bool:
    """Whether a word is a unit by which numbers would have to be converted."""
    try:
        value, dimension = parse(f"1 {word}")
    except QuantityError:
        return False
    return value != 1 or any(dimension)


def _array(path: Path) -> np.ndarray:
    """The numbers of a file .npy; raises TrackError for any other content."""
    try:
        values = np.load(path, allow_pickle=False)
    except (ValueError, EOFError, zipfile.BadZipFile) as fault:
        raise TrackError(f"is no array of numbers: {fault}") from None
    if not isinstance(values, np.ndarray):
        raise TrackError("has several arrays: save one with numpy.save")
    if values.dtype.kind not in "iuf":
        raise TrackError(f"must have real numbers; has the type {values.dtype}")
    return values


def _rows(text: str) -> list[list[str]]:
    """The cells of each line that is neither empty nor a comment."""
    lines = [line for line in text.splitlines() if line.strip(" \t,;") and not line.lstrip().startswith("#")]
    if not lines:
        raise TrackError("is empty")
    delimiter = next((mark for mark in ";\t," if mark in lines[0]), None)
    if delimiter is None:
        return [line.split() for line in lines]
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    except csv.Error as fault:
        raise TrackError(f"cannot be read as a table: {fault}") from None
    for i, row in enumerate(rows):
        if extra := [cell for cell in row[len(rows[0]) :] if cell]:
            raise TrackError(
                f"row {i + 1} has {len(row)} cells, {extra[0]!r} among them, and the first has {len(rows[0])}"
            )
    if delimiter == ";":  # a comma is then the decimal point
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    return rows


def _number(cell: str) -> float | None:
    """The number in a cell, NaN where it is missing; None where it is text."""
    if cell.lower() in MISSING:
        return math.nan
    try:
        return float(cell)
    except ValueError:
        return None


def _numbers(rows: list[list[str]], columns: list[int]) -> np.ndarray:
    """The numbers in some columns [row, column]; NaN where a cell is empty or the row is too short."""
    values = np.full((len(rows), len(columns)), math.nan)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            number = _number(row[column]) if column < len(row) else math.nan
            if number is None:
                raise TrackError(f"row {i + 1} of its numbers has {row[column]!r} in column {column + 1}: no number")
            values[i, j] = number
    return values


def _tokens(name: str) -> list[str]:
    return re.findall(r"[a-zµμ]+", name.replace("_", " "))


def _columns(header: list[str], count: int) -> tuple[list[int], float | None]:
    """The columns of x, y and perhaps z, and one unit in metres if the header says so."""
    if not header:
        if count in (2, 3):
            return list(range(count)), None
        raise TrackError(f"has {count} columns and no header: give 2 or 3 columns, or a header that names x and y")
    found = []
    for axis in "xyz":
        named = [i for i, name in enumerate(header) if name == axis]
        named = named or [i for i, name in enumerate(header) if axis in _tokens(name)]
        if len(named) > 1 or (not named and axis != "z"):
            what = "two columns" if named else "no column"
            raise TrackError(f"has {what} for {axis}: its header is {listed(header)}; name the columns x, y and z")
        found += named
    units = {metres_of(word) for word in _tokens(header[found[0]])} - {None}
    return found, units.pop() if len(units) == 1 else None


def read_array(path: Path, frame: int | None = None) -> Track:
    """An array [point, 2 or 3], or [frame, point, 2 or 3] of which ``frame`` chooses one."""
    values = _array(path)
    if values.ndim not in (2, 3):
        shape = values.shape
        raise TrackError(f"must be an array of numbers [point, 2 or 3] or [frame, point, 2 or 3]; has {shape}")
    if values.ndim == 2:
        if frame is not None:
            raise TrackError(f"frame = {frame}: has one line only, of shape {values.shape}: leave frame out")
        return Track(values.astype(float))
    index = chosen_frame(range(len(values)), frame, None)
    return Track(values[index].astype(float), None, f"frame {index}")
