"""A tiny synthetic set and its Table 1, made once for all tests of the evaluation."""

from __future__ import annotations

import pytest

from datasets.illumination_pools import table1_lights
from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic, synthesize
from evaluation.table1 import run_table1
from evaluation.table1_record import Table1

OBJECTS = ("bear", "cup", "medal")
LIGHTS = table1_lights(None, count=4)


@pytest.fixture(scope="session")
def tiny_set(tmp_path_factory: pytest.TempPathFactory) -> Synthetic:
    """Three objects of 64 pixels in both settings."""
    folder = tmp_path_factory.mktemp("tiny")
    return synthesize(folder, size=64, samples=2, objects=OBJECTS)


@pytest.fixture(scope="session")
def tiny_table(tiny_set: Synthetic) -> Table1:
    """Table 1 of the tiny set under four lights, by one process, without SIRFS."""
    return run_table1(tiny_set, LIGHTS, shipped_parameters(), quick=True)
