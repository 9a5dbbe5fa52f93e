"""The tables [[filaments]] and [[swimmers]] of a scene. A list for a parameter gives one value a rod."""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field

from warp_rods.scene.checks import (
    Faults,
    Rows,
    Table,
    a_number,
    fault,
    number_each,
    numbers,
    point_each,
    refuse,
    rows_each,
    shown,
    vector_each,
    wrong,
)

NumberEach = float | tuple[float, ...]
Points = tuple[tuple[float, ...], ...]
VectorEach = tuple[float, ...] | Points
AnyEach = Annotated[NumberEach, number_each("any number")]
PositiveEach = Annotated[NumberEach, number_each("positive")]
ZeroOrMoreEach = Annotated[NumberEach, number_each("zero or more")]
Positive = Annotated[float, a_number("positive")]

EACH = ", or a list with one for each rod"
NAME = r"^[A-Za-z][A-Za-z0-9_]{0,63}$"
NAME_WORDS = "a name of at most 64 letters, digits and _, that starts with a letter"
MOST = 10_000_000
"""Nodes of one ensemble; more do not fit the memory of any machine in sight."""


class Placement(Table):
    """Where filaments start: points and directions [rods, 3], geodesic curvature [rods, nodes]; 1/length."""

    at: Literal["middle", "start"] = Field(
        default="middle", description='"middle" or "start": the point of the rod that is placed'
    )
    position: Annotated[Points, point_each()] = Field(description="a list of points [x, y, z], one for each rod")
    direction: Annotated[Points, point_each(may_be_zero=False)] = Field(
        description="a list of directions [dx, dy, dz], one for each rod"
    )
    geodesic_curvature: Annotated[float | Rows, rows_each()] = Field(
        default=0.0, description="a number, or a list with a number or one value a node for each rod"
    )


