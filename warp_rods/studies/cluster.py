"""Clusters of Dask: one of this machine's cores (or devices), or any other one, whose scheduler has an address."""

from __future__ import annotations

import contextlib
import multiprocessing
from collections.abc import Iterator
from typing import Any

from warp_rods.errors import SceneError

__all__ = ["INSTALL", "available", "connected", "end_if_a_worker", "require"]

INSTALL = "pip install 'warp-rods[studies]'"


def available() -> bool:
    """Whether Dask is installed."""
    from importlib.util import find_spec

    return find_spec("distributed") is not None


def require() -> None:
    """Raises SceneError where Dask is not installed."""
    if not available():
        raise SceneError(f"a cluster needs Dask, which is not installed: {INSTALL}; or use --part")


def end_if_a_worker() -> None:
    """End this process where it is a worker that imports the script which began the study, as that has no guard."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)


def _local(workers: int) -> Any:
    """A cluster of this machine's cores; raises SceneError where a script of the user cannot be imported for it."""
    from distributed import LocalCluster

    try:
        return LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
            silence_logs=50, memory_limit=0,
        )  # fmt: skip
    except RuntimeError as error:
        raise SceneError(
            f"sweep: the {workers} processes did not start ({error}); each imports the script that calls wr.sweep, "
            f'which must do so below the line: if __name__ == "__main__":'
        ) from None


@contextlib.contextmanager
def connected(scheduler: str | None, workers: int) -> Iterator[Any]:
    """A client of the scheduler at an address, or of a cluster of ``workers`` processes with one thread each here.

    Raises SceneError where there is no scheduler at the address.
    """
    require()
    import dask
    from distributed import Client

    with contextlib.ExitStack() as held:
        held.enter_context(dask.config.set({"distributed.admin.tick.limit": "1h"}))  # a step may take long
        if scheduler is None:
            scheduler = held.enter_context(_local(workers))
        try:
            client = held.enter_context(Client(scheduler, timeout="20s", set_as_default=False))
        except (OSError, ValueError) as error:
            raise SceneError(
                f"scheduler = {scheduler}: there is none ({error}); start one with `dask scheduler`, which prints it"
            ) from None
        yield client
