"""The camera and the lights of a USD stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.view import View, looking_along

_FILLED = 0.92  # largest fraction of the picture that the scene fills
_FOCAL_LENGTH, _APERTURE = 50.0, (36.0, 20.25)  # 16:9, in tenths of a unit as in USD; only ratios matter
# Name, intensity, and direction towards the light in axes of the camera: right, up, backwards.
_LIGHTS = (("Key", 2.2, (-0.7, 0.9, 0.8)), ("Fill", 0.7, (0.9, -0.2, 0.6)))


def add_camera_and_lights(stage: Any, view: View, points: np.ndarray, path: np.ndarray | None = None) -> None:
    """A camera that looks as ``view`` does and whose picture contains all ``points`` [n, 3], and the lights.

    path: where the centre is at each frame [frame, 3], if it moves; points are then relative to it.
    """
    from pxr import Gf, UsdGeom, UsdLux

    axes = view.axes
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
    place = centre + distance * axes[2]
    _place(camera, axes, place if path is None else path + place)

    for name, intensity, direction in _LIGHTS:
        light = UsdLux.DistantLight.Define(stage, f"/World/Lights/{name}")
        light.CreateIntensityAttr(intensity)
        light.CreateAngleAttr(3.0)
        light.CreateNormalizeAttr(True)  # otherwise the brightness would depend on the angle
        _place(light, looking_along(axes.T @ direction), np.zeros(3))
    UsdLux.DomeLight.Define(stage, "/World/Lights/Dome").CreateIntensityAttr(0.5)


def _place(prim: Any, axes: np.ndarray, position: np.ndarray) -> None:
    """Set where a prim is, [3] for all times or [frame, 3]."""
    from pxr import Gf, Usd

    transform, matrix = prim.AddTransformOp(), np.eye(4)
    matrix[:3, :3] = axes
    for frame, place in enumerate(np.atleast_2d(position)):
        matrix[3, :3] = place
        transform.Set(Gf.Matrix4d(matrix.tolist()), frame if position.ndim == 2 else Usd.TimeCode.Default())
