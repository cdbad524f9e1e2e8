"""The page as a browser shows it: nothing overflows, nothing fails to load, dark mode is dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from reports.table1_report import PAGE
from tests.browser import luminance, start_browser
from tests.reports.rival_rows import left_out
from tests.reports.small_result import SmallResult, small_result

__all__ = ["small_result"]
pytestmark = [pytest.mark.browser, pytest.mark.slow]
DARKEST_LIGHT_PAGE, LIGHTEST_DARK_PAGE = 200, 60
LEAST_CONTRAST = 4.5


@pytest.fixture(scope="module")
def page(small_result: SmallResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with everything on it: SIRFS in one setting, entries left out in the other."""
    folder = tmp_path_factory.mktemp("report")
    small_result.write(folder, **left_out(small_result.document, ("natural",)))
    return folder / PAGE


@pytest.fixture(scope="module")
def browser(page: Path) -> Iterator[Chrome]:
    """A browser that shows the page."""
    driver = start_browser()
    driver.get(page.as_uri())
    yield driver
    driver.quit()


def resize(browser: Chrome, width: int, scheme: str = "light", media: str = "screen") -> None:
    """Show the page at a width, in a colour scheme, on screen or paper."""
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": features})


def colour(browser: Chrome, selector: str, quantity: str) -> list[int]:
    """Return a computed colour as red, green, blue."""
    script = "return getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]"
    text = str(browser.execute_script(script, selector, quantity))
    return [int(part) for part in text[text.index("(") + 1 : -1].split(",")[:3]]


@pytest.mark.parametrize("width", [400, 1400])
def test_nothing_overflows(browser: Chrome, width: int) -> None:
    """Neither a telephone nor a wide screen has to scroll the page sideways."""
    resize(browser, width)
    widths = browser.execute_script(
        "document.querySelectorAll('details').forEach(d => d.open = true);"
        "return [document.documentElement.scrollWidth, window.innerWidth]"
    )
    assert widths[0] <= widths[1] == width


def test_wide_tables_scroll_inside_themselves(browser: Chrome) -> None:
    """On a telephone Table 1 is wider than its frame, and arrow keys move it."""
    resize(browser, 400)
    frame = browser.find_element(By.CSS_SELECTOR, ".scroll")
    moved = "return [arguments[0].scrollWidth - arguments[0].clientWidth, arguments[0].scrollLeft]"
    assert browser.execute_script(moved, frame)[0] > 0
    browser.execute_script("arguments[0].focus()", frame)
    browser.switch_to.active_element.send_keys(Keys.ARROW_RIGHT)
    browser.execute_async_script("setTimeout(arguments[0], 400)")
    assert browser.execute_script(moved, frame)[1] > 0


def test_every_picture_is_shown(browser: Chrome) -> None:
    """Every image decodes, to the size the page reserves for it."""
    resize(browser, 1400)
    images = browser.execute_script(
        "return [...document.images].map("
        "  i => [i.complete, i.naturalWidth, +i.getAttribute('width')])"
    )
    assert len(images) > 50
    assert all(complete and own == reserved > 0 for complete, own, reserved in images)


def test_browser_reports_nothing(browser: Chrome) -> None:
    """The console holds no error, and the page asked for nothing but itself."""
    assert browser.get_log("browser") == []
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out(browser: Chrome, scheme: str) -> None:
    """Text of every colour reaches the contrast WCAG asks for, in light and in dark mode."""
    resize(browser, 1400, scheme)
    paper = colour(browser, "body", "backgroundColor")
    dark = max(paper) < LIGHTEST_DARK_PAGE
    assert dark if scheme == "dark" else min(paper) > DARKEST_LIGHT_PAGE
    for selector in ("body", "small", "nav a", ".caption", ".state", ".absent", "svg text"):
        quantity = "fill" if selector == "svg text" else "color"
        bright, dim = sorted(
            [luminance(paper), luminance(colour(browser, selector, quantity))], reverse=True
        )
        assert (bright + 0.05) / (dim + 0.05) >= LEAST_CONTRAST, selector


def test_paper_is_white(browser: Chrome) -> None:
    """Printed, even from dark mode, the page is black on white and without its navigation."""
    resize(browser, 800, "dark", "print")
    assert colour(browser, "body", "backgroundColor") == [255, 255, 255]
    assert colour(browser, "body", "color") == [0, 0, 0]
    assert not browser.find_element(By.TAG_NAME, "nav").is_displayed()


def test_tables_are_sorted_by_pointer_and_keyboard(browser: Chrome) -> None:
    """A heading sorts the rows of each group up, then down; entries without a value stay last."""
    resize(browser, 1400)
    column = (
        "return [...document.querySelectorAll('#entries tbody:first-of-type tr:not(.group)')]"
        ".map(row => row.cells[0].textContent)"
    )
    before = browser.execute_script(column)
    button = browser.find_element(By.CSS_SELECTOR, "#entries thead th[data-column='1'] button")
    values = (
        "return [...document.querySelectorAll('#entries tbody:first-of-type tr:not(.group)')]"
        ".map(row => parseFloat(row.cells[1].textContent))"
    )
    browser.execute_script("arguments[0].click()", button)
    up = browser.execute_script(values)
    assert up[:3] == sorted(up[:3])
    assert None not in up[:3]
    button.send_keys(Keys.ENTER)
    down = browser.execute_script(values)
    assert down[:3] == up[:3][::-1]
    assert sorted(browser.execute_script(column)) == sorted(before)
    sorted_heads = browser.find_elements(By.CSS_SELECTOR, "#entries [aria-sort]")
    assert [head.get_attribute("aria-sort") for head in sorted_heads] == ["descending"]


def test_equations_are_drawn(browser: Chrome) -> None:
    """Every equation takes the room of a formula, and none is wider than a wide screen."""
    resize(browser, 1400)
    boxes = browser.execute_script(
        "return [...document.querySelectorAll('math')].map(m => [m.getBoundingClientRect().width,"
        " m.getBoundingClientRect().height])"
    )
    assert len(boxes) == 3
    assert all(100 < width < 900 and 15 < height < 120 for width, height in boxes)
