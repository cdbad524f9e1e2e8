"""The screens of a study in a browser: who is let in, what is shown how, and for everyone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from selenium.webdriver import Chrome
from selenium.webdriver.common.keys import Keys

from studies.page_build import build_page
from tests.browser import luminance, start_browser
from tests.studies.page_subject import PageSubject
from tests.studies.served_study import HEIGHT, WIDTH, ServedStudy, visible_study, wait_until

pytestmark = pytest.mark.browser
LEAST_CONTRAST = 4.5
LEAST_TARGET = 44
"""CSS pixels that a finger hits (WCAG 2.2, 2.5.5)."""
COLOURS = """
const behind = (element) => {
  for (let one = element; one; one = one.parentElement) {
    const colour = getComputedStyle(one).backgroundColor;
    if (!/, 0\\)$|transparent/.test(colour)) return colour;
  }
  return "rgb(255, 255, 255)";
};
const shown = [...document.querySelectorAll("body *")].filter((element) =>
  element.checkVisibility() && [...element.childNodes].some(
    (node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim()));
return shown.map((element) =>
  [element.textContent.slice(0, 40), getComputedStyle(element).color, behind(element)]);
"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Chrome]:
    """A browser for all tests, each of which has an origin of its own in it."""
    build_page()
    driver = start_browser()
    yield driver
    driver.quit()


@pytest.fixture
def subject(browser: Chrome) -> Iterator[PageSubject]:
    """A subject at a desktop."""
    subject = PageSubject(browser)
    subject.resize(1280, 800)
    yield subject
    browser.get("about:blank")


@pytest.fixture
def served(tmp_path: Path) -> Iterator[ServedStudy]:
    """A study without panel, served."""
    served = ServedStudy(visible_study(tmp_path), tmp_path)
    yield served
    served.stop()


def accessible_controls(browser: Chrome) -> list[tuple[str, str]]:
    """Return role and name of everything that can be operated, as assistive software hears it."""
    nodes: list[dict[str, Any]] = browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})[
        "nodes"
    ]
    roles = {"button", "link", "radio", "textbox", "spinbutton", "progressbar"}
    return [
        (node["role"]["value"], node.get("name", {}).get("value", ""))
        for node in nodes
        if not node["ignored"] and node["role"]["value"] in roles
    ]


def check_contrast(subject: PageSubject) -> None:
    """Fail if a text on the screen stands out too little from what is behind it."""
    for text, *colours in subject.browser.execute_script(COLOURS):
        parts = [[int(n) for n in c[c.index("(") + 1 : -1].split(",")[:3]] for c in colours]
        dim, bright = sorted(luminance(rgb) for rgb in parts)
        assert (bright + 0.05) / (dim + 0.05) >= LEAST_CONTRAST, text


def check_targets(subject: PageSubject) -> None:
    """Fail if something to hit is smaller than a finger."""
    for control in subject.all("#study :is(button, a, .option, input:not([type=radio]), textarea)"):
        assert min(control.size.values()) >= LEAST_TARGET, control.get_attribute("outerHTML")


def focused(subject: PageSubject) -> str:
    """Return what has the focus: its name or text."""
    script = "const e = document.activeElement; return e.ariaLabel || e.textContent.trim()"
    return str(subject.browser.execute_script(script))


def test_screens_for_everyone(subject: PageSubject, served: ServedStudy) -> None:
    """Every screen starts at its heading; its controls have names, room and contrast."""
    subject.browser.get(served.address)
    seen = []
    for name in ("Pictures <img", "Instructions", "Full screen", "Pair"):
        subject.pass_screens(name)
        seen.append(focused(subject))
        assert seen[-1] == subject.heading()
        assert len(subject.all("h1")) == 1
        check_contrast(subject)
        check_targets(subject)
        assert all(label for _, label in accessible_controls(subject.browser))
    assert len(set(seen)) == 4
    subject.answer_pairs(1, 5)
    subject.await_heading("A few questions")
    check_contrast(subject)
    check_targets(subject)
    assert focused(subject) == "A few questions"
    controls = accessible_controls(subject.browser)
    assert ("spinbutton", "Age?") in controls
    assert all(label for _, label in controls)


def test_focus_goes_left_to_right(subject: PageSubject, served: ServedStudy) -> None:
    """From the question, Tab goes to the left picture, the right one and the tie.

    A key that is still held from the pair before does not answer.
    """
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.await_pair(1)
    order = []
    for _ in range(3):
        subject.press(Keys.TAB)
        order.append(focused(subject))
    assert order == ["Left picture", "Right picture", "No difference"]
    style = "return getComputedStyle(document.activeElement).outlineWidth"
    assert subject.browser.execute_script(style) == "3px"
    held = "document.dispatchEvent(new KeyboardEvent('keydown', {key: '1', repeat: true}))"
    subject.browser.execute_script(held)
    assert subject.text(".progress") == "Pair 1 of 5"


def picture_boxes(subject: PageSubject) -> list[tuple[float, float, float, float]]:
    """Return width, height, left and right end of each picture."""
    script = (
        "return [...document.querySelectorAll('.picture img')].map((image) => {"
        "const {width, height, left, right} = image.getBoundingClientRect();"
        "return [width, height, left, right]})"
    )
    return [tuple(box) for box in subject.browser.execute_script(script)]


