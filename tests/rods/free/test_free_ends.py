"""Held, turned and loaded ends, natural shapes and graded rods against exact answers and linear theory."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk, ellipkinc

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods


def arc(nodes):
    return np.linspace(-0.5, 0.5, nodes)


def spectrum(nodes, ends, twist=None, **parameters):
    """Eigenvalues of the equations discretised in s, linearised about a straight rod with this twist [node].

    One rod for each node that has a bending of its own; those about a straight rod depend on it as complex numbers.
    """
    kinds = [end if isinstance(end, str) else end.get("kind", "free") for end in ends]
    own = range(0 if kinds[0] == "clamped" else 1, nodes if kinds[1] == "clamped" else nodes - 1)
    shape, size = np.zeros((len(own), nodes, 3)), 1e-6
    shape[np.arange(len(own)), own, 2] = size
    if twist is not None:
        shape[..., 0] = twist
    rods = FreeRods(len(own), nodes, shape=shape, ends=ends, **{"drag_ratio": 1.0, "twist": 1.0, **parameters})
    found = rods.rates()
    return np.linalg.eigvals(found["bending_rate"][:, own].T / np.diagonal(found["bending"][:, own]))


def threshold(low, high, spectrum_at):
    """The load between ``low`` and ``high`` at which the growth vanishes, by a straight line, and |Im| there."""
    leading = [max(spectrum_at(load), key=lambda value: value.real) for load in (low, high)]
    share = leading[0].real / (leading[0].real - leading[1].real)
    return low + share * (high - low), abs(leading[0].imag) + share * (abs(leading[1].imag) - abs(leading[0].imag))


def extrapolated(values):
    """Of second order, from spacings in the ratio 2; and the order that the last three values show."""
    coarse, middle, fine = np.array(values)
    return fine + (fine - middle) / 3, np.log2(abs((middle - coarse) / (fine - middle)))


NODES = (17, 33, 65)


def pushed_at_the_tip(nodes, load):
    return spectrum(nodes, ("clamped", {"thrust": -load}), bend=1.0, flagella=None)


def pushed_along(nodes, load):
    """Uniform flagella push towards the clamp at the last end."""
    push = {"profile": "uniform", "law": "held"}
    return load * spectrum(nodes, ("free", "clamped"), bend=1 / load, flagella=push)


FOLLOWERS = {
    "tip follower force": (pushed_at_the_tip, (37.2, 38.2), "F L²/b", (37.695, 0.02), (191.26, 0.1)),
    "follower force along a rod": (pushed_along, (75.6, 76.6), "f L³/b", (76.10, 0.03), (196.6, 0.1)),
}
"""Spectrum at a load, loads on both sides of the threshold, the load's name, load and ω there with tolerances."""


@pytest.mark.parametrize("name", FOLLOWERS)
def test_a_clamped_rod_under_a_follower_force_flutters(name, verified):
    spectrum_at, between, load_name, threshold_known, frequency_known = FOLLOWERS[name]
    at_threshold = [threshold(*between, lambda load, n=nodes: spectrum_at(n, load)) for nodes in NODES]
    found, orders = extrapolated(at_threshold)
    verified.order(f"{name}: threshold, in Δs", measured=orders[0], reference="spacings halved twice")
    quantities = (f"{load_name} at the threshold", "ω ζ⊥L⁴/b at the threshold")
    for quantity, measured, known in zip(quantities, found, (threshold_known, frequency_known), strict=True):
        verified(
            "exact", f"{name}: {quantity}", measured=measured, expected=known[0], within=known[1],
            reference="linear theory of the continuum",
        )  # fmt: skip


def test_a_turned_rod_whirls(verified):
    """The twist of a straight rod that is turned at its clamp is −ζr ω (L − s)/c."""
    drag = 1e-3

    def at(nodes):
        def leading(turning):
            ends = ({"kind": "clamped", "turning": turning / drag}, "free")
            twist = turning * (arc(nodes) - 0.5)
            return spectrum(nodes, ends, twist, bend=1.0, rotational_drag=drag, flagella=None)

        return threshold(8.5, 9.2, leading)

    (turning, _), orders = extrapolated([at(nodes) for nodes in NODES])
    verified.order("whirling: threshold, in Δs", measured=orders[0], reference="spacings halved twice")
    verified(
        "published", "clamped rod turned about its tangent: ω ζr L²/b at which it whirls", measured=turning,
        expected=8.9, within=0.1, reference="Wolgemuth, Powers and Goldstein 2000",
    )  # fmt: skip


