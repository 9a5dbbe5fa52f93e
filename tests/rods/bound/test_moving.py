"""Moving membranes (docs/moving_membranes.md): exact solutions, comparison with a membrane at rest, power, orders.

References are closed forms and conservation laws, orders are fitted slopes. Every tolerance is round-off or follows
from the order.
"""

from itertools import pairwise

import numpy as np
import pytest
from examples.bound import BOUNDS, constraint_errors, energy_defect, read
from scipy.integrate import solve_ivp

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods

PARAMETERS = {
    "length": 1.2,
    "stiffness": (1.0, 1.2, 0.8),
    "intrinsic": (0.7, 1.0, 0.3),
    "drag": (1.0, 2.0, 0.3),
}
MOVING_TORUS = "(sqrt((x - c)**2 + y**2) - 1)**2 + z**2 - 0.16"


def arc(nodes: int) -> np.ndarray:
    return np.linspace(-0.5, 0.5, nodes)


def on_torus(nodes: int, surface: surfaces.Surface, device: str = "cpu") -> BoundRods:
    """A bent filament across a torus, with all coefficients different from zero."""
    s = arc(nodes)
    turn = 0.3 + 2 * np.cos(np.pi * s) ** 4 * np.sin(5 * s + 1)
    place = ([[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]])
    return BoundRods(surface, *place, nodes=nodes, geodesic_curvature=turn, device=device, **PARAMETERS)


def breathing(amplitude: float = 0.08, frequency: float = 3.0) -> surfaces.Surface:
    """A torus whose tube swells and shrinks."""
    return surfaces.make("torus", {"major": 1.0, "minor": f"0.4 + {amplitude}*sin({frequency}*t)"})


def slope(differences) -> float:
    """Order from successive differences of solutions, each with half the step of the previous one."""
    return float(np.polyfit(np.arange(len(differences)), -np.log2(differences), 1)[0])


def test_a_great_circle_remains_one_on_a_growing_sphere(device, verified):
    """At constant length and direction of the middle: r = R(t) (cos s/R, sin s/R, 0), exactly."""
    sphere = surfaces.make("sphere", {"radius": "1.0 + 0.2*t"})
    rods = BoundRods(sphere, [[1, 0, 0]], [[0, 1, 0]], nodes=33, length=1.5, device=device)
    rods.step(1e-3, 1000)
    s, R = 1.5 * arc(33), 1.2
    exact = R * np.stack([np.cos(s / R), np.sin(s / R), 0 * s], axis=-1)
    directors, name = rods.rotation[0], "great circle on a growing sphere"
    frames = np.stack([np.stack([-np.sin(s / 1.2), np.cos(s / 1.2), 0 * s], axis=-1), 0 * exact, exact / 1.2], axis=-1)
    frames[:, 2, 1] = 1.0
    errors = {"places": np.abs(rods.position[0] - exact).max(), "directors": np.abs(directors - frames).max()}
    for what, error in errors.items():
        verified.below(
            "exact", f"{name}: {what}", measured=error, bound=1e-13, reference="R(t)(cos s/R, sin s/R, 0) and its frame"
        )
    values = rods.variables()
    # E = ½ B2 L/R²; membrane power dE/dt + ζ∥ ∫(s Ṙ/R)² ds + ζ⊥ L Ṙ²
    rates = -1.5 * 0.2 / R**3 + (0.2 / R) ** 2 * 1.5**3 / 12 + 2.0 * 1.5 * 0.2**2
    verified(
        "exact", f"{name}: power of the membrane", measured=values["membrane_power"][0], expected=rates, relative=0.01,
        reference="dE/dt + ζ∥ ∫(sṘ/R)² ds + ζ⊥ L Ṙ²",
    )  # fmt: skip


def test_a_growing_great_circle_remains_one_on_a_growing_sphere_during_refinement(verified):
    sphere = surfaces.make("sphere", {"radius": "1.0 + 0.2*t"})
    growth = {"rate": 0.3, "until": 9.0, "spacing": 0.05}
    rods = BoundRods(sphere, [[1, 0, 0]], [[0, 1, 0]], nodes=33, length=1.5, growth=growth)
    rods.step(1e-3, 1000)
    assert rods.nodes == 65
    s, R = 1.8 * arc(65), 1.2
    exact = R * np.stack([np.cos(s / R), np.sin(s / R), 0 * s], axis=-1)
    verified.below(
        "exact", "growing great circle on a growing sphere, refined: places",
        measured=np.abs(rods.position[0] - exact).max(), bound=1e-12, reference="R(t)(cos s/R, sin s/R, 0)",
    )  # fmt: skip


