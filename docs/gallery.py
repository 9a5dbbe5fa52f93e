"""Pictures of the gallery: runs scenes and keeps their posters, reduced in size, as docs/gallery/NAME.jpg.

    python docs/gallery.py                      all scenes, some minutes to an hour
    python docs/gallery.py proteins swimmer     only these
    python docs/gallery.py --until 0.1          only the first tenth of each run

Runs are kept in runs/gallery and go on where they were stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "gallery"
WIDTH, QUALITY = 1100, 75
"""Pixels, and the quality of JPEG, of a picture."""


def picture(scene: Path, runs: Path, until: float) -> Path:
    """Run a scene until this share of its time, and keep its poster. Raises SystemExit where there is none."""
    from PIL import Image

    import warp_rods as wr

    loaded = wr.Scene.load(scene)
    if until < 1:
        time = loaded.time.model_copy(update={"end": until * loaded.time.end})
        loaded = loaded.model_copy(update={"time": time})
    folder = runs / scene.stem
    wr.run(loaded, out=folder, resume=True)
    poster = folder / "poster.png"
    if not poster.exists():
        raise SystemExit(f"{poster} is missing: the run has left no poster")
    with Image.open(poster) as image:
        small = image.convert("RGB").resize(
            (WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS
        )
    PICTURES.mkdir(exist_ok=True)
    path = PICTURES / f"{scene.stem}.jpg"
    small.save(path, quality=QUALITY, optimize=True)
    return path


def main() -> None:
    known = {path.stem: path for path in sorted((ROOT / "scenes").glob("*.toml")) if not path.stem.startswith("study")}
    parser = argparse.ArgumentParser(description="Run scenes and keep their posters for the gallery.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="names of scenes; all without one")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs" / "gallery", help="folder of the runs")
    parser.add_argument("--until", type=float, default=1.0, help="share of the time of a scene that is simulated")
    given = parser.parse_args()
    if unknown := set(given.names) - set(known):
        parser.error(f"no such scene: {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    for name in given.names or known:
        print(picture(known[name], given.runs, given.until), flush=True)


if __name__ == "__main__":
    main()
