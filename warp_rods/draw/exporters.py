"""The table of exporters: each makes one file of a run from its trajectory.

To add one, write a function ``(run_dir, path) -> path`` and give it a row of ``EXPORTERS``. ``warp-rods export DIR``
takes its options from this table. A function imports what it needs when it is called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

__all__ = ["EXPORTERS", "Exporter"]


@dataclass(frozen=True)
class Exporter:
    """What an exporter makes, the suffix of its file, and its function; ``stem``: the usual name without the suffix.

    ``function(run_dir, path)`` writes the file to ``path`` and returns the path that it wrote. Raises RunFolderError
    where ``run_dir`` holds no run, or no complete frame.
    """

    what: str
    suffix: str
    function: Callable[[Path, Path], Path]
    stem: str = "animation"

    @property
    def file_name(self) -> str:
        """The usual name of the file in the run folder."""
        return self.stem + self.suffix

    def export(self, run_dir: Path) -> Path:
        """Write the file under its usual name into the run folder; returns its path."""
        return self.function(run_dir, run_dir / self.file_name)


def _usd(run_dir: Path, path: Path) -> Path:
    from warp_rods.draw.usd.export import export_usd

    return export_usd(run_dir, path)


EXPORTERS: dict[str, Exporter] = {
    "usd": Exporter("animation for Blender, Omniverse and usdview", ".usdc", _usd),
}
"""By the name of the option: ``usd`` is ``--usd``."""
