"""Strains of free rods at the start, in the material frame, twist first."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.modes import beam_mode
from warp_rods.rods.per_rod import along, parameter
from warp_rods.scene.shapes import SHAPES as KINDS
from warp_rods.scene.shapes import kind_of

DEFAULT_FLAGELLA = Flagella()
PERTURBED = 6
"""Number of beam modes on which a shape is perturbed."""


def mode(s, amplitude, parameters, flagella, *, mode: int = 0):
    """A beam mode in a plane: κ = amplitude φ_mode."""
    mode, highest = arguments.whole("shape.mode", mode, 0), len(s) - 3
    if mode > highest:  # with fewer than two nodes in a wave it would look like a lower mode
        raise SceneError(f"shape.mode = {mode}: must be {highest} or less for {len(s)} nodes; use more nodes")
    return _strain(0.0, 0.0, amplitude * beam_mode(mode, s))


def writhe(s, amplitude, parameters, flagella, *, balanced: bool = True):
    """A coiled rod (C.63) to (C.65); its twist balances the active moment, or is ten times that, as printed."""
    balanced = arguments.truth("shape.balanced", balanced)
    twist = flagella.balancing_twist(s, parameters["moment"] / parameters["twist"], 1.0 if balanced else 10.0)
    bending = amplitude * beam_mode(0, s)
    turn = 2 * np.pi * s
    return _strain(twist, -bending * np.sin(turn), bending * np.cos(turn))


def straight(s, amplitude, parameters, flagella):
    """No strain."""
    return _strain(0.0, 0.0, 0.0 * amplitude * s)


def formula(s, amplitude, parameters, flagella, *, bend=0.0, bend1=0.0, bend2=0.0, twist=0.0, numbers=None):
    """Strains as formulas of s, or numbers, times the amplitude; ``bend`` is another name of ``bend2``."""
    if bend != 0.0 and bend2 != 0.0:
        raise SceneError("shape.bend and shape.bend2 both give bending in the plane of the modes: give one")
    given = {"twist": twist, "bend1": bend1, "bend2": bend if bend2 == 0.0 else bend2}
    return _strain(*(amplitude * along(f"shape.{name}", value, s, numbers) for name, value in given.items()))


SHAPES: dict[str, Callable[..., np.ndarray]] = {
    "mode": mode,
    "writhe": writhe,
    "straight": straight,
    "formula": formula,
}
"""Functions of s [node], amplitude [rod, 1], parameters {name: [rod, 1]}, ``Flagella`` and the keywords of the kind, by
``kind``: those of ``scene.shapes.SHAPES`` that need no file."""


def initial_strain(
    shape: Any,
    nodes: int,
    parameters: Mapping[str, np.ndarray],
    flagella: Flagella = DEFAULT_FLAGELLA,
    clamped: tuple[bool, bool] = (False, False),
    named: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Strain [rod, node, 3] from a table as in a scene, or from values that broadcast to that shape.

    parameters: {name: [rod] or [rod, node]}; flagella: what a twist may have to balance; clamped: which ends are, as
    strains of the others are set to 0; named: parameters of formulas [rod]. None is beam mode 0 of amplitude 1. Raises
    SceneError for an unknown kind or key, for values whose shape does not fit, and for values that are not finite.
    """
    rods = len(parameters["bend"])
    if shape is None:
        shape = {}
    values = _from_table(shape, nodes, parameters, flagella, named or {}) if isinstance(shape, Mapping) else shape
    expected = f"a table such as {{'kind': 'mode'}}, or strains {(rods, nodes, 3)} [rod, node, 3]"
    if np.ndim(values) == 0:
        raise arguments.wrong("shape", shape, expected)
    strain = arguments.fitted("shape", values, (rods, nodes, 3), expected)
    for node, is_clamped in ((0, clamped[0]), (-1, clamped[1])):
        if not is_clamped:
            strain[:, node] = 0.0
    return strain


