"""The camera and the lights of a USD stage."""

from __future__ import annotations

from typing import Any

import numpy as np

_FROM_CENTRE_TO_CAMERA = (1.0, -1.7, 0.7)
_FILLED = 0.92  # largest fraction of the picture that the scene fills
_FOCAL_LENGTH, _APERTURE = 50.0, (36.0, 20.25)  # 16:9, in tenths of a unit as in USD; only ratios matter
# Name, intensity, and direction towards the light in axes of the camera: right, up, backwards.
_LIGHTS = (("Key", 2.2, (-0.7, 0.9, 0.8)), ("Fill", 0.7, (0.9, -0.2, 0.6)))


def add_camera_and_lights(stage: Any, points: np.ndarray) -> None:
    """A camera whose picture contains all ``points`` [n, 3], and the lights."""
    from pxr import Gf, UsdGeom, UsdLux

    axes = _looking_along(_FROM_CENTRE_TO_CAMERA)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    across, towards = np.abs((points - centre) @ axes[:2].T), (points - centre) @ axes[2]
    slopes = _FILLED * np.array(_APERTURE) / (2 * _FOCAL_LENGTH)
    distance = float(np.max(towards[:, None] + across / slopes))

    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
    camera.CreateHorizontalApertureAttr(_APERTURE[0])
    camera.CreateVerticalApertureAttr(_APERTURE[1])
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01 * distance, 100 * distance))
    camera.CreateFocusDistanceAttr(distance)
    _place(camera, axes, centre + distance * axes[2])

    for name, intensity, direction in _LIGHTS:
        light = UsdLux.DistantLight.Define(stage, f"/World/Lights/{name}")
        light.CreateIntensityAttr(intensity)
        light.CreateAngleAttr(3.0)
        light.CreateNormalizeAttr(True)  # otherwise the brightness would depend on the angle
        _place(light, _looking_along(axes.T @ direction), np.zeros(3))
    UsdLux.DomeLight.Define(stage, "/World/Lights/Dome").CreateIntensityAttr(0.5)


def _looking_along(backward: Any) -> np.ndarray:
    """Rows: the right, up and backward axes of a camera or light that points opposite to ``backward``."""
    back = np.asarray(backward) / np.linalg.norm(backward)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def _place(prim: Any, axes: np.ndarray, position: np.ndarray) -> None:
    from pxr import Gf

    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = axes, position
    prim.AddTransformOp().Set(Gf.Matrix4d(matrix.tolist()))
