"""What the Tab key offers on the command line: scenes, run folders, names of reproductions, benchmarks and plots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from warp_rods.simulation.files import STUDY, TRAJECTORY

__all__ = ["benchmarks", "plots", "plotted_folders", "reproductions", "run_folders", "scene_names", "scenes"]

Offered = Iterator[tuple[str, str]]


def scenes(incomplete: str) -> Offered:
    """Scene files, and names of shipped scenes with their titles."""
    yield from _files(incomplete, lambda path: path.suffix == ".toml")
    yield from scene_names(incomplete)


def scene_names(incomplete: str) -> Offered:
    """Names of shipped scenes, with their titles."""
    from warp_rods.scene.shipped import shipped

    for name, scene in shipped().items():
        if name.startswith(incomplete):
            yield name, scene.title


def run_folders(incomplete: str) -> Offered:
    """Folders of runs, and folders on the way to them."""
    yield from _folders_with(incomplete, TRAJECTORY)


def plotted_folders(incomplete: str) -> Offered:
    """Folders of runs and of studies, and folders on the way to them."""
    yield from _folders_with(incomplete, TRAJECTORY, STUDY)


def _folders_with(incomplete: str, *stores: str) -> Offered:
    def has_one(path: Path) -> bool:
        return any((path / store).exists() for store in stores)

    yield from _files(incomplete, has_one)
    if not incomplete:
        yield from _files("runs/", has_one)


def _files(incomplete: str, is_wanted) -> Offered:  # type: ignore[no-untyped-def]
    """Paths that begin so: those wanted, and folders to go into."""
    folder = Path(incomplete) if incomplete.endswith("/") else Path(incomplete).parent
    for path in sorted(folder.iterdir()) if folder.is_dir() else []:
        hidden = path.name.startswith(".") and not Path(incomplete).name.startswith(".")
        if str(path).startswith(incomplete) and not hidden:
            if is_wanted(path):
                yield str(path), ""
            elif path.is_dir():
                yield f"{path}/", ""


def reproductions(incomplete: str) -> Offered:
    """Names of reproductions, with what they show."""
    from warp_rods.reproductions.catalogue import REPRODUCTIONS

    return _named(incomplete, ((name, row.what) for name, row in REPRODUCTIONS.items()))


def benchmarks(incomplete: str) -> Offered:
    """Names of benchmarks, with what they measure."""
    from warp_rods.bench.catalogue import BENCHMARKS

    return _named(incomplete, ((name, row.what) for name, row in BENCHMARKS.items()))


def plots(incomplete: str) -> Offered:
    """Names of plots."""
    from warp_rods.draw.measured import PLOTS
    from warp_rods.draw.views import VIEWS

    return _named(incomplete, [*((name, row.what) for name, row in VIEWS.items()), *((name, "") for name in PLOTS)])


def _named(incomplete: str, rows: Iterable[tuple[str, str]]) -> Offered:
    return ((name, what) for name, what in rows if name.startswith(incomplete))
