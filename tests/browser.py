"""A browser without a window, as the tests of pages use it."""

from __future__ import annotations

import shutil

import pytest
from selenium.common.exceptions import WebDriverException
from selenium.webdriver import Chrome, ChromeOptions
from selenium.webdriver.chrome.service import Service

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def start_browser() -> Chrome:
    """Return a browser without a window; skips where there is none."""
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    driver = shutil.which("chromedriver")
    if browser is None or driver is None:
        missing = "a Chromium" if browser is None else "chromedriver"
        pytest.skip(f"{missing} was not found (Debian: chromium and chromium-driver)")
    options = ChromeOptions()
    options.binary_location = browser
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    try:
        return Chrome(options=options, service=Service(driver))
    except WebDriverException as error:
        pytest.skip(f"Chromium did not start: {error.msg}")


def luminance(rgb: list[int]) -> float:
    """Return the relative luminance of a colour (WCAG 2.2)."""
    linear = [
        v / 12.92 if (v := part / 255) <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for part in rgb
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