def _from_table(
    table: Mapping[str, Any],
    nodes: int,
    parameters: Mapping[str, np.ndarray],
    flagella: Flagella,
    numbers: Mapping[str, np.ndarray],
) -> np.ndarray:
    """Strains of a table {kind, amplitude, perturbation, seed, …}."""
    rest = dict(table)
    kind = rest.pop("kind", None) or kind_of(rest, KINDS)
    if isinstance(kind, str) and kind in KINDS and KINDS[kind].own_rods:
        raise SceneError(
            f"shape.{kind}: is read by scenes; in Python give strains: those of wr.from_centreline(...), or of a frame "
            f"of wr.open_run(...)"
        )
    make = named(SHAPES, "shape.kind", kind)
    own = [name for name, p in inspect.signature(make).parameters.items() if p.kind is p.KEYWORD_ONLY]
    own = [name for name in own if name != "numbers"]
    rods, s = len(parameters["bend"]), np.linspace(-0.5, 0.5, nodes)
    amplitude = parameter("shape.amplitude", rest.pop("amplitude", 1.0), rods, "any finite number")
    size, seed = rest.pop("perturbation", 0.0), rest.pop("seed", 0)
    refuse_unknown(rest, [*own, "kind", "amplitude", "perturbation", "seed"], f"shape of kind {kind}")
    columns = {name: value if value.ndim == 2 else value[:, None] for name, value in parameters.items()}
    if make is formula:
        rest["numbers"] = numbers
    strain = make(s, amplitude[:, None], columns, flagella, **rest)
    return perturbed(strain, size, parameters["moment"], seed)


@dataclass(frozen=True)
class Parts:
    """Seeds of equal parts of the rods, each of which gets the numbers that it would get alone."""

    seeds: Sequence[Any]

    def normal(self, size: tuple[int, ...]) -> np.ndarray:
        """Standard normal numbers [rod, …]."""
        part = (size[0] // len(self.seeds), *size[1:])
        return np.concatenate([np.random.default_rng(seed).normal(size=part) for seed in self.seeds])


def perturbed(strain: np.ndarray, size: Any, moment: np.ndarray, seed: Any) -> np.ndarray:
    """The strain [rod, node, 3] with a random bending of the given size, in its plane where it is planar.

    moment: M [rod], with which no rod stays in a plane. Raises SceneError for a wrong size or seed.
    """
    size = parameter("shape.perturbation", size, len(moment), "zero or more")
    if not size.any():
        return strain
    s = np.linspace(-0.5, 0.5, strain.shape[-2])
    planar = (moment == 0) & ~np.asarray(strain[..., :2]).any(axis=(-1, -2))
    try:
        rng = seed if isinstance(seed, Parts) else np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise SceneError(f"shape.seed = {seed!r}: must be a whole number, 0 or more, or a list of them") from None
    return strain + perturbation(s, size, planar, rng)


def perturbation(s: np.ndarray, size: np.ndarray, planar: np.ndarray, rng: np.random.Generator | Parts) -> np.ndarray:
    """Random bending strains [rod, node, 3] on the first beam modes, of L² norm ``size`` [rod]; no twist.

    planar [rod]: rods that stay in the plane of Ω[2].
    """
    weights = rng.normal(size=(len(size), 2, PERTURBED))
    weights[planar, 0] = 0.0
    weights *= (size / np.linalg.norm(weights, axis=(1, 2)))[:, None, None]
    first, second = np.moveaxis(weights @ np.array([beam_mode(k, s) for k in range(PERTURBED)]), 1, 0)
    return _strain(0.0, first, second)


def from_midpoint(density: np.ndarray) -> np.ndarray:
    """Integral over s from the middle node of node values [rod, node], by the trapezoid rule; s from −1/2 to 1/2."""
    return from_node(density, density.shape[1] // 2)


def from_node(density: np.ndarray, node: int) -> np.ndarray:
    """``from_midpoint`` from another node."""
    cells = (density[:, 1:] + density[:, :-1]) / (2 * (density.shape[1] - 1))
    total = np.pad(np.cumsum(cells, axis=1), ((0, 0), (1, 0)))
    return total - total[:, [node]]


def _strain(twist, first, second) -> np.ndarray:
    return np.stack(np.broadcast_arrays(twist, first, second), axis=-1)
