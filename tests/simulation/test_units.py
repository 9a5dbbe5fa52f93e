"""Units are the user's: the same physics in units of length, time and force from 1e-9 to 1e9 gives the same numbers.

Swimmers are dimensionless (docs/model.md §1.2): they have no units to choose.
"""

from typing import Any

import numpy as np
import pytest

from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

UNITS = [(1e-9, 1e9, 1e-9), (1e9, 1e-9, 1e9), (1e-9, 1e-9, 1e-9), (1e9, 1e9, 1.0), (1.0, 1e-6, 1e9)]
"""Units of length, time and force."""
EXPONENTS = {
    "position": (1, 0, 0), "strain": (-1, 0, 0), "length": (1, 0, 0), "gauss": (-2, 0, 0), "tension": (0, 0, 1),
    "energy": (1, 0, 1), "steric_energy": (1, 0, 1), "dissipation": (1, -1, 1), "membrane_power": (1, -1, 1),
    "growth_power": (1, -1, 1), "load": (-1, 0, 1), "load_moment": (0, 0, 1), "energy_density": (0, 0, 1),
}  # fmt: skip
"""Units of the saved variables, as powers of length, time and force."""
SURFACES: dict[str, tuple[dict[str, tuple[Any, int]], dict[str, Any]]] = {
    "plane": ({"size": (10.0, 1)}, {}),
    "sphere": ({"radius": (1.0, 1)}, {}),
    "ellipsoid": ({"radii": ([1.0, 1.3, 0.8], 1)}, {}),
    "cylinder": ({"radius": (1.0, 1), "length": (6.0, 1)}, {}),
    "torus": ({"major": (1.0, 1), "minor": (0.4, 1)}, {}),
    "cassini": ({"a": (1.0, 1), "b": (1.15, 1)}, {}),
    "bridge": ({"neck": (0.4, 1), "body": (1.0, 1), "width": (1.0, 1), "length": (4.0, 1)}, {}),
    "undulated": ({"radius": (1.0, 1), "amplitude": (0.16, 2), "wavenumber": (5.0, -1)}, {}),
    "expression": (
        {"a": (1.0, 0), "b": (1.0, 1), "c": (1.0, 1)},
        {"phi": "x**4 + y**4 + z**4 + a*(x**2 + y**2 + z**2)**2 - b**2*(x**2 + y**2 + z**2) - c**4"},
    ),
}
"""Kind of surface → its numbers with their powers of length, and its other values."""
STILL = ("size", "length", "wavenumber")
"""Numbers that do not change on a moving membrane."""


def surface(kind: str, length: float, time: float, moving: bool) -> dict[str, Any]:
    def scaled(name: str, value: Any, power: int) -> Any:
        if isinstance(value, list):
            return [scaled(name, part, power) for part in value]
        number = value * length**power
        return f"{number!r}*(1 + 0.05*sin({3 / time!r}*t))" if moving and name not in STILL else number

    numbers, others = SURFACES[kind]
    found = {name: scaled(name, *value) for name, value in numbers.items()}
    if kind == "expression":
        found = {"parameters": found, "box": [[-1.6 * length, 1.6 * length]] * 3, **others}
    return {"kind": kind, **found}


def scene(kind: str, unit: tuple[float, float, float], moving: bool, **times: float) -> Scene:
    length, time, force = unit
    bending, drag = force * length**2, force * time / length**2
    filaments = {
        "name": "f", "count": 3, "nodes": 17, "length": 0.4 * length,
        "stiffness": [bending, 1.2 * bending, 0.8 * bending],
        "intrinsic": [0.3 / length, 1.2 / length, 0.2 / length],
        "drag": [drag, 2 * drag, 0.1 * force * time],
        "growth": {"rate": 0.5 * length / time, "until": 0.45 * length},
    }  # fmt: skip
    steric = {"strength": 20 * force, "range": 0.05 * length, "core": 0.05 * length}
    table = {name: value * time for name, value in times.items()}
    tables = {"surface": surface(kind, length, time, moving), "filaments": [filaments], "steric": steric}
    return Scene.parse({"seed": 3, **tables, "time": table})


def frames(kind: str, unit: tuple[float, float, float], moving: bool) -> list[dict[str, np.ndarray]]:
    """The frames of a short run, in units of 1, in steps that are not divided at the start: round-off of an error
    decides about the last digits of the parts."""
    simulation = Simulation(scene(kind, unit, moving, end=0.02, step=1e-3, save_every=0.01), "cpu")
    simulation.together._starting, simulation.together._longest = False, simulation.step_size
    found = [simulation.variables()["f"]]
    while not simulation.finished:
        for _ in simulation.to_next_frame():
            pass
        found.append(simulation.variables()["f"])
    powers = {name: float(np.prod(np.power(unit, exponents))) for name, exponents in EXPONENTS.items()}
    return [{name: frame[name] / one for name, one in powers.items()} for frame in found]


CASES = [(kind, moving) for kind in SURFACES for moving in (False, True) if not (moving and kind == "plane")]


@pytest.mark.long
@pytest.mark.parametrize(("kind", "moving"), CASES)
def test_the_same_physics_in_other_units_gives_the_same_numbers(kind, moving, verified):
    expected = frames(kind, (1.0, 1.0, 1.0), moving)
    assert all(np.isfinite(values).all() for frame in expected for values in frame.values())
    errors = []
    for unit in UNITS:
        for found, frame in zip(frames(kind, unit, moving), expected, strict=True):
            for name, values in frame.items():
                size = max(np.abs(values).max(), 1e-6)  # 𝒦 of a cylinder is round-off
                errors.append(np.abs(found[name] - values).max() / size)
    verified.below(
        "symmetry", f"filaments on {kind}{', moving' if moving else ''}, in five other units: all variables, relative",
        measured=errors, bound=1e-9, reference="the same scene in units of 1",
    )  # fmt: skip


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("unit", UNITS)
def test_steps_by_error_are_the_same_in_any_unit(unit, alone, moving):
    """In steps of their own (alone, membrane at rest) and together: their number, their ends, and the result."""
    found = []
    for one in ((1.0, 1.0, 1.0), unit):
        given = scene("torus", one, moving, end=0.02, save_every=0.01)
        simulation = Simulation(given.model_copy(update={"steric": None}) if alone else given, "cpu")
        assert simulation.own_steps == (alone and not moving)
        for _ in simulation.advance():
            pass
        rods = simulation.ensembles["f"]
        found.append((rods, rods.position / one[0], rods.pace_arrays.at.numpy() / one[1]))
    (rods, position, at), (other, *scaled) = found
    assert rods.steps_taken.min() > 20
    np.testing.assert_array_equal(rods.steps_taken, other.steps_taken)
    np.testing.assert_array_equal(rods.steps_rejected, other.steps_rejected)
    np.testing.assert_allclose(scaled[0], position, atol=1e-9)
    np.testing.assert_allclose(scaled[1], at, rtol=1e-6)


def test_a_resumed_run_in_a_small_unit_of_time_refuses_a_time_that_is_not_a_frame():
    """Times of 1e-9 are not all equal."""
    from warp_rods.errors import RunFolderError

    simulation = Simulation(scene("sphere", (1.0, 1e-9, 1.0), False, end=0.02, step=1e-3, save_every=0.01), "cpu")
    simulation.ensembles["f"].step(simulation.step_size, 3)
    with pytest.raises(RunFolderError, match="not a frame"):
        simulation.restore(simulation.state())
