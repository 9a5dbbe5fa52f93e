"""Every reproduction in its quick form, all in one call, against published, exact and independent numbers.

Numbers of ours that nothing independent is known of are in ``regression.csv``. They guard against changes that nobody
meant, say nothing about what is right, and are not in the report of the verification.
"""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from reference import exact
from rich.console import Console
from scipy.optimize import brentq

from warp_rods.reproductions import reproduce
from warp_rods.reproductions.catalogue import REPRODUCTIONS

with (Path(__file__).parent / "regression.csv").open(encoding="utf-8") as file:
    STORED = list(csv.DictReader(file))
"""name, quantity, value of ours, tolerance (absolute; empty for text), and the reason for that tolerance."""


class Known(NamedTuple):
    """What a quantity of a reproduction should be: ``expected`` ± ``within``, from ``reference``."""

    name: str
    quantity: str
    kind: str
    expected: float
    within: float
    reference: str


def critical_stiffness(length: float) -> float:
    """Stiffness in N m² below which a cell of this length in m buckles: B = β* 2πμ u* L³/ln(L/a) (C.2)."""
    return exact.CRITICAL_BEND_BEAM_MODE * 2 * np.pi * 1e-3 * 13e-6 * length**3 / np.log(length / 1e-6)


def critical_length(stiffness: float) -> float:
    """Length in µm of a cell that buckles at this stiffness in N m²."""
    return 1e6 * brentq(lambda length: critical_stiffness(length) - stiffness, 1e-5, 1e-3)


SHOOTING, WAVING = "tests/reference/straight_rod.py", "tests/reference/waving.py"
HOOP = exact.hoop_buckling_length(0.4, 1.2, (1.0, 1.0, 0.1), 1.0)
RISE = "largest rise of a protein's energy between frames"
FLAGELLA = "local drag on a helix, summed in tests/scene/test_moment.py; the dissertation says 1e-3 to 1e-2"
KNOWN = [
    Known(
        "moment", "M, L = 10 µm, local drag", "exact", (2 * 2.0**2 + 1.5**2) / (4 * np.pi * 10), 1e-6, FLAGELLA,
    ),
    Known(
        "moment", "M, L = 100 µm, printed formulas", "exact", 2.0 / (np.pi**2 * 100), 1e-7,
        "P/π²L; the dissertation says 1e-3",
    ),
    Known(
        "stiffness", "dimensionless β*", "independent", exact.CRITICAL_BEND_BEAM_MODE, 5e-7,
        f"{SHOOTING}; the dissertation prints .0101 (C.2)",
    ),
    Known(
        "stiffness", "critical B⊥, L = 50 µm, N m²", "exact", critical_stiffness(50e-6), 1e-27,
        "(C.2) with β* = 1.0154e-2; the dissertation prints 2.6e-23, with .0101",
    ),
    Known(
        "stiffness", "length at which the measured B⊥ is critical, µm", "exact", critical_length(5.5e-22), 0.01,
        "root of (C.2) with β* = 1.0154e-2",
    ),
    Known(
        "critical", "first critical β⊥, full system", "independent", exact.CRITICAL_BEND_BEAM_MODE, 5e-7,
        f"{SHOOTING}; the dissertation prints 1.0e-2",
    ),
    Known(
        "critical", "first critical β⊥, linear operator, tanh", "independent", exact.CRITICAL_BEND_TANH, 1e-7, SHOOTING
    ),
    Known(
        "fig4.2a", "first β⊥ at which μ vanishes", "independent", exact.AIRY_STIFFNESSES[0], 6e-8,
        f"{SHOOTING}; the dissertation prints 1.0e-2 and 1.1e-2",
    ),
    Known(
        "thresholds", "β⊥ above which there is no U", "independent", exact.SADDLE_NODE, 1e-6,
        "SciPy's `solve_bvp`; the dissertation prints 9.1e-3: ours is 2.5 % less",
    ),
    Known("thresholds", "β⊥ at which the U starts to wave", "independent", exact.HOPF, 1e-7, WAVING),
    Known(
        "thresholds", "β⊥ at which the twisted U starts to oscillate, ηr = 0.01", "published", 2e-4, 5e-6,
        "dissertation §4.4: 2e-4; ηr is not given there",
    ),
    Known("symmetry", "parities of Ω₀, Ω₁, Ω₂, f over max |Ω| (C.50)", "symmetry", 0, 1e-13, "0 over 2000 steps"),
    Known("symmetry", "distance from the line turned by π, L (C.52)", "symmetry", 0, 1e-13, "0 over 2000 steps"),
    Known("symmetry", "phases between gauges, strains over max |Ω| (C.77)", "symmetry", 0, 1e-12, "0 over 2000 steps"),
    Known("tension", "(4.34) against the swimmers' own tension, over max |λ|", "independent", 0, 1e-13, "0"),
    Known("tension", "order in ε of λ₀ + ελ₁, (C.10), (C.11)", "orders", 2, 0.05, "(C.10), (C.11): 2"),
    Known("fig5.3", "critical length, neck 0.4", "exact", HOOP, 2e-3, "second variation of the energy"),
    Known("fig5.4", RISE, "conservation", 0, 1e-6, "0: passive filaments lose energy"),
    Known("fig5.5", RISE, "conservation", 0, 1e-6, "0: passive filaments lose energy"),
]  # fmt: skip
MOTIONS = {
    ("fig4.1g", "as β⊥ falls"): "straight, U, waving, flapping",
    ("fig4.1h", "motion at β⊥ = 0.00013"): "waving",
    ("fig4.1i", "motion at β⊥ = 7.6e-05"): "waving or flapping",
    ("fig4.3a", "motion"): "twisted-U",
    ("fig4.3b", "motion"): "waving",
    ("fig4.3c", "motion"): "S",
    ("fig4.3d", "motion"): "flapping",
    ("fig4.3e", "soft at M = 0, ηr = 0.001"): "flapping",
    ("fig4.3f", "delay, ηr = 0.001"): "delayed",
}
"""Motions as published. In Fig 4.1i, which flaps, waving is stable, too."""

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduced")
    return {outcome.name: outcome for outcome in reproduce.run(["all"], True, folder, Console(quiet=True))}


