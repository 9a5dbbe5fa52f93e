"""The command line: exit codes, messages without traceback, no incomplete files."""

import subprocess
import sys
from pathlib import Path

import pytest

SCENES = Path(__file__).parent.parent / "scenes"
SMALL = """
seed = 1
[surface]
kind = "sphere"
radius = 1.0
[[filaments]]
name = "one"
count = 2
nodes = 17
length = 1.0
stiffness = [1.0, 1.0, 1.0]
intrinsic = [0.0, 1.0, 0.0]
drag = [1.0, 2.0, 0.1]
[time]
end = 0.02
step = 0.002
save_every = 0.01
"""


def warp_rods(*arguments, cwd) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "warp_rods", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=300)


@pytest.fixture
def small(tmp_path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


def test_run_export_and_refusal_of_a_used_folder(small, tmp_path):
    done = warp_rods("run", small, "--device", "cpu", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "runs" / "small"
    assert "rod-steps/s" in done.stdout and "compil" in done.stdout
    animation = folder / "animation.usdc"
    animation.unlink()
    assert warp_rods("export", folder, "--usd", cwd=tmp_path).returncode == 0
    assert animation.is_file()
    checked = warp_rods("check", folder, cwd=tmp_path)
    assert checked.returncode == 0 and "3 complete frames of one" in checked.stdout and "no damage" in checked.stdout
    again = warp_rods("run", small, cwd=tmp_path)
    assert again.returncode == 2 and "--overwrite" in again.stderr and "Traceback" not in again.stderr


@pytest.mark.long
@pytest.mark.parametrize("command", [("check",), ("export", "--usd")])
def test_damage_ends_with_exit_code_2(small, tmp_path, command):
    assert warp_rods("run", small, "--device", "cpu", cwd=tmp_path).returncode == 0
    folder = tmp_path / "runs" / "small"
    file = folder / "trajectory.zarr" / "one" / "position" / "c.0.0.0.0"
    file.write_bytes(file.read_bytes()[:-10])
    done = warp_rods(command[0], folder, *command[1:], cwd=tmp_path)
    assert done.returncode == 2 and "frame 2 of one/position is damaged" in done.stderr
    assert "Traceback" not in done.stderr


def test_every_fault_of_a_scene_in_one_message(small, tmp_path):
    text = SMALL.replace("length = 1.0", "length = -1.0").replace("nodes = 17", "nodes = 5").replace("count", "cuont")
    small.write_text(text)
    done = warp_rods("run", small, "--out", tmp_path / "none", cwd=tmp_path)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    for part in ("filaments[0].length", "filaments[0].nodes", "filaments[0].cuont", "did you mean"):
        assert part in done.stderr
    assert not (tmp_path / "none").exists()


@pytest.mark.long
@pytest.mark.parametrize("command", ["run", "check"])
def test_a_surface_that_cannot_be_built_ends_with_exit_code_2(small, tmp_path, command):
    formula = 'kind = "expression"\nphi = "x**2 + y**2 + z**2 + 1"\nbox = [[-2, 2], [-2, 2], [-2, 2]]'
    small.write_text(SMALL.replace('kind = "sphere"\nradius = 1.0', formula))
    done = warp_rods(command, small, cwd=tmp_path)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert "error: surface.phi: φ is positive" in done.stderr
    assert {p.name for p in tmp_path.iterdir()} == {"small.toml"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "nowhere.toml"), "no such file"),
        (("run", "small.toml", "--device", "cuda:99"), "no such device"),
        (("run", "small.toml", "--resume", "--overwrite"), "give one of them"),
        (("export", ".", "--usd"), "no run in"),
    ],
)
def test_mistakes_end_with_exit_code_2(small, tmp_path, arguments, message):
    done = warp_rods(*arguments, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert message in done.stderr and "Traceback" not in done.stderr


def test_an_empty_folder_is_no_folder(small, tmp_path):
    """Not the present one either, which a variable that is not set would stand for."""
    from typer.testing import CliRunner

    import warp_rods as wr
    from warp_rods import cli

    for command in ("run", str(small)), ("reproduce", "list"):
        done = CliRunner().invoke(cli.app, [*command, "--out", ""])
        assert done.exit_code == 2 and "must be the path of a folder" in done.output
    with pytest.raises(wr.SceneError, match="out = ''"):
        wr.run(small, "")


def test_check_reports_what_a_run_would_do(small, tmp_path):
    done = warp_rods("check", small, cwd=tmp_path)
    assert done.returncode == 0 and "one: 2 rods of 17 nodes" in done.stdout and "10 steps" in done.stdout
    assert {p.name for p in tmp_path.iterdir()} == {"small.toml"}


def test_devices_names_the_cpu(tmp_path):
    assert "cpu" in warp_rods("devices", cwd=tmp_path).stdout
