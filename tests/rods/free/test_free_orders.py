"""Active rods: second order in space and time, and agreement with a Galerkin solution in the material frame."""

from itertools import pairwise

import numpy as np
import pytest
from examples.free import MOMENT, SMOOTH, TWIST, in_space, planar, slope, start_in_space
from reference import free as twin
from reference.material import MaterialRod
from scipy.spatial.transform import Rotation

from warp_rods.rods.free.flagella import Flagella

READINGS = ("position", "orientation", "strain", "activity", "tension")


PLACE = {planar: "in a plane", in_space: "in space"}


def orders(sizes, runs):
    """Orders of the readings, from differences of neighbouring runs."""
    return [slope(sizes[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)]) for name in READINGS]


@pytest.mark.parametrize("make", [planar, in_space])
def test_second_order_in_time(device, make, verified):
    steps = np.array([100, 200, 400, 800])
    runs = []
    for count in steps:
        rods = make(device, 33)
        rods.step(0.2 / count, int(count))
        runs.append(rods.variables())
    verified.order(
        f"swimmer {PLACE[make]}: order in Δt of {', '.join(READINGS)}", measured=orders(steps, runs),
        reference="successive differences, Δt = 2e-3 to 2.5e-4",
    )  # fmt: skip


@pytest.mark.parametrize("make", [planar, in_space])
def test_second_order_in_space(device, make, verified):
    sizes = np.array([32, 64, 128, 256])
    runs = []
    for size in sizes:
        rods = make(device, int(size) + 1)
        rods.step(5e-4, 200)
        runs.append({name: values[:, :: size // 32] for name, values in rods.variables().items() if name in READINGS})
    verified.order(
        f"swimmer {PLACE[make]}: order in Δs of {', '.join(READINGS)}", measured=orders(sizes, runs),
        reference="successive differences, N = 32 to 256",
    )  # fmt: skip


def test_second_order_while_the_step_changes(device, verified):
    """Steps alternate between Δt and Δt/2; the coefficients follow their ratio."""
    pairs = np.array([100, 200, 400, 800])
    runs = []
    for count in pairs:
        rods, dt = in_space(device, 33), 0.2 / count / 1.5
        for _ in range(count):
            rods.step(dt)
            rods.step(dt / 2)
        runs.append(rods.variables())
    verified.order(
        "swimmer in space: order in Δt while steps alternate between Δt and Δt/2", measured=orders(pairs, runs),
        reference="successive differences of five readings",
    )  # fmt: skip


def test_the_material_frame_gives_the_same_motion(device, verified):
    """Rods of increasing resolution converge to a Galerkin solution in the material frame.

    The diffusion of the flagella is larger than the default, so that polynomials resolve the boundary layers.
    """
    end, s = 0.05, np.linspace(-0.5, 0.5, 65)
    p = twin.Parameters(bend=1e-3, twist=TWIST, moment=MOMENT, diffusion=1e-2)
    bending, twist, activity, R, r = MaterialRod(p, 22).run(start_in_space, end, s)
    expected = {"bending": bending, "twist": twist, "activity": activity, "R": R, "r": r}
    flagella = Flagella(profile=SMOOTH.profile, diffusion=1e-2)
    sizes, errors = np.array([64, 128, 256]), []
    for size in sizes:
        rods = in_space(device, int(size) + 1, flagella=flagella)
        rods.step(end / (8 * size), int(8 * size))
        found, skip = rods.variables(), size // 64
        strain, middle = found["strain"][0, ::skip], found["orientation"][0, size // 2]
        found = {
            "bending": strain[:, 1] + 1j * strain[:, 2], "twist": strain[:, 0],
            "activity": found["activity"][0, ::skip], "R": Rotation.from_quat(middle).as_matrix(),
            "r": found["position"][0, size // 2],
        }  # fmt: skip
        errors.append({name: abs(found[name] - expected[name]).max() for name in expected})
    verified.order(
        "swimmer in space: order towards another solution, of k, τ, f, R, r",
        measured=[slope(sizes, [e[name] for e in errors]) for name in expected],
        reference="(4.19)–(4.24) in the material frame, Galerkin with 22 polynomials, SciPy's Radau",
    )  # fmt: skip
    verified.below(
        "independent", "swimmer in space: place of the middle at t = 0.05, N = 256", measured=errors[-1]["r"],
        bound=2e-6, reference="the same Galerkin solution",
    )  # fmt: skip
