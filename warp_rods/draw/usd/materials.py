"""Materials of a USD stage, and the colours of elastic energy."""

from __future__ import annotations

from typing import Any

import numpy as np

COLOUR_MAP = "viridis"
_MEMBRANE_COLOUR, _MEMBRANE_OPACITY = (0.62, 0.65, 0.70), 0.4


def energy_colours(density: np.ndarray, low: float, high: float) -> np.ndarray:
    """Linear RGB [..., 3] of energy densities [...] on a perceptually uniform colour map from ``low`` to ``high``."""
    from matplotlib import colormaps

    screen = colormaps[COLOUR_MAP](np.clip((density - low) / (high - low), 0.0, 1.0))[..., :3]
    # The colour map is tabulated in sRGB; displayColor is linear.
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4).astype(np.float32)


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