def ours(outcomes, name: str, quantity: str) -> float | str:
    return {row.quantity: row.ours for row in outcomes[name].rows}[quantity]


@pytest.mark.parametrize("name", REPRODUCTIONS)
def test_each_writes_a_figure_and_data(outcomes, name):
    assert not outcomes[name].error
    assert all(path.exists() for path in outcomes[name].files)


@pytest.mark.parametrize("known", KNOWN, ids=lambda known: f"{known.name}: {known.quantity}")
def test_numbers_agree_with_references(outcomes, known, verified):
    found = ours(outcomes, known.name, known.quantity)
    name = f"`reproduce {known.name}`: {known.quantity}"
    verified(known.kind, name, measured=found, expected=known.expected, within=known.within, reference=known.reference)


def test_motions_are_those_published(outcomes, verified):
    agree = [ours(outcomes, *of) == motion for of, motion in MOTIONS.items()]
    verified(
        "published", "motions of Figs 4.1g–i, 4.3a–f as published", measured=sum(agree),
        expected=len(MOTIONS), within=0,
        reference="dissertation §4.3, §4.4: " + "; ".join(f"{name} {motion}" for (name, _), motion in MOTIONS.items()),
    )  # fmt: skip


@pytest.mark.parametrize(("name", "within"), [
    ("U, planar", 0.01), ("S, planar", 0.01), ("twisted S, Fig 4.3c", 0.01), ("flapping, Fig 4.3d", 0.03)
])  # fmt: skip
def test_asymmetry_grows_in_runs_as_linear_theory_says(outcomes, name, within, verified):
    verified(
        "independent", f"`reproduce asymmetry`: growth in a run about the {name}",
        measured=ours(outcomes, "asymmetry", f"growth rate of asymmetry in a run: {name}"),
        expected=ours(outcomes, "asymmetry", f"growth rate of asymmetry, linear theory: {name}"), relative=within,
        reference="Floquet exponent" if "flapping" in name else "leading eigenvalue of the Jacobian",
    )  # fmt: skip


@pytest.mark.parametrize("stored", STORED, ids=lambda stored: f"{stored['name']}: {stored['quantity']}")
def test_stored_numbers_have_not_changed(outcomes, stored):
    """A regression guard: no check of what is right."""
    found = ours(outcomes, stored["name"], stored["quantity"])
    if not stored["tolerance"]:
        assert found == stored["value"]
    else:
        assert found == pytest.approx(float(stored["value"]), abs=float(stored["tolerance"]), rel=0)


def test_every_reproduction_is_compared_with_a_number():
    named = {known.name for known in KNOWN} | {name for name, _ in MOTIONS} | {stored["name"] for stored in STORED}
    assert named == set(REPRODUCTIONS)


def test_classes_have_the_colours_of_studies():
    from matplotlib.colors import to_rgba
    from matplotlib.figure import Figure

    from warp_rods.draw.diagrams import CLASS_COLOURS, colour_of
    from warp_rods.reproductions import drawn_classes

    names, axes = list(CLASS_COLOURS), Figure().subplots()
    drawn_classes.draw(axes, np.arange(len(names) + 1), np.arange(2), np.array([names]))
    axes.figure.canvas.draw()
    drawn = axes.collections[0].get_facecolors()
    np.testing.assert_allclose(drawn, [to_rgba(colour_of(name, names)) for name in names])
