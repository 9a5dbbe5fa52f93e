"""Surroundings of the command line that are not as usual: ASCII terminals, closed pipes, folders that are read-only."""

import os
import subprocess
import sys

import pytest

from warp_rods import terminal

SCENE = """
[[swimmers]]
name = "cell"
count = 1
nodes = 17
bend = 5e-3
twist = 1e-3
[time]
end = 0.02
save_every = 0.01
"""
COMMAND = [sys.executable, "-m", "warp_rods"]


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def run(scene, out, **environment) -> subprocess.CompletedProcess:
    command = [*COMMAND, "run", str(scene), "--out", str(out), "--device", "cpu"]
    return subprocess.run(command, capture_output=True, text=True, env=os.environ | environment, timeout=300)


@pytest.mark.parametrize(
    ("text", "spelled"),
    [
        ("Δt = 1 → 2 …", "dt = 1 -> 2 ..."),
        ("⟨𝒦⟩, φ ≤ ∇φ", "<K>, phi <= grad phi"),
        ("ζ∥ µm é ☃", "zeta_par um e ?"),
    ],
)
def test_characters_that_a_terminal_lacks_are_spelled_out(text, spelled):
    assert terminal.SPELLED and text.encode("ascii", "spelled").decode() == spelled
    assert text.encode("utf-8", "spelled").decode() == text


def test_a_run_on_an_ascii_terminal(scene, tmp_path):
    done = run(scene, tmp_path / "run", PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert "tolerance 0.01, 3 frames" in done.stdout and done.stdout.isascii()


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_run_goes_on_when_nobody_reads_any_more(scene, tmp_path, stream):
    """As with ``| head``: the pipe is closed before anything is written to it."""
    read, write = os.pipe()
    os.close(read)
    command = [*COMMAND, "run", str(scene), "--out", str(tmp_path / "run"), "--device", "cpu"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | {stream: write}
    done = subprocess.run(command, **pipes, timeout=300)
    os.close(write)
    assert done.returncode == 0 and b"Traceback" not in (done.stderr or b"")
    assert (tmp_path / "run" / "animation.usdc").is_file()


def test_a_kernel_cache_that_cannot_be_made_is_named(scene, tmp_path):
    (tmp_path / "file").touch()
    done = run(scene, tmp_path / "run", WARP_CACHE_PATH=str(tmp_path / "file" / "cache"))
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert "cache of compiled kernels cannot be written" in done.stderr and "Set WARP_CACHE_PATH" in done.stderr
    assert not (tmp_path / "run").exists()


@pytest.fixture
def read_only(tmp_path):
    """A folder that nobody can write to: a file system of its own for root, whom rights do not stop."""
    folder = tmp_path / "read_only"
    folder.mkdir()
    mounted = os.geteuid() == 0 and subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "none", folder]).returncode == 0
    if not mounted:
        folder.chmod(0o555)
    if os.access(folder, os.W_OK):
        pytest.skip("this user can write everywhere and may not mount a file system")
    yield folder
    if mounted:
        subprocess.run(["umount", folder], check=True)
    folder.chmod(0o755)


def test_a_read_only_cache_and_out_are_told_in_words(scene, tmp_path, read_only):
    done = run(scene, tmp_path / "run", WARP_CACHE_PATH=str(read_only))
    assert done.returncode == 2 and "Set WARP_CACHE_PATH" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "run").exists()
    done = run(scene, read_only / "deep" / "run")
    assert done.returncode == 2 and f"{read_only} cannot be written to: give another folder" in done.stderr
    assert "compiling" not in done.stdout + done.stderr
    done = subprocess.run([*COMMAND, "reproduce", "critical", "--out", read_only / "x"], capture_output=True, text=True)
    assert done.returncode == 2 and "cannot be written to" in done.stderr


def test_an_out_below_a_file_is_told_before_anything_is_compiled(scene, tmp_path):
    done = run(scene, scene / "run")
    assert done.returncode == 2 and f"{scene} is a file: give another folder" in done.stderr
    assert "rods placed" not in done.stdout
