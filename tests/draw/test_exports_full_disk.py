"""Exports whose file may not become as large as it is: one line that says so, and nothing is left."""

import subprocess
import sys

import pytest
from examples.drawn import write_run

from warp_rods.draw.exporters import EXPORTERS

pytest.importorskip("resource", reason="limits on files are those of Unix")

LIMITED = """
import resource, sys
from pathlib import Path
from warp_rods import cli
from warp_rods.draw.exporters import EXPORTERS
run, name, scratch = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
made = EXPORTERS[name].export(run, scratch / EXPORTERS[name].file_name)  # compiles kernels, too
largest = max(file.stat().st_size for file in (made.rglob("*") if made.is_dir() else [made]) if file.is_file())
resource.setrlimit(resource.RLIMIT_FSIZE, (largest // 2, resource.RLIM_INFINITY))
sys.argv = ["warp-rods", "export", str(run), "--" + name]
cli.main()
"""


@pytest.mark.parametrize("name", EXPORTERS)
def test_a_file_that_may_not_become_so_large_is_told_in_a_line(name, tmp_path):
    run = tmp_path / "run"
    write_run(run)
    (tmp_path / "scratch").mkdir()
    command = [sys.executable, "-c", LIMITED, str(run), name, str(tmp_path / "scratch")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2, (done.returncode, done.stderr)
    said = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert len(said) == 1 and "cannot be written" in said[0] and "Traceback" not in done.stderr
    assert [path.name for path in run.iterdir()] == ["trajectory.zarr"]
