"""A study with visible pictures, served on this machine, as the tests in a browser need it."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import uvicorn
from PIL import Image

from studies.page_build import page_folder
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.study_records import Study, TrialSettings
from studies.tables import StudyData
from tests.studies.small_study import small_study

WIDTH, HEIGHT = 320, 240
MODES = ("live", "pilot")


def visible_study(folder: Path, *, ids: bool = False) -> Study:
    """Return a study of five pairs, whose texts try to be markup, with pictures of one colour."""
    study = small_study(folder, pairs=2, tasks=1, ids=ids)
    for number, stimulus in enumerate(study.stimuli()):
        colour = np.random.default_rng(number).integers(0, 255, 3, dtype=np.uint8)
        Image.fromarray(np.full((HEIGHT, WIDTH, 3), colour)).save(study.stimulus_path(stimulus))
    return replace(
        study,
        title="Pictures <img src=x onerror=alert(1)>",
        consent="You may stop <script>alert(2)</script>\nat any time.\n\nThat is all.",
        settings=TrialSettings(
            minimum_view_ms=100,
            allow_tie=True,
            minimum_width=300,
            minimum_height=300,
            allow_touch=True,
        ),
    )


class ServedStudy:
    """A study's server in a thread, which can be stopped and started again.

    Parameters
    ----------
    study : Study
    folder : Path
        Where the answers go.
    """

    def __init__(self, study: Study, folder: Path) -> None:
        self.study = study
        self._database = folder / "answers.sqlite"
        self._port = _free_port()
        self.address = f"http://127.0.0.1:{self._port}/"
        self.start()

    def start(self) -> None:
        """Serve, from what an earlier server left."""
        self._store = ResponseStore(self._database)
        app = make_app(self.study, self._store, page=page_folder())
        settings = {"port": self._port, "log_level": "error", "lifespan": "off", "ws": "none"}
        self._server = uvicorn.Server(uvicorn.Config(app, **settings))  # type: ignore[arg-type]
        self._thread = threading.Thread(target=self._server.run)
        self._thread.start()
        wait_until(lambda: self._server.started, "the server to start")

    def stop(self) -> None:
        """Stop serving, at once."""
        self._server.should_exit = self._server.force_exit = True
        self._thread.join()
        self._store.close()

    def read(self) -> StudyData:
        """Return all that is stored, pilots too."""
        return self._store.read(MODES)

    def forget_subjects(self) -> None:
        """Delete every subject."""
        for subject in self.read().subjects["subject"]:
            self._store.delete_subject(subject)

    def answered(self) -> list[int]:
        """Return the trials that are stored, in their order."""
        return sorted(self.read().trials["trial"].tolist())


def wait_until(happens: Callable[[], object], what: str, seconds: float = 30.0) -> None:
    """Wait until something happens, and fail if it does not."""
    end = time.monotonic() + seconds
    while not happens():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.02)


def _free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return int(listening.getsockname()[1])
