"""Tests of reports.html_renderer: colours, security policy, headings."""

from __future__ import annotations

import base64
import hashlib
import re
from importlib.resources import files
from pathlib import Path

import pytest

from reports.html_renderer import html_text, write_html
from shading_model.errors import RelightlabError
from tests.reports.html_outline import read_html
from tests.reports.small_result import SmallResult, small_page, small_result

__all__ = ["small_page", "small_result"]
LEAST_CONTRAST = 4.5


def themes() -> list[dict[str, str]]:
    """Return the colours of the style sheet's themes by name: light, dark, print."""
    text = files("reports").joinpath("templates", "page.css").read_text(encoding="utf-8")
    blocks = re.findall(r":root \{(.*?)\}", text, flags=re.DOTALL)
    return [dict(re.findall(r"--(\w+): (#[0-9a-f]{3,6});", block)) for block in blocks]


def luminance(colour: str) -> float:
    """Return the relative luminance of a hexadecimal colour (WCAG 2.2)."""
    digits = colour[1:] if len(colour) == 7 else "".join(2 * digit for digit in colour[1:])
    parts = [int(digits[place : place + 2], 16) / 255 for place in (0, 2, 4)]
    red, green, blue = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours."""
    bright, dim = sorted([luminance(one), luminance(other)], reverse=True)
    return (bright + 0.05) / (dim + 0.05)


def test_contrast_of_black_and_white() -> None:
    """The ratio is WCAG's: 21 for black on white, 1 for a colour on itself."""
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#a84300", "#a84300") == 1


@pytest.mark.parametrize("place", [0, 1, 2], ids=["light", "dark", "print"])
def test_text_colours_stand_out(place: int) -> None:
    """Every colour of text reaches 4.5 on the paper and on the wash, in each theme."""
    theme = themes()[place]
    for text in ("ink", "quiet", "accent", "good", "bad"):
        for ground in ("paper", "wash"):
            assert contrast(theme[text], theme[ground]) >= LEAST_CONTRAST, (text, ground)


def test_only_the_own_script_may_run(small_page: Path) -> None:
    """The policy allows the one script by its hash and forbids to load anything."""
    outline = read_html(text := small_page.read_text(encoding="utf-8"))
    (policy,) = [e for e in outline.all("meta") if "http-equiv" in e.attributes]
    script = text[text.index("<script>") + len("<script>") : text.index("</script>")]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    content = str(policy.attributes["content"])
    assert f"script-src 'sha256-{digest}'" in content
    assert content.startswith("default-src 'none';")


def test_headings_are_those_of_the_content(small_result: SmallResult) -> None:
    """Each section of the content is a section of the page, in the same order, and in its menu."""
    report = small_result.report()
    outline = read_html(html_text(report))
    titles = [section.title for section in report.sections]
    assert [heading.text for heading in outline.all("h2")] == titles
    assert [link.text for link in outline.one("nav").all("a")] == titles
    assert outline.one("h1").text == report.title


def test_captions_name_their_rows(small_result: SmallResult) -> None:
    """Table 1 shows the beginning of the hash that the provenance has whole."""
    report = small_result.report()
    outline = read_html(html_text(report))
    tables = {str(table.attributes["id"]): table for table in outline.all("table")}
    whole = [cell.text for cell in tables["rows-behind"].all("code") if len(cell.text) == 64]
    shown = tables["entries"].one("caption").one("code").text
    assert whole[0].startswith(shown)
    assert len(whole) == len(tables["rows-behind"].one("tbody").all("tr"))


def test_tables_are_marked_for_sorting(small_result: SmallResult) -> None:
    """Each column of a sortable table has exactly one heading that sorts by it."""
    outline = read_html(html_text(small_result.report()))
    tables = outline.all("table")
    sortable = [t for t in tables if "sortable" in str(t.attributes["class"])]
    assert [t for t in tables if t.attributes["id"] != "facts"] == sortable
    for table in sortable:
        heads = [int(str(c)) for h in table.all("th") if (c := h.attributes.get("data-column"))]
        assert sorted(heads) == list(range(len(heads)))
        first = table.all("tbody")[-1].all("tr")[-1].all("th", "td")
        assert len(heads) == sum(int(cell.attributes.get("colspan") or 1) for cell in first)


def test_unwritable_page_is_one_sentence(small_result: SmallResult, tmp_path: Path) -> None:
    """A page that cannot be written is told in one sentence, and nothing is left."""
    (tmp_path / "file").write_text("taken", encoding="utf-8")
    with pytest.raises(RelightlabError, match="choose another output"):
        write_html(tmp_path / "file" / "index.html", small_result.report())
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
