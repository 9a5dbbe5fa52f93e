"""The house style of figures: sizes, fonts and colours."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

COLUMN, PAGE = 86.0, 178.0
"""Widths of a column and of a page of a journal, mm."""
OKABE_ITO = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")
"""Colours that can be distinguished with any type of colour vision (Okabe and Ito 2008)."""
COLOUR_MAP = "viridis"
STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 7.0,
    "axes.labelsize": 7.0,
    "axes.titlesize": 7.0,
    "xtick.labelsize": 6.0,
    "ytick.labelsize": 6.0,
    "legend.fontsize": 6.0,
    "legend.frameon": False,
    "mathtext.fontset": "dejavusans",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "grid.linewidth": 0.4,
    "grid.color": "0.85",
    "image.cmap": COLOUR_MAP,
    "svg.hashsalt": "warp_rods",  # otherwise identifiers in an SVG, and its bytes, would differ from run to run
}
RESOLUTION = 300
"""Dots per inch of PNG, and of the tubes inside an SVG."""


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Draw in the house style within this context; the settings of Matplotlib are restored afterwards."""
    import matplotlib

    with matplotlib.rc_context(STYLE):  # type: ignore[arg-type]
        yield
