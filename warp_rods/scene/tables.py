"""The tables of a scene that are no ensembles: [surface], [steric], [time], [units]."""

from __future__ import annotations

import re
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, PlainValidator

from warp_rods import formula
from warp_rods.membranes import in_time
from warp_rods.membranes.surfaces import GIVEN, KINDS, SURFACES, Parameter, read
from warp_rods.scene.checks import RULES, Faults, Table, a_number, fault, nearest, number, refuse, row, shown, wrong

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
LENGTH = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*([a-zµμ]+)\s*")

Positive = Annotated[float, a_number("positive")]
ZeroOrMore = Annotated[float, a_number("zero or more")]


class Surface(Table):
    """The membrane: its kind, and beside it the kind's own parameters, named in ``surfaces.KINDS``."""

    model_config = ConfigDict(extra="allow")

    kind: str = Field(description="one of " + ", ".join(KINDS))

    @property
    def parameters(self) -> dict[str, Any]:
        """Name → value of every parameter of this kind."""
        return dict(self.model_extra or {})

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        values, faults = _surface_parameters(data)
        return data if faults else {"kind": data["kind"], **values}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        return _surface_parameters(raw)[1] if "kind" in good else []


def _surface_parameters(data: dict[str, Any]) -> tuple[dict[str, Any], Faults]:
    """The parameters with defaults filled in, and what is wrong with them."""
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        text = f" = {shown(kind)}: must be one of {', '.join(KINDS)}{nearest(kind, KINDS)}"
        return {}, [fault(("kind",), kind, text)]
    if kind in GIVEN:
        values, found = read(kind, {key: value for key, value in data.items() if key != "kind"})
        return values, [fault(where, data, text) for where, text in found]
    known = SURFACES[kind].parameters
    faults: Faults = []
    values = {}
    for name in (key for key in data if key not in known and key != "kind"):
        text = f": not a parameter of {kind}{nearest(name, known)}; it has {', '.join(known)}"
        faults.append(fault((name,), data[name], text))
    for name, parameter in known.items():
        values[name] = _surface_parameter(name, parameter, data, faults)
    if not faults and (impossible := SURFACES[kind].check(in_time.at(values, 0.0))):
        faults.append(fault((), data, f": {impossible}"))
    return values, faults


def _surface_parameter(name: str, parameter: Parameter, data: dict[str, Any], faults: Faults) -> Any:
    value, mine = data.get(name, parameter.default), Faults()
    noun = "number" if parameter.allowed == "any number" else f"{parameter.allowed} number"
    allowed = f"a {noun}" if parameter.size == 1 else f"{parameter.size} {noun}s"
    if value is None:
        faults.append(fault((name,), data, f": missing; must be {allowed}"))
        return None
    if parameter.size == 1:
        read: Any = _number_in_time(value, parameter.allowed, (name,), mine)
    elif isinstance(value, (list, tuple)) and len(value) == parameter.size:
        read = tuple(_number_in_time(v, parameter.allowed, (name, i), mine) for i, v in enumerate(value))
    else:
        read = row(value, (parameter.allowed,) * parameter.size, (name,), mine)
    for f in mine:
        said = f["type"].message() if isinstance(f["input"], str) else ""  # type: ignore[union-attr]
        text = f" = {shown(f['input'])}: must be {allowed}{said and ', ' + said}"
        faults.append(fault(f["loc"], f["input"], text))
    return read


def _number_in_time(value: Any, rule: str, loc: tuple, faults: Faults) -> Any:
    """A number that keeps the rule, or a text in t that does at t = 0; adds a fault where it is neither."""
    if not isinstance(value, str):
        return number(value, rule, loc, faults)
    if said := in_time.fault(value):
        faults.append(wrong(loc, value, f"or a text in t: {said}"))
    elif not RULES[rule](formula.in_time(value)(0.0)):
        faults.append(wrong(loc, value, f"is {formula.in_time(value)(0.0):g} at t = 0"))
    return value.strip()


class Steric(Table):
    """Steric repulsion (5.39): strength g0, range a, core ε (model §3)."""

    strength: ZeroOrMore = Field(description="0 or a positive number")
    range: Positive = Field(description="a positive number")
    core: Positive = Field(description="a positive number")


class Time(Table):
    """How long, in which steps (chosen by the run where absent), and how often a frame is saved."""

    end: Positive = Field(description="a positive number")
    step: Positive | None = Field(default=None, description="a positive number, or left out")
    save_every: Positive = Field(description="a positive number")

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """With a frame every hundredth of the run, or every step where steps are longer."""
        end, step = (number(data.get(key), "positive", (), []) for key in ("end", "step"))
        # With no usable end the scene is refused for that; the 1 only keeps this key from being blamed too.
        every = min(end, np.nanmax([end / 100, step])) if end > 0 else 1.0
        return {"save_every": float(every), **data}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        # One line a key: of the two bounds of the step the later row, its bound by the end, is the one told.
        at_most = [("step", "save_every"), ("save_every", "end"), ("step", "end")]
        faults = {
            short: fault((short,), good[short], f" = {good[short]}: must be at most {long} = {good[long]}")
            for short, long in at_most
            if short in good and long in good and good[short] > good[long]
        }
        return list(faults.values())


def metres(text: Any) -> float:
    """A length such as "1 um" in metres; NaN where it is none."""
    match = LENGTH.fullmatch(text) if isinstance(text, str) else None
    return float(match[1]) * METRES[match[2]] if match and match[2] in METRES else float("nan")


def _length(text: Any) -> str:
    refuse([] if 0 < metres(text) < float("inf") else [wrong((), text)])
    return text


class Units(Table):
    """What one unit of the scene means, for reports and USD."""

    length: Annotated[str, PlainValidator(_length)] = Field(
        description='a positive number and a unit in quotes, such as "1 um" (units: m, cm, mm, um, nm)'
    )

    @property
    def metres(self) -> float:
        """One unit of length in metres."""
        return metres(self.length)
