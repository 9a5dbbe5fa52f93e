"""Materials of a USD stage."""

from __future__ import annotations

from typing import Any

_MEMBRANE_COLOUR, _MEMBRANE_OPACITY = (0.62, 0.65, 0.70), 0.4


def add_translucent_material(stage: Any, name: str, opacity: float) -> Any:
    """A matt, translucent material."""
    from pxr import Gf, Sdf

    material, shader = _material(stage, f"/World/Looks/{name}", roughness=0.7)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*_MEMBRANE_COLOUR))
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    return material


def add_materials(stage: Any) -> tuple[Any, Any]:
    """A translucent material for the membrane, and an opaque one that shows displayColor."""
    from pxr import Gf, Sdf, UsdShade

    membrane = add_translucent_material(stage, "Membrane", _MEMBRANE_OPACITY)
    energy, shader = _material(stage, "/World/Looks/Energy", roughness=0.5)
    reader = UsdShade.Shader.Define(stage, "/World/Looks/Energy/DisplayColor")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0.5))
    colour = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(colour)
    return membrane, energy


def _material(stage: Any, path: str, roughness: float) -> tuple[Any, Any]:
    from pxr import Sdf, UsdShade

    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material, shader
