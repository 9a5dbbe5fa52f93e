"""What makes a USD stage look right when it opens: materials, a camera that sees everything, lights."""

from __future__ import annotations

from typing import Any

import numpy as np

COLOUR_MAP = "viridis"
_FROM_CENTRE_TO_CAMERA = (1.0, -1.7, 0.7)
_MARGIN = 0.92  # how much of the picture the scene may fill
_FOCAL_LENGTH, _APERTURE = 50.0, (36.0, 20.25)  # 16:9, in tenths of a unit as USD has it: only ratios matter
# Name, intensity, and where it shines from: right, up and backwards as the camera sees it.
_SUNS = (("Key", 2.2, (-0.7, 0.9, 0.8)), ("Fill", 0.7, (0.9, -0.2, 0.6)))
_MEMBRANE_COLOUR, _MEMBRANE_OPACITY = (0.62, 0.65, 0.70), 0.4


def energy_colours(density: np.ndarray, low: float, high: float) -> np.ndarray:
    """Linear RGB [..., 3] of energy densities [...] on a perceptually uniform map, ``low`` to ``high``."""
    from matplotlib import colormaps

    screen = colormaps[COLOUR_MAP](np.clip((density - low) / (high - low), 0.0, 1.0))[..., :3]
    # The map is tabulated as seen on a screen (sRGB); displayColor is linear light.
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4).astype(np.float32)


def add_glass(stage: Any, name: str, opacity: float) -> Any:
    """A soft material that lets through what is behind it."""
    from pxr import Gf, Sdf

    material, shader = _material(stage, f"/World/Looks/{name}", roughness=0.7)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*_MEMBRANE_COLOUR))
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    return material


def add_materials(stage: Any) -> tuple[Any, Any]:
    """A soft, half transparent material for the membrane, and one that shows displayColor."""
    from pxr import Gf, Sdf, UsdShade

    membrane = add_glass(stage, "Membrane", _MEMBRANE_OPACITY)
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


def add_camera_and_lights(stage: Any, points: np.ndarray) -> None:
    """A camera that has all ``points`` [n, 3] in its picture, and the lights."""
    from pxr import Gf, UsdGeom, UsdLux

    axes = _looking_along(_FROM_CENTRE_TO_CAMERA)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    across, towards = np.abs((points - centre) @ axes[:2].T), (points - centre) @ axes[2]
    slopes = _MARGIN * np.array(_APERTURE) / (2 * _FOCAL_LENGTH)
    distance = float(np.max(towards[:, None] + across / slopes))

    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
    camera.CreateHorizontalApertureAttr(_APERTURE[0])
    camera.CreateVerticalApertureAttr(_APERTURE[1])
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01 * distance, 100 * distance))
    camera.CreateFocusDistanceAttr(distance)
    _place(camera, axes, centre + distance * axes[2])

    for name, intensity, seen_from in _SUNS:
        sun = UsdLux.DistantLight.Define(stage, f"/World/Lights/{name}")
        sun.CreateIntensityAttr(intensity)
        sun.CreateAngleAttr(3.0)
        sun.CreateNormalizeAttr(True)  # or the light would shrink with the angle
        _place(sun, _looking_along(axes.T @ seen_from), np.zeros(3))
    UsdLux.DomeLight.Define(stage, "/World/Lights/Dome").CreateIntensityAttr(0.5)


def _looking_along(backward: Any) -> np.ndarray:
    """Rows: the right, up and backward axes of a camera or light that looks against ``backward``."""
    back = np.asarray(backward) / np.linalg.norm(backward)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def _place(prim: Any, axes: np.ndarray, position: np.ndarray) -> None:
    from pxr import Gf

    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = axes, position
    prim.AddTransformOp().Set(Gf.Matrix4d(matrix.tolist()))