def test_a_turned_straight_rod_takes_its_exact_twist():
    rods = FreeRods(
        2, 33, bend=1.0, twist=1e-2, flagella=None, shape={"kind": "straight"},
        ends=({"kind": "clamped", "turning": [50.0, -20.0]}, "free"),
    )  # fmt: skip
    rods.advance_to(3.0, 1e-4)
    expected = 3e-3 * np.array([[50.0], [-20.0]]) * (arc(33) - 0.5) / 1e-2
    np.testing.assert_allclose(rods.strain[..., 0], expected, rtol=0, atol=1e-6)


def cantilever(load):
    """Place of the tip of an elastica clamped along x with a dead force across it, F L²/b = ``load``, by quadrature."""
    from scipy.optimize import brentq

    def modulus_of(angle):  # k² = (1 + sin of the angle at the tip)/2
        return (1 + np.sin(angle)) / 2

    def length(angle):
        m = modulus_of(angle)
        return ellipk(m) - ellipkinc(np.arcsin(1 / np.sqrt(2 * m)), m)

    tip = brentq(lambda angle: length(angle) - np.sqrt(load), 1e-6, np.pi / 2 - 1e-9)
    x = np.sqrt(2 * np.sin(tip) / load)
    y = quad(lambda u: np.sin(tip - u * u) * 2 * u / np.sqrt(2 * load * (np.sin(tip) - np.sin(tip - u * u))),
             0, np.sqrt(tip), epsabs=1e-13)[0]  # fmt: skip
    return x, y


def test_elastica_under_a_force_at_its_end(verified):
    expected, errors = np.array(cantilever(3.0)), []
    for nodes in NODES:
        ends = ("clamped", {"force": [0.0, 0.0, 3.0]})
        rods = FreeRods(1, nodes, bend=1.0, twist=1.0, flagella=None, shape={"kind": "straight"}, ends=ends)
        rods.advance_to(4.0, 1e-3)
        tip = rods.position[0, -1] - rods.position[0, 0]
        errors.append(np.hypot(tip[0] - expected[0], tip[2] - expected[1]))
    order = np.polyfit(np.log(1 / (np.array(NODES) - 1.0)), np.log(errors), 1)[0]
    verified.order(
        "elastica with a dead force at its end: place of the tip, in Δs",
        measured=order,
        reference="spacings halved twice",
    )
    verified.below(
        "exact", "elastica, F L²/b = 3: distance of the tip, N = 65", measured=errors[-1], bound=2e-4,
        reference="elliptic integrals",
    )  # fmt: skip


def test_a_couple_bends_a_rod_to_an_arc():
    ends = ("clamped", {"couple": [0.0, 0.0, 2.0]})
    rods = FreeRods(1, 33, bend=1.0, twist=1.0, flagella=None, shape={"kind": "straight"}, ends=ends)
    rods.advance_to(4.0, 1e-3)
    np.testing.assert_allclose(np.abs(rods.strain[0, :, 1:]).max(axis=-1), 2.0, atol=1e-5)


def test_a_graded_rod_bends_as_a_beam(verified):
    """Small deflection of a rod with b = 1 + s under a force at its tip: y'' = F (1/2 − s)/b."""
    force, errors = 1e-4, []
    expected = quad(lambda s: force * (0.5 - s) ** 2 / (1 + s), -0.5, 0.5)[0]
    for nodes in NODES:
        ends = ("clamped", {"force": [0.0, force, 0.0]})
        rods = FreeRods(1, nodes, bend="1 + s", twist=1.0, flagella=None, shape={"kind": "straight"}, ends=ends)
        rods.advance_to(6.0, 1e-4)
        errors.append(abs(rods.position[0, -1, 1] - expected) / expected)
    order = np.polyfit(np.log(1 / (np.array(NODES) - 1.0)), np.log(errors), 1)[0]
    verified.order("graded beam: deflection, in Δs", measured=order, reference="spacings halved twice")
    verified.below("exact", "graded beam: deflection, N = 65", measured=errors[-1], bound=1e-3, reference="quadrature")


@pytest.mark.parametrize("ends", [None, ("clamped", "free")])
def test_natural_bend_and_twist_give_a_helix(ends, verified):
    options = {"bend": 1e-2, "twist": 1e-2, "natural_bend": 3.0, "natural_twist": 4.0, "flagella": None}
    rods = FreeRods(1, 33, **options, shape={"kind": "straight"}, ends=ends)
    rods.advance_to(40.0 if ends is None else 300.0, 1e-2)
    verified.below(
        "exact", f"natural helix, ends {ends}: strain at rest", measured=abs(rods.strain - [4.0, 0.0, 3.0]),
        bound=2e-3, reference="the natural strain",
    )  # fmt: skip
    assert rods.energy[0] < 1e-8


