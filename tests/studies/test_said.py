"""What a sweep says at its end, and when it is stopped."""

import contextlib
import logging
from importlib import import_module

import pytest
from examples.study import SENSOR, cells, sensors
from rich.console import Console

import warp_rods as wr
from warp_rods.simulation.interruption import Interrupted
from warp_rods.studies import cluster, dispatch
from warp_rods.studies.sweep import STOPPING


def test_warnings_of_kept_runs_are_said_once_with_their_point(tmp_path, caplog, monkeypatch):
    monkeypatch.setitem(SENSOR, "length", 1.5)
    with caplog.at_level(logging.INFO, "warp_rods"):
        study = wr.sweep(sensors(keep="trajectory"), tmp_path / "study", device="cpu", part=(1, 1))
    assert not [record for record in caplog.records if "nodes" in record.getMessage()]
    said = [line for line in study.messages if "9 nodes are" in line and "first point" not in line]
    assert (
        len(said) == 1
        and "filaments.sensors.intrinsic.1 = 0.0, seed = 3 and 3 other points: sensors: 9 nodes" in said[0]
    )


def stopped(monkeypatch, where, name: str, before: bool, error: BaseException) -> None:
    """Let a function raise what a signal does, before or after its work."""
    real = getattr(where, name)

    def function(*arguments, **options):
        if not before:
            real(*arguments, **options)
        raise error

    monkeypatch.setattr(where, name, function)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), Interrupted(2)])
def test_a_signal_after_the_last_point_is_no_failure(tmp_path, monkeypatch, error):
    stopped(monkeypatch, import_module("warp_rods.studies.sweep"), "run_here", False, error)
    console = Console(record=True, quiet=False, width=200)
    study = wr.sweep(sensors(), tmp_path / "study", device="cpu", part=(1, 1), console=console)
    assert study.left == 0 and "all points were finished in the meantime" in console.export_text()


def test_a_signal_is_answered_at_once_where_processes_have_to_end(tmp_path, monkeypatch):
    console, said = Console(record=True, width=200), []

    @contextlib.contextmanager
    def connected(*_):
        yield object()
        said.append(console.export_text(clear=False))

    monkeypatch.setattr(cluster, "connected", connected)
    stopped(monkeypatch, dispatch, "run_on", True, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        wr.sweep(cells(), tmp_path / "study", device="cpu", workers=1, console=console)
    assert STOPPING in said[0] and "stopped: what was finished is kept" not in said[0]
    assert "stopped: what was finished is kept" in console.export_text()
