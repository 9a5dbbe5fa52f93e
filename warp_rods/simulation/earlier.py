"""Trajectories of earlier versions: strains had the dimension ``axis`` of vectors, and no dimension had labels."""

from __future__ import annotations

import xarray as xr

from warp_rods.rods.variables import FILAMENT_VARIABLES, STATIC, SWIMMER_VARIABLES

RENAMED = {"bend": "bending_stiffness", "twist": "twist_stiffness"}
"""Earlier names of stiffnesses, and the present ones."""


def labelled(dataset: xr.Dataset) -> xr.Dataset:
    """A group with the names, dimensions and labels of the present version, still read lazily."""
    dataset = dataset.rename({old: new for old, new in RENAMED.items() if old in dataset})
    today = STATIC | (SWIMMER_VARIABLES if "activity" in dataset else FILAMENT_VARIABLES)
    vectors = {name: today[name] for name in map(str, dataset.data_vars) if name in today and today[name].components}
    strains = [name for name, variable in vectors.items() if "strain_component" in variable.dims]
    dataset = dataset.assign({name: dataset[name].rename(axis="strain_component") for name in strains})
    return dataset.assign_coords({dim: list(labels) for v in vectors.values() for dim, labels in v.labels.items()})
