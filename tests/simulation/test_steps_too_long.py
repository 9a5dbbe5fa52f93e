"""Steps of a given length that are too long: a result that is wrong by more than 3 % is told; one that is right is not.

Each case was silently wrong with steps that looked sensible. Exact is the result by error with tolerance 1e-4.
"""

import functools

import numpy as np
import pytest

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.watch import StepWatch

SWIMMER = {
    "name": "c", "count": 1, "nodes": 65, "bend": 5e-3, "twist": 1e-3,
    "shape": {"kind": "mode", "mode": 0, "amplitude": 3.0},
}  # fmt: skip
FILAMENT = {"name": "f", "count": 1, "nodes": 33, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
BENT = {"intrinsic": [0, 0, 1], "length": 1.0, "placement": {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]}}
SLIDING = {"count": 6, "length": 0.3, "intrinsic": [0, -0.8, 0]}
TURNING = {"count": 4, "nodes": 65, "length": 0.6, "intrinsic": [0, 1, 0]}

UNDULATED, TORUS = {"kind": "undulated"}, {"kind": "torus", "major": 1.0, "minor": 0.4}


def swimmer(end: float, **values) -> dict:
    return {"swimmers": [SWIMMER | values], "time": {"end": end}}


def filament(end: float, surface: dict, **values) -> dict:
    return {"seed": 5, "surface": surface, "filaments": [FILAMENT | values], "time": {"end": end}}


CASES = {
    "a start that the ends contradict": filament(1.0, {"kind": "plane"}, **BENT),
    "little drag along": filament(0.1, UNDULATED, **SLIDING, drag=[0.1, 2, 0.1]),
    "hardly any drag along": filament(0.1, UNDULATED, **SLIDING, drag=[0.01, 2, 0.1]),
    "fast turning": filament(0.05, TORUS, **TURNING),
    "stiff against normal bending": filament(0.05, TORUS, **TURNING, stiffness=[10, 10, 1]),
    "fast flagella": swimmer(0.3, symmetric=True, flagella={"relaxation": 3e-5}),
    "very stiff": swimmer(0.3, bend=3.0),
    "very soft": swimmer(0.3, bend=3e-6, nodes=487),
    "stiff against twist": swimmer(0.3, bend=8e-5, twist=8e-2, moment=6e-3, nodes=165),
    "many periods of waving": swimmer(10.0, symmetric=True, bend=1e-4, nodes=129),
    "flapping": swimmer(5.0, symmetric=True, bend=6e-5, nodes=129),
}
WRONG = {
    "little drag along": 7e-3, "hardly any drag along": 1e-3, "fast turning": 1e-2,
    "stiff against normal bending": 1e-2, "fast flagella": 3e-4, "stiff against twist": 3e-2,
    "many periods of waving": 1.8e-2, "flapping": 4e-2,
}  # fmt: skip
RIGHT = {
    "a start that the ends contradict": 1e-2, "little drag along": 1e-4, "fast turning": 1e-3,
    "stiff against normal bending": 1e-3, "fast flagella": 1e-4, "very stiff": 1e-2, "very soft": 3e-4,
    "stiff against twist": 5e-3, "many periods of waving": 4e-3, "flapping": 4e-3,
}  # fmt: skip
"""Steps."""


def finished(name: str, **time: float) -> tuple[Simulation, dict[str, np.ndarray]]:
    tables = CASES[name]
    end = tables["time"]["end"]
    simulation = Simulation(Scene.parse(tables | {"time": {"end": end, "save_every": end, **time}}), "cpu")
    for _ in simulation.advance():
        pass
    return simulation, next(iter(simulation.variables().values()))


@functools.cache
def exact(name: str) -> dict[str, np.ndarray]:
    return finished(name, tolerance=1e-4)[1]


def error(name: str, found: dict[str, np.ndarray]) -> float:
    """The largest error of places over the length."""
    apart = np.abs(found["position"] - exact(name)["position"]).max(axis=(1, 2))
    return float((apart / found.get("length", 1.0)).max())


def told(simulation: Simulation) -> list[str]:
    return [line for line in simulation.new_warnings() if "had an error of" in line]


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_result_is_told(name):
    simulation, found = finished(name, step=WRONG[name])
    assert error(name, found) > 0.03
    (line,) = told(simulation)
    assert "by estimate: the result can be wrong without diverging" in line and line.endswith("(leave time.step out)")


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_result_is_not(name):
    simulation, found = finished(name, step=RIGHT[name])
    assert error(name, found) < 2e-3
    assert not told(simulation)


STEPS_BEFORE = {
    "little drag along": 0.1 / 1.12e-4, "hardly any drag along": 0.1 / 1.12e-5, "fast flagella": 0.3 / 6.7e-5,
    "very stiff": 0.3 / 1.1e-4, "very soft": 0.3 / 1.5e-4, "stiff against twist": 0.3 / 6.8e-5,
    "a start that the ends contradict": 1.0 / 1e-3,
}  # fmt: skip
"""Steps of the length that these cases asked for when bounds chose it."""
FEWER = {"little drag along": 1.4, "hardly any drag along": 4, "a start that the ends contradict": 4}
"""How many times fewer steps by error are at least; 10 for the others."""


@pytest.mark.parametrize("name", STEPS_BEFORE)
def test_steps_by_error_end_right_and_are_few(name, verified):
    simulation, found = finished(name)
    (rods,) = simulation.ensembles.values()
    verified.below(
        "independent", f"steps by error, {name}: error of places over the length", measured=error(name, found),
        bound=3e-3, reference="a tolerance 100 times smaller",
    )  # fmt: skip
    for other, allowed in (("energy", 0.01), ("strain", 0.02)):
        rms, size = (np.sqrt(np.mean(values**2)) for values in (found[other] - exact(name)[other], exact(name)[other]))
        assert rms < allowed * max(size, 1e-9), other  # 0 at rest
    if "gauss" in found:
        gauss = exact(name)["gauss"]
        assert np.abs(found["gauss"] - gauss).max() <= 0.01 * np.abs(gauss).max()
    assert (rods.steps_taken + rods.steps_rejected).max() < STEPS_BEFORE[name] / FEWER.get(name, 10)
    assert not simulation.new_warnings()


def test_a_swimmer_with_fast_flagella_swims_as_with_short_steps():
    (_, found), (_, short) = finished("fast flagella"), finished("fast flagella", step=3e-5)
    assert found["energy"] == pytest.approx(short["energy"], rel=1e-3)
    np.testing.assert_allclose(found["position"], short["position"], atol=2e-4)


def test_a_step_that_is_too_long_where_a_filament_has_come_to_is_told_once():
    neck = surfaces.make("bridge", {"neck": 0.1, "body": 1.0, "width": 0.3, "length": 6.0})

    def after(dt: float) -> dict[str, BoundRods]:
        rods = BoundRods(neck, [[1.0, 0, 2.5], [0.1, 0, 0]], [[0, 1, 0], [0, 1, 0.1]], nodes=17, length=0.1)
        rods.advance(dt, 20)
        return {"f": rods}

    watch, long = StepWatch(), after(1e-3)
    (line,) = watch.check(long)
    assert line.startswith("f: by t = 0.02 a step of rod 1 had an error of")
    assert not watch.check(long)
    assert not StepWatch().check(after(1e-6))


def test_own_loops_are_told_once(caplog):
    rods = BoundRods(surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], intrinsic=(0, 0, 1))
    for _ in range(3):
        rods.step(0.1, 5)
    assert len([record for record in caplog.records if "had an error of" in record.message]) == 1
