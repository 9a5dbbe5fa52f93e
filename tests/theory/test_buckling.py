"""Buckling of clamped filaments (docs/model.md §3): the linearised rates against exact answers and simulations."""

from pathlib import Path

import numpy as np
import pytest
from reference.exact import BRIDGE_BUCKLING_LENGTH, hoop_buckling_length
from scipy.interpolate import CubicSpline

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.theory import buckling
from warp_rods.theory.buckling import Clamped

SPIRAL = Path(__file__).parents[2] / "scenes" / "escrt_spiral.toml"
BRIDGE = surfaces.make("bridge", {"neck": 0.4, "body": 1.0, "width": 1.0})
PUBLISHED = {"stiffness": (1.0, 1.0, 0.1), "intrinsic": (0.0, 1.0, 0.0), "drag": (1.0, 2.0, 0.1)}
EXACT = hoop_buckling_length(0.4, 1.2, (1.0, 1.0, 0.1), 1.0)


def on_hoop(nodes: int, **changes) -> Clamped:
    """A filament clamped along the hoop (the waist) of the neck, where ρ'' = 2 (body − neck)/width² = 1.2."""
    return Clamped(BRIDGE, [0.4, 0.0, 0.0], [0.0, 1.0, 0.0], nodes, {**PUBLISHED, **changes})


def test_the_published_length_is_that_of_the_energys_second_variation():
    assert pytest.approx(BRIDGE_BUCKLING_LENGTH, abs=5e-4) == EXACT


def test_critical_length_is_exact_to_second_order(verified):
    cells = np.array([32, 48, 96])
    found = np.array([buckling.critical_length(on_hoop(n + 1), (0.7, 1.0)) for n in cells])
    verified.order(
        "critical length on the hoop: order in Δs",
        measured=-np.polyfit(np.log(cells), np.log(np.abs(found - EXACT)), 1)[0], reference="closed form",
    )  # fmt: skip
    verified(
        "exact", "critical length on the hoop of a bridge, extrapolated", measured=(4 * found[2] - found[1]) / 3,
        expected=EXACT, relative=1e-4, reference="second variation of the energy, root of a determinant",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("stiffness", "normal_curvature"),
    [((1.0, 1.0, 0.5), 1.0), ((3.0, 1.0, 0.1), 1.0), ((1.0, 1.0, 0.1), 2.0), ((0.1, 1.0, 0.1), 1.0)],
)
def test_critical_lengths_of_other_filaments(stiffness, normal_curvature, verified):
    exact = hoop_buckling_length(0.4, 1.2, stiffness, normal_curvature)
    coarse, fine = (
        buckling.critical_length(
            on_hoop(nodes, stiffness=stiffness, intrinsic=(0.0, normal_curvature, 0.0)), (0.7 * exact, 1.3 * exact)
        )
        for nodes in (49, 97)
    )
    verified(
        "exact", f"critical length on the hoop, B = {stiffness}, σ2 = {normal_curvature:g}",
        measured=(4 * fine - coarse) / 3, expected=exact, relative=4e-3, reference="second variation of the energy",
    )  # fmt: skip


def test_a_cantilever_on_the_plane_has_the_spectrum_of_a_beam(verified):
    plane = Clamped(surfaces.make("plane", {}), [0, 0, 0], [1, 0, 0], 65, {"drag": (1.0, 2.0, 0.0)})
    exact = -0.5 * (np.array([1.87510407, 4.69409113]) / 0.8) ** 4
    found = np.sort(np.linalg.eigvals(buckling.linearise(plane, 0.8)[1]).real)[::-1]
    verified(
        "exact", "spectrum of a cantilever on the plane, N = 64", measured=found[:2], expected=exact, relative=3e-3,
        reference="−(B3/ζ⊥)(x/L)⁴, cos x cosh x = −1",
    )  # fmt: skip
    assert buckling.growth_rate(plane, 0.8) == found[0]


def test_growing_filaments_leave_the_hoop_at_the_critical_length(verified):
    """A small deflection has its minimum at that length, up to an error of first order in the rate of growth."""
    nodes, rates = 33, [0.04, 0.02, 0.01]
    deflected = 1e-5 * np.linspace(1, 0, nodes) ** 2
    rods = BoundRods(
        BRIDGE, np.tile([0.4, 0.0, 0.0], (3, 1)), np.tile([0.0, 1.0, 0.0], (3, 1)), nodes=nodes, length=0.8, at="start",
        ends=("clamped", "free"), geodesic_curvature=deflected, growth={"rate": rates, "until": 0.9}, **PUBLISHED,
    )  # fmt: skip
    lengths, deflections = [], []
    for _ in range(120):
        rods.step(4e-3, 20)
        lengths.append(rods.variables()["length"])
        deflections.append(np.log(np.abs(rods.position[:, -1, 2])))
    leaving = [minimum(*pair) for pair in zip(np.transpose(lengths), np.transpose(deflections), strict=True)]
    critical = buckling.critical_length(on_hoop(nodes), (0.7, 1.0))
    delays = np.abs(np.array(leaving) - critical)
    verified.order(
        "growing filament leaves the hoop: order of its delay in the rate of growth",
        measured=np.polyfit(np.log(rates), np.log(delays), 1)[0], expected=1, within=0.05, reference="critical length",
    )  # fmt: skip
    verified(
        "independent", "length at which a growing filament leaves the hoop, rate → 0",
        measured=2 * leaving[2] - leaving[1], expected=critical, within=1e-5, reference="linear theory, same grid",
    )  # fmt: skip


