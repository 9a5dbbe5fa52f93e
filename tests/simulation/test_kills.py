"""Runs that are killed at any moment are resumed to the bits of runs that were never stopped."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def kill(folder: Path, count: int, *scenes: str) -> dict[str, int]:
    """Kills by kind of moment; all of them must have been survived."""
    command = [sys.executable, HERE / "killed.py", folder, count, 14, *scenes]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=3000)
    print(done.stdout)
    assert done.returncode == 0, done.stderr[-3000:]
    table = {line[:45].strip(): line[45:].split() for line in done.stdout.splitlines()}
    assert all(tried == survived for tried, survived in table.values()), done.stdout + done.stderr[-3000:]
    return {kind: int(tried) for kind, (tried, _) in table.items()}


KINDS = {
    "start, no store yet", "start, no store yet (replacing a run)", "before the first checkpoint", "step", "frame",
    "checkpoint", "scene.toml", "resume", "export",
}  # fmt: skip


def test_killed_runs_resume_to_the_same_bits(tmp_path):
    """Kills at the nth change of a file, half a write included, and at random times."""
    tried = kill(tmp_path, 12, "steps together")
    assert tried.keys() >= KINDS and tried["all"] == 12


@pytest.mark.long
def test_a_hundred_killed_runs_resume_to_the_same_bits(tmp_path):
    tried = kill(tmp_path, 130)
    assert tried.keys() >= KINDS and tried["all"] == 130 and min(tried.values()) >= 5