def test_the_geodesic_curvature_of_a_latitude_circle_decreases_on_a_growing_sphere(verified):
    """Without motion across, Ω = cot θ/R at constant θ: ∂tΩ = −Ω Ṙ/R."""
    sphere = surfaces.make("sphere", {"radius": "0.9 + 0.3*t"})
    turn = 0.8
    rods = BoundRods(
        sphere, [[0.9, 0, 0]], [[0, 1, 0]], nodes=33, stiffness=(1e-6,) * 3, intrinsic=(0.0, 0.0, turn),
        geodesic_curvature=turn, drag=(1.0, 1e9, 0.0),
    )  # fmt: skip
    rods.evaluate()
    verified(
        "exact", "latitude circle on a growing sphere: ∂tΩ", measured=read(rods, "geodesic_rate")[0, 1:-1],
        expected=-turn * 0.3 / 0.9, relative=1e-8, reference="−Ω Ṙ/R",
    )  # fmt: skip


def test_a_filament_rolls_under_a_sphere_that_moves_sideways(verified):
    """On the equator of a sphere with velocity c along its axis: ω0 = (c − u2)/R, u2 = c (ζr/R²)/(ζ⊥ + ζr/R²)."""
    radius, velocity, drag = 0.8, 0.5, (1.0, 2.0, 0.7)
    text = f"x**2 + y**2 + (z - c)**2 - {radius**2}"
    sphere = surfaces.make("expression", {"phi": text, "box": [[-1, 1]] * 3, "parameters": {"c": f"{velocity}*t"}})
    rods = BoundRods(sphere, [[radius, 0, 0]], [[0, 1, 0]], nodes=33, drag=drag)
    rods.evaluate()
    up = rods.rotation[0, :, 2, 1]
    roll = drag[2] / radius**2
    verified(
        "exact", "filament under a sphere that moves sideways: velocity across",
        measured=read(rods, "velocity_across")[0] * up, expected=velocity * roll / (drag[1] + roll), relative=1e-8,
        reference="c (ζr/R²)/(ζ⊥ + ζr/R²)",
    )  # fmt: skip


def test_a_filament_follows_a_rising_plane(device, verified):
    rising = surfaces.make("expression", {"phi": "z - h", "box": [[-2, 2]] * 3, "parameters": {"h": "0.3*sin(2*t)"}})
    lines = []
    for surface in (rising, surfaces.make("plane", {})):
        rods = BoundRods(
            surface, [[0, 0, 0]], [[1, 0.3, 0]], nodes=33, geodesic_curvature=3 * np.cos(np.pi * arc(33)) ** 2,
            device=device,
        )  # fmt: skip
        rods.step(1e-3, 200)
        lines.append(rods.position[0])
    lines[0][:, 2] -= 0.3 * np.sin(0.4)
    verified.below(
        "symmetry", "filament on a rising plane against one at rest: places",
        measured=np.abs(lines[0] - lines[1]).max(), bound=1e-12, reference="the same, moved by h(t)",
    )  # fmt: skip


