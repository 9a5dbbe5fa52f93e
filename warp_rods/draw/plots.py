"""Figures in the house style, with rods drawn as shaded tubes. Sizes are in millimetres.

    with plots.style():
        figure = plots.figure()
        plots.tubes(figure.subplots(), position)
    plots.save(figure, "rods")  # rods.png and rods.svg

Figures are Matplotlib figures made without pyplot: no window, no global list of figures, no change of settings.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from warp_rods.draw.style import COLOUR_MAP, COLUMN, OKABE_ITO, PAGE, RESOLUTION, STYLE, style
from warp_rods.draw.tubes import one_scale, scale_bar, tubes
from warp_rods.simulation.files import replace_file
from warp_rods.simulation.leftovers import partial_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOUR_MAP",
    "COLUMN",
    "OKABE_ITO",
    "PAGE",
    "RESOLUTION",
    "STYLE",
    "figure",
    "one_scale",
    "panel_title",
    "save",
    "scale_bar",
    "style",
    "tubes",
]


def figure(width: float = COLUMN, height: float = 60.0) -> Figure:
    """An empty ``matplotlib.figure.Figure`` of this size in mm; draw on it within ``style()``."""
    from warp_rods.draw.figure import StyledFigure

    with style():
        return StyledFigure(figsize=(width / 25.4, height / 25.4), layout="constrained")


def save(figure: Figure, stem: str | Path) -> tuple[Path, Path]:
    """Write ``stem``.png and ``stem``.svg, creating the folder; returns both paths. Equal figures give equal bytes.

    Each is replaced as a whole. Raises OSError where that fails.
    """
    stem = Path(stem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    png, svg = stem.with_name(stem.name + ".png"), stem.with_name(stem.name + ".svg")
    for path, how in ((png, {"dpi": RESOLUTION, "metadata": {"Software": None}}), (svg, {"metadata": {"Date": None}})):
        drawn = io.BytesIO()
        figure.savefig(drawn, format=path.suffix[1:], **how)
        replace_file(path, drawn.getbuffer(), partial_of(path))
    return png, svg


def panel_title(axes: Axes, text: str) -> None:
    """The title of a panel, above its upper left corner."""
    axes.set_title(text, loc="left", fontweight="bold")
