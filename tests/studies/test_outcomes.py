"""What becomes of tasks by what the scheduler says of their copies: rare words, which a stand-in for it says."""

import pytest
from examples.study import cells

import warp_rods as wr
from warp_rods.errors import RunFolderError
from warp_rods.simulation.storage import StorageError
from warp_rods.studies.dispatch import SchedulerLost, _ended, _Running
from warp_rods.studies.store import STORE, Store
from warp_rods.studies.tasks import Outcome, Task

TASK = Task(0, (0, 0, 0), ((0, 0, 0), (0, 0, 1)))


class Future:
    """A task with the scheduler, until it ends with an outcome, an error, or only a word."""

    def __init__(self, key: str):
        self.key, self.status = key, "pending"

    def add_done_callback(self, callback) -> None:
        self.callback = callback

    def end(self, status: str, outcome=None) -> None:
        self.status, self.outcome = status, outcome
        self.callback(self)

    def result(self, timeout):
        if self.outcome is None:
            raise TimeoutError
        return self.outcome

    def exception(self):
        return self.outcome

    def cancel(self) -> None:
        self.status = "cancelled"


class Scheduler:
    """A client of one with two workers."""

    id, alive = "me", True

    def nthreads(self) -> dict[str, int]:
        if not self.alive:
            raise OSError("closed")
        return {"one": 1, "two": 1}

    def submit(self, *given, key, pure, workers=(), allow_other_workers=True) -> Future:
        return Future(key)


@pytest.fixture
def running() -> _Running:
    found = _Running(Scheduler(), "no folder", "cpu", wr.__version__)
    found.add(TASK)
    return found


def copies(running: _Running) -> list[Future]:
    return running.tasks[TASK.name].futures


def help_late(running: _Running) -> None:
    copies(running).append(running.submit(TASK))


@pytest.mark.parametrize(("word", "why"), [("error", RunFolderError("not there")), ("cancelled", None), ("lost", None)])
def test_a_copy_that_fails_does_not_stop_the_other(running, word, why):
    help_late(running)
    first, copy = copies(running)
    copy.end(word, why)
    assert running.next_ended() is None
    first.end("finished", Outcome(2, {}, 3.0))
    told: list[Outcome] = []
    assert _ended(running, *running.next_ended(), lambda task, outcome: told.append(outcome)) == 3.0
    assert told == [Outcome(2, {}, 3.0)] and not running.tasks


@pytest.mark.parametrize("word", ["finished", "lost", "cancelled"])
def test_an_outcome_that_cannot_be_fetched_is_found_again(running, word):
    """The worker got stuck, or was killed, after its task. That its copies are given up is no word of the task."""
    if word == "finished":
        help_late(running)
    before = copies(running)
    before[0].end("finished")
    before[0].status = word
    told: list[Outcome] = []
    _ended(running, *running.next_ended(), lambda task, outcome: told.append(outcome))
    assert all(future.status == "cancelled" for future in before[1:]) and not told
    for future in before:
        future.end("cancelled")
        assert running.next_ended() is None
    (again,) = copies(running)
    again.end("finished", Outcome(2, {}, 3.0))
    _ended(running, *running.next_ended(), lambda task, outcome: told.append(outcome))
    assert told and not running.tasks and again.key not in {future.key for future in before}


@pytest.mark.parametrize("fault", [StorageError("full"), OSError(28, "full"), RunFolderError("not there")])
def test_a_study_that_cannot_be_written_ends(running, fault):
    copies(running)[0].end("error", fault)
    with pytest.raises(type(fault), match=r"full|not there"):
        _ended(running, *running.next_ended(), lambda task, outcome: None)


def test_the_scheduler_is_lost_where_all_copies_are(running):
    help_late(running)
    running.client.alive = False
    for future in list(copies(running)):
        future.end("cancelled")
    assert running.next_ended() is None
    with pytest.raises(SchedulerLost, match="the scheduler is lost"):
        _ended(running, *running.next_ended(), lambda task, outcome: None)


def test_of_a_task_that_kills_workers_only_the_point_that_does_so_is_given_up(tmp_path):
    """What was written before stays, and the others are tried one by one."""
    study = wr.sweep(cells({"swimmers.cell.bend": [1e-3]}), tmp_path / "study", device="cpu", part="1/1")
    store = Store(study.folder / STORE)
    states = store.states()
    states[0, 0, :] = 0
    (store.path / "state" / "c.0.0.0").write_bytes(store._encoded("state", states))
    running = _Running(Scheduler(), str(study.folder), "cpu", wr.__version__)
    task = Task(0, (0, 0, 0), ((0, 0, 0), (0, 0, 1), (0, 1, 0)))
    running.add(task)
    told: list[Outcome] = []
    tell = lambda task, outcome: told.append(outcome)  # noqa: E731
    running.tasks[task.name].futures[0].end("error", MemoryError("killed"))
    _ended(running, *running.next_ended(), tell)
    assert [one.task.points for one in running.tasks.values()] == [((0, 0, 0),), ((0, 0, 1),)]
    assert [outcome.done for outcome in told] == [1]  # which it had written before
    one, other = (copies.futures[0] for copies in running.tasks.values())
    one.end("error", MemoryError("killed"))
    other.end("finished", Outcome(1, {}, 1.0))
    for _ in range(2):
        _ended(running, *running.next_ended(), tell)
    assert not running.tasks and store.states()[0].tolist() == [[3, 0], [1, 1], [1, 1]]
    assert store.whole("message")[0, 0, 0] == "MemoryError: killed"


def test_a_script_without_a_guard_is_told_so(tmp_path):
    """Processes of a study import the script that began it."""
    import subprocess
    import sys

    script = tmp_path / "script.py"
    script.write_text(
        "import warp_rods as wr\n"
        f"wr.sweep({str(tmp_path / 'scene.toml')!r}, {str(tmp_path / 'study')!r}, device='cpu', workers=2)\n"
    )
    (tmp_path / "scene.toml").write_text(cells().to_toml())
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count('below the line: if __name__ == "__main__":') == 1
    assert done.stderr.count("Traceback") == 1