def test_pictures_keep_their_shape(subject: PageSubject, served: ServedStudy) -> None:
    """Both pictures have one scale, even sides, and are never enlarged, at any size of window."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.await_pair(1)
    for size, least, most in [
        ((1280, 800), WIDTH, WIDTH),
        ((400, 700), 180, 200),
        ((1280, 800), WIDTH, WIDTH),
        ((1280, 330), 120, WIDTH - 1),  # too low for them
    ]:
        subject.resize(*size)

        def settled(least: int = least, most: int = most) -> bool:
            return least <= picture_boxes(subject)[0][0] <= most and not subject.has_overflow()

        wait_until(settled, f"pictures that fit {size}")
        (w, h, _, end), (other_w, other_h, start, _) = picture_boxes(subject)
        assert (w, h) == (other_w, other_h)
        assert w / h == pytest.approx(WIDTH / HEIGHT, rel=0.005)
        assert end <= start


def test_answers_too_soon_do_not_count(subject: PageSubject, tmp_path: Path) -> None:
    """Before the minimum view time neither key nor pointer answers."""
    study = visible_study(tmp_path)
    study = replace(study, settings=replace(study.settings, minimum_view_ms=60_000))
    served = ServedStudy(study, tmp_path)
    try:
        subject.browser.get(served.address)
        subject.pass_screens("Pair")
        subject.press("1", Keys.ARROW_RIGHT, "3")
        subject.click(".picture.left")
        subject.press("2")
        assert subject.text(".progress") == "Pair 1 of 5"
        assert len(subject.all("#study button:disabled")) == 3
        assert served.answered() == []
    finally:
        served.stop()


def test_declined(subject: PageSubject, served: ServedStudy) -> None:
    """Who does not agree leaves nothing behind."""
    subject.browser.get(served.address)
    subject.pass_screens("Pictures")
    subject.click("#study button:last-of-type")
    subject.await_heading("Thank you")
    assert served.read().subjects.empty
    stored = "return JSON.stringify(localStorage).includes('session')"
    assert not subject.browser.execute_script(stored)


def test_window_too_small(subject: PageSubject, served: ServedStudy) -> None:
    """A window that is too small is asked to grow, and goes on by itself when it has."""
    subject.resize(600, 250)
    subject.browser.get(served.address)
    subject.await_heading("This window is too small")
    wait_until(lambda: "at least 300 by 300" in subject.text("#study"), "the sizes")
    subject.resize(600, 700)
    wait_until(lambda: "too small" not in subject.heading(), "the next screen")
    subject.pass_screens("Pictures")
    assert served.read().subjects.empty


def test_devices_that_do_not_fit(subject: PageSubject, tmp_path: Path) -> None:
    """Who cannot enlarge the window, or only has fingers where a pointer is asked for, is told."""
    study = visible_study(tmp_path)
    settings = replace(study.settings, allow_touch=False)
    served = ServedStudy(replace(study, settings=settings), tmp_path)
    fingers = "Emulation.setTouchEmulationEnabled"
    try:
        subject.resize(600, 250)
        subject.browser.get(served.address)
        subject.click("#browser-check-max-size-btn")
        subject.await_heading("This device does not fit the study")
        subject.resize(600, 700)
        subject.browser.execute_cdp_cmd(fingers, {"enabled": True})
        subject.browser.get(served.address)
        subject.await_heading("This device does not fit the study")
        assert "a mouse or another pointer" in subject.text("#study")
        assert served.read().subjects.empty
    finally:
        subject.browser.execute_cdp_cmd(fingers, {"enabled": False})
        served.stop()


def test_pictures_that_do_not_load(subject: PageSubject, served: ServedStudy) -> None:
    """Pictures that do not load are asked for again, and no trial starts without them."""
    subject.browser.get(served.address)
    subject.pass_screens("Pictures")
    subject.browser.execute_cdp_cmd("Network.enable", {})
    subject.browser.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["*/stimuli/*"]})
    subject.click("#study button")
    subject.await_heading("Some pictures did not load")
    subject.browser.execute_cdp_cmd("Network.setBlockedURLs", {"urls": []})
    subject.click("#study button")
    subject.pass_screens("Pair")
    loaded = "return [...document.querySelectorAll('.picture img')].map((i) => i.naturalWidth)"
    assert subject.browser.execute_script(loaded) == [WIDTH, WIDTH]


def test_panel_without_ids(subject: PageSubject, tmp_path: Path) -> None:
    """A link without the panel's ids is told so in the server's own words."""
    served = ServedStudy(visible_study(tmp_path, ids=True), tmp_path)
    try:
        subject.browser.get(served.address)
        subject.pass_screens("The study cannot start")
        assert "the link lacks PROLIFIC_PID" in subject.text("#study")
    finally:
        served.stop()


def test_nothing_moves(subject: PageSubject, served: ServedStudy) -> None:
    """Where motion is unwanted, no element has a transition or an animation."""
    features = [{"name": "prefers-reduced-motion", "value": "reduce"}]
    subject.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    script = (
        "return [...document.querySelectorAll('*')].map((e) => getComputedStyle(e))"
        ".filter((s) => s.animationName !== 'none' || s.transitionDuration !== '0s').length"
    )
    assert subject.browser.execute_script(script) == 0
    subject.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
