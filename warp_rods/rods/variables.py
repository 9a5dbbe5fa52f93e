"""The variables of a trajectory: names, shapes, units and source equations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from warp_rods.rods.status import Status


@dataclass(frozen=True)
class Variable:
    """One array of the store.

    ``dims`` are ``frame``, ``rod``, ``node`` or ``end`` (first, last), and a last dimension whose entries have names,
    ``components``: ``axis`` (x, y, z), ``strain_component`` or ``quaternion``. ``units`` are products of the scene's
    units of length, force and time. ``source`` is the equation, by its number in the dissertation. ``flags`` are values
    and their meanings.
    """

    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    source: str
    components: tuple[str, ...] = ()
    flags: tuple[tuple[int, str], ...] = ()

    @property
    def labels(self) -> dict[str, tuple[str, ...]]:
        """The labels of each dimension whose entries have names."""
        found = {"end": ENDS} if "end" in self.dims else {}
        return found | ({self.dims[-1]: self.components} if self.components else {})

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the array in the store, named as in the CF conventions."""
        found: dict[str, Any] = {"units": self.units, "long_name": self.long_name, "source": self.source}
        if self.flags:
            found["flag_values"] = [value for value, _ in self.flags]
            found["flag_meanings"] = " ".join(meaning for _, meaning in self.flags)
        return {key: value for key, value in found.items() if value}


AXES = ("x", "y", "z")
ENDS = ("first", "last")
FILAMENT_STRAINS = ("twist", "normal", "geodesic")
SWIMMER_STRAINS = ("twist", "bend1", "bend2")
STRETCHES = ("stretch", "shear1", "shear2")
_ROD = ("frame", "rod")
_NODE = ("frame", "rod", "node")
_VECTOR = ("frame", "rod", "node", "axis")
_END = ("frame", "rod", "end", "axis")
_STRAIN = ("frame", "rod", "node", "strain_component")
_QUATERNION = ("frame", "rod", "node", "quaternion")
TIME = Variable(("frame",), "float64", "time", "time", "")
STATIC = {
    "length": Variable(("rod",), "float64", "length", "length of the rod", ""),
    "bending_stiffness": Variable(("rod",), "float64", "1", "bending stiffness β⊥", "B⊥/f*L³"),
    "twist_stiffness": Variable(("rod",), "float64", "1", "twist stiffness β∥", "B∥/f*L³"),
    "bending_stiffness_along": Variable(("rod", "node"), "float64", "1", "bending stiffness β⊥", "B⊥/f*L³"),
    "twist_stiffness_along": Variable(("rod", "node"), "float64", "1", "twist stiffness β∥", "B∥/f*L³"),
    "drag_along": Variable(("rod",), "float64", "1", "drag along ζ∥", ""),
    "drag_along_along": Variable(("rod", "node"), "float64", "1", "drag along ζ∥", ""),
    "drag_ratio_along": Variable(("rod", "node"), "float64", "1", "drag ratio η", "ζ⊥/ζ∥"),
    "rotational_drag_along": Variable(("rod", "node"), "float64", "1", "rotational drag ηr", "ζr/ζ∥L²"),
    "rest_strain": Variable(
        ("rod", "node", "strain_component"), "float64", "1/length", "natural strain, at t = 0", "", SWIMMER_STRAINS
    ),
    "moment": Variable(("rod",), "float64", "1", "active moment M", "m = M f"),
    "drag_ratio": Variable(("rod",), "float64", "1", "drag ratio η", "ζ⊥/ζ∥"),
    "rotational_drag": Variable(("rod",), "float64", "1", "rotational drag ηr", "ζr/ζ∥L²"),
    "stiffness": Variable(
        ("rod", "strain_component"), "float64", "force*length^2", "stiffness B", "(5.28)", FILAMENT_STRAINS
    ),
    "stiffness_matrix": Variable(
        ("rod", "stiffness_entry"),
        "float64",
        "1",
        "stiffness K of ξ = (Ω, U)",
        "∂²e/∂ξ², docs/model.md §10",
        tuple(f"{row} {column}" for row in (*SWIMMER_STRAINS, *STRETCHES) for column in (*SWIMMER_STRAINS, *STRETCHES)),
    ),
    "natural_strain": Variable(
        ("rod", "node", "natural_component"),
        "float64",
        "1",
        "natural strain ξ0 = (Ω0, U0)",
        "docs/model.md §10",
        (*SWIMMER_STRAINS, *STRETCHES),
    ),
    "period": Variable(
        ("axis",), "float64", "length", "period of the box along each axis, inf where it is open", "", AXES
    ),
    "intrinsic": Variable(
        ("rod", "strain_component"), "float64", "1/length", "intrinsic strain σ", "(5.28)", FILAMENT_STRAINS
    ),
}
"""Arrays that a group may hold and that do not change with time."""


def static_variable(name: str, ndim: int) -> Variable:
    """A row of ``STATIC``, with nodes where the values [rod, node, …] change along the rods."""
    row = STATIC[name]
    return row if ndim == len(row.dims) else replace(row, dims=("rod", "node", *row.dims[1:]))


def along_in_time(name: str) -> Variable:
    """A row of ``STATIC`` as a variable of each frame, along the rods."""
    return replace(STATIC[name], dims=("frame", "rod", "node", *STATIC[name].dims[1:]))


ARC = Variable(("node",), "float64", "1", "arc length over rod length, from the middle", "")

