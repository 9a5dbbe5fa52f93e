"""The class of figures. It inherits from Matplotlib's, and is therefore imported only where a figure is made."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.figure import Figure  # noqa: TID253

from warp_rods.draw.style import style

DISPLAY_RESOLUTION = 200
"""Dots per inch in a notebook."""


class StyledFigure(Figure):
    """A figure that is saved in the house style, and that notebooks show although it is not registered with pyplot."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """As ``Figure.savefig``, in the house style."""
        with style():
            super().savefig(fname, **options)

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=DISPLAY_RESOLUTION)
        return picture.getvalue()
