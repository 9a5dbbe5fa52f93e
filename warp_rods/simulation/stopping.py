"""A run that is stopped before its end: its state is saved, and the user is told how to go on."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from warp_rods.simulation.interruption import Interrupted
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.report import Report
from warp_rods.simulation.run_folder import RunFolder
from warp_rods.simulation.storage import how_to_continue

__all__ = ["leave", "stopping"]


def leave(simulation: Simulation, kept: RunFolder) -> None:
    """Save the present state between two frames, so that a restart has the bits of a run that was never stopped."""
    if simulation.can_be_left:
        kept.checkpoint(simulation.state())
        kept.continues_from = simulation.now


@contextlib.contextmanager
def stopping(simulation: Simulation, kept: RunFolder, report: Report) -> Iterator[None]:
    """Adds to the messages of a run what has ended it, and from where it can be continued."""
    try:
        yield
    except (KeyboardInterrupt, Interrupted) as signal:
        by = ""
        if isinstance(signal, Interrupted):
            by, signal.told = f" by {signal.name}", True
        report.note(
            f"stopped at t = {simulation.now:g}{by}; {kept.path} is readable, --resume continues from "
            f"t = {kept.continues_from:g}: {how_to_continue(kept.path, str(simulation.device))}"
        )
        raise
    except Exception as error:
        report.keep(f"ended at t = {simulation.now:g} by {type(error).__name__}: {error}")
        raise
