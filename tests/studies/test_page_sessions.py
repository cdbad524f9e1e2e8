"""A study in a browser: whole sessions, and sessions in which something goes wrong."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium.webdriver import Chrome
from selenium.webdriver.common.keys import Keys

from studies.page_build import build_page
from tests.browser import start_browser
from tests.studies.page_subject import PageSubject
from tests.studies.served_study import ServedStudy, visible_study, wait_until
from tests.studies.small_study import IDS

pytestmark = pytest.mark.browser
ALL = [0, 1, 2, 3, 4]
INJECTED = "</textarea><script>alert(3)</script>"
BLOCKED_STORAGE = "Storage.prototype.setItem = () => { throw new DOMException('no'); };"


@pytest.fixture(scope="module")
def browser() -> Iterator[Chrome]:
    """A browser for all tests, each of which has an origin of its own in it."""
    build_page()
    driver = start_browser()
    yield driver
    driver.quit()


@pytest.fixture
def subject(browser: Chrome) -> Iterator[PageSubject]:
    """A subject at a desktop, whose network is whole before and after."""
    subject = PageSubject(browser)
    subject.resize(1280, 800)
    yield subject
    subject.set_offline(False)
    browser.get("about:blank")
    browser.get_log("browser")


@pytest.fixture
def served(tmp_path: Path) -> Iterator[ServedStudy]:
    """A study without panel, served."""
    served = ServedStudy(visible_study(tmp_path), tmp_path)
    yield served
    served.stop()


def query(ids: dict[str, str]) -> str:
    """Return ids as the end of an address."""
    return "?" + "&".join(f"{name}={value}" for name, value in ids.items())


def test_whole_session_by_pointer(subject: PageSubject, tmp_path: Path) -> None:
    """By pointer alone, every answer arrives as given, and texts and comments stay texts."""
    served = ServedStudy(visible_study(tmp_path, ids=True), tmp_path)
    try:
        subject.browser.get(served.address + query(IDS))
        subject.await_heading("Pictures <img src=x onerror=alert(1)>")
        assert served.read().subjects.empty  # nothing before consent
        subject.pass_screens("Pair")
        for number, side in enumerate(["left", "right", "right", "left"], start=1):
            subject.await_pair(number)
            subject.click(f".picture.{side}")
        subject.await_pair(5)
        subject.click(".tie")
        subject.fill_questionnaire("31", INJECTED)
        subject.click("#jspsych-survey-html-form-next")
        subject.await_heading("Finished")
        data = served.read()
        assert data.trials["response"].tolist() == ["left", "right", "right", "left", "tie"]
        assert data.trials["reaction_ms"].between(100, 60_000).all()
        assert (data.trials["shown_ms"] <= data.trials["reaction_ms"]).all()
        assert set(data.trials["display_width"]) == {1280.0}
        answers = dict(
            zip(data.questionnaires["question"], data.questionnaires["answer"], strict=True)
        )
        assert answers == {"gender": "female", "age": "31", "comment": INJECTED}
        assert data.subjects["status"].tolist() == ["complete"]
        code = subject.text("#code")
        assert len(code) == 12
        link = subject.all("#redirect")[0].get_attribute("href")
        assert link == f"https://panel.example/complete?cc={code}"
        assert subject.browser.get_log("browser") == []  # no fault, and nothing against the policy
    finally:
        served.stop()


def test_whole_session_by_keyboard(subject: PageSubject, served: ServedStudy) -> None:
    """By keys alone, in a window of 400 pixels, a pilot session works and is marked as one."""
    subject.resize(400, 700)
    subject.browser.get(served.address + "?mode=pilot")
    subject.pass_screens("Pictures", by_key=True)
    assert subject.text("#pilot").startswith("Pilot.")
    assert subject.all("#pilot")[0].is_displayed()
    subject.pass_screens("Pair", by_key=True)
    for number, key in enumerate([Keys.ARROW_LEFT, "2", Keys.ARROW_DOWN], start=1):
        subject.await_pair(number)
        assert not subject.has_overflow()
        subject.press(key)
    subject.await_pair(4)
    subject.press(Keys.TAB, Keys.TAB, Keys.ENTER)
    subject.await_pair(5)
    subject.press(Keys.TAB, Keys.SPACE)
    subject.await_heading("A few questions")
    assert not subject.has_overflow()
    subject.press(Keys.TAB, Keys.SPACE, Keys.TAB, "44", Keys.TAB, Keys.TAB, "fine", Keys.TAB)
    subject.press(Keys.ENTER)
    subject.await_heading("Finished")
    data = served.read()
    assert data.trials["response"].tolist() == ["left", "right", "tie", "right", "left"]
    assert data.subjects["mode"].tolist() == ["pilot"]
    answers = dict(zip(data.questionnaires["question"], data.questionnaires["answer"], strict=True))
    assert answers == {"gender": "male", "age": "44", "comment": "fine"}


def test_network_lost_and_found(subject: PageSubject, served: ServedStudy, tmp_path: Path) -> None:
    """Without a network trials go on, the page says so and gives a file; later all is sent."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 2)
    wait_until(lambda: served.answered() == [0, 1], "two answers")
    subject.set_offline(True)
    subject.answer_pairs(3, 5)
    subject.fill_questionnaire("50", "offline")
    subject.click("#jspsych-survey-html-form-next")
    subject.await_heading("Sending your answers")
    wait_until(lambda: "cannot be sent" in subject.text("#notice"), "the notice")
    subject.save_file(tmp_path)
    file = tmp_path / "study-answers.json"
    wait_until(file.exists, "the file")
    unsent = json.loads(file.read_text(encoding="utf-8"))["unsent"]
    places = [entry["path"].split("/", 3)[3] for entry in unsent if entry["method"] == "PUT"]
    assert places == ["trials/2", "trials/3", "trials/4", "questionnaire"]
    assert subject.all("#code") == []
    assert served.answered() == [0, 1]
    subject.set_offline(False)
    subject.await_heading("Finished")
    assert served.answered() == ALL
    assert subject.text("#notice") == ""


