"""How far apart the nodes of rods may be: the criteria, measured in docs/model.md §2.10 and §3.10.

Each gives the largest spacing of nodes at which the shape, the speed, the period and the place of a rod are right to
about one per cent, and the reason. ``resolution.py`` chooses numbers of nodes by them, and warns by them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warp_rods import arguments
from warp_rods.rods.along import Along, at_nodes
from warp_rods.rods.bound.along import Components, for_each_rod
from warp_rods.rods.bound.checks import RULES
from warp_rods.rods.free.natural import Natural
from warp_rods.rods.modes import beam_mode
from warp_rods.rods.per_rod import along, each_rod, named_numbers
from warp_rods.scene.along import AtNodes, given_along
from warp_rods.scene.components import numbers_of, rows_of
from warp_rods.scene.cosserat import CosseratTable
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.flagella import DEFAULT_LAW, LAWS, PROFILES
from warp_rods.scene.shapes import ShapeTable
from warp_rods.scene.swimmers import NaturalBend, SwimmersTable
from warp_rods.scene.tables import Steric
from warp_rods.simulation.samples import TIMES, Sample

BENDS, WAVES = 0.5, 0.18
"""Largest spacing for a swimmer that swims steadily, and for one that waves, in units of (β⊥/η)^(1/3)."""
WAVING, SOFTEST_STEADY = 3.2e-3, 4e-5
"""A swimmer may wave where β⊥/η is below this times the width of the reversal of f; the softest may wave at any width.
The U begins to wave at 2.3e-3 to 3.3e-3 (D from 1e-4 to 3e-3, η from 1.5 to 4)."""
REVERSAL = 1 / 3
"""Width of the reversal of f = −tanh(as) of held flagella in units of 1/a; as wide as √D is with diffusion."""
WOUND, UNWOUND = 0.5, 1.0
"""Largest spacing of a swimmer that starts with the twist that balances its moment, and of one that starts without, in
units of (β⊥/T)(β∥/β⊥)^(1/3), T the twist moment."""
LEAST_TWIST_RATIO = 0.1
"""β∥/β⊥ below which the growth of helices was not measured; that spacing is used there."""
UNBALANCED = 10.0
"""The twist moment of a writhe that is not balanced (C.63), in units of the balanced one."""
CELLS_PER_HALF_WAVE = 18
"""Cells for each half-wave of a beam mode at the start."""
MOST_CELLS = 1e6
"""Cells that are asked for by a formula, at most."""
BENT_START = 1.0
"""Bending in radians per cell of a swimmer at the start."""
FEWEST_CELLS = 16
"""Cells of a filament on a membrane, however flat."""
LARGEST_ANGLE = 0.25
"""Bending of a filament in radians per cell."""
SAMPLES = 257
"""Places along a rod at which values along it are looked at."""
LEAST_WAVE = 1e-6
"""Second derivatives along a rod below this part of the values, over its length, are regarded as round-off."""
VARIES = 0.1
"""Largest spacing of a filament in units of √(κ/κ''), the length over which the curvature of the membrane varies."""
ANGLES = 72
"""Orientations in the tangent plane at which the energy is evaluated."""
ROWS_AT_ONCE = 500
"""Filaments whose bounds of e'' are computed at once."""
TURNS = 1.0
"""Largest spacing of a filament in units of √(B3/e''), the length over which its ends turn in the membrane."""

ACROSS = 1.5
"""Largest spacing for contact in units of √(aε), the width along a rod of the force between rods that touch: with it,
and at most ε, the sum over nodes is within 1.5 % of the integral where centre lines are ε/2 apart or more."""


@dataclass(frozen=True)
class Criterion:
    """Something to resolve: the largest spacing of nodes that does, or the fewest cells of a rod; and why."""

    reason: str
    spacing: float = math.inf
    cells: int = 0


def criteria_of_swimmers(table: SwimmersTable, steric: Steric | None, bent: float = 0.0) -> list[Criterion]:
    """What the nodes of swimmers must resolve: bending under their thrust, twist, the start, and contact.

    bent: the largest curvature of a start that is from a file.
    """
    return [
        _buckling(table),
        *_twist(table),
        *_natural(table),
        *_start(table),
        *_bent_start(bent, BENT_START),
        *_contact(steric),
    ]


def criteria_of_filaments(
    table: FilamentsTable, samples: Sequence[Sample], steric: Steric | None, bent: float = 0.0, end: float = 0.0
) -> list[Criterion]:
    """What the nodes of filaments must resolve on a membrane, given by samples of it, until the time ``end``.

    bent: the largest geodesic curvature of a start that is from a file.
    """
    principal = np.concatenate([sample.principal for sample in samples])
    stiffness, intrinsic = (_components(table, name, end) for name in ("stiffness", "intrinsic"))
    few = Criterion(f"a filament has {FEWEST_CELLS} cells or more", cells=FEWEST_CELLS)
    found = [few, *_angles(table, principal, intrinsic), *_variation(samples), *_waves(stiffness, intrinsic)]
    found += [*_turning(principal, stiffness, intrinsic), *_bent_start(bent, LARGEST_ANGLE), *_contact(steric)]
    if table.growth is not None and table.growth.spacing is not None:
        found.append(Criterion("nodes are at most growth.spacing apart at the start", table.growth.spacing))
    return found


def criteria_of_cosserat(table: CosseratTable, steric: Steric | None) -> list[Criterion]:
    """What the nodes of Cosserat rods must resolve: the start, and contact; natural strains are exact."""
    few = Criterion(f"a rod has {FEWEST_CELLS} cells or more", cells=FEWEST_CELLS)
    waves = (table.shape.mode or 0) + 1.5
    reason = f"the start has {waves:g} half-waves: {CELLS_PER_HALF_WAVE} cells for each"
    of_start = [Criterion(reason, cells=math.ceil(CELLS_PER_HALF_WAVE * waves))] if table.shape.kind == "mode" else []
    return [few, *of_start, *_contact(steric)]


# --- swimmers ---------------------------------------------------------------------------------------------------------


def _buckling(table: SwimmersTable) -> Criterion:
    bend, drag = _along(table, "bend").min(axis=1), _along(table, "drag_ratio").max(axis=1)
    soft = bend / drag
    waves = (soft < np.maximum(SOFTEST_STEADY, WAVING * _reversal(table))) & (_imbalance(table) > 0)
    share = np.where(waves, WAVES, BENDS)
    rod = int(np.argmin(share * np.cbrt(soft)))
    largest = float(share[rod] * np.cbrt(soft[rod]))
    what = "may wave" if waves[rod] else "bends under its thrust"
    reason = f"a swimmer of β⊥ = {bend[rod]:.3g} {what}: Δs ≤ {share[rod]:g} (β⊥/η)^(1/3) = {largest:.3g}"
    return Criterion(reason, largest)


def _along(table: SwimmersTable, name: str) -> np.ndarray:
    """Values of a parameter [rod, sample] along the rods."""
    given = getattr(table, name)
    given = 1.0 if given is None else given
    count = len(given.nodes) if isinstance(given, AtNodes) else SAMPLES
    named = named_numbers(table.parameters, table.count)
    return at_nodes(Along(name, given_along(given), table.count, count, arguments.ANY, named=named).values, count)


def _natural(table: SwimmersTable) -> list[Criterion]:
    """Natural bending: its half waves, and the largest angle from node to node; at the start, if it changes in time."""
    given = table.natural_bend
    if given is None:
        return []
    pair = (given.second, given.third) if isinstance(given, NaturalBend) else (0.0, given)
    tables = [part for part in pair if isinstance(part, AtNodes)]
    count = len(tables[0].nodes) if tables else SAMPLES
    bend = {"second": given_along(pair[0]), "third": given_along(pair[1])}
    natural = Natural(bend, 0.0, table.count, count, named_numbers(table.parameters, table.count))
    largest = float(np.hypot(*np.moveaxis(natural.bending, -1, 0)).max())
    if not largest:
        return []
    signs = np.sign(natural.bending)
    half_waves = 1 + int((signs[:, 1:] * signs[:, :-1] < 0).sum(axis=1).max())
    return [
        Criterion(f"natural bending has {half_waves} half waves", cells=CELLS_PER_HALF_WAVE * half_waves),
        Criterion(f"natural bending is up to {largest:.3g}", LARGEST_ANGLE / largest),
    ]


def _reversal(table: SwimmersTable) -> np.ndarray:
    """The width of the layer in which the flagellar field changes sign, or [rod] widths."""
    flagella = table.flagella
    if LAWS[flagella.law or DEFAULT_LAW].diffuses:
        return np.sqrt(each_rod(flagella.diffusion, table.count))
    return np.array(REVERSAL / flagella.sharpness if flagella.profile == "tanh" else 0.0)


def _imbalance(table: SwimmersTable) -> float:
    """The largest |∫ (f − mean of f) ds| along the rod for the profile with f = ±1: 1/2 if it reverses, 0 if not."""
    f = np.sign(PROFILES[table.flagella.profile](np.linspace(-0.5, 0.5, 1001), table.flagella.sharpness))
    return float(np.abs(np.cumsum(f - f.mean())).max() / (len(f) - 1))


def _twist(table: SwimmersTable) -> list[Criterion]:
    """A twist moment T makes a straight rod coil into helices of wavenumber 3T/4β⊥ (docs/model.md §9)."""
    bend, twist = (_along(table, name).min(axis=1) for name in ("bend", "twist"))
    moment = each_rod(table.moment, table.count)
    writhes = table.shape.kind == "writhe"
    T = np.abs(moment) * _imbalance(table) * (UNBALANCED if writhes and not table.shape.balanced else 1.0)
    if not T.any():
        return []
    with np.errstate(divide="ignore"):
        spacing = (WOUND if writhes else UNWOUND) * bend / T * np.cbrt(np.maximum(twist / bend, LEAST_TWIST_RATIO))
    rod = int(np.argmin(spacing))
    largest = float(spacing[rod])
    values = f"β⊥ = {bend[rod]:.3g} and M = {moment[rod]:.3g}"
    reason = f"a swimmer of {values} coils under the twist moment T = {T[rod]:.3g} of its flagella: Δs ≤ {largest:.3g}"
    return [Criterion(reason, largest)]


def _start(table: SwimmersTable) -> list[Criterion]:
    shape = table.shape
    if shape.kind == "formula":
        return _formula_start(shape, named_numbers(table.parameters, table.count))
    if shape.kind == "straight" or shape.from_file:
        return []
    mode = shape.mode or 0
    waves = mode + 1.5
    found = [
        Criterion(
            f"the {waves:g} half-waves of the mode {mode} at the start have {CELLS_PER_HALF_WAVE} cells each",
            cells=math.ceil(CELLS_PER_HALF_WAVE * waves),
        )
    ]
    largest = float(np.abs(beam_mode(mode, np.linspace(-0.5, 0.5, 2001))).max())
    return [*found, *_bent_start(_amplitude(shape) * largest, BENT_START)]


def _formula_start(shape: ShapeTable, named: Mapping[str, np.ndarray]) -> list[Criterion]:
    """As of the mode whose slope is as steep against its size as that of the formulas."""
    s = np.linspace(-0.5, 0.5, 2001)
    given = {name: getattr(shape, name) for name in ("bend1", "bend2", "bend") if getattr(shape, name) is not None}
    parts = [along(f"shape.{name}", value, s, named) for name, value in given.items()] or [0.0 * s]
    k = np.stack(np.broadcast_arrays(*parts))  # [component, node], or [component, rod, node]
    size, slope = (float(np.linalg.norm(values, axis=0).max()) for values in (k, np.gradient(k, s, axis=-1)))
    if size == 0:
        return []
    waves = max(slope / (math.pi * size), 1.0)
    reason = f"the {waves:.3g} half-waves of the formulas at the start have {CELLS_PER_HALF_WAVE} cells each"
    cells = Criterion(reason, cells=math.ceil(min(CELLS_PER_HALF_WAVE * waves, MOST_CELLS)))
    return [cells, *_bent_start(_amplitude(shape) * size, BENT_START)]


def _amplitude(shape: ShapeTable) -> float:
    """The largest amplitude of a rod."""
    return float(np.max(np.abs(1.0 if shape.amplitude is None else shape.amplitude)))


def _bent_start(curvature: float, angle: float) -> list[Criterion]:
    if curvature <= 0:
        return []
    reason = f"the curvature at the start reaches {curvature:.3g}: it bends by {angle:g} radian a cell at most"
    return [Criterion(reason, angle / curvature)]


# --- filaments --------------------------------------------------------------------------------------------------------


def _components(table: FilamentsTable, name: str, end: float) -> np.ndarray:
    """Values of a parameter [rod, sample, component] along filaments, at several times; or [rod, 1, 3]."""
    given = getattr(table, name)
    if numbers_of(given):
        return each_rod(given, table.count, 3)[:, None]
    nodes = next((len(p) for row in rows_of(given) for p in row if isinstance(p, list)), SAMPLES)
    rows = for_each_rod(rows_of(given), table.count, named_numbers(table.parameters, table.count))
    found = Components(name, rows, table.count, nodes, RULES[name])
    times = np.linspace(0.0, end, TIMES) if found.varies else np.zeros(1)
    return np.concatenate([found.at(time, nodes) for time in times])


def _waves(*parameters: np.ndarray) -> list[Criterion]:
    """Stiffness and intrinsic strains that change along filaments [rod, sample, component]."""
    length = math.inf
    for values in parameters:
        if values.shape[1] < 3:
            continue
        size = np.abs(values).max(axis=(0, 1))
        bent = np.abs(np.diff(values, 2, axis=1)).max(axis=(0, 1)) * (values.shape[1] - 1) ** 2
        seen = bent > size * LEAST_WAVE
        length = min(length, float(np.sqrt(size[seen] / bent[seen]).min(initial=math.inf)))
    if math.isinf(length):
        return []
    reason = f"stiffness or intrinsic strains vary over {length:.3g} of the length: {VARIES:g} of it a cell at most"
    return [Criterion(reason, cells=math.ceil(1 / (VARIES * length)))]


def _angles(table: FilamentsTable, principal: np.ndarray, intrinsic: np.ndarray) -> list[Criterion]:
    """The membrane bends the filament, and its intrinsic strains do, and a start that is curved."""
    placed = table.placement
    start = 0.0 if placed is None or isinstance(placed, str) else _largest_geodesic(placed.geodesic_curvature)
    membrane, natural = float(np.abs(principal).max(initial=0.0)), float(np.abs(intrinsic).max())
    words = {"curvatures of the membrane": membrane, "intrinsic strains": natural, "curvatures at the start": start}
    what, largest = max(words.items(), key=lambda item: item[1])
    if largest == 0:
        return []
    reason = f"{what} reach {largest:.3g}: a filament bends by {LARGEST_ANGLE:g} radian a cell at most"
    return [Criterion(reason, LARGEST_ANGLE / largest)]


def _variation(samples: Sequence[Sample]) -> list[Criterion]:
    """A filament moves by the differences of its energy, which follow from the curvature along it."""
    varies = max(sample.variation for sample in samples)
    if varies == 0:
        return []
    length = 1 / math.sqrt(varies)
    largest = VARIES * length
    reason = f"curvatures of the membrane vary over a length √(κ/κ'') = {length:.3g}: Δs ≤ {VARIES:g} of it"
    return [Criterion(reason, largest)]


def _largest_geodesic(given: str | float | Sequence) -> float:
    """The largest absolute value of a formula of s, or of what has numbers."""
    if isinstance(given, str):
        given = along("placement.geodesic_curvature", given, np.linspace(-0.5, 0.5, 1001)).tolist()
    return _largest(given)


def _largest(values: float | Sequence) -> float:
    """The largest absolute value of a number, or of nested lists of numbers."""
    return abs(float(values)) if isinstance(values, (int, float)) else max(map(_largest, values), default=0.0)


def _turning(principal: np.ndarray, stiffness: np.ndarray, intrinsic: np.ndarray) -> list[Criterion]:
    """Normal bending and twist turn a filament in the membrane, with e'' per angle; B3 spreads this over √(B3/e'')."""
    rows = np.unique(_pairs(stiffness, intrinsic), axis=0)
    parts = np.array_split(rows, -(-len(rows) // ROWS_AT_ONCE))
    highest = np.concatenate([_bounds_of_turning(principal, part)[1].max(axis=1) / part[:, 2] for part in parts])
    shortest, found = math.inf, 0.0
    for index in np.argsort(-highest, kind="stable"):
        row = rows[index]
        if highest[index] * (1 + 1e-9) < shortest**-2:  # nor do those that follow come up to it
            break
        low, high = (bounds[0] for bounds in _bounds_of_turning(principal, row[None]))
        e2 = _orientation_stiffness(principal[high * (1 + 1e-9) >= low.max()], row[:3], row[3:])
        if e2 > 0 and (length := math.sqrt(row[2] / e2)) < shortest:
            shortest, found = length, e2
    if math.isinf(shortest):
        return []
    reason = (
        f"the ends of a filament turn in the membrane over a length √(B3/e'') = {shortest:.3g}, with the orientation "
        f"stiffness e'' = {found:.3g}"
    )
    return [Criterion(reason, TURNS * shortest)]


def _pairs(stiffness: np.ndarray, intrinsic: np.ndarray) -> np.ndarray:
    """Rows (B, σ) [row, 6]: those of each rod and sample, at all times if one of the two changes."""
    if stiffness.shape[:2] != intrinsic.shape[:2]:  # extremes in place of what belongs together
        extremes = [np.stack([v.min(axis=(0, 1)), v.max(axis=(0, 1))]) for v in (stiffness, intrinsic)]
        stiff = stiffness.reshape(-1, 3) if stiffness.shape[1] == 1 else extremes[0]
        rest = intrinsic.reshape(-1, 3) if intrinsic.shape[1] == 1 else extremes[1]
        return np.array([[*b, *s] for b in np.unique(stiff, axis=0) for s in np.unique(rest, axis=0)])
    return np.concatenate([stiffness, intrinsic], axis=-1).reshape(-1, 6)


def _bounds_of_turning(principal: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds [row, sample] of the largest e''(α) of filaments with (B, σ) [row, 6], by the amplitudes of its terms.

    e'' is 4h²(B1 − B2) cos 4α − 4h (B1σ1 sin 2α + B2(m + σ2) cos 2α), with the mean m and half the difference h of the
    principal curvatures. One of the angles is within half a step of the crest of the second term.
    """
    mean, half = principal.mean(axis=-1), (principal[:, 1] - principal[:, 0]) / 2
    B1, B2, _, twist, bend, _ = rows.T[:, :, None]
    first, second = 4 * half**2 * np.abs(B1 - B2), 4 * np.abs(half) * np.hypot(B1 * twist, B2 * (mean + bend))
    return second * math.cos(math.pi / ANGLES) - first, first + second


