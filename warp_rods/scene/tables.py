"""The tables [surface], [steric], [time] and [output] of a scene."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from warp_rods.membranes.catalogue import KINDS, read
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.values import SMALLEST, Number, Positive, ZeroOrMore, number

__all__ = ["Output", "Steric", "SurfaceTable", "Time"]

Tolerance = Annotated[Number, Field(ge=1e-8, le=0.1)]
ROUND_OFF = 1e-9
"""Relative difference up to which times are equal: the step as run is the spacing of the frames over a whole number."""


class SurfaceTable(Table):
    """A surface: its kind and the values of this kind, which are listed in ``catalogue.KINDS``. Builds nothing."""

    model_config = ConfigDict(extra="allow")

    kind: str = Field(title="kind of membrane", description="one of " + ", ".join(KINDS))

    @property
    def parameters(self) -> dict[str, Any]:
        """The values by name, defaults filled in."""
        return dict(self.model_extra or {})

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        values, faults = _read(data)
        return data if faults else {"kind": data["kind"], **values}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        return [fault(loc, raw, text) for loc, text in _read(raw)[1]] if "kind" in good else []


def _read(data: dict[str, Any]) -> tuple[dict[str, Any], list]:
    return read(data.get("kind"), {key: value for key, value in data.items() if key != "kind"})


class Steric(Table):
    """Steric repulsion of rods (5.39)."""

    strength: ZeroOrMore = Field(
        title="strength g0 (force); rods that cross feel a barrier of about g0 a exp(−ε/a)/2",
        description="0 or a positive number",
    )
    range: Positive = Field(title="range a of the repulsion (length)", description="a positive number")
    core: Positive = Field(title="core ε, at least the spacing of the nodes (length)", description="a positive number")


class Time(Table):
    """The end time, the time between saved frames, and how steps are chosen: by their error, or all equal.

    Without ``step`` rods take steps whose length and order keep the error of the run below about ``tolerance`` of the
    length of a rod (default 0.01).
    """

    end: Positive = Field(title="time at which the run ends", description="a positive number")
    step: Positive | None = Field(
        default=None,
        title="time that every step takes; steps follow their error if left out",
        description="a positive number, or left out",
    )
    tolerance: Tolerance | None = Field(
        default=None,
        title="error at the end, of places in L and of strains in 1/L; 0.01 if left out",
        description="a number between 1e-8 and 0.1, or left out",
    )
    save_every: Positive = Field(
        title="time between saved frames; end/100 if left out", description="a positive number"
    )

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with the default for save_every: a hundredth of the run, or the step where that is longer."""
        end, step = (_positive(data.get(key)) for key in ("end", "step"))
        if end is None:  # end is a fault already: any value will do
            return {"save_every": 1.0, **data}
        return {"save_every": min(end, max(end / 100, step or 0.0, SMALLEST)), **data}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        if "step" in good and "tolerance" in good:
            return [fault(("tolerance",), good["tolerance"], ": has no meaning with step: leave one of them out")]
        # One line for each key: where step exceeds both bounds, the later line, on end, is kept.
        at_most = [("step", "save_every"), ("save_every", "end"), ("step", "end")]
        faults = {
            short: fault((short,), good[short], f" = {good[short]}: must be at most {long} = {good[long]}")
            for short, long in at_most
            if short in good and long in good and good[short] > good[long] * (1 + ROUND_OFF)
        }
        return list(faults.values())


class Output(Table):
    """What a run leaves: animation, poster and film, which variables of a frame are saved, and frames in a file.

    Position, status and time are always saved. Which variables there are depends on the rods, so that names are checked
    when a scene is laid out.
    """

    usd: bool = Field(default=True, title="whether an animation is made at the end", description="true or false")
    poster: bool = Field(default=True, title="whether a picture of three frames is made", description="true or false")
    film: bool = Field(
        default=False, title="whether a film in MP4 is made, for which ffmpeg is needed", description="true or false"
    )
    variables: tuple[str, ...] | None = Field(
        default=None,
        title="what is saved besides position, status and time",
        description="a list of names of variables in quotes, or left out for all of them",
    )
    frames_per_file: Annotated[int, Field(ge=1)] | None = Field(
        default=None,
        title="frames in each file of the trajectory; what fits in 256 MB if left out",
        description="a whole number, 1 or more, or left out",
    )


def _positive(value: Any) -> float | None:
    """The value where it is a positive number, else None."""
    try:
        return number(value, Positive)
    except ValueError:
        return None
