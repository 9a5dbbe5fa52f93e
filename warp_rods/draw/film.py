"""Films of a run, with clock, scale bar and colour bar: MP4 by ffmpeg, animated GIF."""

from __future__ import annotations

import contextlib
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from warp_rods.draw.content import Content
from warp_rods.draw.exporters import need_ffmpeg
from warp_rods.draw.poster import pictures

__all__ = ["draw_gif", "draw_mp4", "gif_size", "mp4_size"]

_MP4, _GIF = (1280, 720), (640, 400)
"""Pixels of a film."""
_QUALITY = 20
"""Constant rate factor of H.264: smaller is better and larger."""


def draw_mp4(shown: Content, path: Path, fps: float) -> None:
    """Write a film of all frames in H.264; SceneError: there is no ffmpeg; OSError, with its last words: it failed."""
    need_ffmpeg()
    with tempfile.TemporaryFile() as words:  # a pipe that nobody reads could fill
        failed = _filmed(
            _command(path, fps), (canvas.picture.tobytes() for canvas in pictures(shown, *_MP4, "MP4")), words
        )
        words.seek(0)
        said = [line.strip() for line in words.read().decode(errors="replace").splitlines() if line.strip()]
    if failed:
        raise OSError(f"ffmpeg ended with code {failed}: {said[-1] if said else 'it said nothing'}")


def _filmed(command: list[str], frames: Iterable[bytes], words: IO[bytes]) -> int:
    """Give pictures to ffmpeg, and return its exit code; it is killed where anything ends this."""
    # Without restore_signals it hears of a file that becomes too large, instead of being killed by it.
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=words, restore_signals=False
    ) as film:
        assert film.stdin is not None
        try:
            with contextlib.suppress(BrokenPipeError):  # it has ended, and its code says how
                for frame in frames:
                    film.stdin.write(frame)
                film.stdin.close()
            return film.wait()
        except BaseException:
            film.kill()
            with contextlib.suppress(OSError):
                film.stdin.close()
            raise


def _command(path: Path, fps: float) -> list[str]:
    """The command of ffmpeg that reads pictures from its standard input."""
    from imageio_ffmpeg import get_ffmpeg_exe

    pictures_in = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "{}x{}".format(*_MP4), "-r", f"{fps:.9g}", "-i", "-"]
    film_out = ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", str(_QUALITY), "-movflags", "+faststart"]
    quiet = ["-hide_banner", "-nostats", "-loglevel", "error"]
    return [get_ffmpeg_exe(), "-y", *quiet, *pictures_in, *film_out, "-f", "mp4", f"file:{path}"]


def draw_gif(shown: Content, path: Path, fps: float) -> None:
    """Write a film of all frames as an animated GIF that repeats; its clock counts hundredths of a second."""
    from PIL import Image

    frames = (canvas.image.quantize(256, Image.Quantize.FASTOCTREE) for canvas in pictures(shown, *_GIF, "GIF"))
    first = next(frames)
    hundredths = max(round(100 / fps), 2)  # viewers slow down what is faster
    first.save(path, format="GIF", save_all=True, append_images=frames, duration=10 * hundredths, loop=0)


def mp4_size(shown: Content, fps: float) -> float:
    """About how many bytes the film has."""
    return 5e4 + 6e3 * shown.frames


def gif_size(shown: Content, fps: float) -> float:
    """About how many bytes the GIF has."""
    return 3e4 * shown.frames
