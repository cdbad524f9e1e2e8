"""Tests of the row store: what a crash, a full disk and a second run leave of it."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evaluation.grid_status import grid_summary
from evaluation.row_lines import DamagedLine, encode_rows
from evaluation.row_store import MemoryRows, RowStore
from shading_model.errors import RelightlabError
from tests.evaluation.small_grids import rows_of, small_experiment

ROWS = [{"experiment": "small", "cell": {"object": str(n)}, "imse": n / 7} for n in range(6)]
APPEND = """
import sys
from pathlib import Path
from evaluation.row_store import RowStore
store, name, count = RowStore(Path(sys.argv[1])), sys.argv[2], int(sys.argv[3])
for number in range(count):
    store.append([{"seed": name, "number": number, "words": name * 200}])
"""
FULL_DISK = """
import resource, signal, sys
from pathlib import Path
from evaluation.row_store import RowStore
from shading_model.errors import RelightlabError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
store = RowStore(Path(sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
for number in range(1000):
    try:
        store.append([{"number": number, "words": "word " * 50}])
    except RelightlabError as error:
        print(number, error)
        break
"""
MILLION = 1_000_000


@pytest.fixture
def store(tmp_path: Path) -> RowStore:
    """Six rows in two batches."""
    store = RowStore(tmp_path / "store" / "rows.jsonl")
    store.append(ROWS[:3])
    store.append(ROWS[3:])
    return store


def test_rows_come_back_in_order(store: RowStore) -> None:
    """Rows are read in the order of writing, by file and by memory alike."""
    memory = MemoryRows()
    memory.append(ROWS)
    assert store.read() == memory.read() == (ROWS, [])
    assert list(store.stream()) == ROWS


def test_a_store_that_is_not_there_is_empty(tmp_path: Path) -> None:
    """No file is no rows; reading does not make one."""
    store = RowStore(tmp_path / "none" / "rows.jsonl")
    assert store.read() == ([], [])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("cut", [2, 7, 40])
def test_only_the_cut_line_is_lost(store: RowStore, cut: int) -> None:
    """A last line that was cut is lost alone, also after more rows were appended."""
    os.truncate(store.path, store.path.stat().st_size - cut)
    store.append([{"after": 1}])
    rows, damaged = store.read()
    assert rows == [*ROWS[:5], {"after": 1}]
    assert [line.number for line in damaged] == [8]


def test_a_row_without_its_newline_is_whole(store: RowStore) -> None:
    """Where only the last newline was cut, the next append gives it back."""
    os.truncate(store.path, store.path.stat().st_size - 1)
    store.append([{"after": 1}])
    assert store.read() == ([*ROWS, {"after": 1}], [])


@given(st.data())
@settings(max_examples=200)
def test_a_flipped_bit_is_never_a_wrong_row(data: st.DataObject) -> None:
    """Whatever bit flips, every row that is read is one that was written, and loss is reported."""
    content = bytearray(b"".join(encode_rows(ROWS[:3])) + b"".join(encode_rows(ROWS[3:])))
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] ^= 1 << data.draw(st.integers(0, 7))
    memory = MemoryRows()
    memory._lines = bytes(content).splitlines(keepends=True)
    rows, damaged = memory.read()
    left = iter(ROWS)
    assert all(row in left for row in rows)
    assert damaged


def test_nan_is_refused_and_nothing_written(store: RowStore) -> None:
    """A batch that holds NaN leaves the file as it was."""
    before = store.path.read_bytes()
    with pytest.raises(RelightlabError, match="not JSON"):
        store.append([{"imse": 0.5}, {"imse": float("nan")}])
    assert store.path.read_bytes() == before


@pytest.mark.parametrize("target", ["file/rows.jsonl", "folder"])
def test_a_place_that_cannot_be_written(tmp_path: Path, target: str) -> None:
    """A folder below a file, and a folder in place of the file, are told in one sentence."""
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    with pytest.raises(RelightlabError, match=r"cannot append to .*choose another folder"):
        RowStore(tmp_path / target).append(ROWS)


def test_a_place_that_cannot_be_read(tmp_path: Path) -> None:
    """A folder in place of the file is told in one sentence."""
    with pytest.raises(RelightlabError, match="cannot read"):
        RowStore(tmp_path).read()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder(tmp_path: Path) -> None:
    """A folder without the right to write is told in one sentence."""
    tmp_path.chmod(0o500)
    with pytest.raises(RelightlabError, match="Permission denied"):
        RowStore(tmp_path / "rows.jsonl").append(ROWS)


def test_a_full_disk_costs_the_last_rows_only(tmp_path: Path) -> None:
    """Where there is no more room, rows before are safe and the file ends with a whole line."""
    path = tmp_path / "rows.jsonl"
    done = _python(FULL_DISK, str(path))
    output, _ = done.communicate(timeout=60)
    number, sentence = output.split(" ", 1)
    assert "make room or choose another folder" in sentence
    rows, damaged = RowStore(path).read()
    assert [row["number"] for row in rows] == list(range(int(number)))
    assert damaged == []
    assert path.read_bytes().endswith(b"\n")


def test_two_processes_append_at_once(tmp_path: Path) -> None:
    """No line is lost or mixed with another, and each process's rows keep their order."""
    path = tmp_path / "rows.jsonl"
    both = [_python(APPEND, str(path), name, "300") for name in "ab"]
    assert [process.communicate(timeout=60)[0] for process in both] == ["", ""]
    assert [process.returncode for process in both] == [0, 0]
    rows, damaged = RowStore(path).read()
    assert damaged == []
    for name in "ab":
        numbers = [row["number"] for row in rows if row["seed"] == name]
        assert numbers == list(range(300))


def test_the_clock_plays_no_part(store: RowStore, monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes backwards changes neither bytes nor which row counts."""
    twin = RowStore(store.path.with_name("twin.jsonl"))
    monkeypatch.setattr(time, "time", lambda: -1e9)
    twin.append(ROWS[:3])
    os.utime(twin.path, (0, 0))
    twin.append(ROWS[3:])
    assert twin.path.read_bytes() == store.path.read_bytes()


@pytest.mark.slow
def test_a_million_rows(tmp_path: Path) -> None:
    """A million rows are appended at 20,000/s or more, and summed up in bounded memory."""
    axes = {"object": tuple(map(str, range(1000))), "light": tuple(map(str, range(1000)))}
    experiment = small_experiment(axes=axes)
    store = RowStore(tmp_path / "rows.jsonl")
    template = rows_of(small_experiment())[0] | {"inputs": experiment.input_hash()}
    seconds = 0.0
    for name in axes["object"]:
        batch = [{**template, "cell": {"object": name, "light": light}} for light in axes["light"]]
        started = time.perf_counter()
        store.append(batch)
        seconds += time.perf_counter() - started
    assert MILLION / seconds >= 20_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    started = time.perf_counter()
    summary = grid_summary(experiment, store)
    assert time.perf_counter() - started < 60
    assert (summary.done, summary.to_run, summary.damaged) == (MILLION, 0, ())
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    unit = 1 if sys.platform == "darwin" else 1024
    assert grown * unit < 100e6


def test_damage_is_known_by_its_line(store: RowStore) -> None:
    """A damaged line is reported with its number in the file and a reason."""
    lines = store.path.read_bytes().splitlines(keepends=True)
    store.path.write_bytes(b"".join([*lines[:2], b"nonsense\n", *lines[2:]]))
    assert store.read()[1] == [DamagedLine(3, "the checksum does not fit the line")]


def _python(code: str, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
