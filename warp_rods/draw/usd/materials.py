"""Materials of a USD stage."""

from __future__ import annotations

from typing import Any

MEMBRANE_COLOUR, MEMBRANE_OPACITY = (0.62, 0.65, 0.70), 0.4


def add_translucent_material(stage: Any, name: str, opacity: float) -> Any:
    """A matt, translucent material that shows displayColor, and is grey where there is none."""
    from pxr import Sdf

    material, shader = _material(stage, f"/World/Looks/{name}", 0.7, MEMBRANE_COLOUR)
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    return material


def add_materials(stage: Any) -> tuple[Any, Any]:
    """A translucent material for the membrane, and an opaque one; both show displayColor."""
    membrane = add_translucent_material(stage, "Membrane", MEMBRANE_OPACITY)
    return membrane, _material(stage, "/World/Looks/Energy", 0.5, (0.5, 0.5, 0.5))[0]


def _material(stage: Any, path: str, roughness: float, fallback: tuple[float, float, float]) -> tuple[Any, Any]:
    """A material with the colours of displayColor, or ``fallback`` where a prim has none; and its shader."""
    from pxr import Gf, Sdf, UsdShade

    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    reader = UsdShade.Shader.Define(stage, f"{path}/DisplayColor")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(*fallback))
    colour = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(colour)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material, shader
