"""What simulators of cables read of the rods in a stage: how thick and how stiff they are, and their natural shape.

The names are those of the proposal for deformable bodies in USD, by which Newton imports curves as cables. A viewer
leaves them alone. All values are in the units of the scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.content import Content
from warp_rods.draw.rods import Rods
from warp_rods.draw.usd.curves import path_of
from warp_rods.frames.products import ALONG, path_product

__all__ = ["describe_cables"]


def describe_cables(stage: Any, shown: Content) -> None:
    """Mark the curves of a stage as cables that are, at the default time, where they are in the first frame."""
    from pxr import Sdf, UsdGeom, UsdShade, Vt

    for rods in shown.rods:
        prim = stage.GetPrimAtPath(path_of(rods.name))
        prim.AddAppliedSchema("PhysicsCurvesDeformableSimAPI")
        for attribute in ("points", "extent"):
            prim.GetAttribute(attribute).Set(prim.GetAttribute(attribute).Get(0))
        prim.CreateAttribute("physics:thicknesses", Sdf.ValueTypeNames.FloatArray).Set([2 * rods.radius])
        prim.CreateAttribute("physics:thicknesses:elementType", Sdf.ValueTypeNames.Token).Set(UsdGeom.Tokens.constant)
        natural = Vt.Vec3fArray.FromNumpy(_natural_shapes(rods).reshape(-1, 3).astype(np.float32))
        prim.CreateAttribute("physics:restShapePoints", Sdf.ValueTypeNames.Point3fArray).Set(natural)
        material = UsdShade.Material.Define(stage, f"/World/Looks/{prim.GetName()}Cable")
        material.GetPrim().AddAppliedSchema("PhysicsCurvesDeformableMaterialAPI")
        for name, value in _stiffness(rods.data).items():
            attribute = material.GetPrim().CreateAttribute(f"physics:curves{name}Stiffness", Sdf.ValueTypeNames.Float)
            attribute.Set(value)
        UsdShade.MaterialBindingAPI(prim).Bind(material, materialPurpose="physics")


def _natural_shapes(rods: Rods) -> np.ndarray:
    """Centre lines [rod, node, 3] of rods without moments and forces, each from the origin along x.

    That of a growing filament has its first length; natural strains that change with time are those at the beginning.
    """
    data, shape = rods.data, (rods.count, rods.nodes, 3)
    strain, stretch = np.zeros(shape), np.broadcast_to(ALONG, shape)
    if "natural_strain" in data:
        both = _at_nodes(data["natural_strain"], rods)
        strain, stretch = both[..., :3], both[..., 3:]
    for name in ("rest_strain", "intrinsic"):
        if name in data:
            strain = _at_nodes(data[name], rods)
    length = data["length"] if "length" in data else xr.DataArray(np.ones(rods.count), dims="rod")
    length = length.isel(frame=0) if "frame" in length.dims else length
    return np.asarray(path_product(strain, length.to_numpy() / (rods.nodes - 1), stretch)[1])


def _at_nodes(values: xr.DataArray, rods: Rods) -> np.ndarray:
    """Strains [rod, node, component] of a variable that need not have frames, nor nodes."""
    first = values.isel(frame=0) if "frame" in values.dims else values
    whole = first if "node" in first.dims else first.expand_dims(node=rods.nodes)
    return whole.transpose("rod", "node", ...).to_numpy()


def _stiffness(data: xr.Dataset) -> Mapping[str, float]:
    """The stiffnesses of cables, as far as all rods have the same, which is uniform and alike in both directions."""
    found: dict[str, np.ndarray] = {}
    if "bending_stiffness" in data:
        found = {"Bend": data["bending_stiffness"].to_numpy(), "Twist": data["twist_stiffness"].to_numpy()}
    elif "stiffness" in data and "node" not in data["stiffness"].dims:
        twist, out, along = data["stiffness"].transpose("strain_component", "rod").to_numpy()
        found = {"Twist": twist, "Bend": np.concatenate([out, along])}
    elif "stiffness_matrix" in data:
        K = data["stiffness_matrix"].transpose("rod", ...).to_numpy().reshape(-1, 6, 6)
        if not (K * (1 - np.eye(6))).any():
            twist, one, other, stretch, across, up = np.diagonal(K, axis1=1, axis2=2).T
            bend, shear = np.concatenate([one, other]), np.concatenate([across, up])
            found = {"Twist": twist, "Bend": bend, "Stretch": stretch, "Shear": shear}
    return {name: float(values[0]) for name, values in found.items() if values.ndim == 1 and np.ptp(values) == 0}
