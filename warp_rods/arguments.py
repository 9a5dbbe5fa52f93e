"""Checks of arguments that are given in Python: each raises SceneError with the name, the value and what is allowed.

Scenes are checked by their tables (``scene/checks.py``); arguments of functions and of ensembles are checked here.
"""

from __future__ import annotations

import functools
import inspect
import operator
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from warp_rods.errors import SceneError, nearest

T = TypeVar("T")

ANY = "any finite number"
RULES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    ANY: np.isfinite,
    "positive": lambda values: values > 0,
    "zero or more": lambda values: values >= 0,
}
"""Rules for numbers in words, with the condition on their values; all numbers must be finite."""
LONGEST_SHOWN = 80


def wrong(name: str, value: Any, allowed: str) -> SceneError:
    """The error for a value that is not allowed."""
    text = " ".join(repr(value).split())
    text = text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 3] + "..."
    return SceneError(f"{name} = {text}: must be {allowed}")


def whole(name: str, value: Any, least: int = 1) -> int:
    """A whole number of any integer type of Python or NumPy, at least ``least``."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise wrong(name, value, f"a whole number, {least} or more")
    return number


def real(name: str, value: Any, rule: str = "positive") -> float:
    """A finite number that obeys a rule of ``RULES``."""
    read = reals(name, value)
    if read.ndim:
        raise wrong(name, value, "one number")
    check(name, read, rule)
    return float(read)


def reals(name: str, values: Any) -> np.ndarray:
    """Numbers of any real type, as an array of its own in double precision; text, booleans and masks are refused."""
    if np.ma.is_masked(values):
        raise SceneError(f"{name}: has masked values; give numbers for all, or leave these rods out")
    try:
        read = np.asarray(values)
    except ValueError as error:
        raise SceneError(f"{name}: must be numbers: {error}") from None
    truths = isinstance(values, (list, tuple)) and any(isinstance(value, (bool, np.bool_)) for value in values)
    if read.dtype.kind not in "iuf" or truths:
        raise wrong(name, values, "numbers" if read.ndim else "a number")
    return np.array(read, dtype=np.float64)


def fitted(name: str, values: Any, shape: tuple[int, ...], allowed: str) -> np.ndarray:
    """Finite numbers that broadcast to this shape, as a contiguous array of it; ``allowed`` says so in words."""
    try:
        read = reals(name, values)
    except SceneError:
        raise wrong(name, values, allowed) from None
    try:
        whole_array = np.array(np.broadcast_to(read, shape))
    except ValueError:
        raise SceneError(f"{name}: must be {allowed}; has shape {read.shape}") from None
    if not np.isfinite(whole_array).all():
        raise SceneError(f"{name}: must be finite at every node")
    return whole_array


def check(name: str, values: np.ndarray, rule: str) -> None:
    """Raises SceneError naming the first of these numbers that is not finite, or does not obey a rule of ``RULES``."""
    flat = values.reshape(-1)
    if len(bad := flat[~np.isfinite(flat)]):
        raise SceneError(f"{name} = {bad[0]:g}: must be {'' if rule == ANY else rule + ' and '}finite")
    if len(bad := flat[~RULES[rule](flat)]):
        raise SceneError(f"{name} = {bad[0]:g}: must be {rule}")


def truth(name: str, value: Any) -> bool:
    """True or False, of Python or NumPy."""
    if not isinstance(value, (bool, np.bool_)):
        raise wrong(name, value, "True or False")
    return bool(value)


def instance(name: str, value: Any, kind: type[T], allowed: str) -> T:
    """An object of a class; ``allowed`` says in words what is expected and how it is made."""
    if not isinstance(value, kind):
        raise wrong(name, value, allowed)
    return value


def function(name: str, value: Any, count: int, allowed: str) -> Callable:
    """A function that takes ``count`` arguments; ``allowed`` says in words what it is."""
    if not callable(value):
        raise wrong(name, value, allowed)
    try:
        inspect.signature(value).bind(*[None] * count)
    except TypeError as error:
        raise SceneError(f"{name}: must be {allowed}: {error}") from None
    except ValueError:  # functions written in C may have no signature
        pass
    return value


def naming(make: Callable[..., None]) -> Callable[..., None]:
    """``__init__`` of a class whose unknown and missing arguments are a SceneError that names them."""
    signature = inspect.signature(make)

    @functools.wraps(make)
    def checked(self: Any, *given: Any, **named: Any) -> None:
        try:
            signature.bind(self, *given, **named)
        except TypeError as error:
            raise SceneError(_misfit(type(self).__name__, signature, len(given), named, str(error))) from None
        make(self, *given, **named)

    return checked


def _misfit(of: str, signature: inspect.Signature, positional: int, named: Mapping[str, Any], otherwise: str) -> str:
    """What is wrong with arguments that do not fit a signature, whose first one is ``self``."""
    known = list(signature.parameters.values())[1:]
    names = [one.name for one in known]
    for name in named:
        if name not in names:
            return f"{name}: {of} has no such argument{nearest(name, names)}; it has {', '.join(names)}"
    needed = [one.name for one in known if one.default is one.empty]
    missing = [name for name in needed if name not in named and names.index(name) >= positional]
    if missing:
        return f"{', '.join(missing)}: missing; {of} needs {', '.join(needed)}"
    return f"{of}: {otherwise}"


def path(name: str, value: Any) -> Path:
    """A path, as text or as an object with a path; empty text, as of a variable of a shell that is not set, is none."""
    if not isinstance(value, (str, os.PathLike)) or value == "":
        raise wrong(name, value, "a path")
    return Path(value)
