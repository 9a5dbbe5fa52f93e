"""The code blocks of README.md and of the pages in docs/, and what of them is not run, with the reason."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LANGUAGES = {"python", "toml", "bash", "", "text"}
"""Of fenced blocks; those without a language are equations and what programs print."""

NOT_RUN = {
    r"python3 -m venv .*": "needs the network: .ci/run runs the line of the tests, and the other one installs less",
    r"pip install .*": "needs the network, and may run for twenty minutes: tests/bench has the reduced forms",
    r"warp-rods sweep .* (--scheduler|--part) .*": "needs a cluster: tests/studies/test_cluster.py starts one",
    r"python -m pytest --validate": "takes a quarter of an hour: it is run before a release",
}
"""Lines of a shell that are not run, as patterns of the whole line, with the reason."""

PYTHON_NOT_RUN = {
    "SLURMCluster": "needs a cluster with SLURM: tests/studies/test_cluster.py has workers started as processes",
    "runs/study_phase": "needs a study that takes minutes: tests/studies opens smaller ones in the same way",
}
"""What marks blocks in Python that are compiled and not run, with the reason."""

SHORTENED = {
    "proteins": (
        0.02,
        "a whole run takes a minute; tests/simulation/test_scenes.py has its end",
    ),
    "container": (0.06, "a whole run takes minutes"),
    "swarm_2d": (0.01, "a whole run takes minutes"),
}
"""Shipped scenes that end earlier where blocks run them: when, and the reason."""

OTHER_FILES = {"microscope.toml": "of warp-rods export --optics, which the next block runs"}
"""Files in TOML that are no scenes, and what reads them."""

RUNS_BEFORE = {
    "export.md": ("proteins",),
    "paraview.md": ("proteins",),
    "pictures.md": ("proteins", "swarm_2d", "container"),
    "README.md": ("proteins",),
    "analyse.md": ("proteins", "swarm_2d"),
    "loop.md": ("swimmer",),
}
"""Runs that a page has before its first block, since it says that they were made by hand."""


@dataclass(frozen=True)
class Block:
    """A block of code: language, text, and the number of its first line of text."""

    language: str
    text: str
    line: int


def blocks_of(page: Path) -> list[Block]:
    """The fenced blocks of a page, and lines of a shell that are indented by four spaces, in order."""
    found: list[Block] = []
    fence: tuple[str, int] | None = None
    inside: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").split("\n"), 1):
        if fence is None and line.startswith("```"):
            fence, inside = (line[3:].strip(), number + 1), []
        elif fence is not None and line == "```":
            found.append(Block(fence[0], "\n".join(inside), fence[1]))
            fence = None
        elif fence is not None:
            inside.append(line)
        elif re.match(r"    (python|pip|warp-rods|mkdocs)", line):
            found.append(Block("bash", line.strip(), number))
    assert fence is None, f"{page}: the block of line {fence[1]} has no end"
    return found


def reason_not_to_run(command: str) -> str | None:
    """Why a line of a shell is not run; None for one that is."""
    return next((why for pattern, why in NOT_RUN.items() if re.fullmatch(pattern, command)), None)
