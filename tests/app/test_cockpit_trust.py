"""What a user relies on: what a lever writes, whose figures stand there, what a reload and a kill leave."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, still

from epicyclic.cockpit.state.state import opened

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
    shown = Tab(context, cockpit.address, wait=False)
    shown.page.set_default_timeout(3 * PATIENCE)  # the first one waits for the live process to be warm
    shown.painted()
    yield shown
    assert shown.errors() == []


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
    found: dict[str, str] = {}
    for text, shown in (("40", "40"), ("20", "20"), ("40 um", "40"), ("0.02 mm", "20"), ("4e-5 m", "40")):
        typed(tab, text)
        assert answer(tab, "planet") == found.setdefault(shown, answer(tab, "planet")), text
        assert tab.page.locator(f"{PIN} input.ck-box-number").input_value() == shown
    assert re.search(r"1\.[1-9]", found["40"])  # one pin that is off: one planet carries more
    assert found["40"] != found["20"]


def test_an_assumed_value_is_marked_until_it_is_set(tab: Tab) -> None:
    sun = "[data-lever='stages.main.sun.support.radial']"
    mark = tab.page.locator(f"{sun} .ck-assumed")
    mark.wait_for()
    assert "the sun of a herringbone set floats axially" in mark.get_attribute("title")
    assert tab.page.locator("[data-lever='stages.main.module'] .ck-assumed").count() == 0  # it is printed
    typed(tab, "2e8", sun)
    mark.wait_for(state="detached")
    tab.page.get_by_label(re.compile("^Undo")).click()
    mark.wait_for()


def test_a_file_with_an_error_stands_above_no_figures_of_another_train(tab: Tab, tmp_path: Path) -> None:
    facts = tab.page.locator(".ck-facts")
    tab.page.wait_for_function("() => document.querySelector('.ck-facts').innerText.includes('ratio')")
    before = facts.inner_text()
    broken = tmp_path / "broken.toml"
    text = opened("ren2021").base
    broken.write_text(re.sub(r'module( *)= "32 mm"', r'module\1= "-32 mm"', text), encoding="utf-8")
    assert broken.read_text("utf-8") != text
    tab.page.locator("input[type=file]").first.set_input_files(str(broken))
    tab.page.get_by_text("stages.main.module").first.wait_for()
    tab.page.get_by_test_id("name").filter(has_text="broken.toml").wait_for()
    tab.page.wait_for_function("() => Object.keys(window.cockpit.parts).length === 0")
    for kind in ("train", "sweep", "evidence"):
        tab.page.locator(f"[data-kind={kind}] .ck-empty").get_by_text("broken.toml does not compute. stages").wait_for()
    tab.page.wait_for_function("() => !document.querySelector('.ck-facts').innerText")
    assert tab.page.locator(".ck-mode:visible").count() == 0
    assert tab.page.locator("[data-answer] .ck-figure:visible").count() == 0
    assert answer(tab, "planet") == "· Which planet carries most? Not computed: see the error above."
    tab.page.get_by_label(re.compile("^Undo")).first.click()
    tab.page.wait_for_function("before => document.querySelector('.ck-facts').innerText === before", arg=before)
    tab.page.wait_for_function("() => window.cockpit.parts.sweep")
    # of an edit that fails the curves before stay, pale, and the message says whose they are
    field = tab.page.locator("[data-lever='stages.main.module'] input.ck-box-number")
    field.fill("-3")
    field.press("Enter")
    tab.page.locator(".ck-message").get_by_text("The pale figures are those before “main.module = -3 mm”").wait_for()
    assert tab.page.locator("[data-kind=sweep]").get_attribute("data-stale") == "true"


def workers(cockpit: Cockpit) -> list[Any]:
    """Processes that compute or wait to: started by the server, without those that only watch over them."""
    import psutil

    found = []
    for one in psutil.Process(cockpit.process.pid).children():
        with suppress(psutil.NoSuchProcess):  # it has ended since, a zombie too
            found += [one] * ("spawn_main" in " ".join(one.cmdline()))
    return found


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
    field = tab.page.locator(f"{PIN} input.ck-box-number")
    field.fill("15")  # the state moves on meanwhile
    field.press("Enter")
    job.get_by_text("of another state").wait_for()
    # jobs compute at a lower priority than the live process and the one that waits
    end, killed = time.monotonic() + PATIENCE / 1000, list[Any]()
    while not killed and time.monotonic() < end:
        killed = [one for one in workers(cockpit) if one.nice() > 5]
        time.sleep(0.1)
    killed[0].kill()
    job.get_by_text("stopped: its process was killed (signal 9) at").wait_for()
    tab.page.get_by_role("tab", name="Jobs").click()
    row = tab.page.locator(".ck-job-row").first
    row.get_by_text("stopped: its process was killed").wait_for()
    row.get_by_role("button", name="Run again").click()
    job.get_by_role("button", name="Cancel").click()
    job.get_by_text("cancelled").wait_for()


def test_three_tabs_hold_four_workers_at_most(tab: Tab, context: Any, cockpit: Cockpit) -> None:
    tabs = [tab, *(Tab(context, cockpit.address) for _ in range(2))]
    most = 0
    for one in tabs:
        begun(one, "Contact loss", "contact_loss")
        begun(one, "Transient", "transient")
        most = max(most, len(workers(cockpit)))
    tabs[-1].page.get_by_role("tab", name="Jobs").click()  # four jobs were begun before its own
    tabs[-1].page.locator(".ck-job-row").get_by_text("waits for another job").first.wait_for()
    most = max(most, len(workers(cockpit)))
    assert 3 <= most <= 4
    for one in tabs:  # they would compute for ten seconds more
        for words, name in (("Transient", "transient"), ("Contact loss", "contact_loss")):
            one.page.get_by_role("tab", name=words).click()
            job = one.page.locator(f"[data-job={name}]")
            # none where the job has ended
            job.get_by_role("button", name="Cancel").evaluate_all("found => found.forEach(one => one.click())")
    for one in tabs[1:]:
        one.page.close()


def test_a_reload_keeps_all_that_a_tab_has(tab: Tab, context: Any, cockpit: Cockpit) -> None:
    tab.page.get_by_role("button", name="Pin A", exact=True).click()
    typed(tab, "30")
    typed(tab, "25")
    tab.page.get_by_label(re.compile("^Undo")).click()
    tab.page.get_by_label(re.compile("^Redo: .*25")).wait_for()
    tab.page.get_by_role("tab", name="Stiffness").click()
    stiffness = tab.page.locator("[data-job=stiffness]")
    stiffness.get_by_role("button", name="Run", exact=True).click()
    found = stiffness.get_by_text("varies most over its cycle")
    found.wait_for(timeout=100_000)
    words = found.inner_text()
    tab.page.locator(".ck-mode[data-mode='2']").click()
    running = begun(tab, "Contact loss", "contact_loss")
    tab.page.get_by_role("tab", name="Stiffness").click()
    tab.page.reload()
    tab.painted()
    chosen = tab.page.get_by_role("tab", name="Stiffness")
    tab.page.wait_for_function("() => window.cockpit.mode === 2")
    assert chosen.get_attribute("aria-selected") == "true"
    assert tab.page.locator(".ck-mode[data-mode='2']").get_attribute("aria-pressed") == "true"
    stiffness.get_by_text(words).wait_for()
    assert tab.page.get_by_role("button", name="Unpin A").is_visible()
    assert tab.page.get_by_label(re.compile("^Undo: .*30")).is_enabled()
    tab.page.get_by_label(re.compile("^Redo: .*25")).click()
    tab.page.wait_for_function(f"() => document.querySelector(\"{PIN} input.ck-box-number\").value === '25'")
    tab.page.get_by_role("tab", name="Contact loss").click()
    running.get_by_role("button", name="Cancel").click()  # it runs still
    running.get_by_role("button", name="Run", exact=True).wait_for()
    # a copy of the tab gets its own session: what it does changes nothing here
    secret = tab.page.evaluate("sessionStorage.getItem('epicyclic.secret')")
    assert len(secret.split()[0]) >= 32
    copy = Tab(context, cockpit.address, wait=False)
    copy.page.evaluate("secret => sessionStorage.setItem('epicyclic.secret', secret)", secret)
    copy.page.reload()
    copy.painted()
    assert copy.page.get_by_label("Redo", exact=True).is_disabled()
    copy.page.close()


def test_a_browser_that_does_not_answer_is_asked_again(browser: Any, cockpit: Cockpit) -> None:
    context = still(browser)
    context.add_init_script("""if (!sessionStorage.getItem("asked")) {
        sessionStorage.setItem("asked", "yes");
        navigator.locks.request = () => new Promise(() => {});  // the first time it never says what it kept
    }""")
    tab = Tab(context, cockpit.address)
    tab.page.locator(".ck-mode").nth(3).wait_for()
    assert tab.page.evaluate(
        "[sessionStorage.getItem('asked'), performance.getEntriesByType('navigation')[0].type]"
    ) == [
        "yes",
        "reload",
    ]
    assert tab.errors() == []
    context.close()
