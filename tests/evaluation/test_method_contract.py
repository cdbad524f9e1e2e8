"""The contract of a method: each fault is named."""

from __future__ import annotations

import pytest

from evaluation.method_contract import check_method, contract_object
from evaluation.own_rows import own_choices
from evaluation.part_registries import find_part
from shading_model.errors import RelightlabError

PARTS = "tests.evaluation.own_parts"


@pytest.mark.parametrize("word", ["paper-model", f"{PARTS}:ball"])
def test_methods_that_keep_the_contract_pass(word: str) -> None:
    """The paper's model and a method of five lines take part."""
    check_method(find_part("method", word))


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("gray_shape", "relight returned shape (48, 64), expected (48, 64, 3)"),
        ("not_finite", "pixels in the mask that are not finite"),
        ("constant", "relight returned the same image under two different lights"),
        ("forgetful", "the same photograph gave another result the second time"),
        ("careless", "it changed the image or the mask it was given"),
        ("needs_whole", "with a hole in the mask, build raised ValueError: a hole"),
        ("raising", "build raised KeyError: 'weights.bin'"),
        ("without_relight", "build returned ndarray, which has no relight"),
        ("complex_values", "relight returned values of type complex128, expected numbers"),
    ],
)
def test_what_a_method_got_wrong_is_named(name: str, fault: str) -> None:
    """One sentence that names the method and the fault."""
    with pytest.raises(RelightlabError) as error:
        check_method(find_part("method", f"{PARTS}:{name}"))
    assert f"the method '{PARTS}:{name}' cannot take part" in str(error.value)
    assert fault in str(error.value)


def test_the_object_is_not_square_and_has_its_hole() -> None:
    """A method that swaps rows and columns, or fills holes, is found out."""
    image, mask = contract_object(hole=True)
    assert image.shape[:2] == mask.shape == (48, 64)
    assert not mask[24, 32]
    assert (image[mask] >= 0).all()
    assert image[mask].max() > 0.05


@pytest.mark.parametrize(
    ("choices", "fault"),
    [
        ({"shape": "short_shape"}, "expected heights by"),
        ({"shape": "raising"}, "cannot take part: it raised KeyError: 'weights.bin'"),
        ({"detail_layer": "unknown_detail"}, "to be finite on the mask, got"),
        ({"detail_layer": "raising"}, "cannot take part: it raised KeyError: 'weights.bin'"),
        ({"weight_rules": "flat_weights"}, "returned shape (2,), expected (objects, lights, 2)"),
        ({"weight_rules": "built_nothing"}, "cannot take part: it raised TypeError"),
    ],
)
def test_what_a_part_got_wrong_is_named(choices: dict[str, str], fault: str) -> None:
    """Shapes, layers and rules are tried, too, before anything is measured."""
    given = {
        kind: [f"{PARTS}:{name}"] if kind == "weight_rules" else f"{PARTS}:{name}"
        for kind, name in choices.items()
    }
    with pytest.raises(RelightlabError) as error:
        own_choices(**given)  # type: ignore[arg-type]
    assert fault in str(error.value)


def test_parts_that_keep_the_contract_pass() -> None:
    """A cone, another layer and a rule of one's own."""
    chosen = own_choices(
        shape=f"{PARTS}:cone",
        detail_layer=f"{PARTS}:doubled_detail",
        weight_rules=[f"{PARTS}:quarter"],
    )
    assert chosen.parts.method == f"ours + {PARTS}:cone + {PARTS}:doubled_detail"
