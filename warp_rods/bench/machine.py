"""What figures depend on besides the code: the machine, versions of packages, the commit."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import warp_rods
from warp_rods.device import cores

VERSIONS = ("warp-rods", "warp-lang", "numpy", "scipy", "numba", "pyelastica")
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Variables that packages read when they are imported."""


def processor() -> str:
    """The name of the processor, as the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def commit_of(folder: Path) -> str:
    """The commit of a working tree, and whether it was changed since; "no commit" outside one."""

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        changed = ", changed" if git("status", "--porcelain", "--untracked-files=no") else ""
        return git("rev-parse", "--short", "HEAD") + changed
    except (OSError, subprocess.CalledProcessError):
        return "no commit"


def versions() -> str:
    """Versions of the packages that are installed."""
    found = [f"Python {platform.python_version()}"]
    for name in VERSIONS:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


def provenance(core_count: int) -> str:
    """One line for a section of the results; ``core_count``: of the machine, as far as this process may use it."""
    commit = commit_of(Path(warp_rods.__file__).parents[1])
    return f"{date.today()}, commit {commit}; {processor()}, {core_count} cores; {versions()}"


def use_one_core() -> None:
    """Restrict this process to one core, where the system can; threads of a step follow."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def use_cores(count: int) -> bool:
    """Let this process use so many cores; returns whether it can."""
    if not hasattr(os, "sched_setaffinity") or count > (os.cpu_count() or 1):
        return False
    os.sched_setaffinity(0, set(range(count)))
    return cores() == count
