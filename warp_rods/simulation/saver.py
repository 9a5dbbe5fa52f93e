"""The hook that writes a run: frames, checkpoints, messages."""

from __future__ import annotations

import time

import numpy as np

from warp_rods.errors import WarpRodsError
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.output import chosen
from warp_rods.simulation.report import LOG, Report
from warp_rods.simulation.run_folder import RunFolder

__all__ = ["Saver", "stop_for_failures"]

CHECKPOINT_EVERY = 2.0
"""Seconds between checkpoints, at most one a frame."""


class Saver:
    """The hook that writes a run: a frame whenever one is reached, a checkpoint now and then."""

    def __init__(self, kept: RunFolder, report: Report):
        self._kept, self._report = kept, report
        self._checkpointed = -np.inf
        self._earlier = kept.writer.messages
        self._said = 0

    def __call__(self, simulation: Simulation) -> None:
        output, frame = simulation.scene.output, simulation.variables()
        saved = {name: chosen(output, simulation.ensembles[name].saved) for name in frame}
        self._kept.append(
            simulation.time, {name: {label: values[label] for label in saved[name]} for name, values in frame.items()}
        )
        stop_for_failures(simulation)
        if time.perf_counter() - self._checkpointed > CHECKPOINT_EVERY or simulation.finished:
            self._checkpointed = time.perf_counter()
            self._kept.checkpoint(simulation.state())
            self._kept.continues_from = simulation.time
        for line in simulation.new_failures():
            self._report.warn(f"lost: {line}")
        for line in simulation.new_warnings():
            self._report.warn(line)
        self.keep_messages()

    def keep_messages(self) -> None:
        """Write what the run has said to the trajectory's attributes, where there is more of it."""
        if len(self._report.messages) > self._said:
            self._said = len(self._report.messages)
            self._kept.describe(messages=[*self._earlier, *self._report.messages])

    def keep_last_messages(self, error: type[BaseException] | None, *_: object) -> None:
        """Write them at the end of a run, whose outcome does not depend on it; ``error`` has ended the run."""
        try:
            self.keep_messages()
        except WarpRodsError as fault:
            if error is None:
                LOG.warning(f"the last messages of the run are not in its trajectory: {fault}")


def stop_for_failures(simulation: Simulation) -> None:
    """End the run where a rod was lost and the scene says so."""
    if simulation.scene.on_failure == "stop" and simulation.frozen:
        simulation.stop(
            'a rod was lost, and on_failure = "stop"; to go on without it: on_failure = "continue", --resume'
        )
