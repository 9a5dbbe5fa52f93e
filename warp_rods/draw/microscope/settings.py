"""The microscope: its settings as a table in TOML, and those that follow from a run where they are left out."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tomli_w
from pydantic import AfterValidator, Field

from warp_rods.errors import SceneError
from warp_rods.scene.checks import Table, read_table
from warp_rods.scene.units import metres
from warp_rods.values import Number, Positive, ZeroOrMore

if TYPE_CHECKING:
    from warp_rods.draw.content import Content

__all__ = ["Complete", "Microscope", "microscope", "widths"]

BRIGHT = 200.0
"""Photons of a piece of a rod as long as the width of the point spread function, where ``photons`` is left out."""
WIDTH_OF_A_ROD, AXIAL = 1.5, 3.0
"""Lateral width in radii of a rod, and axial over lateral width, where lengths have no unit and no width is given."""


def _wavelength(text: str) -> str:
    if not 0 < metres(text) < math.inf:
        raise ValueError("no length")
    return text


class Microscope(Table):
    """A fluorescence microscope with a Gaussian point spread function. Lengths are in units of the scene."""

    wavelength: Annotated[str, AfterValidator(_wavelength)] = Field(
        default="520 nm", description='a length in quotes, such as "520 nm"'
    )
    aperture: Positive = Field(default=1.2, description="a positive number: the numerical aperture")
    index: Positive = Field(default=1.333, description="a positive number: the refractive index")
    width: Positive | None = Field(
        default=None, description="a positive number: the lateral standard deviation, or left out"
    )
    depth: Positive | None = Field(
        default=None, description="a positive number: the axial standard deviation, or left out"
    )
    pixel: Positive | None = Field(default=None, description="a positive number: the edge of a pixel, or left out")
    planes: Annotated[int, Field(ge=1, le=10_000)] = Field(default=1, description="a whole number, 1 to 10000")
    spacing: Positive | None = Field(default=None, description="a positive number: between planes, or left out")
    focus: Number | None = Field(default=None, description="a number: z of the middle of the planes, or left out")
    photons: Positive | None = Field(default=None, description="a positive number: per length of a rod, or left out")
    background: ZeroOrMore = Field(default=10.0, description="0 or a positive number: photons in a pixel")
    gain: Positive = Field(default=2.0, description="a positive number: counts for a photon")
    offset: ZeroOrMore = Field(default=100.0, description="0 or a positive number: counts in the dark")
    read_noise: ZeroOrMore = Field(default=1.5, description="0 or a positive number: its standard deviation in photons")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(default=0, description="a whole number from 0 to 2^63 − 1")

    def to_toml(self) -> str:
        """The settings as TOML; ``microscope`` reads the same from it."""
        return tomli_w.dumps({key: value for key, value in self.model_dump().items() if value is not None})


class Complete(Microscope):
    """A microscope of which nothing is left out."""

    width: Positive
    depth: Positive
    pixel: Positive
    spacing: Positive
    focus: Number
    photons: Positive


def widths(wavelength: float, aperture: float, index: float) -> tuple[float, float]:
    """Lateral and axial standard deviation of the Gaussian with the curvature of the paraxial wide-field peak.

    √2 λ/(2π NA) = 0.225 λ/NA and √6 n λ/(π NA²) = 0.78 n λ/NA² (Zhang, Zerubia and Olivo-Marin, Appl. Opt. 46, 1819,
    2007): those of (2 J₁(v)/v)² with v = 2π NA r/λ, and of (sin(u/4)/(u/4))² with u = 2π NA² z/(n λ).
    """
    lateral = math.sqrt(2) * wavelength / (2 * math.pi * aperture)
    return lateral, math.sqrt(6) * index * wavelength / (math.pi * aperture**2)


def microscope(content: Content, path: str = "") -> Complete:
    """The settings in a file (none where ``path`` is empty), with those that it leaves out, for what is shown.

    Raises SceneError for a file that cannot be read, and with a line for each wrong setting.
    """
    given = read_table(Microscope, _read(path), *([path] if path else []))
    found = given.model_dump()
    lateral, axial = _widths(given, content)
    found |= {"width": given.width or lateral, "depth": given.depth or axial * (given.width or lateral) / lateral}
    defaults = {
        "pixel": found["width"],
        "spacing": found["depth"],
        "focus": _middle(content),
        "photons": BRIGHT / found["width"],
    }
    return Complete.model_validate({key: defaults.get(key) if value is None else value for key, value in found.items()})


def _widths(given: Microscope, content: Content) -> tuple[float, float]:
    """The widths that the optics give, or those that suit the rods where the scene has no unit of length."""
    if content.scene.units:
        return widths(metres(given.wavelength) / content.metres, given.aperture, given.index)
    width = WIDTH_OF_A_ROD * min(rods.radius for rods in content.rods)
    return width, AXIAL * width


def _middle(content: Content) -> float:
    """The mean height of the nodes at the first frame."""
    return float(np.mean([rods.positions(0)[..., 2].mean() for rods in content.rods]))


def _read(path: str) -> dict[str, Any]:
    if not path:
        return {}
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as fault:
        raise SceneError(f"optics = {path!r}: cannot be read: {fault.strerror or fault}") from None
    except ValueError as fault:
        raise SceneError(f"optics = {path!r}: this is not TOML: {fault}") from None