def _orientation_stiffness(principal: np.ndarray, stiffness: np.ndarray, intrinsic: np.ndarray) -> float:
    """The largest e''(α) at these principal curvatures and any angle α to the first of their directions; force.

    e = ½B1(K12 − σ1)² + ½B2(K11 + σ2)² is the energy per length of a short geodesic filament.
    """
    alpha = np.linspace(0, np.pi, ANGLES, endpoint=False)
    mean, half = principal.mean(axis=-1)[:, None], (principal[:, 1:] - principal[:, :1]) / 2
    cosine, sine = np.cos(2 * alpha), np.sin(2 * alpha)
    K11, K12 = mean + half * cosine, -half * sine
    twist = 4 * half**2 * cosine**2 + 4 * half * sine * (K12 - intrinsic[0])
    bend = 4 * half**2 * sine**2 - 4 * half * cosine * (K11 + intrinsic[1])
    return float((stiffness[0] * twist + stiffness[1] * bend).max(initial=0.0))


# --- both -------------------------------------------------------------------------------------------------------------


def _contact(steric: Steric | None) -> list[Criterion]:
    if steric is None or steric.strength == 0:
        return []
    across = ACROSS * math.sqrt(steric.range * steric.core)
    if across < steric.core:
        reason = f"contact acts over a length √(range · core): Δs ≤ {ACROSS:g} √(range · core) = {across:.3g}"
        return [Criterion(reason, across)]
    reason = f"rods may pass between nodes that are more than the steric core {steric.core:g} apart"
    return [Criterion(reason, steric.core)]
