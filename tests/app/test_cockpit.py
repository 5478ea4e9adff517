"""The cockpit as a person uses it: one server in a process of its own, a real browser."""

from __future__ import annotations

import http.server
import re
import threading
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import PATIENCE, Cockpit, Tab, start, still

pytestmark = pytest.mark.browser

# [s] after which nothing of a closed tab may compute any more
STOPPED = 10.0
KEPT = 1.0  # [s] after which the browser keeps a change
SETTLED = 0.2  # [s] in which a number that a key moves has another value
QUIET = 0.06  # share of a core that an idle server and its processes may take, its pings included


# No frame of a state before, and none of this one, is still to come.
SETTLED_DOWN = """() => !document.querySelector('.ck-page').dataset.busy
  && cockpit.painted.rev === cockpit.rev && cockpit.parts.sharing?.rev === cockpit.rev"""


@pytest.fixture
def context(browser: Any) -> Iterator[Any]:
    made = still(browser, accept_downloads=True)
    yield made
    made.close()


@pytest.fixture
def own_tab(context: Any, cockpit: Cockpit) -> Iterator[Tab]:
    """A tab of a test that leaves the train for another one, pins it or follows the focus."""
    opened = Tab(context, cockpit.address)
    yield opened
    assert opened.errors() == []


@pytest.fixture(scope="module")
def one_tab(browser: Any, cockpit: Cockpit) -> Iterator[Tab]:
    context = still(browser)
    opened = Tab(context, cockpit.address)
    yield opened
    context.close()


@pytest.fixture
def tab(one_tab: Tab) -> Iterator[Tab]:
    """The tab of all other tests, which each of them finds with the train as it was opened."""
    yield one_tab
    one_tab.page.keyboard.press("Escape")
    undo = one_tab.page.get_by_label(re.compile("^Undo"))
    while undo.is_enabled():
        rev = one_tab.rev
        undo.click()
        one_tab.painted(rev)
    one_tab.page.wait_for_function(SETTLED_DOWN)
    assert one_tab.errors() == []


def lever(tab: Tab, index: int = 0) -> Any:
    """A slider that takes keys."""
    return tab.page.locator("[data-lever] [role=slider]").nth(index)


def nudge(tab: Tab, times: int = 8) -> None:
    """Move a slider by so many keys."""
    lever(tab).focus()
    for _ in range(times):
        tab.page.keyboard.press("ArrowRight")


def box(tab: Tab, index: int = 0) -> Any:
    """The number box of a lever."""
    return tab.page.locator("[data-lever] input").nth(index)


def test_the_first_thing_on_the_page_is_the_answer(tab: Tab) -> None:
    tab.page.locator("[data-answer]").nth(4).wait_for()
    lines = tab.page.locator("[data-answer]").all()
    assert [one.get_attribute("data-answer") for one in lines] == ["resonance", "planet", "float", "error", "relief"]
    for one in lines[:4]:
        one.filter(has_text=re.compile(r"\d")).wait_for()  # a number, which is computed after the first picture
    assert tab.page.get_by_text("No strength rating").first.is_visible()
    tab.page.locator("[data-lever]").nth(4).wait_for()
    assert not tab.page.get_by_label("Load case", exact=True).is_visible()  # the model has none
    assert not tab.page.get_by_role("tab", name="Load cases").is_visible()
    # without scrolling: answers, drawing and curve
    for place in ("[data-answer=relief]", "[data-kind=train]", "[data-kind=sweep]"):
        seen = tab.page.locator(place).first.bounding_box()
        assert seen["y"] >= 0
        assert seen["y"] + seen["height"] <= 800
        assert seen["x"] + seen["width"] <= 1280


def test_a_slider_moves_the_curve(tab: Tab) -> None:
    curve = tab.page.locator("[data-kind=sweep]").first
    before, rev, shown = curve.screenshot(), tab.rev, int(curve.get_attribute("data-rev"))
    nudge(tab)
    tab.painted(rev)
    tab.page.wait_for_function(
        "rev => Number(document.querySelector('[data-kind=sweep]').dataset.rev) > rev", arg=shown
    )
    assert curve.screenshot() != before


