"""What a run says: each line goes to the log of the package, and is kept for the run and its trajectory."""

from __future__ import annotations

import logging

LOG = logging.getLogger("warp_rods")


class Report:
    """Lines of one run: ``messages`` holds all of them in order, warnings marked as such."""

    def __init__(self) -> None:
        self.messages: list[str] = []

    def note(self, line: str) -> None:
        """Something worth knowing."""
        self.messages.append(line)
        LOG.info(line)

    def warn(self, line: str) -> None:
        """Something that throws doubt on the answers, or a rod that was lost."""
        self.messages.append(f"warning: {line}")
        LOG.warning(line)
