"""What one measures of rods: the table of measures, and ``measure`` to take several at once.

To add a measure, write a function of a dataset that returns a DataArray with units, long_name and source
(``measures.described``), and give it a row of ``MEASURES``.
"""

from __future__ import annotations

from collections.abc import Callable

import xarray as xr

from warp_rods.analysis import measures, motion_class

MEASURES: dict[str, Callable[..., xr.DataArray]] = {
    "mode_coefficients": measures.mode_coefficients,
    "twist_harmonics": measures.twist_harmonics,
    "total_twist": measures.total_twist,
    "writhe": measures.writhe,
    "speed": measures.speed,
    "instantaneous_speed": measures.instantaneous_speed,
    "energy_balance": measures.energy_balance,
    "bending_energy": measures.bending_energy,
    "twist_energy": measures.twist_energy,
    "arc_length": measures.arc_length,
    "orthonormality": measures.orthonormality,
    "period": motion_class.period,
    "shape_class": motion_class.shape_class,
}
"""By name: functions ``(dataset, **options)``; what the options are is said by each."""


def measure(dataset: xr.Dataset, *names: str) -> xr.Dataset:
    """The measures of these names, each with its default options, of one group of a trajectory.

    ``dataset``: ``open_run(run_dir)[group].to_dataset()``. Raises ValueError for an unknown name, and where
    the group lacks what a measure needs.
    """
    return measures.taken(MEASURES, dataset, names)