def test_a_refused_value_leaves_the_curve_and_says_what_is_allowed(tab: Tab) -> None:
    rev = tab.rev
    field = tab.page.locator("[data-lever] input.ck-box-number").first
    good = field.input_value()
    field.fill("five um")
    field.press("Enter")
    message = tab.page.locator("[role=alert]:visible").filter(has_text=re.compile("allowed|above|least|positive"))
    message.first.wait_for()
    assert tab.page.locator("[data-kind=sweep]").first.is_visible()
    assert tab.rev <= rev  # the last good curve stays
    field.fill(good)
    field.press("Enter")
    tab.page.wait_for_function("() => [...document.querySelectorAll('[role=alert]')].every(e => !e.offsetParent)")
    tab.painted(rev)


def test_undo_goes_through_everything(tab: Tab) -> None:
    undo, redo = tab.page.get_by_label(re.compile("^Undo")), tab.page.get_by_label(re.compile("^Redo"))
    first = box(tab).input_value()
    nudge(tab, 1)
    second = changed(tab, first)
    tab.painted(0)
    undo.click()
    assert settled(tab, first) == first
    redo.click()
    assert settled(tab, second) == second
    lever(tab).focus()  # keys of a text field are its own, those of a slider are not
    tab.page.keyboard.press("Control+z")
    assert settled(tab, first) == first


def changed(tab: Tab, before: str) -> str:
    """Value of the first number box once it is another one and no key moves it any more."""
    end, last = time.monotonic() + PATIENCE / 1000, before
    while time.monotonic() < end:
        now = str(box(tab).input_value())
        if now == last != before:
            return now
        last = now
        time.sleep(SETTLED)
    raise AssertionError(f"still {before}")


def settled(tab: Tab, wanted: str) -> str:
    """Value of the first number box once it is the wanted one; else that which stands there in the end."""
    end = time.monotonic() + PATIENCE / 1000
    while (now := str(box(tab).input_value())) != wanted and time.monotonic() < end:
        time.sleep(0.05)
    return now


def test_a_job_runs_and_is_cancelled_while_a_slider_answers(tab: Tab) -> None:
    job = long_job(tab)
    cancel = job.get_by_role("button", name="Cancel")
    rev = tab.rev
    lever(tab).focus()
    tab.page.keyboard.press("ArrowRight")
    tab.painted(rev)
    assert cancel.is_visible()  # the job runs still
    cancel.click()
    job.get_by_role("button", name="Run", exact=True).wait_for()  # of one that has ended by itself: Run again


def open_link(tab: Tab, link: str) -> None:
    """Put a link into the address of a tab."""
    with tab.page.expect_navigation():
        tab.page.evaluate(f"location.hash = {link!r}")


def long_job(tab: Tab) -> Any:
    """A job of half a minute and more, which runs: contact loss with shaft orders."""
    tab.page.get_by_role("tab", name="Contact loss").click()
    job = tab.page.locator("[data-job=contact_loss]")
    job.get_by_text("Options").click()
    job.get_by_label("Shaft orders").select_option("yes")
    job.get_by_role("button", name="Run").click()
    job.get_by_role("button", name="Cancel").wait_for()
    return job


def test_pin_and_compare(own_tab: Tab) -> None:
    own_tab.page.get_by_role("button", name="Pin A", exact=True).click()
    rev = own_tab.rev
    nudge(own_tab)
    own_tab.painted(rev)
    own_tab.page.get_by_role("button", name="Compare", exact=True).click()
    table = own_tab.page.get_by_label("Differences of model and results")
    table.wait_for()
    for differs in (re.compile(r"drawing.*deviations\..* um"), re.compile(r"sharing.*K_gamma.*%")):
        row = table.get_by_role("row").filter(has_text=differs)
        row.wait_for()
        assert row.count() == 1


def test_a_button_that_goes_hands_on_the_focus(own_tab: Tab) -> None:
    own_tab.set_limit("1.02")
    for name, place in (("Let the sun float", "[data-answer=float]"), ("Pin A", ".ck-head")):
        button = own_tab.page.get_by_role("button", name=name, exact=True)
        button.focus()
        own_tab.page.keyboard.press("Enter")
        button.wait_for(state="hidden")
        within = "place => document.activeElement.closest(place) !== null"
        own_tab.page.wait_for_function(within, arg=place)
        assert own_tab.page.evaluate(within, place), name


