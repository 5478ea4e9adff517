"""What a user must be able to rely on: what a lever writes, whose figures stand there, what a reload and a kill leave."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, still

pytestmark = pytest.mark.browser
MODEL = "xu2020"
PIN = "[data-lever='deviations.planet.position.y']"


@pytest.fixture
def context(browser: Any) -> Iterator[Any]:
    made = still(browser)
    yield made
    made.close()


@pytest.fixture
def tab(context: Any, cockpit: Cockpit) -> Iterator[Tab]:
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []


def typed(tab: Tab, text: str, lever: str = PIN) -> None:
    """Type into the box of a lever, and wait for its figure."""
    field = tab.page.locator(f"{lever} input.ck-box-number")
    rev = tab.rev
    field.fill(text)
    field.press("Enter")
    tab.painted(rev, "sharing")


def answer(tab: Tab, key: str) -> str:
    return " ".join(str(tab.page.locator(f"[data-answer={key}]").inner_text()).split())


def test_a_number_and_a_text_with_its_unit_are_the_same_train(tab: Tab) -> None:
    tab.painted(-1, "sharing")
    typed(tab, "40")
    number = answer(tab, "planet")
    assert re.search(r"1\.[1-9]", number)  # one pin that is off: one planet carries more
    for text in ("40 um", "0.04 mm", "4e-5 m"):
        typed(tab, "20")
        typed(tab, text)
        assert answer(tab, "planet") == number, text
        assert tab.page.locator(f"{PIN} input.ck-box-number").input_value() == "40"


def workers(cockpit: Cockpit) -> list[Any]:
    """Processes that compute or wait to: started by the server, without those that only watch over them."""
    import psutil

    found = psutil.Process(cockpit.process.pid).children()
    return [one for one in found if "spawn_main" in " ".join(one.cmdline())]


def begun(tab: Tab, words: str, name: str) -> Any:
    """A job of half a minute and more that was started in its tab; its bar."""
    tab.page.get_by_role("tab", name=words).click()
    job = tab.page.locator(f"[data-job={name}]")
    job.get_by_role("button", name="Run", exact=True).click()
    job.get_by_role("button", name="Cancel").wait_for()
    return job


def test_a_job_whose_process_is_killed_says_so_and_is_run_again(tab: Tab, cockpit: Cockpit) -> None:
    job = begun(tab, "Contact loss", "contact_loss")
    job.get_by_text("%").wait_for()
    typed(tab, "15")  # the state moves on meanwhile
    # jobs compute at a lower priority than the live process and the one that waits
    killed = [one for one in workers(cockpit) if one.nice() > 5]
    assert len(killed) == 1
    killed[0].kill()
    job.get_by_text("stopped: its process was killed (signal 9) at").wait_for()
    tab.page.get_by_role("tab", name="Jobs").click()
    row = tab.page.locator(".ck-job-row").first
    row.get_by_text("stopped: its process was killed").wait_for()
    row.get_by_role("button", name="Run again").click()
    job.get_by_role("button", name="Cancel").click()
    job.get_by_text("cancelled").wait_for()


def test_five_tabs_hold_four_workers_at_most(tab: Tab, context: Any, cockpit: Cockpit) -> None:
    tabs = [tab, *(Tab(context, cockpit.address) for _ in range(4))]
    most = 0
    for one in tabs:
        begun(one, "Contact loss", "contact_loss")
        begun(one, "Transient", "transient")
        most = max(most, len(workers(cockpit)))
    for one in tabs[1:]:
        one.page.get_by_role("tab", name="Jobs").click()
        assert one.page.locator(".ck-job-row").get_by_text("waits for another job").count() == 2
        most = max(most, len(workers(cockpit)))
    assert 3 <= most <= 4
    for one in tabs[1:]:
        one.page.close()
