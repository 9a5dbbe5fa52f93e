"""The report of the verification as Markdown."""

import math
import os
import platform
import subprocess
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

KINDS = {
    "orders": ("Orders of accuracy", "Slopes of errors against steps or spacings, fitted over refinements."),
    "exact": ("Exact answers", "Closed forms, and roots of equations in closed form."),
    "conservation": ("Conservation laws and balances", "Energy, momentum, forces and moments."),
    "symmetry": ("Symmetries", "Rigid motions, mirror images, gauge, units, and the order of what is summed."),
    "published": (
        "Published numbers",
        "Numbers of the dissertation, to half a unit of the last digit printed, and its statements. Where ours\n"
        "differs, the row compares with an independent value, and the reference says what was printed.",
    ),
    "independent": ("Independent solvers", "The same equations in NumPy, SciPy or SymPy, or by another method."),
    "constraint": ("Exactness of constraints", "Lengths, frames and attachment, from the frames as they are kept."),
    "determinism": ("Determinism", "Numbers of values that differ: alone and in a batch, after a restart, in threads."),
}
"""Kind → heading, and what its checks are."""

INTRODUCTION = """\
# Verification

Numbers of warp_rods beside what they should be, by the equations of [model.md](model.md): whether these describe a
given experiment is another question, which nothing here answers. Each row is a comparison that a test makes: what is
compared, with what, how far the two may be apart, and the value found. `±` is two-sided. `≤` bounds an error, which is
zero or positive. Of several values compared at once the worst is shown, with their number. References in brackets are
equations of the dissertation; § refers to [model.md](model.md). The name of a check leads to its test.

The report is made by

    python -m pytest --validate

which runs exactly these tests, long ones included, and writes this file; `python -m pytest` runs the short ones with
all other tests. A test belongs to the verification if it uses the fixture `verified` (`tests/verification.py`). Numbers
of our own that only guard against changes (`tests/reproductions/regression.csv`) are not here.
"""


class Row(NamedTuple):
    """A comparison. ``expected`` is None where ``allowed`` bounds an error; ``count`` values were compared."""

    kind: str
    name: str
    reference: str
    measured: float
    expected: float | None
    allowed: float
    count: int
    passed: bool
    test: str

    @property
    def shown(self) -> str:
        """The value found."""
        several = f" (worst of {self.count})" if self.count > 1 else ""
        return _number(self.measured, self._digits) + several

    @property
    def tolerance(self) -> str:
        if self.expected is None:
            return f"≤ {_number(self.allowed)}"
        if self.allowed == 0:
            return f"{_number(self.expected)}, exactly"
        return f"{_number(self.expected, self._digits)} ± {_number(self.allowed, 2)}"

    @property
    def _digits(self) -> int:
        """Enough to show a difference as large as the tolerance."""
        if not self.expected or not self.allowed:
            return 4
        return min(15, max(4, 2 + math.ceil(math.log10(abs(self.expected) / self.allowed))))


def _number(value: float, digits: int = 4) -> str:
    return f"{value:.{digits}g}"


def written(rows: Iterable[Row], broken: Iterable[str], root: Path) -> str:
    """The report; ``broken``: tests that failed before they had a value."""
    rows, broken, today = list(rows), sorted(broken), datetime.now(UTC).date().isoformat()
    failed = [row for row in rows if not row.passed]
    parts = [INTRODUCTION, _made_with(root, today), _counts(rows, failed, broken)]
    if failed:
        parts.append("## Checks that failed\n\n" + _table(failed, today))
    if broken:
        parts.append(
            "## Tests that failed without a value\n\n" + "".join(f"- **failed**: `{test}`\n" for test in broken)
        )
    for kind, (heading, what) in KINDS.items():
        of_kind = sorted((row for row in rows if row.kind == kind), key=lambda row: (row.test.split("::")[0], row.name))
        if of_kind:
            parts.append(f"## {heading}\n\n{what}\n\n" + _table(of_kind, today))
    return "\n".join(parts)


def _made_with(root: Path, today: str) -> str:
    packages = ", ".join(f"{name} {version(package)}" for name, package in PACKAGES.items())
    machine = f"{platform.system()}, {platform.machine()}, {os.cpu_count()} cores"
    return f"Made on {today} at commit {_commit(root)}: Python {platform.python_version()}, {packages}; {machine}.\n"


PACKAGES = {"Warp": "warp-lang", "NumPy": "numpy", "SciPy": "scipy", "SymPy": "sympy"}


def _commit(root: Path) -> str:
    """The present commit, and whether files were changed since."""
    try:
        found = [
            subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=True).stdout.strip()
            for words in (("rev-parse", "--short", "HEAD"), ("status", "--porcelain", "--untracked-files=no"))
        ]
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"`{found[0]}`" + (" with changes" if found[1] else "")


def _counts(rows: list[Row], failed: list[Row], broken: list[str]) -> str:
    said = f"**{len(rows)} checks, " + (f"{len(failed)} failed.**" if failed else "none failed.**")
    if broken:
        said += f" **{len(broken)} tests failed without a value.**"
    lines = [said]
    lines += ["", "| kind | checks | failed |", "|---|---|---|"]
    for kind, (heading, _) in KINDS.items():
        of_kind = [row for row in rows if row.kind == kind]
        lines.append(f"| {heading} | {len(of_kind)} | {sum(not row.passed for row in of_kind)} |")
    return "\n".join(lines) + "\n"


def _table(rows: list[Row], today: str) -> str:
    lines = ["| check | reference | tolerance | measured | | date |", "|---|---|---|---|---|---|"]
    for row in rows:
        name = f"[{_cell(row.name)}](../{row.test.split('::')[0]})"
        result = "passed" if row.passed else "**failed**"
        cells = (name, _cell(row.reference), row.tolerance, row.shown, result, today)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