class Growth(Table):
    """Growth of the tips: a rate in length per time until a final length, or lengths at times."""

    rate: PositiveEach | None = Field(default=None, description="a positive number" + EACH)
    until: PositiveEach | None = Field(default=None, description="a positive number" + EACH)
    start: ZeroOrMoreEach | None = Field(default=None, description="0 or a positive number" + EACH)
    time: Annotated[tuple[float, ...], numbers("zero or more")] | None = Field(
        default=None, description="a list of increasing times, with length"
    )
    length: Annotated[tuple[float, ...], numbers("positive")] | None = Field(
        default=None, description="a list of lengths at the times in time"
    )
    spacing: Positive | None = Field(
        default=None, description="a positive number: nodes are doubled before Δs would exceed it"
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        if raw.keys() - {"spacing", "start"} in ({"rate", "until"}, {"time", "length"}):
            return []
        return [fault((), raw, ": must be { rate, until } or { time, length }; start and spacing may be added")]


def _placement(value: Any) -> Any:
    if value == "random" or isinstance(value, Placement):
        return value
    if not isinstance(value, dict):
        refuse([wrong((), value)])
    return Placement.model_validate(value)


def _lookup(raw: Any, path: tuple[str, ...]) -> Any:
    for key in path:
        raw = raw.get(key) if isinstance(raw, dict) else None
    return raw


def length_faults(
    raw: dict[str, Any], good: dict[str, Any], paths: tuple[str, ...], vectors: tuple[str, ...] = ()
) -> Faults:
    """Lists without one entry for each of ``count`` rods; of vectors only lists of lists are looked at."""
    count, faults = good.get("count"), []
    for path in paths + vectors:
        loc = tuple(path.split("."))
        value = _lookup(raw, loc)
        is_list = isinstance(value, (list, tuple))
        one_vector = path in vectors and is_list and not any(isinstance(v, (list, tuple)) for v in value)
        if count is not None and is_list and not one_vector and len(value) != count:
            text = f" = {shown(value)}: has {len(value)} entries; must have one for each of {count} rods"
            faults.append(fault(loc, value, text))
    return faults


class Filaments(Table):
    """An ensemble of filaments bound to the surface (model §3)."""

    name: str = Field(pattern=NAME, description=NAME_WORDS)
    count: int = Field(ge=1, le=MOST, strict=True, description="a whole number, 1 or more, at most 10 million")
    nodes: int = Field(ge=9, le=100_000, strict=True, description="a whole number, 9 or more, at most 100 000")
    length: PositiveEach = Field(description="a positive number" + EACH)
    stiffness: Annotated[VectorEach, vector_each(*["positive"] * 3)] = Field(
        description="3 positive numbers (twist, normal bending, geodesic bending)" + EACH
    )
    intrinsic: Annotated[VectorEach, vector_each(*["any number"] * 3)] = Field(
        default=(0.0, 0.0, 0.0), description="3 numbers (twist, normal curvature, geodesic curvature)" + EACH
    )
    drag: Annotated[VectorEach, vector_each("positive", "positive", "zero or more")] = Field(
        description="3 numbers (along > 0, across > 0, rotational 0 or more)" + EACH
    )
    ends: tuple[Literal["free", "clamped"], Literal["free", "clamped"]] = Field(
        default=("free", "free"), description='a pair such as ["free", "free"], each "free" or "clamped"'
    )
    placement: Annotated[Literal["random"] | Placement, BeforeValidator(_placement)] = Field(
        default="random", description='"random" or a table { at, position, direction, geodesic_curvature }'
    )
    growth: Growth | None = Field(default=None, description="a table { rate, until } or { time, length }")

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        placement = tuple("placement." + key for key in ("position", "direction", "geodesic_curvature"))
        return [
            *length_faults(
                raw,
                good,
                ("length", "growth.rate", "growth.until", "growth.start", *placement),
                vectors=("stiffness", "intrinsic", "drag"),
            ),
            *_node_faults(raw, good),
        ]


def _node_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    rows = _lookup(raw, ("placement", "geodesic_curvature"))
    nodes = good.get("nodes")
    if nodes is None or not isinstance(rows, (list, tuple)):
        return []
    return [
        fault(
            ("placement", "geodesic_curvature", i),
            values,
            f" = {shown(values)}: has {len(values)} values; must have one for each of {nodes} nodes",
        )
        for i, values in enumerate(rows)
        if isinstance(values, (list, tuple)) and len(values) != nodes
    ]


class Flagella(Table):
    """The flagellar field (4.12): relaxation time τf, diffusion D, and its profile at the start."""

    relaxation: PositiveEach = Field(default=1e-2, description="a positive number" + EACH)
    diffusion: ZeroOrMoreEach = Field(default=1e-3, description="0 or a positive number" + EACH)
    profile: Literal["tanh", "piecewise", "uniform"] = Field(
        default="tanh", description='"tanh", "piecewise" or "uniform"'
    )
    sharpness: Positive = Field(default=10.0, description="a positive number: of the profile tanh")


SHAPE_DEFAULTS: dict[str, dict[str, Any]] = {"mode": {"mode": 0}, "writhe": {"balanced": True}, "straight": {}}
"""Kind of a shape → the keys that only this kind has, and their defaults."""


class Shape(Table):
    """Curvature at the start: amplitude times a beam mode, or C.63–C.66 with that amplitude, or none."""

    kind: Literal["mode", "writhe", "straight"] = Field(default="mode", description='"mode", "writhe" or "straight"')
    mode: int | None = Field(default=None, ge=0, strict=True, description="a whole number, 0 or more")
    amplitude: AnyEach = Field(default=1.0, description="a number" + EACH)
    balanced: bool | None = Field(
        default=None,
        strict=True,
        description="true or false: a writhe's twist that balances the active torque, or C.63 as printed",
    )

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = data.get("kind", "mode")
        return {**SHAPE_DEFAULTS.get(kind, {}), **data} if isinstance(kind, str) else data

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind", "mode" if "kind" not in raw else None)
        return [
            fault((key,), raw[key], f": a shape of kind {kind} has no {key}; leave it out")
            for other, defaults in SHAPE_DEFAULTS.items()
            for key in defaults
            if kind not in (None, other) and key in good
        ]


class FreePlacement(Table):
    """Where swimmers start: middle points and directions of the tangent there [rods, 3]."""

    position: Annotated[Points, point_each()] = Field(description="a list of points [x, y, z], one for each rod")
    direction: Annotated[Points, point_each(may_be_zero=False)] | None = Field(
        None, description="a list of directions [dx, dy, dz], one for each rod; left out: along x"
    )


Arrangement = Literal["random", "aligned", "polar lanes", "nematic lanes", "bands"]
ARRANGEMENTS = [f'"{name}"' for name in get_args(Arrangement)]


def _arrangement(value: Any) -> Any:
    if isinstance(value, str) and value in get_args(Arrangement):
        return value
    if not isinstance(value, (dict, FreePlacement)) and value is not None:
        refuse([wrong((), value)])
    return value if value is None else FreePlacement.model_validate(value)


def _odd(nodes: int) -> int:
    refuse([] if nodes % 2 else [wrong((), nodes)])
    return nodes


class Swimmers(Table):
    """An ensemble of active free rods (model §2), dimensionless as there."""

    name: str = Field(pattern=NAME, description=NAME_WORDS)
    count: int = Field(ge=1, le=MOST, strict=True, description="a whole number, 1 or more, at most 10 million")
    nodes: Annotated[int, AfterValidator(_odd)] = Field(
        ge=17, le=100_000, strict=True, description="an odd whole number, 17 or more, at most 100 000"
    )
    bend: PositiveEach = Field(description="a positive number" + EACH)
    twist: PositiveEach = Field(description="a positive number" + EACH)
    moment: AnyEach = Field(default=0.0, description="a number" + EACH)
    drag_ratio: PositiveEach = Field(default=2.0, description="a positive number" + EACH)
    rotational_drag: PositiveEach = Field(default=3e-3, description="a positive number" + EACH)
    flagella: Flagella = Field(
        default_factory=Flagella, description="a table { relaxation, diffusion, profile, sharpness }"
    )
    shape: Shape = Field(default_factory=Shape, description="a table { kind, mode, amplitude, balanced }")
    symmetric: bool = Field(default=False, strict=True, description="true or false")
    placement: Annotated[Arrangement | FreePlacement | None, BeforeValidator(_arrangement)] = Field(
        default=None, description=f"a table {{ position, direction }}, or in a box one of {', '.join(ARRANGEMENTS)}"
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        plain_keys = ("bend", "twist", "moment", "drag_ratio", "rotational_drag")
        nested = ("flagella.relaxation", "flagella.diffusion", "shape.amplitude")
        return length_faults(raw, good, (*plain_keys, *nested, "placement.position", "placement.direction"))
