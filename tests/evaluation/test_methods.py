"""Methods and parts of one's own as rows of Table 1."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.grid_run import RunOptions
from evaluation.methods import MethodContext, method_experiment
from evaluation.own_rows import OwnChoices, OwnRows, own_choices, run_own_rows
from evaluation.part_registries import find_part
from evaluation.row_store import MemoryRows
from evaluation.table1 import run_table1
from evaluation.table1_record import Table1
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import LIGHTS, OBJECTS

PARTS = "tests.evaluation.own_parts"


def measured(choices: OwnChoices, tiny_set: Synthetic, **options: object) -> OwnRows:
    """Return a user's rows on the tiny set."""
    return run_own_rows(  # type: ignore[arg-type]
        choices, tiny_set, LIGHTS, shipped_parameters(), quick=True, **options
    )


def test_our_model_as_a_method_has_our_numbers(tiny_set: Synthetic, tiny_table: Table1) -> None:
    """The same pixels, targets and scale: the row of the default weights, object for object."""
    own = measured(own_choices([f"{PARTS}:ours_again"]), tiny_set)
    rows = own.rows()
    assert [list(row) for row in rows] == [list(tiny_table.rows()[0])] * 2
    assert {(r["method"], r["detail_source"], r["weights"]) for r in rows} == {
        ("again", "own", "none")
    }
    assert {row["cells"] for row in rows} == {len(OBJECTS) * len(LIGHTS)}
    key = {"detail_source": "default", "weights": "default"}
    for mine, theirs in ((rows, tiny_table.rows()), (own.object_rows(), tiny_table.object_rows())):
        ours = [row for row in theirs if key.items() <= row.items()]
        for name in ("imse", "relative_imse"):
            assert np.allclose([r[name] for r in mine], [r[name] for r in ours], rtol=1e-9)


def test_color_compares_three_channels(tiny_set: Synthetic) -> None:
    """A method's colours count with `color`, and do not with `gray`."""
    choices = own_choices(["paper-model"])
    gray, color = (measured(choices, tiny_set, channels=c).rows() for c in ("gray", "color"))
    assert gray[0]["imse"] != color[0]["imse"]


def test_rows_are_kept_and_resumed(tiny_set: Synthetic) -> None:
    """A second run on the same store measures nothing; another version of the method does."""
    store = MemoryRows()
    choices = own_choices([f"{PARTS}:ours_again"])
    first = measured(choices, tiny_set, store=store)
    count = len(list(store.read()[0]))
    assert count == 2 * len(OBJECTS) * len(LIGHTS)
    assert measured(choices, tiny_set, store=store).rows() == first.rows()
    assert len(list(store.read()[0])) == count
    (method,) = choices.methods
    newer = dataclasses.replace(method, identity="another")  # type: ignore[type-var]
    measured(OwnChoices((newer,)), tiny_set, store=store)
    assert len(list(store.read()[0])) == 2 * count