def minimum(lengths: np.ndarray, deflections: np.ndarray) -> float:
    """The length at which a deflection has its minimum during growth, by a cubic fit about it."""
    growing = np.flatnonzero((lengths > 0.81) & (lengths < 0.899))
    guess = lengths[growing[deflections[growing].argmin()]]
    near = growing[np.abs(lengths[growing] - guess) < 0.02]
    slope = np.polyder(np.poly1d(np.polyfit(lengths[near] - guess, deflections[near], 3)))
    return guess + min(slope.roots.real, key=abs)


def test_relaxation_and_time_stepping_find_the_same_equilibrium(verified):
    filament, length = on_hoop(33), 1.0
    start = np.linspace(-0.3, 0.0, 33)[:-1]
    rest = buckling.equilibrium(filament, length, start)
    rods = filament.filaments(length, start[None])
    rods.step(4e-3, 4000)
    verified.below(
        "independent", "buckled filament at rest by time steps: Ω",
        measured=np.abs(rods.strain[0, :-1, 2] - rest).max(), bound=1e-6,
        reference="Newton's method (`buckling.equilibrium`)",
    )  # fmt: skip
    assert np.abs(rest).max() > 1.0
    assert buckling.growth_rate(filament, length, rest) < 0 < buckling.growth_rate(filament, length)


@pytest.mark.long
def test_a_spiral_filament_snaps_with_hysteresis():
    """A fold away from the waist, with σ3 ≠ 0: shapes differ between growing through it and shrinking back."""
    site = BRIDGE.project(np.array([0.5, 0.0, 0.32]))
    parameters = {"stiffness": (0.6, 1.0, 0.8), "intrinsic": (0.0, -0.7, -1.8), "drag": (1.0, 2.0, 0.1)}
    filament = Clamped(BRIDGE, site, [0.0, 1.0, 0.0], 33, parameters)
    lengths = np.arange(0.3, 2.95, 0.1)
    up = buckling.follow(filament, lengths)
    down = buckling.follow(filament, lengths[:21:-1], up[-1])[::-1]
    apart = np.array([np.abs(a - b).max() for a, b in zip(up[22:], down, strict=True)])
    fold = lengths[22:][apart < 1e-6][0]
    assert 2.6 < fold < 2.9
    assert (apart[lengths[22:] < fold] > 1.0).all()


def test_a_bracket_without_a_critical_length_is_refused():
    with pytest.raises(ValueError, match="both stable"):
        buckling.critical_length(on_hoop(17), (0.5, 0.6))


def smallest_gap(position: np.ndarray, length: float, core: float) -> float:
    """Smallest distance within a centre line by cubic splines, without the pairs that the sterics leave out."""
    s = np.linspace(0, length, len(position))
    fine = np.linspace(0, length, 4 * len(position) - 3)
    r = CubicSpline(s, position)(fine)
    apart = np.abs(fine[:, None] - fine)
    return np.linalg.norm(r[:, None] - r, axis=-1)[apart > max(2 * core, 4 * s[1])].min()


def shortened_spiral(steric: bool) -> Scene:
    """The scene of the spiral with growth from length 1.5 to 5.5, one to two turns, at a higher rate."""
    scene = Scene.load(SPIRAL)
    filaments = scene.filaments[0].model_dump(exclude_none=True)
    filaments |= {"nodes": 101, "length": 1.5, "growth": {"rate": 2.0, "until": 5.5}}
    table = scene.model_dump(exclude_none=True) | {"filaments": [filaments]}
    table["time"] = {"end": 2.2, "save_every": 0.05}
    return Scene.model_validate(table if steric else {k: v for k, v in table.items() if k != "steric"})


@pytest.mark.long
def test_a_spiral_does_not_pass_through_itself(tmp_path):
    """Without sterics its turns come closer than half the core."""
    gaps = {}
    for steric in (True, False):
        run = runner.simulate(shortened_spiral(steric), tmp_path / str(steric), device="cpu")
        data = run.data["escrt"].to_dataset().load().isel(rod=0)
        frames = zip(data.position.values, data.length.values, strict=True)
        gaps[steric] = min(smallest_gap(position, float(length), 0.05) for position, length in frames)
    assert gaps[True] >= 0.5 * 0.05
    assert gaps[False] < 0.5 * 0.05
