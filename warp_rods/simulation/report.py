"""Messages of a run: each goes to the logger of the package, and is kept for the run and its trajectory."""

from __future__ import annotations

import logging

LOG = logging.getLogger("warp_rods")


class Report:
    """The messages of one run.

    ``messages`` holds all of them in order; warnings begin with "warning: ", and what ended the run with "error: ".
    """

    def __init__(self) -> None:
        self.messages: list[str] = []

    def note(self, line: str) -> None:
        """Information for the user."""
        self.messages.append(line)
        LOG.info(line)

    def keep(self, line: str) -> None:
        """What ended a run: it is raised as an error, too, and not logged here."""
        self.messages.append(f"error: {line}")

    def warn(self, line: str) -> None:
        """A warning: the results may be wrong, or a rod was frozen."""
        self.messages.append(f"warning: {line}")
        LOG.warning(line)
