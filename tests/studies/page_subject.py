"""A subject at the page of a study: looks at the screen, points, types, and loses the network."""

from __future__ import annotations

from pathlib import Path

from selenium.common.exceptions import (
    ElementNotInteractableException,
    StaleElementReferenceException,
)
from selenium.webdriver import ActionChains, Chrome
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.studies.served_study import wait_until

CHOICE = "#jspsych-html-button-response-btngroup button"


class PageSubject:
    """What tests do in a browser window.

    Parameters
    ----------
    browser : Chrome
    """

    def __init__(self, browser: Chrome) -> None:
        self.browser = browser

    def resize(self, width: int, height: int) -> None:
        """Give the window a size in CSS pixels."""
        self.browser.set_window_size(width, height)
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def set_offline(self, offline: bool) -> None:
        """Cut the network, or mend it."""
        self.browser.execute_cdp_cmd("Network.enable", {})
        conditions = {"offline": offline, "latency": 0}
        conditions |= {"downloadThroughput": -1, "uploadThroughput": -1}
        self.browser.execute_cdp_cmd("Network.emulateNetworkConditions", conditions)

    def all(self, selector: str) -> list[WebElement]:
        """Return the elements of a CSS selector."""
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        """Return the text of the first element of a CSS selector; empty if there is none."""
        script = "return document.querySelector(arguments[0])?.textContent ?? ''"
        return str(self.browser.execute_script(script, selector))

    def heading(self) -> str:
        """Return the heading of the screen."""
        return self.text("#study h1")

    def await_heading(self, text: str) -> None:
        """Wait for the screen with this heading."""
        wait_until(lambda: text in self.heading(), f"{text!r}, after {self.heading()!r}")

    def await_pair(self, number: int) -> None:
        """Wait until the pair of this number, from 1, can be answered."""
        start = f"Pair {number} of"
        wait_until(
            lambda: self.text(".pair .progress").startswith(start) and self.all(".picture:enabled"),
            start,
        )

    def click(self, selector: str) -> None:
        """Point at an element and click."""
        wait_until(lambda: self._is_clicked(selector), selector)

    def _is_clicked(self, selector: str) -> bool:
        """Click an element, unless it is not there or goes just then, and return whether it was."""
        try:
            found = self.all(selector)
            if found:
                found[0].click()
            return bool(found)
        except (StaleElementReferenceException, ElementNotInteractableException):
            return False

    def press(self, *keys: str) -> None:
        """Press keys, wherever the focus is."""
        ActionChains(self.browser).send_keys(*keys).perform()

    def pass_screens(self, until: str, *, by_key: bool = False) -> None:
        """Press the first button of each screen until one with this heading, or a pair, is there.

        Parameters
        ----------
        until : str
            Part of a heading; ``"Pair"`` for the first pair.
        by_key : bool
            Whether by Tab and Enter.
        """
        for _ in range(8):
            before = self._next_heading("", "Loading the pictures", "Sending your answers")
            if until in before or (until == "Pair" and self.all(".picture")):
                return
            if by_key:
                self.press(Keys.TAB, Keys.ENTER)
            else:
                self.click("#study button")
            self._next_heading(before)
        raise AssertionError(f"no screen {until!r}, but {self.heading()!r}")

    def _next_heading(self, *passing: str) -> str:
        """Wait for a heading other than these and return it."""
        seen = [passing[0]]
        wait_until(
            lambda: seen.append(self.heading()) or seen[-1] not in passing,
            f"what follows {passing[0]!r}",
        )
        return seen[-1]

    def answer_pairs(self, first: int, last: int, key: str = "1") -> None:
        """Answer pairs, counted from 1, by a key."""
        for number in range(first, last + 1):
            self.await_pair(number)
            self.press(key)

    def fill_questionnaire(self, age: str, comment: str) -> None:
        """Fill in the questionnaire by pointer and keys, without sending it."""
        self.await_heading("A few questions")
        self.click("input[type=radio][value=female]")
        self.all("input[type=number]")[0].send_keys(age)
        self.all("textarea")[0].send_keys(comment)

    def save_file(self, folder: Path) -> None:
        """Ask the page for the file with the unsent answers."""
        behavior = {"behavior": "allow", "downloadPath": str(folder)}
        self.browser.execute_cdp_cmd("Browser.setDownloadBehavior", behavior)
        self.click("#notice button:last-of-type")

    def has_overflow(self) -> bool:
        """Return whether the page is wider than the window."""
        script = "return document.documentElement.scrollWidth > window.innerWidth"
        return bool(self.browser.execute_script(script))