_EVERY_ROD = {
    "position": Variable(_VECTOR, "float64", "length", "centre line", "∂s r = q0, (4.29)", AXES),
    "strain": Variable(_STRAIN, "float64", "1/length", "strain in the material frame", "∂s R = R Ω×, (4.30)"),
    "orientation": Variable(_QUATERNION, "float32", "1", "material frame as quaternion", "(4.30)", (*AXES, "w")),
    "tension": Variable(_NODE, "float32", "force", "tension", "(4.16)"),
    "energy_density": Variable(_NODE, "float32", "force", "elastic energy per length", "½ Σ B_i (Ω_i − σ_i)², (5.29)"),
    "energy": Variable(_ROD, "float64", "force*length", "elastic energy", "∫ of its density ds, (5.28)"),
    "dissipation": Variable(_ROD, "float64", "force*length/time", "power dissipated by drag", "∫ u·ζu + ζr ω0² ds"),
    "steric_energy": Variable(
        _ROD, "float64", "force*length", "steric energy; each rod of a pair has half", "½ Σ w_i w_j G, (5.27)"
    ),
    "power": Variable(
        _ROD, "float64", "force*length/time", "power of everything that does work on the rod", "dE/dt + D"
    ),
    "status": Variable(
        _ROD,
        "int32",
        "1",
        "status of the rod, 0 unless it was frozen",
        "",
        flags=tuple((one.value, one.name.lower()) for one in Status),
    ),
}

FILAMENT_VARIABLES: dict[str, Variable] = {
    **_EVERY_ROD,
    "strain": replace(_EVERY_ROD["strain"], components=FILAMENT_STRAINS),
    "tension": replace(
        _EVERY_ROD["tension"], long_name="tension: internal force along the tangent", source="q·Λ = λ of (D.28)"
    ),
    "stretch_force": Variable(
        _NODE,
        "float32",
        "force",
        "force that does work where a section slides along the membrane",
        "λ + K12 m1 − K11 m2, (D.58)",
    ),
    "length": Variable(_ROD, "float64", "length", "length of the rod", "L(t)"),
    "growth_power": Variable(_ROD, "float64", "force*length/time", "energy gained by growth, per time", "dL/dt e(tip)"),
    "membrane_power": Variable(
        _ROD, "float64", "force*length/time", "power of a moving membrane on the rod", "docs/moving_membranes.md"
    ),
    "gauss": Variable(_ROD, "float64", "1/length^2", "Gaussian curvature at the midpoint", "K11 K22 − K12²"),
    "load": Variable(
        _VECTOR, "float32", "force/length", "force on the membrane per length", "ν, χ of (5.31), (5.32)", AXES
    ),
    "load_moment": Variable(
        _NODE, "float32", "force", "moment on the membrane per length, about the tangent", "χ of (5.31), (D.33)"
    ),
    "end_load": Variable(
        _END, "float64", "force", "force of the end sections on the membrane", "∓(λ, λ2, λ3) of (D.30), (D.32)", AXES
    ),
    "end_moment": Variable(
        _END, "float64", "force*length", "moment of the end sections on the membrane", "∓m of (D.58)", AXES
    ),
    "constraint": Variable(_ROD, "float64", "length", "largest distance of a node to the membrane", "max |φ|/|∇φ|"),
    "orthogonality": Variable(_ROD, "float64", "1", "largest component of a tangent along the normal", "max |q·n|"),
    "arc_length": Variable(_ROD, "float64", "1", "largest relative error of the length of a segment", "|∂s r| = 1"),
}

SWIMMER_VARIABLES: dict[str, Variable] = {
    **_EVERY_ROD,
    "strain": replace(_EVERY_ROD["strain"], components=SWIMMER_STRAINS),
    "activity": Variable(_NODE, "float32", "1", "flagellar field f", "(4.12)"),
    "wall_energy": Variable(_ROD, "float64", "force*length", "energy in the walls of the box", "∫ ½ k (d + δ)² ds"),
    "power": replace(
        _EVERY_ROD["power"], long_name="power of flagella, external forces and flow", source="∫ f u0 + M f ω0 + f·u ds"
    ),
}


def variables_of_behaviours(names: Iterable[str]) -> dict[str, Variable]:
    """What is saved of rods with behaviours of these names; nothing of rods without."""
    row = Variable(
        ("frame", "rod", "behaviour"),
        "int32",
        "1",
        "events so far; a tumble has two",
        "docs/model.md §2.13",
        tuple(names),
    )
    return {"events": row} if row.components else {}


COSSERAT_VARIABLES: dict[str, Variable] = {
    **_EVERY_ROD,
    "position": replace(_EVERY_ROD["position"], source="∂s r = R U, (3.64)"),
    "strain": replace(_EVERY_ROD["strain"], components=SWIMMER_STRAINS),
    "stretch": Variable(
        ("frame", "rod", "node", "stretch_component"),
        "float64",
        "1",
        "stretch and shear U",
        "∂s r = R U, (3.64)",
        STRETCHES,
    ),
    "tension": replace(
        _EVERY_ROD["tension"], long_name="tension: internal force along the first director", source="(3.76)"
    ),
    "internal_moment": Variable(
        _STRAIN, "float64", "force*length", "internal moment m in the frame", "(3.75)", SWIMMER_STRAINS
    ),
    "internal_force": Variable(
        ("frame", "rod", "node", "stretch_component"),
        "float64",
        "force",
        "internal force n in the frame",
        "(3.76)",
        STRETCHES,
    ),
    "energy_density": replace(_EVERY_ROD["energy_density"], source="½ (ξ − ξ0)ᵀK(ξ − ξ0), ξ = (Ω, U)"),
    "dissipation": replace(_EVERY_ROD["dissipation"], source="∫ u·ζu + ηr ω0² ds"),
    "power": replace(_EVERY_ROD["power"], long_name="power of forces and couples", source="∫ f·u + l·ω ds"),
}
