"""Maps of classes of motion in the colours of diagrams of studies: cells and legend."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.diagrams import CLASS_COLOURS

__all__ = ["CLASS_COLOURS", "cells", "draw", "legend"]


def cells(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about values in equal ratios."""
    between = np.sqrt(values[:-1] * values[1:])
    return np.concatenate([[values[0] ** 2 / between[0]], between, [values[-1] ** 2 / between[-1]]])


def draw(axes: Any, x_edges: np.ndarray, y_edges: np.ndarray, classes: np.ndarray) -> None:
    """Cells in the colours of the ``classes`` [y, x]."""
    from matplotlib.colors import ListedColormap

    order = list(CLASS_COLOURS)
    numbers = np.vectorize(order.index)(classes)
    axes.pcolormesh(
        x_edges, y_edges, numbers, cmap=ListedColormap(list(CLASS_COLOURS.values())), vmin=-0.5, vmax=len(order) - 0.5,
        edgecolors="white", linewidth=0.4,
    )  # fmt: skip


def legend(figure: Any, classes: np.ndarray, columns: int = 3) -> None:
    """Below a figure, the classes that occur."""
    from matplotlib.patches import Patch

    handles = [Patch(color=colour, label=name) for name, colour in CLASS_COLOURS.items() if name in classes]
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)
