"""The rows of Table 1 that a user adds: methods, and models with parts of their own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from datasets.records import Dataset
from evaluation.grid_run import DEFAULT_OPTIONS, Progress, RunOptions
from evaluation.method_contract import check_method, check_parts, check_weight_rule
from evaluation.methods import (
    DETAIL_SOURCE,
    WEIGHTS,
    Method,
    MethodContext,
    MethodResult,
    run_methods,
)
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.part_registries import Part, find_part
from evaluation.row_store import MemoryRows, Rows
from evaluation.sirfs_fits import UNKEPT, SirfsFits
from evaluation.table1 import run_table1
from evaluation.table1_record import MissingCell, Table1
from evaluation.weight_rules import MANUAL, WEIGHT_RULES, WeightRule
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters, Weights


@dataclass(frozen=True, eq=False)
class OwnChoices:
    """What a user brings to Table 1.

    Parameters
    ----------
    methods : tuple of Method
    parts : ModelParts
        With one of its own, a second model beside the paper's.
    rules : tuple of Part
        Weight rules beside those of Table 1.
    """

    methods: tuple[Method, ...] = ()
    parts: ModelParts = PAPER_PARTS
    rules: tuple[Part, ...] = ()

    def weight_rules(self) -> dict[str, WeightRule]:
        """Return the rules of Table 1 and those of the user."""
        return {**WEIGHT_RULES, **{part.name: part.load() for part in self.rules}}


NOTHING = OwnChoices()


@dataclass(frozen=True, eq=False)
class OwnRows:
    """What was measured of a user's own methods and parts.

    Parameters
    ----------
    table : Table1, optional
        Of the model with parts of one's own.
    methods : tuple of MethodResult
    dataset : str
    objects : tuple of str
        Those reported.
    all_objects : tuple of str
    """

    table: Table1 | None
    methods: tuple[MethodResult, ...]
    dataset: str
    objects: tuple[str, ...]
    all_objects: tuple[str, ...]

    def rows(self) -> list[dict[str, str | float | int]]:
        """Return rows of the same keys as those of `Table1.rows`."""
        own = self.table.rows() if self.table else []
        return own + [
            self._row(setting, method, errors, powers)
            for setting, method, errors, powers in self._measured()
        ]

    def object_rows(self) -> list[dict[str, str | float | int]]:
        """Return the mean error of every object, with the method's name."""
        table = self.table
        own = table.object_rows() if table else []
        return own + [
            {**self._row(setting, method, errors[[index]], powers[[index]]), "object": name}
            for setting, method, errors, powers in self._measured()
            for index, name in enumerate(self.objects)
        ]

    def missing_entries(self) -> tuple[MissingCell, ...]:
        """Return the missing cells of the reported objects."""
        own = self.table.missing_entries() if self.table else ()
        named = [
            MissingCell({**found.cell, "method": self.table.method}, found.reason)
            for found in own
            if self.table
        ]
        return (
            *named,
            *(
                MissingCell(cell, reason)
                for method in self.methods
                for cell, reason in method.missing
                if cell["object"] in self.objects
            ),
        )

    def _measured(self) -> Iterator[tuple[str, str, Float, Float]]:
        reported = [name in self.objects for name in self.all_objects]
        for method in self.methods:
            for setting, errors in method.errors.items():
                yield setting, method.name, errors[reported], method.powers[setting][reported]

    def _row(
        self, setting: str, method: str, errors: Float, powers: Float
    ) -> dict[str, str | float | int]:
        known = np.isfinite(errors)
        imse = float(errors[known].mean()) if known.any() else float("nan")
        power = float(powers[known].mean()) if known.any() else float("nan")
        return {
            "dataset": self.dataset,
            "setting": setting,
            "method": method,
            "detail_source": DETAIL_SOURCE,
            "weights": WEIGHTS,
            "imse": imse,
            "relative_imse": imse / power,
            "cells": int(known.sum()),
        }


def own_choices(
    methods: Sequence[str] = (),
    commands: Sequence[Method] = (),
    shape: str | None = None,
    detail_layer: str | None = None,
    weight_rules: Sequence[str] = (),
) -> OwnChoices:
    """Find what the user names, and try all of it before anything is measured.

    Parameters
    ----------
    methods : sequence of str
        Names, or ``module:callable``.
    commands : sequence of CommandMethod
    shape, detail_layer : str, optional
    weight_rules : sequence of str

    Returns
    -------
    OwnChoices

    Raises
    ------
    RelightlabError
        For unknown names, a name given twice, or what breaks its contract.

    Examples
    --------
    >>> own_choices(shape="flat").parts.method
    'ours + flat'
    """
    found = [find_part("method", word) for word in methods]
    for method in found:
        check_method(method)
    rules = [find_part("weight-rule", word) for word in weight_rules]
    names = [*WEIGHT_RULES, *(rule.name for rule in rules)]
    for rule in rules:
        if names.count(rule.name) > 1:
            raise RelightlabError(f"the weight rule {rule.name!r} stands in Table 1 already")
    parts = ModelParts(
        None if shape is None else find_part("shape", shape),
        None if detail_layer is None else find_part("detail-layer", detail_layer),
    )
    for rule in rules:
        check_weight_rule(rule)
    if parts != PAPER_PARTS:
        check_parts(parts)
    return OwnChoices((*found, *commands), parts, tuple(rules))


def run_own_rows(
    choices: OwnChoices,
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    *,
    objects: Sequence[str] = (),
    channels: str = "gray",
    manual: Weights = MANUAL,
    seed: str = "",
    store: Rows | None = None,
    quick: bool = False,
    fits: SirfsFits = UNKEPT,
    options: RunOptions = DEFAULT_OPTIONS,
    progress: Progress | None = None,
) -> OwnRows:
    """Measure what a user brings, on the dataset, lights and pixels of Table 1.

    Parameters
    ----------
    choices : OwnChoices
    dataset, lights, parameters, objects, channels, manual, seed, store
        As for `evaluation.table1.run_table1`.
    quick, fits, options, progress
        As for `evaluation.table1.run_table1`.

    Returns
    -------
    OwnRows

    Raises
    ------
    RelightlabError
        As `run_table1` and `run_methods`.
    """
    rows = store or MemoryRows()
    table = None
    if choices.parts != PAPER_PARTS:
        table = run_table1(
            dataset,
            lights,
            parameters,
            objects=objects,
            channels=channels,
            manual=manual,
            seed=seed,
            parts=choices.parts,
            rules=choices.weight_rules(),
            store=rows,
            quick=quick,
            fits=fits,
            options=options,
            progress=progress,
        )
    contexts = [MethodContext(dataset, tuple(lights), channels, m) for m in choices.methods]
    results = run_methods(contexts, rows, options, seed=seed, progress=progress)
    reported = tuple(name for name in dataset.objects if not objects or name in objects)
    return OwnRows(table, results, dataset.name, reported, dataset.objects)