def differences_from_torus_at_rest(nodes: int) -> tuple[float, float]:
    """Largest differences in position and load between filaments on a torus that moves at (c, 0, 0) and on one at rest.

    On the torus at rest the fluid flows past: the drag −ζ∥ c∥ − ζ⊥ c⊥ is an external force; ω is the same for both.
    """
    velocity, dt, steps = 0.8, 4e-4 * 32 / (nodes - 1), 2 * (nodes - 1)
    box = [[-1.6, 1.6], [-1.6, 1.6], [-0.6, 0.6]]
    values = {"phi": MOVING_TORUS, "box": box, "parameters": {"c": f"{velocity}*t"}}
    moving = on_torus(nodes, surfaces.make("expression", values))
    resting = on_torus(nodes, surfaces.make("torus", {"major": 1.0, "minor": 0.4}))

    def apply_flow() -> None:
        q, c = resting.rotation[..., 0], np.array([velocity, 0.0, 0.0])
        along = q * (q @ c)[..., None]
        resting.force = -1.0 * along - 2.0 * (c - along)

    for _ in range(steps):
        apply_flow()
        resting.step(dt)
    moving.step(dt, steps)
    apply_flow()
    difference = moving.position - resting.position - [velocity * moving.time, 0.0, 0.0]
    loads = [rods.variables()["load"] for rods in (moving, resting)]
    return np.abs(difference).max(), np.abs(loads[0] - loads[1])[:, 3:-3].max() / np.abs(loads[1]).max()


def test_a_moving_membrane_is_equivalent_to_one_at_rest_in_a_flow(verified):
    position, load = np.transpose([differences_from_torus_at_rest(nodes) for nodes in (17, 33, 65)])
    name = "filament on a torus that moves against one at rest in a flow"
    verified.below(
        "symmetry", f"{name}: places, N = 64", measured=position[-1], bound=2e-6, reference="the same, moved by ct"
    )
    verified.order(f"{name}: order in Δs and Δt", measured=slope(position), reference="differences of places")
    verified.below(
        "symmetry", f"{name}: load, relative, N = 64", measured=load[-1], bound=1e-4, reference="the same load"
    )


