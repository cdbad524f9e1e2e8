"""Tests of reports.table1_report as its page shows it, and of the tables and verdict on it."""

from __future__ import annotations

import copy
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from reports.table1_entries import BASELINE, LEFT_OUT, Entry, missing_reasons, table1_rows
from reports.table1_report import PAGE, PRINTED, protocol_sections, write_report
from reports.table1_verdict import detail_effect, table1_verdict
from shading_model.errors import RelightlabError
from tests.reports.html_outline import Element, read_html
from tests.reports.rival_rows import left_out
from tests.reports.small_result import (
    OBJECTS,
    SmallResult,
    provenance,
    small_page,
    small_result,
)

__all__ = ["small_page", "small_result"]
LARGEST_PAGE = 6_000_000


@pytest.fixture(scope="module")
def outline(small_page: Path) -> Element:
    """The elements of the small page."""
    return read_html(small_page.read_text(encoding="utf-8"))


def table(outline: Element, identifier: str) -> Element:
    """Return the table of an identifier."""
    (found,) = [e for e in outline.all("table") if e.attributes["id"] == identifier]
    return found


def published_alone(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document whose measured rows are the published ones, a tenth as large."""
    return document | {"rows": [row | {"imse": row["imse"] / 10} for row in document["published"]]}


def test_page_has_one_heading_a_title_and_a_language(outline: Element) -> None:
    """A page has one h1, a language, a title, and headings that skip no level."""
    assert outline.one("html").attributes["lang"] == "en"
    assert "synthetic" in outline.one("title").text
    assert outline.one("h1").text
    levels = [int(heading.tag[1]) for heading in outline.all("h1", "h2", "h3", "h4")]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_page_has_landmarks_and_working_links(outline: Element) -> None:
    """Header, navigation, main and footer exist once, and every link leads to an element."""
    for landmark in ("header", "nav", "main", "footer"):
        outline.one(landmark)
    identifiers = [element.attributes.get("id") for element in outline.all()]
    named = [identifier for identifier in identifiers if identifier]
    assert len(named) == len(set(named))
    targets = [str(link.attributes["href"]) for link in outline.all("a")]
    assert len(targets) > 5
    assert {target.removeprefix("#") for target in targets} <= set(named)


def test_every_picture_is_described(outline: Element) -> None:
    """Every image is described, in a row each differently, and every figure has a caption."""
    images = outline.one("main").all("img")
    descriptions = [str(image.attributes["alt"]) for image in images]
    assert len(images) > 50
    assert all(descriptions)
    for row in outline.all("div"):
        if str(row.attributes.get("class")).startswith("panels"):
            own = [image.attributes["alt"] for image in row.all("img")]
            assert len(set(own)) == len(own)
    assert all(figure.one("figcaption").text for figure in outline.all("figure"))
    assert all(plot.attributes["aria-hidden"] == "true" for plot in outline.all("svg"))


def test_every_table_is_captioned_and_its_headings_scoped(outline: Element) -> None:
    """Every table has a caption, every heading cell a scope, every row the same width."""
    identifiers = [table.attributes["id"] for table in outline.all("table")]
    assert identifiers == [
        *("entries", "entries-held-out", "differences", "objects-natural", "objects-laboratory"),
        *("sirfs-summary", "sirfs-natural-colour", "sirfs-laboratory-colour"),
        *("facts", "rows-behind"),
    ]
    for one in outline.all("table"):
        assert one.one("caption").text
        assert all("scope" in cell.attributes for cell in one.all("th"))
        widths = {
            sum(int(cell.attributes.get("colspan") or 1) for cell in row.all("th", "td"))
            for body in one.all("tbody")
            for row in body.all("tr")
        }
        assert len(widths) == 1


def test_wide_tables_scroll_by_keyboard(outline: Element) -> None:
    """Whatever scrolls sideways can be focused and has a name."""
    scrolling = [e for e in outline.all("div") if e.attributes.get("class") == "scroll"]
    assert len(scrolling) >= 4
    assert all(e.attributes["tabindex"] == "0" for e in scrolling)
    identifiers = {e.attributes.get("id") for e in outline.all()}
    for element in scrolling:
        named = element.attributes.get("aria-labelledby")
        assert named in identifiers if named else element.attributes["aria-label"]


def test_page_needs_no_network(small_page: Path, outline: Element) -> None:
    """A page refers to nothing outside itself, runs one script of its own, and is not too large."""
    text = re.sub(r'src="data:[^"]*"', "", small_page.read_text(encoding="utf-8"))
    assert not re.search(r"https?://|//[a-z]|@import|url\((?!#)", text)
    assert outline.all("iframe", "object") == []
    assert outline.one("script").attributes == {}
    sources = [str(image.attributes["src"]) for image in outline.all("img")]
    assert all(source.startswith("data:image/") for source in sources)
    assert small_page.stat().st_size < LARGEST_PAGE


def test_numbers_are_those_of_the_document(outline: Element, small_result: SmallResult) -> None:
    """Table 1 on the page holds every measured and every published value of the document."""
    shown = [cell.text for cell in table(outline, "entries").all("td")]
    document = small_result.document
    for row in [*document["rows"], *document["baselines"]]:
        expected = f"{row['imse']:.5f} {100 * row['relative_imse']:.1f} %"
        assert expected in shown
    for row in document["published"]:
        assert f"{row['imse']:.4f}" in shown
    compared = [
        row.entries[rule]
        for setting in ("natural", "laboratory")
        for row in table1_rows(document, setting)
        for rule in ("regression", "oracle", "none")
        if rule in row.entries
    ]
    known = {f"{e.ratio:.2f} {e.word}" for e in compared if e.ratio is not None}
    assert sum(e.ratio is not None for e in compared) == 14
    assert known <= set(shown)


def test_values_by_object_are_those_of_the_document(
    outline: Element, small_result: SmallResult
) -> None:
    """The tables by object hold every object's oracle error, LMSE and residuals."""
    for setting in ("natural", "laboratory"):
        shown = table(outline, f"objects-{setting}").one("tbody")
        rows = {row.all("th")[0].text: row for row in shown.all("tr")}
        assert tuple(rows) == OBJECTS
        for own in small_result.document["intrinsic"]:
            if own["setting"] == setting:
                cells = [cell.text for cell in rows[own["object"]].all("td")]
                assert cells[-3:] == [
                    f"{own['lmse']:.4f}",
                    f"{own['point_light_residual']:.3f}",
                    f"{own['harmonic_residual']:.3f}",
                ]
        for row in small_result.document["objects"]:
            if row["setting"] == setting and row["weights"] == "oracle":
                assert f"{row['imse']:.5f}" in rows[row["object"]].text


def test_sirfs_stands_once_beside_both_rules(outline: Element, small_result: SmallResult) -> None:
    """The row of B+M has one number, one published value and no weights to choose."""
    shown = table(outline, "entries").all("tr")
    rows = [row for row in shown if row.all("th")[0].text == "B+M"]
    ours = [row["imse"] for row in small_result.document["rows"] if row["method"] == "sirfs"]
    assert len(rows) == len(ours) == 2
    for row, imse in zip(rows, ours, strict=True):
        assert f"{imse:.5f}" in row.text
        assert "no weights to choose" in row.text
        assert len([cell for cell in row.all("td") if "published" in cell.attributes["class"]]) == 1


def test_quick_run_is_stamped_and_not_incomplete(small_result: SmallResult, tmp_path: Path) -> None:
    """Without SIRFS the head, each table and the rows say so; the run lacks nothing else."""
    outline = read_html(small_result.write(tmp_path, **left_out(small_result.document)))
    header = outline.one("header").text
    assert "QUICK Without SIRFS" in header
    assert "INCOMPLETE" not in outline.text
    entries = table(outline, "entries")
    by_object = [table(outline, f"objects-{setting}") for setting in ("natural", "laboratory")]
    assert entries.one("caption").text.startswith("QUICK: without SIRFS.")
    for title, published in (("(b) B+M S", 2), ("B+M", 1)):
        rows = [row for row in entries.all("tr") if row.all("th")[0].text == title]
        assert len(rows) == 2
        for row in rows:
            assert LEFT_OUT in row.text
            assert len(re.findall(r"\d\.\d+", row.text)) == published
    assert all("B+M" not in one.one("thead").text for one in by_object)


def test_the_test_objects_have_a_table_of_their_own(
    outline: Element, small_result: SmallResult, tmp_path: Path
) -> None:
    """Entries over the objects that no prior has seen are shown where there are any."""
    shown = [cell.text for cell in table(outline, "entries-held-out").all("td")]
    for row in small_result.document["test_rows"]:
        assert f"{row['imse']:.5f} {100 * row['relative_imse']:.1f} %" in shown
    assert BASELINE not in table(outline, "entries-held-out").text
    assert 'id="entries-held-out"' not in small_result.write(tmp_path, test_rows=[])


def test_values_of_sirfs_stand_by_object(outline: Element, small_result: SmallResult) -> None:
    """Each object's error of B+M and of the models with its shading are in the tables by object."""
    tables = [table(outline, f"objects-{setting}") for setting in ("natural", "laboratory")]
    shown = {cell.text for one in tables for cell in one.all("td")}
    for row in small_result.document["objects"]:
        if row["weights"] in {"none", "oracle"}:
            assert f"{row['imse']:.5f}" in shown


def test_synthetic_set_is_stamped(outline: Element) -> None:
    """A page of the synthetic set says so at its head, and does not cite the photographs."""
    assert "SYNTHETIC SET" in outline.one("header").text
    assert "INCOMPLETE" not in outline.text
    assert "Grosse" not in outline.one("main").all("section")[-1].text


def test_missing_cells_are_stamped(small_result: SmallResult, tmp_path: Path) -> None:
    """A page of a run with missing cells or entries says INCOMPLETE, and why."""
    rows = copy.deepcopy(small_result.document["rows"])
    rows[0] |= {"imse": None, "relative_imse": None}
    text = small_result.write(
        tmp_path, rows=rows, provenance=provenance(cells_missing=4).document()
    )
    header = read_html(text).one("header").text
    assert "INCOMPLETE 4 cells were not measured; 1 table entries have no value" in header
    assert "missing" in table(read_html(text), "entries").text


def test_subset_of_objects_is_incomplete(small_result: SmallResult) -> None:
    """A result on some objects of a set is not the table of the set."""
    assert missing_reasons(small_result.document, len(OBJECTS)) == ()
    assert missing_reasons(small_result.document, 20) == ("3 of 20 objects are reported",)


def test_missing_cells_are_named(small_result: SmallResult, tmp_path: Path) -> None:
    """The stamp lists the cells that are missing with the reasons, and counts those it leaves."""
    cell = {"object": "cup", "light": "3", "reason": "MemoryError"}
    header = read_html(small_result.write(tmp_path, missing=[cell] * 15)).one("header")
    assert "INCOMPLETE 15 cells are missing" in header.text
    outline = read_html((tmp_path / PAGE).read_text(encoding="utf-8"))
    stamped = ("entries", "differences", "objects-natural", "objects-laboratory")
    captions = [table(outline, name).one("caption").text for name in stamped]
    assert all(caption.startswith("INCOMPLETE: 15 cells missing.") for caption in captions)
    listed = [item.text for item in header.all("li")]
    assert listed[0] == "cup, 3: MemoryError"
    assert listed[-1] == "and 3 more, all in results/table1.json"


def test_same_result_gives_same_bytes(small_page: Path, small_result: SmallResult) -> None:
    """Two reports of one result, drawn anew, are equal byte for byte."""
    again = small_page.with_name("again")
    small_result.write(again)
    for name in (PAGE, PRINTED):
        assert (again / name).read_bytes() == small_page.with_name(name).read_bytes()


def test_text_of_the_document_is_escaped(small_result: SmallResult, tmp_path: Path) -> None:
    """Text from a document appears as text, never as markup."""
    machine = "<script>alert('x')</script> & co"
    page = small_result.write(tmp_path, provenance=provenance(machine=machine).document())
    outline = read_html(page)
    assert len(outline.all("script")) == 1
    assert machine in table(outline, "facts").text


def test_unwritable_place_is_one_sentence(small_result: SmallResult, tmp_path: Path) -> None:
    """A page cannot be written where a file takes the place of its folder; nothing is left."""
    (tmp_path / "file").write_text("taken", encoding="utf-8")
    with pytest.raises(RelightlabError, match=r"cannot write .*choose another output"):
        small_result.write(tmp_path / "file" / "report")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_another_dataset_or_other_lights_are_refused(
    small_result: SmallResult, tmp_path: Path
) -> None:
    """Pictures of another set, or under other lights, are not put beside the numbers."""
    foreign = provenance(dataset="mit-berkeley").document()
    with pytest.raises(RelightlabError, match="measured on mit-berkeley but the pictures"):
        small_result.write(tmp_path, provenance=foreign)
    with pytest.raises(RelightlabError, match="4 lights but 1 were given"):
        write_report(
            tmp_path,
            document=small_result.document,
            dataset=small_result.dataset,
            lights=small_result.lights[:1],
            parameters=small_result.parameters,
        )
    with pytest.raises(RelightlabError, match="reports no object"):
        small_result.write(tmp_path, intrinsic=[], objects=[])
    assert list(tmp_path.iterdir()) == []


def test_published_values_confirm_themselves(small_result: SmallResult) -> None:
    """Every ordering holds for the published table itself, whatever its scale."""
    verdict = table1_verdict(published_alone(small_result.document))
    assert {finding.state for finding in verdict.findings} == {"holds"}
    assert (verdict.pairs_alike, verdict.pairs) == (91, 91)
    assert verdict.sentence.startswith("All 8 of the paper's orderings")


def test_quick_run_is_judged_on_what_it_has(small_result: SmallResult) -> None:
    """Without SIRFS, the orderings that need it are not measured and the others are judged."""
    verdict = table1_verdict(left_out(published_alone(small_result.document)))
    assert [finding.state for finding in verdict.findings] == ["holds"] * 4 + ["not measured"] * 4
    assert (verdict.pairs_alike, verdict.pairs) == (28, 28)


def test_reversed_values_contradict_the_paper(small_result: SmallResult) -> None:
    """A table in the opposite order confirms no ordering."""
    document = published_alone(small_result.document)
    rows = [row | {"imse": 1e-4 / row["imse"]} for row in document["rows"]]
    verdict = table1_verdict(document | {"rows": rows})
    assert {finding.state for finding in verdict.findings} == {"does not hold"}
    assert verdict.pairs_alike == 0
    assert verdict.sentence.startswith("0 of the 8 of the paper's orderings")


def test_one_contrary_value_is_named(small_result: SmallResult) -> None:
    """An ordering that fails in one place holds in part, and its evidence shows where."""
    document = published_alone(small_result.document)
    contrary = {"setting": "natural", "detail_source": "default", "weights": "oracle"}
    rows = [
        row | ({"imse": 1.0} if contrary.items() <= row.items() else {}) for row in document["rows"]
    ]
    finding = table1_verdict(document | {"rows": rows}).findings[0]
    assert (finding.state, finding.held, finding.compared) == ("holds in part", 5, 6)
    assert "natural, default: 1.00 ≥ 0.0036" in finding.evidence


def test_nothing_measured_is_no_verdict(small_result: SmallResult) -> None:
    """Without entries no ordering is judged."""
    verdict = table1_verdict(small_result.document | {"rows": []})
    assert {finding.state for finding in verdict.findings} == {"not measured"}
    assert "Too few entries" in verdict.sentence
    assert all(not finding.compared for finding in detail_effect({"rows": []}))


def test_oracle_never_loses_to_the_coarse_shading(small_result: SmallResult) -> None:
    """The effect of detail is shown for each rule, and the oracle is never worse than none."""
    effect = {f.statement.split()[0]: f for f in detail_effect(small_result.document)}
    assert tuple(effect) == ("Oracle", "Regression", "Manual", "Default")
    assert effect["Oracle"].state == "holds"


def test_ratio_needs_both_values() -> None:
    """A ratio is ours over published, and nothing without either."""
    assert Entry(imse=0.1, published=0.4).ratio == 0.25
    assert Entry(published=0.4).ratio is None
    assert Entry(imse=0.1).ratio is None


@pytest.mark.parametrize(
    ("imse", "word"), [(0.43, "alike"), (0.37, "alike"), (0.45, "higher"), (0.35, "lower")]
)
def test_ratio_has_a_word(imse: float, word: str) -> None:
    """Within a tenth of the published value an entry is alike, else lower or higher."""
    assert Entry(imse=imse, published=0.4).word == word
    assert Entry(imse=imse).word == ""


def test_baseline_is_the_last_row(small_result: SmallResult) -> None:
    """The flat shape is shown below the published rows, with its one value."""
    last = table1_rows(small_result.document, "natural")[-1]
    assert last.title == BASELINE
    assert last.entries["coarse"].imse == small_result.document["baselines"][0]["imse"]


def test_rows_of_the_user_stand_beside_ours(small_result: SmallResult, tmp_path: Path) -> None:
    """A user's method, model and weight rule have rows of Table 1, and values by object."""
    document = small_result.document
    first = document["rows"][0]
    number = {"imse": 0.123456, "relative_imse": 0.25}
    added = [
        first | number | {"method": "mine", "detail_source": "own", "weights": "none"},
        first | number | {"method": "ours + flat", "weights": "oracle", "imse": 0.234567},
        first | number | {"weights": "halves", "imse": 0.345678},
    ]
    own_objects = [row | {"object": "cup"} for row in added]
    changes = {"rows": [*document["rows"], *added], "own_objects": own_objects}
    outline = read_html(small_result.write(tmp_path, **changes))
    entries = table(outline, "entries").all("tr")
    rows = {row.all("th")[0].text: row.text for row in entries}
    assert "0.12346" in rows["mine"]
    assert "0.23457" in rows["ours + flat, (a) default"]
    assert "0.34568" in rows["ours, (a) default, halves"]
    own = table(outline, "objects-own")
    assert [row.all("td")[1].text for row in own.one("tbody").all("tr")] == [
        *("mine", "ours + flat", "ours")
    ]
    assert table1_verdict(document | changes) == table1_verdict(document)


def test_protocol_is_printed_whole(outline: Element) -> None:
    """Every choice of the protocol's docstring stands on the page."""
    from evaluation import table1

    sections = protocol_sections(table1.__doc__ or "")
    assert [term for term, _ in sections][:3] == ["Objects and settings", "Lights", "Target"]
    indented = [line for line in (table1.__doc__ or "").splitlines() if line.startswith("    ")]
    assert " ".join(text for _, text in sections).split() == " ".join(indented).split()
    assert [term.text for term in outline.all("dt")] == [term for term, _ in sections]
