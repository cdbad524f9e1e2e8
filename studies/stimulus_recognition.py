"""Telling which pair a served trial shows by its pixels, as someone with the study's files can.

A server gives pictures names and files that tell nothing. A simulated observer, who must know the
target to choose it at a given rate, compares what it is shown with the study's own pictures.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO

from PIL import Image

from shading_model.errors import RelightlabError
from studies.observers import ShownTrial
from studies.served_stimuli import plain_png
from studies.study_records import Pair, Study

Pictures = tuple[str, str]
"""Digests of the pictures on the left and on the right."""


def pixel_digest(content: bytes) -> str:
    """Return the SHA-256 of a picture's pixels, however its file is compressed.

    Parameters
    ----------
    content : bytes
        A picture that Pillow reads.

    Raises
    ------
    RelightlabError
        If it is no picture.

    Examples
    --------
    >>> stream = BytesIO()
    >>> Image.new("RGB", (2, 2)).save(stream, "PNG")
    >>> len(pixel_digest(stream.getvalue()))
    64
    """
    try:
        with Image.open(BytesIO(content)) as picture:
            head = f"{picture.mode}{picture.size}".encode()
            return hashlib.sha256(head + picture.tobytes()).hexdigest()
    except OSError as error:
        raise RelightlabError(f"the server sent a stimulus that is no picture: {error}") from error


@dataclass(frozen=True)
class StimulusBook:
    """The pairs of a study by the digests of their pictures.

    Parameters
    ----------
    study : Study
    digests : mapping of str to str
        Of each stimulus, by its path.
    """

    study: Study
    digests: dict[str, str]

    def recognise(self, trials: Sequence[Pictures]) -> tuple[str, list[ShownTrial]]:
        """Return the task of a session and its trials.

        Raises
        ------
        RelightlabError
            If a trial shows no pair of the study.
        """
        task = max(self._tasks(), key=lambda name: self._known(name, trials))
        pairs = self._pairs(task)
        seen: Counter[str] = Counter()
        shown = []
        for number, pictures in enumerate(trials):
            if pictures not in pairs:
                raise RelightlabError(
                    f"trial {number} of the server shows no pair of the study {self.study.name}:"
                    " give the file of the study that is served"
                )
            kind, pair, side = pairs[pictures]
            seen[kind] += 1
            shown.append(ShownTrial(kind, pair, side, seen[kind]))
        return task, shown

    def _tasks(self) -> list[str]:
        return [task.name for task in self.study.tasks]

    def _known(self, task: str, trials: Iterable[Pictures]) -> int:
        pairs = self._pairs(task)
        return sum(pictures in pairs for pictures in trials)

    def _pairs(self, task: str) -> dict[Pictures, tuple[str, str, str]]:
        parts: Iterator[tuple[str, Sequence[Pair]]] = iter(
            [
                ("closing", self.study.closing),
                ("qualification", self.study.qualification),
                ("main", self.study.task(task).pairs),
            ]
        )
        known = {}
        for kind, pairs in parts:
            for pair in pairs:
                target, other = self.digests[pair.target], self.digests[pair.other]
                known[target, other] = (kind, pair.name, "left")
                known[other, target] = (kind, pair.name, "right")
        return known


def stimulus_book(study: Study) -> StimulusBook:
    """Return the book of a study whose pictures are here.

    Parameters
    ----------
    study : Study

    Raises
    ------
    RelightlabError
        If a picture cannot be read.
    """
    paths = study.stimuli()
    digests = {path: pixel_digest(plain_png(study.stimulus_path(path))) for path in paths}
    return StimulusBook(study, digests)