def test_identity_follows_name_version_and_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two callables of one file differ by name and version; the input hash holds the identity."""
    again, ball = (find_part("method", f"{PARTS}:{name}") for name in ("ours_again", "ball"))
    assert again.identity != ball.identity
    assert find_part("method", f"{PARTS}:ball").identity == ball.identity
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "user_module_of_this_test.py"
    source.write_text("def build(image, mask): pass\n", encoding="utf-8")
    before = find_part("method", "user_module_of_this_test:build").identity
    source.write_text("def build(image, mask): return 1\n", encoding="utf-8")
    assert find_part("method", "user_module_of_this_test:build").identity != before


def test_the_input_hash_holds_the_method(tiny_set: Synthetic) -> None:
    """Two methods of one name but other code do not share rows."""
    method = find_part("method", "paper-model")
    other = dataclasses.replace(method, identity="x")
    one, two = (
        method_experiment(MethodContext(tiny_set, LIGHTS, "gray", m)) for m in (method, other)
    )
    assert one.name == two.name
    assert one.input_hash() != two.input_hash()


@pytest.mark.slow
def test_workers_find_the_method_again(tiny_set: Synthetic) -> None:
    """Two processes give the numbers of one."""
    choices = own_choices([f"{PARTS}:ours_again"])
    two = measured(choices, tiny_set, options=RunOptions(workers=2))
    assert two.rows() == measured(choices, tiny_set).rows()


def test_a_failing_method_fails_its_cells_alone(tiny_set: Synthetic) -> None:
    """The rows have no value, and every cell its reason in one line."""
    broken = find_part("method", f"{PARTS}:gray_shape")
    own = measured(OwnChoices((broken,)), tiny_set, objects=["cup"])
    assert all(np.isnan(row["imse"]) and row["cells"] == 0 for row in own.rows())
    missing = own.missing_entries()
    assert len(missing) == 2 * len(LIGHTS)
    assert missing[0].cell["method"] == f"{PARTS}:gray_shape"
    assert missing[0].reason.startswith("relight returned shape (")


@pytest.mark.slow
def test_a_base_shape_of_ones_own_makes_a_second_model(
    tiny_set: Synthetic, tiny_table: Table1
) -> None:
    """The shipped contour shape gives our numbers again, a cone others, under its own name."""
    same = measured(own_choices(shape="contour", detail_layer="sparse"), tiny_set).rows()
    ours = tiny_table.rows()
    assert [row["imse"] for row in same] == pytest.approx([row["imse"] for row in ours], rel=1e-9)
    assert {row["method"] for row in same} == {"ours + contour + sparse"}
    cone = measured(own_choices(shape=f"{PARTS}:cone"), tiny_set)
    assert {row["method"] for row in cone.rows()} == {f"ours + {PARTS}:cone"}
    assert cone.rows()[0]["imse"] != ours[0]["imse"]
    assert len(cone.object_rows()) == len(tiny_table.object_rows())
    assert cone.missing_entries() == ()


@pytest.mark.slow
def test_a_detail_layer_takes_the_place_of_the_geometric_one(tiny_set: Synthetic) -> None:
    """Coarse rows stay, rows with detail change."""
    rows = measured(own_choices(detail_layer=f"{PARTS}:doubled_detail"), tiny_set).rows()
    none = measured(own_choices(detail_layer="none"), tiny_set).rows()
    for one, other in zip(rows, none, strict=True):
        assert (one["imse"] == other["imse"]) == (one["weights"] == "coarse")


def test_a_weight_rule_of_ones_own_is_a_row(tiny_set: Synthetic, tiny_table: Table1) -> None:
    """It stands last in every entry, with the error at its weights; the others stay."""
    name = f"{PARTS}:quarter"
    rules = own_choices(weight_rules=[name]).weight_rules()
    table = run_table1(tiny_set, LIGHTS, shipped_parameters(), rules=rules, quick=True)
    assert [row for row in table.rows() if row["weights"] != name] == tiny_table.rows()
    cell = table.results[0].cells["default"][0]
    from shading_model.object_model import Weights

    assert table.errors("natural", "default", name)[0, 0] == cell.error(Weights(0.25, 0.25))


@pytest.mark.parametrize(
    ("kind", "word", "sentence"),
    [
        ("method", "paper-modle", "Unknown method 'paper-modle'. Did you mean 'paper-model'?"),
        ("shape", "contuor", "Unknown base shape 'contuor'. Did you mean 'contour'?"),
        ("detail-layer", "nonne", "Unknown detail layer 'nonne'. Did you mean 'none'?"),
        ("weight-rule", "oracel", "Unknown weight rule 'oracel'. Did you mean 'oracle'?"),
        ("method", "no_such_module_here:build", "cannot import the method"),
        ("method", f"{PARTS}:bal", "Did you mean 'ball'?"),
        ("method", f"{PARTS}:NOT_CALLABLE", "to be callable, got int"),
    ],
)
def test_unknown_parts_are_told(kind: str, word: str, sentence: str) -> None:
    """A name that is not there is answered with those that are."""
    with pytest.raises(RelightlabError) as error:
        find_part(kind, word)
    assert sentence in str(error.value)


def test_an_installed_package_is_found_by_its_entry_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A distribution that declares a group's entry is known by the entry's name."""
    metadata = tmp_path / "users_package-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: users-package\nVersion: 1.0\n")
    entry = f"[relightlab.shapes]\nusers-cone = {PARTS}:cone\n"
    (metadata / "entry_points.txt").write_text(entry, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert find_part("shape", "users-cone").load().__name__ == "cone"


def test_names_that_stand_in_the_table_are_refused(tiny_set: Synthetic) -> None:
    """A method twice, or a rule of Table 1 again, would be two rows of one name."""
    twice = own_choices(["paper-model", "paper-model"])
    with pytest.raises(RelightlabError, match="stands in Table 1 already"):
        measured(twice, tiny_set)
    with pytest.raises(RelightlabError, match="'oracle' stands in Table 1 already"):
        own_choices(weight_rules=["oracle"])