def test_reload_closed_tab_and_back(subject: PageSubject, served: ServedStudy) -> None:
    """After a reload, the back button or a closed tab, the subject goes on where they were."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 1)
    subject.await_pair(2)
    subject.browser.refresh()
    subject.await_heading("Welcome back")
    assert "1 of 5 pairs" in subject.text("#study")
    subject.pass_screens("Pair")
    subject.answer_pairs(2, 2, "2")
    subject.await_pair(3)
    subject.browser.get(served.address + "healthz")
    subject.browser.back()
    subject.pass_screens("Pair")
    subject.answer_pairs(3, 3)
    subject.await_pair(4)
    old = subject.browser.current_window_handle
    subject.browser.switch_to.new_window("tab")
    new = subject.browser.current_window_handle
    subject.browser.switch_to.window(old)
    subject.browser.close()
    subject.browser.switch_to.window(new)
    subject.resize(1280, 800)
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(4, 5)
    subject.fill_questionnaire("20", "kept")
    subject.browser.refresh()
    subject.pass_screens("Welcome back")
    subject.pass_screens("A few questions")
    assert subject.all("textarea")[0].get_attribute("value") == "kept"
    subject.click("#jspsych-survey-html-form-next")
    subject.await_heading("Finished")
    code = subject.text("#code")
    subject.browser.refresh()
    subject.await_heading("Finished")
    assert subject.text("#code") == code
    subject.click(".aside button")  # the next person at a laboratory's computer
    subject.pass_screens("Pictures")
    data = served.read()
    assert data.trials["response"].tolist() == ["left", "right", "left", "left", "left"]
    assert len(data.subjects) == 1


def test_the_next_person_does_not_go_on_for_the_last(
    subject: PageSubject, served: ServedStudy
) -> None:
    """Whoever finds another's unfinished session in the browser begins one of their own."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 2)
    wait_until(lambda: served.answered() == [0, 1], "two answers")
    subject.browser.get(served.address)
    subject.pass_screens("Welcome back")
    subject.click("#study button:nth-of-type(2)")
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 1)
    wait_until(lambda: len(served.read().trials) == 3, "three answers")
    counts = served.read().trials["subject"].value_counts()
    assert sorted(counts) == [1, 2]
    subject.answer_pairs(2, 5)
    subject.fill_questionnaire("20", "secret")
    subject.browser.refresh()
    subject.pass_screens("Welcome back")
    subject.click("#study button:nth-of-type(2)")
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 5)
    subject.await_heading("A few questions")
    assert subject.all("textarea")[0].get_attribute("value") == ""


