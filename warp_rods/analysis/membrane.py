"""The membrane of a run, from the scene in its attributes."""

from __future__ import annotations

import tomllib

import xarray as xr

from warp_rods.errors import RunFolderError
from warp_rods.membranes.motion import is_moving
from warp_rods.membranes.surfaces import Surface, make
from warp_rods.scene.scene import Scene


def membrane_of(data: xr.DataTree | xr.Dataset) -> Surface:
    """The membrane of a run opened by ``open_run``, or of one group of it.

    Raises RunFolderError where the scene has no membrane, and ValueError where the data have no scene.
    """
    if "scene" not in data.attrs:
        raise ValueError("these data have no scene and hence no membrane: open the run with open_run, or give surface=")
    surface = Scene.parse(data.attrs["scene"]).surface
    if surface is None:
        raise RunFolderError("the scene of this run has no [surface]: there is no membrane")
    return make(surface.kind, surface.parameters)


def has_membrane(data: xr.Dataset) -> bool:
    """Whether the scene of the data has a membrane."""
    return "surface" in tomllib.loads(data.attrs.get("scene", ""))


def membrane_moves(data: xr.Dataset) -> bool:
    """Whether the membrane in the scene of the data moves."""
    table = tomllib.loads(data.attrs.get("scene", "")).get("surface", {})
    return is_moving({key: value for key, value in table.items() if key != "kind"})
