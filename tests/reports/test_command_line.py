"""Tests of the command line as a whole: help, failures and interruptions."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from reports import command_line
from reports.command_line import run
from shading_model.errors import RelightlabError

START = [sys.executable, "-c", "from reports.command_line import main; main()"]
HEAVY = ("cv2", "evaluation", "matplotlib", "mitsuba", "numpy", "pandas", "scipy", "skimage")


def started(*arguments: str, **options: object) -> subprocess.Popen[str]:
    """Start the command in a process group of its own, as a shell does."""
    return subprocess.Popen(  # type: ignore[call-overload,no-any-return]
        [*START, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **options,
    )


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    """The help names every group of commands."""
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in ("reproduce", "data", "model", "evaluate", "gate"))


@pytest.mark.parametrize(
    "command",
    [
        *(["reproduce"], ["data", "list"], ["data", "fetch"], ["data", "verify"]),
        *(["data", "synthesize"], ["model", "build"], ["model", "relight"]),
        *(["evaluate", "rerendering"], ["evaluate", "sirfs"]),
        *(["gate", "check"], ["gate", "record"]),
        *(["grid", name] for name in ("status", "plan", "archive", "verify", "merge")),
    ],
)
def test_every_command_has_help(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Every command says what it does, with the options it takes."""
    assert run([*command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert f"relightlab {' '.join(command)}" in shown
    assert "--" in shown.replace("--help", "")


def test_help_loads_nothing_heavy() -> None:
    """Help imports none of the libraries that only some commands need."""
    code = (
        "import sys; from reports.command_line import run; run(['--help']);"
        f"print('loaded:', [name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "loaded: []"


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    """The version is that of the installed distribution."""
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"relightlab {version('relightlab')}\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--nonsense"], "No such option: --nonsense"),
        (["nonsense"], "nonsense"),
        (["data"], "Missing command"),
        (["data", "list", "--nonsense"], "--nonsense"),
        (["model", "build", "a.png"], "--out"),
        (["evaluate", "rerendering", "--workers", "many"], "valid integer"),
        (["evaluate", "rerendering", "--manual", "1"], "expected 2 numbers"),
        (["evaluate", "rerendering", "--dataset", "synthtic"], "Did you mean 'synthetic'?"),
        (["evaluate", "rerendering", "--objects", ","], "expected names"),
        (["data", "fetch", "mit-berkley"], "Did you mean 'mit-berkeley'?"),
        (["data", "fetch", "mit-berkeley"], "run again with --accept-licence"),
        (["data", "list", "--data", "no such folder"], "no such folder"),
        (["data", "synthesize", "--size", "3"], "at least 32"),
        (["model", "relight", "m.npz", "--out", "a.png", "--weights", "a,b"], "expected 2 numbers"),
    ],
)
def test_wrong_use_is_one_sentence(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wrong use is told in one line on standard error, with exit code 2."""
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("relightlab: ")
    assert shown.err.count("\n") == 1
    assert words in shown.err


def test_without_arguments_it_shows_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    """The bare command is wrong use, but a way to get to know it."""
    assert run([]) == 2
    assert "Usage: relightlab" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (RelightlabError("one sentence"), 2, "relightlab: one sentence\n"),
        (PermissionError(13, "Permission denied", "a.png"), 2, "a.png: Permission denied"),
        (MemoryError(), 2, "not enough memory"),
        (KeyboardInterrupt(), 130, "stopped before the end"),
    ],
)
def test_errors_become_sentences(
    error: BaseException,
    code: int,
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """What a command may raise becomes one line on standard error, without a traceback."""

    def fails(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(command_line, "app", fails)
    assert run([]) == code
    assert words in capsys.readouterr().err


def test_a_fault_of_ours_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """A programming error is not passed off as wrong use."""

    def fails(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(command_line, "app", fails)
    with pytest.raises(ZeroDivisionError):
        run([])


@pytest.mark.skipif(os.name != "posix", reason="signals and pipes of POSIX")
def test_a_broken_pipe_is_quiet(tmp_path: Path) -> None:
    """A reader that leaves before the output came is no error to complain of."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.exr").touch()
    process = started("data", "list", "--data", str(tmp_path))
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    _, errors = process.communicate(timeout=60)
    assert errors == ""
    assert process.returncode != 0


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals and pipes of POSIX")
@pytest.mark.parametrize("workers", ["1", "2"])
def test_an_interrupt_leaves_no_half_written_file(tmp_path: Path, workers: str) -> None:
    """Ctrl-C gives exit code 130 and one sentence; only whole files have final names."""
    out = tmp_path / "set"
    made = ["data", "synthesize", "--out", str(out), "--size", "64", "--workers", workers]
    process = started(*made)
    assert process.stderr is not None
    process.stderr.readline()
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors.splitlines()[-1] == "relightlab: stopped before the end"
    assert "Traceback" not in errors
    from datasets.synthetic_objects import load_object

    finished = list(out.glob("[!.]*.npz"))
    assert finished
    assert all(load_object(path).name == path.stem for path in finished)
    assert not (out / "manifest.json").exists()