def test_refused_answers_are_given_as_a_file(
    subject: PageSubject, served: ServedStudy, tmp_path: Path
) -> None:
    """What the server will not have, here of a subject deleted meanwhile, is kept and said."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.await_pair(1)
    served.forget_subjects()
    subject.press("1")
    wait_until(lambda: "did not accept" in subject.text("#notice"), "the notice")
    subject.save_file(tmp_path)
    file = tmp_path / "study-answers.json"
    wait_until(file.exists, "the file")
    assert json.loads(file.read_text(encoding="utf-8"))["unsent"][0]["body"]["response"] == "left"
    subject.click("#notice button:last-of-type")
    wait_until(lambda: not subject.text("#notice"), "an empty notice")
    subject.browser.refresh()
    subject.pass_screens("Pictures")


def test_server_restarted(subject: PageSubject, served: ServedStudy) -> None:
    """Answers given while the server is away survive a reload and arrive when it is back."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 1)
    wait_until(lambda: served.answered() == [0], "one answer")
    served.stop()
    subject.answer_pairs(2, 4)
    subject.await_pair(5)
    served.start()
    subject.browser.refresh()
    subject.pass_screens("Pair")
    subject.answer_pairs(5, 5)
    wait_until(lambda: served.answered() == ALL, "all answers")
    assert len(served.read().trials) == len(ALL)


def test_two_tabs(subject: PageSubject, served: ServedStudy) -> None:
    """A second tab takes the session over, the first says so, and no answer counts twice."""
    subject.browser.get(served.address)
    subject.pass_screens("Pair")
    subject.answer_pairs(1, 2)
    subject.await_pair(3)
    first = subject.browser.current_window_handle
    subject.browser.switch_to.new_window("tab")
    subject.resize(1280, 800)
    subject.browser.get(served.address)
    subject.await_heading("Welcome back")
    second = subject.browser.current_window_handle
    subject.browser.switch_to.window(first)
    subject.await_heading("The study is open in another tab")
    subject.press("2")
    subject.click("#study button")
    subject.await_heading("Welcome back")
    subject.browser.switch_to.window(second)
    subject.await_heading("The study is open in another tab")
    subject.browser.close()
    subject.browser.switch_to.window(first)
    subject.pass_screens("Pair")
    subject.answer_pairs(3, 5)
    wait_until(lambda: served.answered() == ALL, "all answers")
    assert served.read().trials["response"].tolist() == ["left"] * 5


def test_blocked_storage(subject: PageSubject, served: ServedStudy) -> None:
    """Where the browser keeps nothing, answers arrive all the same, and a reload goes on."""
    script = {"source": BLOCKED_STORAGE}
    method = "Page.addScriptToEvaluateOnNewDocument"
    added = subject.browser.execute_cdp_cmd(method, script)
    try:
        subject.browser.get(served.address)
        subject.pass_screens("Pair")
        subject.answer_pairs(1, 2)
        wait_until(lambda: served.answered() == [0, 1], "two answers")
        subject.browser.refresh()
        subject.await_heading("Welcome back")
        subject.pass_screens("Pair")
        subject.answer_pairs(3, 3)
        wait_until(lambda: served.answered() == [0, 1, 2], "three answers")
        assert "storage-blocked" in served.read().events["event"].tolist()
    finally:
        method = "Page.removeScriptToEvaluateOnNewDocument"
        subject.browser.execute_cdp_cmd(method, added)
