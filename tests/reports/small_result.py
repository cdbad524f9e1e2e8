"""A Table 1 of three small synthetic objects, measured once for all tests of the page."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from datasets.illumination_pools import table1_lights
from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic, synthesize
from evaluation.provenance import Provenance
from evaluation.table1 import run_table1
from evaluation.table1_results import table1_document
from reports.content import Report
from reports.subject import Subject
from reports.table1_report import PAGE, table1_report, write_report
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters
from tests.reports.fake_fits import TruthFits
from tests.reports.rival_rows import left_out, with_rival

OBJECTS = ("apple", "cup", "shell")


@dataclass(frozen=True)
class SmallResult:
    """The arguments of `write_report` for a small set."""

    document: dict[str, Any]
    dataset: Synthetic
    lights: tuple[LogHarmonics, ...]
    parameters: ModelParameters

    def subject(self, **changes: Any) -> Subject:
        """Return the subject of the figures, with changed parts of the document."""
        document = copy.deepcopy(self.document) | changes
        return Subject(document, self.dataset, self.lights, self.parameters, TruthFits())

    def report(self, **changes: Any) -> Report:
        """Return the content of the report, with changed parts of the document."""
        return table1_report(self.subject(**changes))

    def write(self, folder: Path, **changes: Any) -> str:
        """Write the report, with changed parts of the document, and return its page."""
        page, _ = write_report(
            folder,
            document=copy.deepcopy(self.document) | changes,
            dataset=self.dataset,
            lights=self.lights,
            parameters=self.parameters,
            fits=TruthFits(),
        )
        return page.read_text(encoding="utf-8")


def provenance(**changes: Any) -> Provenance:
    """Return the provenance of a run that no clock and no machine has a part in."""
    values: dict[str, Any] = {
        "project": "0.1.0",
        "commit": "0123456789abcdef",
        "protocol": "table-1 version 1",
        "dataset": "synthetic",
        "data_hash": "ab" * 32,
        "seeds": {"lights": "table-1"},
        "python": "3.11.0",
        "machine": "a machine",
        "versions": {"numpy": "2.0"},
        "seconds": 1.5,
        "workers": 1,
        "cells_done": 24,
        "cells_missing": 0,
    }
    return Provenance(**(values | changes))


@pytest.fixture(scope="session")
def small_result(tmp_path_factory: pytest.TempPathFactory) -> SmallResult:
    """Three objects of 64 pixels, in both settings, under four lights; its SIRFS is a fake."""
    folder = tmp_path_factory.mktemp("small")
    dataset = synthesize(folder, size=64, samples=2, objects=OBJECTS)
    lights = table1_lights(None, count=4)
    parameters = shipped_parameters()
    table = run_table1(dataset, lights, parameters, quick=True)
    document = with_rival(left_out(table1_document(table, provenance())))
    return SmallResult(document, dataset, lights, parameters)


@pytest.fixture(scope="session")
def small_page(small_result: SmallResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the small result, with its PDF beside it."""
    folder = tmp_path_factory.mktemp("report")
    small_result.write(folder)
    return folder / PAGE
