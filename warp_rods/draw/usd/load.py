"""What filaments do to their membrane, in a USD stage: the force per length as arrows.

An arrow is one linear curve, base – neck – neck – tip, whose widths make its head: it moves as the rods do,
in every reader that draws those. The arrows have the purpose "guide": hundreds of them would bury the rods;
usdview (Display › Display Purposes › Guide) and Blender (import with "Guide" ticked) show them when asked to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.usd.curves import linear_curves, sampled, set_points
from warp_rods.progress import with_progress

_SPACING = 8  # nodes from arrow to arrow, about; they double the file if there is one a node or two
_QUANTILE, _SHARE = 0.95, 0.08  # the arrow of this quantile of |load| is so long, in sizes of the membrane
_ALONG = np.array([0.0, 0.7, 0.7, 1.0])  # base, neck twice, tip
_WIDTHS = np.array([0.05, 0.05, 0.15, 0.0])  # there, in lengths of the arrow of that quantile
_COLOUR = (0.80, 0.10, 0.02)  # not a colour of the energies' map
_DOCUMENTATION = "force per length of the filaments on the membrane: −ν, −χ of (5.31), (5.32)"


def draw_loads(stage: Any, ensembles: dict[str, xr.Dataset], size: float, look: Any) -> None:
    """Arrows for each ensemble with a load that is not zero, on one scale for all of them and the whole run.

    The quantile 0.95 of |load| is drawn as 0.08 ``size``, the membrane's.
    """
    sizes = {name: _loads(data["load"]) for name, data in ensembles.items() if "load" in data}
    loaded = {name: load for name, load in sizes.items() if load.any()}
    if not loaded:
        return
    every = np.concatenate(list(loaded.values()))
    typical = float(np.quantile(every, _QUANTILE)) or float(every.max())
    for name in loaded:
        _draw_load(stage, name, ensembles[name], typical, _SHARE * size, look)


def _loads(load: xr.DataArray) -> np.ndarray:
    """|load| at all nodes, wherever it is finite, of some frames."""
    values = np.linalg.norm(sampled(load).values, axis=-1)
    return values[np.isfinite(values)]


def _arrow_nodes(nodes: int) -> np.ndarray:
    """Where a filament of so many nodes has arrows: both ends, and evenly between them."""
    return np.linspace(0, nodes - 1, max(3, (nodes - 1) // _SPACING + 1)).round().astype(int)


def _draw_load(stage: Any, name: str, data: xr.Dataset, typical: float, length: float, look: Any) -> None:
    """One ensemble's arrows, every frame; a load of ``typical`` is an arrow of ``length``."""
    from pxr import Gf, Tf, UsdGeom, Vt

    rods, nodes = data.sizes["rod"], _arrow_nodes(data.sizes["node"])
    path = f"/World/Loads/{Tf.MakeValidIdentifier(name)}_load"
    arrows = linear_curves(stage, path, np.full(rods * len(nodes), len(_ALONG)), look)
    arrows.CreatePurposeAttr(UsdGeom.Tokens.guide)
    arrows.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(*_COLOUR)])
    arrows.GetPrim().SetDocumentation(_DOCUMENTATION)
    arrows.GetPrim().SetCustomDataByKey("lengthPerLoad", length / typical)
    arrows.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    base, load = np.zeros((2, rods, len(nodes), 3))
    for frame in with_progress(range(data.sizes["frame"]), f"USD: load of {name}"):
        now = data.isel(frame=frame)
        position, force = now.position.values[:, nodes], now["load"].values[:, nodes]
        sound = np.isfinite(position + force).all(axis=(1, 2), keepdims=True)
        base, load = np.where(sound, position, base), np.where(sound, force, load)  # as the rods are drawn
        points = base[..., None, :] + _ALONG[:, None] * load[..., None, :] * (length / typical)
        set_points(arrows, frame, points.reshape(-1, 3), _WIDTHS.max() / 2 * length)
        # Arrows shorter than that of the typical load are thinner too, or they would be discs.
        thinner = np.minimum(np.linalg.norm(load, axis=-1, keepdims=True) / typical, 1.0)
        widths = (thinner * _WIDTHS * length).astype(np.float32)
        arrows.CreateWidthsAttr().Set(Vt.FloatArray.FromNumpy(widths.ravel()), frame)
