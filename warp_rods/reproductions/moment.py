"""Section 4.2: the active moment of a cell with helical flagella, from their pitch and circumference."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.scene.moment import moment_from_flagella

PITCH, CIRCUMFERENCE = 2.0, 1.5
"""P and C of a flagellum in µm."""
LENGTHS = {10.0: 1e-2, 100.0: 1e-3}
"""Length of the cell in µm → M, as the text gives them."""


def of_the_text(length: Any) -> Any:
    """M = L_ν/(L F_ν) = P/π²L of the printed F_ν and L_ν."""
    return PITCH / (np.pi**2 * length)


def moments(quick: bool) -> Result:
    """M of cells of both lengths by the printed formulas, and by local drag on the helix."""
    rows = []
    for length, published in LENGTHS.items():
        ours = float(moment_from_flagella(PITCH, CIRCUMFERENCE, length))
        thin = PITCH / (np.pi * length)
        name = f"M, L = {length:g} µm"
        rows += [
            Comparison(
                f"{name}, printed formulas", published, float(of_the_text(length)), "P/π²L, twice what the text says"
            ),
            Comparison(f"{name}, thin helix", published, thin, "P/πL: local drag, C ≪ P; the text has π² for π"),
            Comparison(f"{name}, local drag", published, ours, "(2P² + C²)/(2πPL): moment_from_flagella"),
        ]
    lengths = np.geomspace(8.0, 120.0, 40)
    data = {
        "length_um": lengths,
        "moment": moment_from_flagella(PITCH, CIRCUMFERENCE, lengths),
        "moment_of_the_text": of_the_text(lengths),
    }
    note = "P = 2 µm, C = 1.5 µm; length, thickness and speed of the flagella cancel"
    return Result(_figure(data), rows, data, (note,))


def _figure(data: dict[str, np.ndarray]) -> Any:
    figure = plots.figure(plots.COLUMN, 55)
    axes = figure.subplots()
    axes.loglog(data["length_um"], data["moment"], color=plots.OKABE_ITO[0], label="local drag on the helix")
    axes.loglog(data["length_um"], data["moment_of_the_text"], "--", color=plots.OKABE_ITO[1], label="printed formulas")
    axes.loglog(list(LENGTHS), list(LENGTHS.values()), "o", color=plots.OKABE_ITO[1], mfc="white", label="the text")
    axes.set_xlabel("length of the cell L (µm)")
    axes.set_ylabel("active moment M")
    axes.legend(loc="upper right")
    return figure