@pytest.mark.long
def test_second_order_in_space_on_a_breathing_torus(device, verified):
    lines = []
    for nodes in (17, 33, 65, 129):
        rods = on_torus(nodes, breathing(), device)
        rods.step(1e-4, 200)
        lines.append(rods.position[0, :: (nodes - 1) // 16])
    found = slope([np.abs(a - b).max() for a, b in pairwise(lines)])
    verified.order("filament on a breathing torus: order in Δs", measured=found, reference="N = 16 to 128")


@pytest.mark.long
def test_second_order_in_time_on_a_breathing_torus(device, verified):
    lines = []
    for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        rods = on_torus(33, breathing(), device)
        rods.step(2.5e-5, 2000)  # the fast initial relaxation, with the same steps in every run
        rods.step(step, round(0.1 / step))
        lines.append(rods.position[0])
    found = slope([np.abs(a - b).max() for a, b in pairwise(lines)])
    verified.order("filament on a breathing torus: order in Δt", measured=found, reference="Δt = 2e-3 to 2.5e-4")


def test_the_energy_balance_includes_the_power_of_the_membrane(verified):
    """On a torus whose tube swells fast."""
    residuals = []
    for nodes in (33, 65, 129):
        rods = on_torus(nodes, breathing(0.2, 5.0))
        rods.step(1e-4, 500)
        residuals.append(energy_defect(rods, 2e-5))
    name = "filament on a breathing torus: |dE/dt + dissipation − power|"
    verified.order(f"{name}, order in Δs", measured=slope(residuals), reference="N = 32, 64, 128")
    verified.below(
        "conservation", f"{name} over the dissipation, N = 128", measured=residuals[-1], bound=1e-4, reference="0"
    )


def test_a_filament_stays_on_the_moving_membrane_and_keeps_its_length(device, verified):
    rods, found = on_torus(49, breathing(), device), []
    for _ in range(10):
        rods.step(1e-3, 100)
        found.append(constraint_errors(rods))
    for name, bound in BOUNDS.items():
        verified.below(
            "constraint", f"filament on a breathing torus: {name}", measured=[errors[name] for errors in found],
            bound=bound, reference="0, at ten times of 1000 steps",
        )  # fmt: skip


def test_a_restored_state_continues_with_the_same_bits(device, verified):
    rods = on_torus(33, breathing(), device)
    rods.step(1e-3, 20)
    state = rods.state()
    rods.step(1e-3, 30)
    other = on_torus(33, breathing(), device)
    other.restore(state)
    other.step(1e-3, 30)
    verified.same("filament on a breathing torus: a restored state", other.position, rods.position, reference="no stop")


def test_a_membrane_with_zero_velocity_gives_the_bits_of_one_at_rest(verified):
    """The terms of a moving membrane vanish exactly for V = 0."""
    lines = []
    for minor in ("0.4 + 0*t", 0.4):
        rods = on_torus(33, surfaces.make("torus", {"major": 1.0, "minor": minor}))
        rods.step(1e-3, 50)
        lines.append(rods.variables())
    verified.same("membrane with zero velocity: a frame", lines[0], lines[1], reference="membrane at rest")


def clamped(surface, position, direction, nodes=33, **given):
    return BoundRods(surface, [position], [direction], nodes=nodes, at="start", ends=("clamped", "free"), **given)


@pytest.mark.parametrize("ends", [("clamped", "free"), ("free", "clamped")], ids="-".join)
def test_a_clamped_great_circle_remains_one_on_a_growing_sphere(ends, device, verified):
    """The clamp keeps its direction from the centre: r = R(t) (cos(s/R), sin(s/R), 0) from it on, exactly."""
    sphere = surfaces.make("sphere", {"radius": "1.0 + 0.2*t"})
    rods = BoundRods(
        sphere, [[1, 0, 0]], [[0, 1, 0]], nodes=33, length=1.5, at="start", ends=ends, device=device,
    )  # fmt: skip
    held = 0 if ends[0] == "clamped" else -1
    at_clamp = 0.0 if ends[0] == "clamped" else 1.5
    rods.step(1e-3, 1000)
    s = np.linspace(0, 1.5, 33)
    angle = at_clamp + (s - s[held]) / 1.2
    exact = 1.2 * np.stack([np.cos(angle), np.sin(angle), 0 * s], axis=-1)
    verified.below(
        "exact", f"clamped great circle on a growing sphere, {'-'.join(ends)}: places",
        measured=np.abs(rods.position[0] - exact).max(), bound=1e-13, reference="R(t)(cos, sin, 0) from the clamp on",
    )  # fmt: skip


@pytest.mark.parametrize(("turn", "bound"), [(0.0, 1e-9), (1.5, 3e-6)], ids=["straight", "curved"])
def test_a_clamped_filament_is_carried_by_a_plane_that_tilts(turn, bound, device, verified):
    """As a rigid body, about an axis in the plane; V' by differences along a curved filament costs Δs² Δt."""
    parameters = {"w": "0.7*sin(2*t)"}
    plane = surfaces.make("expression", {"phi": "cos(w)*z - sin(w)*x", "box": [[-3, 3]] * 3, "parameters": parameters})
    rods = clamped(
        plane, [0.5, 0.2, 0], [0.6, 0.8, 0], 17, geodesic_curvature=turn, intrinsic=(0, 0, turn), device=device
    )
    start, w = rods.position[0], 0.7 * np.sin(2.4)
    rods.step(6e-3, 200)
    turned = start @ np.array([[np.cos(w), 0, np.sin(w)], [0, 1, 0], [-np.sin(w), 0, np.cos(w)]])
    name = f"clamped filament, Ω = {turn}, on a plane that tilts"
    verified.below(
        "exact", f"{name}: places, N = 16, Δt = 6e-3", measured=np.abs(rods.position[0] - turned).max(), bound=bound,
        reference="a rigid body",
    )  # fmt: skip
    verified.below(
        "exact", f"{name}: strains", measured=np.abs(rods.strain[0] - [0, 0, turn]).max(), bound=1e-11,
        reference="those of the start",
    )  # fmt: skip


def test_a_clamp_on_a_rising_plane_keeps_its_strains_and_place(device, verified):
    rising = surfaces.make("expression", {"phi": "z - h", "box": [[-2, 2]] * 3, "parameters": {"h": "0.3*sin(2*t)"}})
    lines = []
    for surface in (rising, surfaces.make("plane", {})):
        rods = clamped(surface, [0, 0, 0], [1, 0.3, 0], geodesic_curvature=3 * np.cos(np.pi * arc(33)) ** 2)
        rods.step(1e-3, 200)
        lines.append(rods.position[0])
    lines[0][:, 2] -= 0.3 * np.sin(0.4)
    verified.below(
        "symmetry", "clamped filament on a rising plane against one at rest: places",
        measured=np.abs(lines[0] - lines[1]).max(), bound=1e-12, reference="the same, moved by h(t)",
    )  # fmt: skip


def test_a_clamp_does_not_spin_about_the_normal_of_a_cylinder_that_swells(device, verified):
    """Its tangent keeps its angle to the hoop, where a line of the membrane would turn: tan α ∝ 1/R."""
    cylinder = surfaces.make("cylinder", {"radius": "0.5 + 0.5*t", "length": 10.0})
    angles = []
    for nodes in (17, 33):
        rods = clamped(cylinder, [0.5, 0, 0], [0, 1, 1], nodes, length=0.6, device=device)
        rods.step(1e-3, 500)
        q, r = rods.rotation[0, 0, :, 0], rods.position[0, 0]
        angles.append(np.arctan2(q[2], q[1]))
        np.testing.assert_allclose(r, [0.75, 0, 0], rtol=0, atol=1e-12)
    verified(
        "exact", "clamp on a cylinder that swells: angle to the hoop", measured=angles, expected=np.pi / 4,
        within=1e-12, reference="ω[2] = 0",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("clamped", "free"), ("free", "clamped")], ids="-".join)
def test_the_energy_balance_with_a_clamp_on_a_breathing_torus(ends, verified):
    """From N = 32 on the defect is 2e-4 and 8e-4 of the dissipation, and falls fourfold or faster."""
    residuals = []
    for nodes in (33, 65):
        turn = 0.3 + 2 * np.cos(np.pi * arc(nodes)) ** 4 * np.sin(5 * arc(nodes) + 1)
        rods = BoundRods(
            breathing(0.2, 5.0), [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=nodes, ends=ends,
            geodesic_curvature=turn, **PARAMETERS,
        )  # fmt: skip
        rods.step(2.5e-4, 200)
        residuals.append(energy_defect(rods, 2e-5))
    verified.below(
        "conservation", f"filament {'-'.join(ends)} on a breathing torus: |dE/dt + D − power|/D, N = 64",
        measured=residuals[1], bound=min(3e-4, residuals[0] / 3.5), reference="0, and a quarter of that with N = 32",
    )  # fmt: skip


def test_a_clamp_follows_the_normal_of_an_ellipsoid_that_changes_its_form(device, verified):
    """dX/dt = V n, dq/dt = −(q·dn/dt) n: the tangent turns with n, and not about it."""
    axes, rates = np.array([1.0, 0.8, 1.2]), np.array([0.4, -0.2, 0.3])

    def velocity(t, y):
        x, q, axis = y[:3], y[3:], axes + rates * t
        g, H = 2 * x / axis**2, 2 / axis**2
        size, n = np.linalg.norm(g), g / np.linalg.norm(g)
        v = 2 * np.sum(x**2 * rates / axis**3) / size * n
        change = H * v - 4 * x * rates / axis**3
        return np.concatenate([v, -(q @ (change - n * (n @ change)) / size) * n])

    ellipsoid = surfaces.make("ellipsoid", {"radii": [f"{a} + {r}*t" for a, r in zip(axes, rates, strict=True)]})
    errors = []
    for step in (2e-2, 1e-2, 5e-3):
        rods = clamped(ellipsoid, [0.5, 0.5, 0.5], [1, 0.2, -0.5], 17, length=0.6, device=device)
        start = np.concatenate([rods.position[0, 0], rods.rotation[0, 0, :, 0]])
        rods.step(step, round(0.8 / step))
        exact = solve_ivp(velocity, (0, 0.8), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        errors.append(np.abs(np.concatenate([rods.position[0, 0], rods.rotation[0, 0, :, 0]]) - exact).max())
    name = "clamp on an ellipsoid that changes its form: place and tangent"
    verified.order(f"{name}, order in Δt", measured=slope(errors), reference="dX/dt = Vn by SciPy's DOP853")
    verified.below("exact", f"{name}, Δt = 5e-3", measured=errors[-1], bound=1e-5, reference="the same")


def test_both_ends_clamped_are_refused_on_a_moving_membrane():
    with pytest.raises(SceneError, match="cannot follow two points of a moving membrane that move apart: free one end"):
        BoundRods(breathing(), [[1.3, 0, 0.3]], [[0, 1, 0]], ends=("clamped", "clamped"))
