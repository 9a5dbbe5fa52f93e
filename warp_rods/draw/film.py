"""Films of a run, with clock, scale bar and colour bar: MP4 by ffmpeg, animated GIF."""

from __future__ import annotations

from pathlib import Path

from warp_rods.draw.content import Content
from warp_rods.draw.exporters import need_ffmpeg
from warp_rods.draw.poster import pictures

__all__ = ["draw_gif", "draw_mp4", "gif_size", "mp4_size"]

_MP4, _GIF = (1280, 720), (640, 400)
"""Pixels of a film."""
_QUALITY = 20
"""Constant rate factor of H.264: smaller is better and larger."""


def draw_mp4(shown: Content, path: Path, fps: float) -> None:
    """Write a film of all frames in H.264; raises SceneError without ffmpeg."""
    need_ffmpeg()
    from imageio_ffmpeg import write_frames

    options = ["-crf", str(_QUALITY), "-movflags", "+faststart"]
    film = write_frames(
        str(path), _MP4, fps=fps, codec="libx264", macro_block_size=2, quality=None, output_params=options
    )
    film.send(None)
    try:
        for canvas in pictures(shown, *_MP4, "MP4"):
            film.send(canvas.picture.tobytes())
    finally:
        film.close()


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