@contextmanager
def another_site(link: str) -> Iterator[str]:
    """A page of another origin with a link, a frame and a picture of the cockpit."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            page = f"<a href='{link}'>the train</a><iframe src='{link}'></iframe><img src='{link}'>".encode()
            self.send_response(200)
            self.send_header("content-type", "text/html")
            self.send_header("content-length", str(len(page)))
            self.end_headers()
            self.wfile.write(page)

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://localhost:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()


def test_a_link_followed_on_another_site_reopens_the_state(own_tab: Tab, cockpit: Cockpit, browser: Any) -> None:
    from epicyclic.cockpit.state.state import fragment_of, opened, with_value

    state = with_value(opened("lin1999-n4"), "title", "the linked train")
    link = f"{cockpit.origin}/#{fragment_of(state)}"
    with another_site(link) as address:
        own_tab.page.goto(address)
        frame = own_tab.page.frame_locator("iframe")
        assert frame.locator("[data-kind]").count() == 0
        own_tab.page.get_by_role("link").click()
        own_tab.painted()
        assert "#" not in own_tab.page.url
        own_tab.page.get_by_text("lin1999-n4").first.wait_for()
        stranger = still(browser)  # a browser that was never let in
        page = stranger.new_page()
        page.goto(address)
        page.get_by_role("link").click()
        page.get_by_text("not known here").wait_for()
        stranger.close()
    own_tab.said.clear()  # the frame was refused, as it should


def test_a_link_put_into_a_tab_loses_nothing(own_tab: Tab) -> None:
    from epicyclic.cockpit.state.state import fragment_of, opened, with_value

    first = box(own_tab).input_value()
    nudge(own_tab, 1)
    second = changed(own_tab, first)
    own_tab.page.get_by_text("edited", exact=True).wait_for()
    time.sleep(KEPT)
    own_tab.page.evaluate("location.hash = 'state=eNqrVspLzE1VslIqSs0zMjA0UdJRyi9LLSpLzEnNTwIAAAAA'")
    own_tab.page.get_by_text("The link cannot be opened").wait_for()
    own_tab.painted()
    assert settled(own_tab, second) == second
    link = fragment_of(with_value(opened("lin1999-n4"), "title", "the linked train"))
    open_link(own_tab, link)
    own_tab.page.get_by_text("lin1999-n4").first.wait_for()
    own_tab.page.get_by_label(re.compile("^Undo")).click()
    own_tab.page.get_by_text("edited", exact=True).wait_for()
    assert settled(own_tab, second) == second
    own_tab.said.clear()


def test_two_tabs_are_apart(tab: Tab, cockpit: Cockpit) -> None:
    other = Tab(tab.page.context, cockpit.address)
    before = box(other).input_value()
    rev, quiet = tab.rev, other.rev
    nudge(tab, 1)
    tab.painted(rev)
    time.sleep(0.5)
    assert box(other).input_value() == before
    assert other.rev == quiet
    other.page.close()


def test_a_state_is_saved_downloaded_reopened_and_outlives_a_restart(tmp_path: Path, browser: Any) -> None:
    from epicyclic.cockpit.state.state import opened

    path = tmp_path / "box.toml"
    path.write_text(opened("lin1999-n4").base, encoding="utf-8")
    context = still(browser, accept_downloads=True)
    server = start(tmp_path, str(path))
    try:
        tab = Tab(context, server.address)
        saved_downloaded_and_reopened(tab, path)
        for text in ("0.7", "0.8"):
            mass(tab).fill(text)
            tab.page.keyboard.press("Enter")
            tab.page.get_by_label(re.compile(f"^Undo: .*{text}")).wait_for()
        time.sleep(KEPT)
    finally:
        server.stop()
    banner = tab.page.locator("#popup span").last
    told = "element => getComputedStyle(element, '::after').content"
    assert "undo and results of jobs only as long as the server runs" in banner.evaluate(told)
    again = start(tmp_path, str(path), port=server.port)
    try:
        # a nudge, the file that was opened, and two numbers
        tab.page.get_by_text("Not kept: 4 steps of undo; the server was started anew").wait_for()
        assert mass(tab).input_value() == "0.8"
    finally:
        context.close()
        again.stop()


def mass(tab: Tab) -> Any:
    return tab.page.locator("[data-lever='stages.main.planet.mass'] input.ck-box-number")


def saved_downloaded_and_reopened(tab: Tab, path: Path) -> None:
    before, first = path.read_text("utf-8"), box(tab).input_value()
    nudge(tab, 1)
    changed(tab, first)
    time.sleep(0.5)  # the last key has arrived
    tab.page.get_by_role("button", name="Save", exact=True).click()
    tab.page.get_by_text("Saved: ").first.wait_for()
    saved = path.read_text("utf-8")
    assert tomllib.loads(saved) != tomllib.loads(before)
    assert saved.count("#") == before.count("#")  # comments stay
    tab.page.get_by_role("button", name="Take away").click()
    with tab.page.expect_download() as download:
        tab.page.get_by_role("button", name="Model file (.toml)").click()
    taken = path.with_name("taken.toml")
    download.value.save_as(taken)
    assert tomllib.loads(taken.read_text("utf-8")) == tomllib.loads(saved)
    tab.page.keyboard.press("Escape")
    rev = tab.rev
    tab.page.locator("input[type=file]").first.set_input_files(str(taken))
    tab.painted(rev)
    tab.page.get_by_text("taken.toml").first.wait_for()


def test_an_upload_that_is_too_large_is_refused(tab: Tab, tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * 5_000_000)
    rev = tab.rev
    tab.page.locator("input[type=file]").first.set_input_files(str(path))
    tab.page.get_by_text(re.compile("^Not opened")).first.wait_for()
    assert tab.rev == rev


def test_a_closed_tab_stops_its_jobs(context: Any, cockpit: Cockpit) -> None:
    import psutil

    tab = Tab(context, cockpit.address)
    long_job(tab)
    computing = time.monotonic() + 60  # a loaded machine is slow to begin
    # jobs compute at a lower priority than all others
    while not (jobs := [one for one in cockpit.processes() if one.nice() > psutil.Process().nice() + 5]) or (
        cores(cockpit, 0.5) <= 2 * QUIET
    ):
        assert time.monotonic() < computing, "the job computes nothing"
    for one in jobs:
        one.suspend()  # it is ended all the same, and takes no core until then
    tab.page.close()
    time.sleep(STOPPED - 2.0)
    stopped = time.monotonic() + 15  # of a job of half a minute and more, on a loaded machine
    assert psutil.wait_procs(jobs, timeout=15)[1] == [], "the job goes on"
    while cores(cockpit, 2.0) >= QUIET:
        assert time.monotonic() < stopped, "something goes on"


def cores(cockpit: Cockpit, seconds: float) -> float:
    """Cores that the server and its processes take, in the mean of so many seconds."""
    before = cockpit.seconds()
    time.sleep(seconds)
    after = cockpit.seconds()
    return sum(after[pid] - before.get(pid, 0.0) for pid in after) / seconds


def test_the_wizard_ends_in_a_curve(tab: Tab) -> None:
    rev = tab.rev
    tab.page.get_by_role("button", name="New train").first.click()
    for label, text in {
        "Teeth sun/planet/ring": "21/39/99",
        "Planets": "3",
        "Normal module": "10 mm",
        "Helix angle": "7.5 deg",
        "Face width": "200 mm",
        "Power of the sun": "750 kW",
        "Speed of the sun": "1000 rpm",
    }.items():
        field = tab.page.get_by_role("dialog").get_by_label(re.compile(rf"^{label}( \[.*)?$")).first
        field.fill(text)
        field.press("Tab")
    tab.page.get_by_role("dialog").get_by_role("button", name="Create").click()
    tab.painted(rev)
    assert int(tab.page.locator("[data-kind=sweep]").first.get_attribute("data-rev")) > rev
    tab.page.get_by_text("5.714").first.wait_for()  # its ratio, 1 + 99/21


def test_a_tab_that_was_closed_leaves_its_changes(context: Any, cockpit: Cockpit) -> None:
    tab = Tab(context, cockpit.address)
    # the torque is a lever of every state; others are chosen by what they move
    torque = "[data-lever='operation.torque.sun']"
    first = tab.page.locator(f"{torque} input.ck-box-number").input_value()
    tab.page.locator(f"{torque} input.ck-box-number").fill("123")
    tab.page.keyboard.press("Enter")
    time.sleep(KEPT)
    tab.page.close()
    other = Tab(context, cockpit.address)
    own = other.page.locator(f"{torque} input.ck-box-number")
    assert own.input_value() == first  # nothing is restored unasked
    other.page.get_by_text("left in a closed tab").wait_for()
    other.page.get_by_role("button", name="Restore").click()
    other.page.wait_for_function(
        "place => document.querySelector(place + ' input.ck-box-number')?.value === '123'", arg=torque
    )
    other.page.get_by_text("left in a closed tab").wait_for(state="hidden")
