"""Dispatching to worker processes of this machine: order, faults, threads, and what is sent."""

from __future__ import annotations

import pickle
import sys
import time
import types
from pathlib import Path

import pytest

from evaluation import dispatch as dispatch_module
from evaluation import task_process
from evaluation.code_version import code_hash
from evaluation.dispatch import CHANGED_CODE, dispatch
from evaluation.task_process import TaskProcess, run_in_own_process
from shading_model.errors import RelightlabError
from tests.evaluation.dispatch_tasks import (
    MarkingWork,
    broken,
    printed,
    process_here,
    threads_here,
)

SQUARES = {number: number * number for number in range(8)}


def test_one_worker_is_this_process(tmp_path: Path) -> None:
    """In order, with no process started."""
    work = MarkingWork(tmp_path)
    assert list(dispatch(work, range(8))) == list(SQUARES.items())
    assert work.processes() == {process_here(0)}


@pytest.mark.parametrize("workers", [0, -1])
def test_no_worker_is_refused(workers: int) -> None:
    """In one sentence."""
    with pytest.raises(RelightlabError, match="at least one worker"):
        list(dispatch(abs, [1], workers=workers))


def test_two_workers_share_the_items(tmp_path: Path) -> None:
    """All results, each once, by two other processes."""
    work = MarkingWork(tmp_path, seconds=0.05)
    results = list(dispatch(work, range(8), workers=2))
    assert sorted(results) == sorted(SQUARES.items())
    assert len(work.processes()) == 2
    assert process_here(0) not in work.processes()


def test_results_come_as_they_finish(tmp_path: Path) -> None:
    """The first is here when most have not begun: at most one item waits for a worker."""
    work = MarkingWork(tmp_path, seconds=0.2)
    results = dispatch(work, range(8), workers=2)
    next(results)
    assert len(list(tmp_path.iterdir())) <= 4
    results.close()


def test_leaving_early_stops_the_workers(tmp_path: Path) -> None:
    """Whoever stops taking results does not wait for those that are being made."""
    results = dispatch(MarkingWork(tmp_path, hanging=1), [1, 2], workers=2)
    assert next(results) == (2, 4)
    started = time.monotonic()
    results.close()
    assert time.monotonic() - started < 20


def test_a_killed_worker_costs_time_not_results(tmp_path: Path) -> None:
    """The item that was in flight is done at the second attempt; no finished one is repeated."""
    work = MarkingWork(tmp_path, killing=3, times=1, seconds=0.05)
    assert dict(dispatch(work, range(8), workers=2)) == SQUARES
    assert work.attempts(3) == 2
    assert sum(work.attempts(number) for number in range(8)) <= 8 + 3


def test_an_item_that_kills_twice_has_no_result(tmp_path: Path) -> None:
    """It alone: it is not tried a third time, and the others are done."""
    work = MarkingWork(tmp_path, killing=3, times=99)
    assert dict(dispatch(work, range(8), workers=2)) == {**SQUARES, 3: None}
    assert work.attempts(3) == 2


def test_every_worker_has_one_thread() -> None:
    """For each numerical library, by limit and by environment, in pools and in own processes."""
    for _, (threads, environment) in dispatch(threads_here, range(2), workers=2):
        assert threads
        assert set(threads) == {1}
        assert set(environment.values()) == {"1"}
    threads, environment = run_in_own_process(
        pickle.dumps(threads_here), code_hash(), pickle.dumps(0)
    )
    assert threads
    assert set(threads) == {1}
    assert set(environment.values()) == {"1"}


def test_what_tasks_share_is_pickled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A context of a megabyte is pickled once, however many items there are."""
    sent: list[int] = []

    def counting(work: object) -> bytes:
        content = pickle.dumps(work)
        sent.append(len(content))
        return content

    monkeypatch.setattr(dispatch_module, "_pickled", counting)
    work = bytes(1_000_000).find
    assert len(list(dispatch(work, [b"\0"] * 20, workers=2))) == 20
    assert len(sent) == 1
    assert sent[0] > 1_000_000


def test_work_that_cannot_be_sent_is_told() -> None:
    """A function that lies in no module, in one sentence."""
    with pytest.raises(RelightlabError, match="define it in a module, or use --workers 1"):
        list(dispatch(lambda item: item, [1, 2], workers=2))


def test_changed_code_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker that would run other code than the rows are to be labelled with does nothing."""
    monkeypatch.setattr(dispatch_module, "code_hash", lambda: "another version")
    with pytest.raises(RelightlabError) as caught:
        list(dispatch(abs, [-1, -2], workers=2))
    assert str(caught.value) == CHANGED_CODE


def test_work_that_a_worker_cannot_load_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A module that only this process knows: one sentence, not a dead worker."""
    module = types.ModuleType("only_here")
    exec("def work(item):\n    return item", module.__dict__)  # noqa: S102
    monkeypatch.setitem(sys.modules, "only_here", module)
    with pytest.raises(RelightlabError, match=r"ModuleNotFoundError: No module named 'only_here'"):
        list(dispatch(module.work, [1, 2, 3], workers=2))


def test_an_own_process_outlives_its_items_and_not_its_owner() -> None:
    """Items of one thread are done by one process, which ends with its connection."""
    process = TaskProcess(pickle.dumps(process_here), code_hash())
    numbers = {process.run(pickle.dumps(item)) for item in range(3)}
    assert len(numbers) == 1
    assert process.serves(pickle.dumps(process_here), code_hash())
    process._connection.close()
    assert process._process.wait(timeout=20) == 1
    assert not process.serves(pickle.dumps(process_here), code_hash())


def test_what_the_work_prints_does_not_disturb_its_result(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """It goes to standard error."""
    assert run_in_own_process(pickle.dumps(printed), code_hash(), pickle.dumps(7)) == 7
    task_process._close_own()
    shown = capfd.readouterr()
    assert shown.out == ""
    assert "words on standard output" in shown.err


def test_an_own_process_that_dies_is_replaced_once(tmp_path: Path) -> None:
    """Killed once, the item is done; killed twice, it has no result; the next one is done."""
    once = MarkingWork(tmp_path / "once", killing=3, times=1)
    always = MarkingWork(tmp_path / "always", killing=3, times=99)
    for work, result in ((once, 9), (always, None)):
        work.folder.mkdir()
        pickled = pickle.dumps(work)
        assert run_in_own_process(pickled, code_hash(), pickle.dumps(3)) == result
        assert work.attempts(3) == 2
        assert run_in_own_process(pickled, code_hash(), pickle.dumps(4)) == 16
    task_process._close_own()


@pytest.mark.parametrize(
    ("work", "code", "words"),
    [
        (pickle.dumps(broken), None, "ZeroDivisionError: work returns its faults"),
        (pickle.dumps(abs), "other", "of another version than the one that asks"),
        (b"cno_such_module\nwork\n.", None, "No module named 'no_such_module'"),
    ],
)
def test_a_process_that_cannot_do_the_work_says_why(
    work: bytes, code: str | None, words: str
) -> None:
    """Other code, a missing package, or work that raises: not a death, but a sentence."""
    with pytest.raises(RelightlabError, match=words):
        run_in_own_process(work, code or code_hash(), pickle.dumps(1))
    task_process._close_own()