def test_ends_stay_where_they_are_held(verified):
    worst = []
    for ends in (("clamped", "hinged"), ("hinged", "hinged"), ("clamped", "clamped")):
        rods = FreeRods(1, 33, bend=1.0, twist=1.0, flagella=None, shape={"kind": "mode", "amplitude": 2.0}, ends=ends)
        before = rods.position[0, [0, -1]]
        rods.advance_to(0.02, 1e-2)
        worst.append(abs(rods.position[0, [0, -1]] - before).max())
        assert rods.status[0] == 0
    verified.below("exact", "two held ends: distance from their places", measured=worst, bound=1e-5, reference="0")


def test_a_moved_clamp_follows_its_motion(verified):
    motion = {"kind": "clamped", "motion": ["0.1*sin(2*t)", 0, "0.2*t"], "rotation": [0, "0.5*sin(3*t)", 0]}
    rods = FreeRods(1, 33, bend=1e-2, twist=1e-2, flagella=None, shape={"kind": "straight"}, ends=(motion, "free"))
    before = rods.position[0, 0]
    rods.advance_to(1.0, 1e-2)
    found = [*(rods.position[0, 0] - before), 2 * np.arcsin(rods.orientation[0, 0, 1])]
    expected = [0.1 * np.sin(2.0), 0.0, 0.2, 0.5 * np.sin(3.0)]
    verified.below(
        "exact", "moved clamp: place and angle", measured=abs(np.array(found) - expected), bound=1e-4,
        reference="its motion",
    )  # fmt: skip


def test_a_travelling_natural_bend_swims(verified):
    """A long flagellum of small amplitude: RFT of an infinite wave θ = θ₀ sin(qs − ωt), within its end effects."""
    from scipy.special import j0

    waves, angle = 4, 0.4
    q, omega = 2 * np.pi * waves, 2 * np.pi
    rods = FreeRods(
        1, 97, bend=2e-3, twist=2e-3, natural_bend=f"{angle * q}*cos({q}*s - {omega}*t)", flagella=None,
        shape={"kind": "straight"},
    )  # fmt: skip
    places = []
    for time in (1.0, 2.0):
        rods.advance_to(time, 1e-2)
        places.append(rods.position[0].mean(axis=0))
    moved = (places[1] - places[0]) / (omega / q)
    straight = 0.5 * (1 + j0(2 * angle))
    verified(
        "published", "flagellum, 4 waves: speed over wave speed", measured=moved[0],
        expected=-(1 - straight) / (2 - straight), within=0.005, reference="infinite planar wave, η = 2",
    )  # fmt: skip
    assert abs(moved[1]) < 0.01


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"ends": ("clamped",)}, "ends"),
        ({"ends": ("fixed", "free")}, "ends\\[0\\].kind = 'fixed'"),
        ({"ends": ({"kind": "clamped", "thrust": 1.0}, "free")}, "thrust"),
        ({"ends": ("free", {"force": [1.0, 2.0]})}, "ends\\[1\\].force"),
        ({"ends": ({"kind": "hinged", "motion": ["x", 0, 0]}, "free")}, "x is not known here"),
        ({"natural_bend": "sin(q*s)"}, "q is not known here"),
        ({"natural_bend": "1/s"}, "natural_bend: a formula has no finite value"),
        ({"bend": "s"}, "bend = -0.5: must be positive"),
        ({"bend": np.ones((2, 7))}, "bend: must be a number, .*; has shape \\(2, 7\\)"),
        ({"bend": ["1", "1", "1"]}, "bend: has 3 formulas; give one, or 2"),
        ({"ends": ("hinged", "free"), "symmetric": True}, "symmetric = true: the ends must be free"),
    ],
)
def test_mistakes_are_named(wrong, named):
    with pytest.raises(SceneError, match=named):
        FreeRods(2, 17, **{"bend": 1e-2, "twist": 1e-2, **wrong})


def test_a_rod_pulled_straight_between_two_hinges_is_told():
    rods = FreeRods(
        1, 17, bend=1e-2, twist=1e-2, flagella=None, shape={"kind": "straight"},
        ends=("hinged", {"kind": "hinged", "motion": ["0.2*t", 0, 0]}),
    )  # fmt: skip
    rods.advance_to(1.0)
    assert "cannot be stretched" in rods.failures()[0].what
