"""The membrane of a run, from the scene that the run was made of."""

from __future__ import annotations

import tomllib

import xarray as xr

from warp_rods.errors import RunFolderError
from warp_rods.membranes.surfaces import Surface, make
from warp_rods.scene.scene import Scene


def membrane_of(data: xr.DataTree | xr.Dataset) -> Surface:
    """The membrane of a run opened by ``open_run``, or of one group of it.

    Raises RunFolderError where the scene has no membrane, and ValueError where the data have no scene.
    """
    if "scene" not in data.attrs:
        raise ValueError("these data do not name their membrane: open the run with open_run, or give surface=")
    surface = Scene.parse(data.attrs["scene"]).surface
    if surface is None:
        raise RunFolderError("The scene of this run has no [surface], so that there is no membrane to sense.")
    return make(surface.kind, surface.parameters)


def has_membrane(data: xr.Dataset) -> bool:
    """Whether ``membrane_of`` finds one."""
    return "surface" in tomllib.loads(data.attrs.get("scene", ""))
