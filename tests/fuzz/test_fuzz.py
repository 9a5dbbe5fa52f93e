"""Hostile input: each case runs, or is refused with exit code 2 and a key, in ten seconds and a gigabyte.

A case is its kind and its number: ``cd tests && python -c "from fuzz import scenes; print(scenes.text(17))"`` prints
one to be pasted. A case that fails is printed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from fuzz.worker import MAKE

TESTS = Path(__file__).parents[1]


class Case(NamedTuple):
    """What became of a case."""

    kind: str
    number: int
    outcome: str
    seconds: float
    what: str


def batch(kind: str, first: int, last: int, folder: Path, compiled: int = 0) -> list[Case]:
    """The cases of these numbers. A process that dies took its last case with it; another one goes on after that."""
    found: list[Case] = []
    folder.mkdir(parents=True, exist_ok=True)
    while first < last:
        command = [sys.executable, "-m", "fuzz.worker", kind, str(first), str(last), str(folder), str(compiled)]
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(command, cwd=TESTS, capture_output=True, text=True, env=os.environ | threads, check=False)
        lines: list[dict[str, Any]] = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        for begun, ended in zip(lines[::2], lines[1::2], strict=False):
            found.append(Case(kind, begun["number"], **ended))
        first += len(lines[1::2])
        if first < last:
            found.append(Case(kind, first, "died", 0.0, done.stderr[-3000:]))
            first += 1
    return found


def judge(cases: list[Case], folder: Path) -> None:
    """Print outcomes and the slowest; fail with the first few cases that crashed or died."""
    counts = Counter((case.kind, case.outcome) for case in cases)
    slowest = max(cases, key=lambda case: case.seconds)
    print(
        f"{len(cases)} cases:", *(f"{kind} {outcome} {n}" for (kind, outcome), n in sorted(counts.items())), sep="\n  "
    )
    print(f"slowest: {slowest.kind} {slowest.number}, {slowest.seconds:.1f} s")
    wrong = [case for case in cases if case.outcome in ("crashed", "died")]
    shown = [f"{c.kind} {c.number} {c.outcome}:\n{MAKE[c.kind](c.number, folder)}\n{c.what}" for c in wrong[:5]]
    assert not wrong, f"{len(wrong)} of {len(cases)}\n" + "\n\n".join(shown)


def test_hostile_input(tmp_path):
    numbers = {"scene": 100, "formula": 30, "mesh": 6, "stack": 10, "line": 30}
    cases = [case for kind, count in numbers.items() for case in batch(kind, 0, count, tmp_path / kind)]
    judge(cases, tmp_path)
    assert {case.outcome for case in cases} >= {"ran", "refused"}


@pytest.mark.long
def test_much_hostile_input(tmp_path):
    numbers = {"scene": 8000, "formula": 1200, "mesh": 300, "stack": 500, "line": 1500}
    parts = [
        (kind, first, min(first + 250, count), tmp_path / f"{kind}{first}")
        for kind, count in numbers.items()
        for first in range(0, count, 250)
    ]
    with ThreadPoolExecutor(2) as pool:
        cases = [case for part in pool.map(lambda part: batch(*part), parts) for case in part]
    judge(cases, tmp_path)


@pytest.mark.long
def test_hostile_formulas_that_are_compiled(tmp_path):
    judge(batch("formula", 0, 300, tmp_path, compiled=10), tmp_path)
