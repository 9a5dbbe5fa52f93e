"""The table of exporters: each makes one file, or one folder, of a run from its trajectory.

To add one, write a function ``(content, path, **options) -> None``, which writes what ``content`` (``draw/content.py``)
shows to ``path``, and give it a row of ``EXPORTERS``; options are rows of ``OPTIONS``. ``warp-rods export DIR`` takes
its flags and options from these tables. A function imports what it needs when it is called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_rods.errors import SceneError

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.selection import Selection

__all__ = ["EXPORTERS", "OPTIONS", "Exporter", "Option", "need_ffmpeg"]


@dataclass(frozen=True)
class Option:
    """An option of exporters: its type on the command line, its default, what it is, and for numbers their bounds."""

    kind: type
    default: Any
    what: str
    bounds: tuple[float, float] | None = None

    def checked(self, name: str, value: Any) -> Any:
        """The value; raises SceneError with what is allowed."""
        from warp_rods.arguments import wrong

        if self.bounds is None:
            return value
        low, high = self.bounds
        whole = self.kind is int
        number = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
        if not number or not low <= value <= high:
            raise wrong(name, value, f"a {'whole ' * whole}number from {low:g} to {high:g}")
        return value


OPTIONS: dict[str, Option] = {
    "fps": Option(float, 24.0, "frames of the trajectory shown in a second", (0.01, 1000.0)),
    "dpi": Option(int, 200, "dots per inch of pictures", (10, 1200)),
    "tubes": Option(bool, False, "rods as meshes, for viewers of USD that draw no curves"),
    "activity": Option(bool, False, "arrows of the flagellar activity in USD"),
    "limit": Option(
        float, 25.0, "largest size of a page in MB; frames are left out evenly to stay below", (0.001, 1000.0)
    ),
    "optics": Option(str, "", "file that describes the microscope; each export writes the one it used"),
}
"""By name; exporters name those that they take."""


@dataclass(frozen=True)
class Exporter:
    """What an exporter makes, the suffix of its file (none for a folder), and its function.

    ``function(content, path, **options)`` writes to ``path``, a temporary name that is then changed. ``size(content,
    **options)``: about how many bytes that will be. stem: the usual name without the suffix. options: names of
    ``OPTIONS``. also: other suffixes that the file may have. holds: a regular expression for the paths of what is in a
    folder: one that holds anything else is not replaced. forward: whether times must increase from frame to frame.
    """

    what: str
    suffix: str
    function: Callable[..., None]
    size: Callable[..., float]
    stem: str = "animation"
    options: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    holds: str = ""
    forward: bool = False

    @property
    def file_name(self) -> str:
        """The usual name of the file in the run folder."""
        return self.stem + self.suffix

    def export(
        self, run_dir: Path, path: Path | None = None, selection: Selection | None = None, **options: Any
    ) -> Path:
        """Write the file of a run; returns its path, by default that of its usual name in the run folder.

        options: of this exporter, others are left alone. Raises RunFolderError where there is no run, no complete
        frame, or where the file cannot be written; SceneError for a selection that does not fit the run, and for a path
        with another suffix, or where something would be lost that is not of an export of this kind.
        """
        from warp_rods.draw.content import content

        path = run_dir / self.file_name if path is None else path
        return self.write(content(run_dir, selection), path, **options)

    def write(self, content: Content, path: Path, **options: Any) -> Path:
        """Write what is shown to ``path``, under a temporary name until it is whole; returns the path.

        A file goes into a folder ``path`` under its usual name. Raises as ``export``.
        """
        from warp_rods.arguments import wrong
        from warp_rods.draw.places import file_place, folder_place, placed

        taken = self._taken(options)
        if self.forward and len(content.numbers) > 1 and content.numbers.step < 0:
            raise wrong("step of frames", content.numbers.step, "positive: times increase in such a file")
        if self.suffix:
            path = file_place(path, self.file_name, (self.suffix, *self.also))
        with placed(path if self.suffix else folder_place(path, self.holds)) as temporary:
            self.function(content, temporary, **taken)
        return path

    def estimate(self, content: Content, **options: Any) -> float:
        """About how many bytes the file will have."""
        return self.size(content, **self._taken(options))

    def _taken(self, options: dict[str, Any]) -> dict[str, Any]:
        """Its own options, each with a value; raises SceneError for one that is not allowed."""
        return {name: OPTIONS[name].checked(name, options.get(name, OPTIONS[name].default)) for name in self.options}


def need_ffmpeg() -> None:
    """Raises SceneError with what to install where films in MP4 cannot be made."""
    if find_spec("imageio_ffmpeg") is None:
        raise SceneError("a film in MP4 needs ffmpeg: pip install -e '.[film]'; or make a GIF, --gif")


def _of(module: str, name: str) -> Callable[..., Any]:
    """The function of this name in a module of this room, which is imported when it is called."""
    return lambda *given, **options: getattr(import_module(f"warp_rods.draw.{module}"), name)(*given, **options)


def _file(what: str, module: str, suffix: str, stem: str = "rods", holds: str = "") -> Exporter:
    """A row for a file of another program, whose module has ``write`` and ``size``."""
    write, size = _of(f"files.{module}", "write"), _of(f"files.{module}", "size")
    return Exporter(what, suffix, write, size, stem, holds=holds, forward=True)


def _usd_size(content: Content, fps: float, tubes: bool, activity: bool) -> float:
    from warp_rods.draw.usd.export import size

    return size(content, tubes, activity)


def _usdz_size(content: Content, fps: float, activity: bool) -> float:
    return _usd_size(content, fps, True, activity)


def _few(size: float) -> Callable[..., float]:
    """The size of a file that hardly depends on the run."""
    return lambda _content, **_options: size


_usd, _usdz = _of("usd.export", "write_usd"), _of("usd.export", "write_usdz")
_clips, _blender = _of("usd.clips", "write_clips"), _of("usd.blender", "write_script")
_poster = _of("poster", "draw_poster")
_pictures = _of("poster", "draw_stills"), _of("poster", "stills_size")
_mp4 = _of("film", "draw_mp4"), _of("film", "mp4_size")
_gif = _of("film", "draw_gif"), _of("film", "gif_size")
_microscope = _of("microscope.export", "write"), _of("microscope.export", "size")
_page = _of("page.export", "write"), _of("page.export", "size")
_STAGE = ("fps", "tubes", "activity")
EXPORTERS: dict[str, Exporter] = {
    "usd": Exporter(
        "animation for Blender, Omniverse and usdview", ".usdc", _usd, _usd_size, options=_STAGE, also=(".usd", ".usda")
    ),
    "usdz": Exporter("animation in one package, with tubes", ".usdz", _usdz, _usdz_size, options=("fps", "activity")),
    "clips": Exporter(
        "animation in parts, for long runs: a folder", "", _clips, _usd_size, "animation_clips", options=_STAGE,
        holds=r"animation\.usdc|parts(/(\d+\.usdc|manifest\.usda))?",
    ),
    "blender": Exporter(
        "script that opens animation.usdc in Blender, with its colours", ".py", _blender, _few(4e3), "blender"
    ),
    "poster": Exporter("first, middle and last frame side by side", ".png", _poster, _few(6e5), "poster"),
    "png": Exporter(
        "a folder with a picture of each frame", "", *_pictures, "pictures", ("dpi",), holds=r"frame_\d+\.png"
    ),
    "mp4": Exporter("film", ".mp4", *_mp4, "film", ("fps",)),
    "gif": Exporter("film for slides and pages", ".gif", *_gif, "film", ("fps",)),
    "html": Exporter("page that plays in any browser", ".html", *_page, options=("limit",), also=(".htm",)),
    "vtkhdf": _file(
        "folder of files with all variables for ParaView", "vtkhdf", "", "vtkhdf",
        holds=r"(rods_[^/]+|membrane|container|box)\.vtkhdf",
    ),
    "gsd": _file("beads and bonds for OVITO, MDAnalysis and freud", "gsd", ".gsd"),
    "simularium": _file("fibres for the Simularium viewer", "simularium", ".simularium"),
    "wcon": _file("midlines for trackers of worms", "wcon", ".wcon"),
    "csv": _file("table of all nodes", "csv", ".csv"),
    "microscope": Exporter(
        "folder of fluorescence images with masks (OME-TIFF)", "", *_microscope, "microscope", ("optics",),
        holds=r"(image|masks)\.ome\.tif|microscope\.toml", forward=True,
    ),
}  # fmt: skip
"""By the name of the option: ``usd`` is ``--usd``."""
