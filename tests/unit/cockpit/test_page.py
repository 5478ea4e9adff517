"""The page of a session: what it shows of frames, what it asks for, its states; no browser, nothing computed."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from nicegui.element import Element
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import visit

from epicyclic.cockpit.computing.job_kinds import JOBS
from epicyclic.cockpit.page import page
from epicyclic.cockpit.page.controls import Board
from epicyclic.cockpit.page.job_bar import progress_text, time_words
from epicyclic.cockpit.page.page import LeverControl, cockpit_page
from epicyclic.cockpit.processes.jobs import Job
from epicyclic.cockpit.state.frames import PageFrame, pack
from epicyclic.cockpit.state.state import opened
from epicyclic.engine.source import Drive
from epicyclic.errors import ModelError
from epicyclic.options import Shape, shape_of
from epicyclic.verbs.options import READERS

MASS: dict[str, Any] = {
    "path": "stages.main.sun.mass",
    "label": "mass of the sun",
    "value": 750.0,
    "unit": "kg",
    "least": 75.0,
    "most": 3000.0,
    "step": 25.0,
}
STIFFNESS: dict[str, Any] = {
    "path": "stages.main.planet.bearing.radial",
    "label": "planet bearing",
    "value": 1e9,
    "unit": "N/m",
    "least": 1e8,
    "most": 1e10,
    "log": True,
}
ANSWER = {
    "key": "float",
    "question": "What does a floating sun buy?",
    "text": "K_gamma falls from 1.034 to 1.000.",
    "figure": "1.034",
    "then": "1.000",
    "limit": {"value": 1.1, "words": "3 planets, table", "source": "3 planets, a standard", "path": "limits.k_gamma"},
    "level": "warn",
    "apply": {"stages.main.sun.mass": "500 kg"},
    "apply_label": "Let the sun float",
    "evidence": "errors",
    "job": None,
    "stale": False,
}


class PageSession(FakeSession):
    """A session that plays frames which a test gives it."""

    def __init__(self, state: Any) -> None:
        super().__init__(state)
        self.levers: tuple[dict[str, Any], ...] = (MASS, STIFFNESS)
        self.failed = None
        self.rev = self.released_rev = 1
        self.relative_speed, self.busy = 1.0, False
        self.pinned_packed: dict[str, bytes] = {}
        self.started: list[Job] = []
        self.jobs = SimpleNamespace(start=self.begin, cancel=self.end, visible=lambda: self.started)

    def set(self, path: str, value: object, *, released: bool, key: str | None = None) -> None:
        if value == "nonsense":
            raise ModelError("is no number", path=path, allowed="a mass")
        self.rev += 1
        self.released_rev = self.rev if released else self.released_rev
        super().set(path, value, released=released, key=key)

    def operate_at(self, relative_speed: float) -> None:
        self.relative_speed = relative_speed
        self.tell("state")

    def begin(self, name: str, options: Any) -> Job:
        self.calls.append(("job", name, dict(options)))
        job = Job(id=len(self.started) + 1, name=name, label=name, rev=self.rev, status="runs")
        job.origin = self.now.origin
        self.started.append(job)
        return self.started[-1]

    def end(self, job: Job) -> None:
        job.status = "cancelled"
        self.tell("jobs")

    def fail(self, failed: dict[str, str] | None) -> None:
        self.failed = failed
        self.tell("failed", failed)

    def play(self, **head: Any) -> None:
        frame = PageFrame(rev=self.rev, kind="live", head=head, arrays={"modes/frequency": np.zeros(1, np.float32)})
        self.tell("frame", pack(frame), frame)


async def played(session: PageSession, **head: Any) -> None:
    """A frame, and the words that follow its curves."""
    session.play(**head)
    await asyncio.sleep(2 * page._WORDS_AFTER)


def look(talk: Any, session: PageSession | None = None) -> PageSession:
    shown = session or PageSession(opened("ren2021"))
    visit(cockpit_page, talk, shown)
    return shown


def levers(user: User) -> dict[str, LeverControl]:
    return {one.path: one for one in user.find(LeverControl).elements}


def raise_in(element: Any, kind: str, value: Any = None) -> None:
    """What a browser would send."""
    for listener in element._event_listeners.values():
        if listener.type == kind:
            element._handle_event({"listener_id": listener.id, "args": value})


def texts(user: User, **props: str) -> str:
    """All texts below the elements with these properties."""
    assert user.client is not None
    found = [
        one
        for one in user.client.elements.values()
        if all(one.props.get(name.replace("_", "-")) == value for name, value in props.items())
    ]
    return " | ".join(
        str(part._text) for one in found for part in [one, *one.descendants()] if part._text and not _hidden(part)
    )


def _hidden(element: Any) -> bool:
    return any(one.props.get("hidden") for one in [element, *element.ancestors()])


def press(user: User, words: str) -> None:
    """Click the button with a text or a name that is seen."""
    assert user.client is not None
    found = [
        one
        for one in user.client.elements.values()
        if one.tag == "button" and words in (one._text, one.props.get("aria-label")) and not _hidden(one)
    ]
    assert len(found) == 1, (words, len(found))
    raise_in(found[0], "click", {})


def test_a_lever_moves_the_session_and_a_release_ends_the_drag() -> None:
    async def talk(user: User, session: PageSession) -> None:
        lever = levers(user)[MASS["path"]]
        raise_in(lever, "move", 800.0)
        raise_in(lever, "move", 825.0)
        assert session.released_rev == 1
        raise_in(lever, "release", 850.0)
        assert session.released_rev == session.rev
        assert session.calls == [("set", MASS["path"], f"{mass} kg") for mass in (800, 825, 850)]
        # the lever shows its own moves itself: the server says nothing that would tear it back
        assert lever.props["shown"] == [0, 750.0]
        assert lever.props["changed"] is True
        session.undo()
        assert lever.props["shown"][1] == 825.0
        for value in (True, "many", float("nan"), None):
            raise_in(lever, "move", value)
        assert len(session.calls) == 3

    look(talk)


def test_a_number_typed_takes_the_unit_of_the_lever_or_its_own() -> None:
    async def talk(user: User, session: PageSession) -> None:
        found = levers(user)
        raise_in(found[MASS["path"]], "typed", "0.6 t")
        assert session.now.overrides[MASS["path"]] == "0.6 t"
        assert found[MASS["path"]].props["shown"][1] == pytest.approx(600.0)
        raise_in(found[STIFFNESS["path"]], "typed", "2.5e9")
        assert session.now.overrides[STIFFNESS["path"]] == "2.5e+09 N/m"
        assert found[STIFFNESS["path"]].props["shown"][1] == pytest.approx(2.5e9)  # the slider moves there
        count = found[STIFFNESS["path"]].props["shown"][0]
        raise_in(found[STIFFNESS["path"]], "typed", "1e999")
        assert found[STIFFNESS["path"]].props["shown"][0] == count  # infinity is no number of JSON
        raise_in(found[MASS["path"]], "reset")
        assert MASS["path"] not in session.now.overrides
        assert found[MASS["path"]].props["shown"][1] == pytest.approx(750.0)
        assert found[MASS["path"]].props["changed"] is False

    look(talk)


def test_a_value_that_the_file_does_not_state_is_taken_back() -> None:
    pin = {**MASS, "path": "deviations.planet.position.tangential", "value": 0.0, "unit": "um", "least": 0.0}

    async def talk(user: User, session: PageSession) -> None:
        lever = levers(user)[pin["path"]]
        raise_in(lever, "release", 12.5)
        session.undo()
        assert lever.props["shown"][1] == 0.0
        raise_in(lever, "release", 12.5)
        raise_in(lever, "reset")
        assert lever.props["shown"] == [2, 0.0]
        assert not session.now.overrides

    session = PageSession(opened("ren2021"))
    session.levers = (pin,)
    look(talk, session)


def test_escape_takes_back_what_was_refused() -> None:
    async def talk(user: User, session: PageSession) -> None:
        lever = levers(user)[MASS["path"]]
        raise_in(lever, "typed", "nonsense")
        raise_in(lever, "restore")
        assert lever.props["message"] == ""
        raise_in(lever, "typed", "-5")
        session.fail({"path": MASS["path"], "message": "out of range", "given": "-5 kg", "allowed": ">= 0"})
        raise_in(lever, "restore")
        assert lever.props["message"] == ""
        assert MASS["path"] not in session.now.overrides
        assert lever.props["shown"][1] == 750.0
        raise_in(lever, "typed", "-5")
        session.apply({"stages.main.ring.mass": "600 kg"}, "another")
        session.fail({"path": MASS["path"], "message": "out of range", "given": "-5 kg", "allowed": ">= 0"})
        raise_in(lever, "restore")  # of a newer step nothing is taken back
        assert session.now.overrides["stages.main.ring.mass"] == "600 kg"

    look(talk)


def test_what_is_refused_stands_beside_its_lever_until_it_computes_again() -> None:
    async def talk(user: User, session: PageSession) -> None:
        lever = levers(user)[MASS["path"]]
        raise_in(lever, "typed", "nonsense")
        assert lever.props["message"] == "is no number; allowed: a mass"
        raise_in(lever, "typed", "-5")
        session.fail({"path": MASS["path"], "message": "out of range", "given": "-5 kg", "allowed": ">= 0"})
        assert lever.props["message"] == "out of range; allowed: >= 0"
        assert texts(user, role="alert") == ""  # not twice
        session.fail(None)
        assert lever.props["message"] == ""
        session.fail({"path": "stages.main.ring.teeth", "message": "too few", "given": "3", "allowed": "5 or more"})
        assert lever.props["message"] == ""
        assert "stages.main.ring.teeth: too few; allowed: 5 or more" in texts(user, role="alert")
        session.fail(None)
        assert texts(user, role="alert") == ""

    look(talk)


def test_nothing_of_another_train_stands_under_the_title_of_one_that_fails() -> None:
    async def talk(user: User, session: PageSession) -> None:
        modes = [{"index": 0, "frequency": 86.7, "label": "sun turns", "met_by": ""}]
        state = {"ratio": 3.478, "speeds": [], "torques": []}
        check = {"level": "bad", "code": "x", "text": "teeth do not meet", "path": ""}
        await played(session, answers=[ANSWER], checks=[check], modes=modes, state=state)
        session.is_of_another_model = True
        session.fail({"path": "stages.main.module", "message": "must be above 0", "given": "-3", "allowed": "> 0"})
        await asyncio.sleep(2 * page._WORDS_AFTER)
        assert (
            texts(user, data_answer="float") == "· | What does a floating sun buy? Not computed: see the error above."
        )
        await user.should_not_see("ratio 3.478")
        await user.should_not_see("1 warning")
        assert "teeth do not meet" not in texts(user, aria_label="Answers")
        assert "sun turns" not in texts(user, aria_label="Modes")
        told = "ren2021 does not compute. stages.main.module: must be above 0; allowed: > 0"
        boards = [one for one in user.client.elements.values() if isinstance(one, Board)]  # type: ignore[union-attr]
        assert [one._sent for one in boards] == [{}, {}, {}]
        assert [one._told.get("clear") for one in boards] == [(told,), None, None]
        assert [one._told.get("stale") for one in boards] == [(False,)] * 3
        session.is_of_another_model = False
        session.fail(None)
        await played(session, answers=[ANSWER], checks=[], modes=modes, state=state)
        assert boards[0]._told.get("clear") is None
        assert texts(user, data_answer="float").startswith("! | 1.034 | 1.000 | 1.1")
        await user.should_see("sun turns")

    look(talk)


def test_an_assumed_value_is_marked_with_its_reason_until_it_is_set() -> None:
    async def talk(user: User, session: PageSession) -> None:
        mass, bearing = levers(user)[MASS["path"]], levers(user)[STIFFNESS["path"]]
        # of the planets' bearing x and y are assumed as one, and z is no lever
        assumed = {MASS["path"]: "weighed by eye", "stages.main.planet.bearing": "a usual one"}
        await played(session, assumed=assumed)
        assert (mass.props["assumed"], bearing.props["assumed"]) == ("weighed by eye", "a usual one")
        raise_in(bearing, "release", 2e9)
        assert (mass.props["assumed"], bearing.props["assumed"]) == ("weighed by eye", "")
        session.undo()
        assert bearing.props["assumed"] == "a usual one"
        await played(session, assumed={})
        assert (mass.props["assumed"], bearing.props["assumed"]) == ("", "")
        # assumed by what an answer applies: the reason goes once a person sets the value
        session.apply({MASS["path"]: "640 kg", f'assumed."{MASS["path"]}"': "as usual"}, "assume")
        await played(session, assumed={MASS["path"]: "as usual"})
        assert mass.props["assumed"] == "as usual"
        raise_in(mass, "release", 650.0)
        assert dict(session.now.overrides) == {MASS["path"]: "650 kg"}
        assert mass.props["assumed"] == ""

    look(talk)


def test_what_another_page_showed_is_shown_again() -> None:
    async def talk(user: User, session: PageSession) -> None:
        rows = [{"index": i, "frequency": 86.7 + i, "label": f"mode {i}", "met_by": ""} for i in (0, 1)]
        await played(session, modes=rows)
        session.view = {"tab": "errors", "mode": 1}
        session.tell("view")
        assert texts(user, role="tab", aria_selected="true") == "Errors"
        assert "mode 1" in texts(user, data_mode="1", aria_pressed="true")
        session.view = {"tab": ["x"], "mode": "1"}  # of a snapshot that somebody has changed
        session.tell("view")
        assert texts(user, role="tab", aria_selected="true") == "Errors"
        press(user, "Sharing")
        assert session.view == {"tab": "sharing", "mode": None}

    look(talk)


def test_an_answer_is_applied_and_taken_back() -> None:
    async def talk(user: User, session: PageSession) -> None:
        assert "What tip relief to grind?" in texts(user, data_answer="relief")
        await played(
            session, answers=[ANSWER], checks=[{"level": "bad", "code": "x", "text": "teeth do not meet", "path": ""}]
        )
        assert texts(user, data_answer="float").startswith("! | 1.034 | 1.000 | 1.1 | K_gamma falls")
        assert "teeth do not meet" in texts(user, data_check="")
        assert "No strength rating" in texts(user, aria_label="Answers")
        press(user, "Let the sun float")
        assert session.now.overrides == {"stages.main.sun.mass": "500 kg"}
        assert session.history.undo_label == "Let the sun float"
        session.undo()
        assert not session.now.overrides
        await played(session, answers=[{**ANSWER, "apply": None}], checks=[])
        assert "Let the sun float" not in texts(user, data_answer="float")
        assert texts(user, data_check="") == ""
        press(user, "Show errors")
        assert texts(user, role="tab", aria_selected="true") == "Errors"

    look(talk)


def test_curves_of_the_state_before_are_drawn_as_such_where_the_next_one_takes_long() -> None:
    async def talk(user: User, session: PageSession) -> None:
        await played(session, answers=[ANSWER])
        panes = [one for one in user.client.elements.values() if isinstance(one, Board)]  # type: ignore[union-attr]
        assert len(panes) == 3
        await asyncio.sleep(2 * page._LATE)
        assert [pane._told.get("stale") for pane in panes] == [None] * 3  # nothing is waited for
        raise_in(levers(user)[MASS["path"]], "move", 800.0)
        await played(session, answers=[ANSWER])
        await asyncio.sleep(2 * page._LATE)
        assert [pane._told.get("stale") for pane in panes] == [None] * 3
        raise_in(levers(user)[MASS["path"]], "move", 900.0)
        await asyncio.sleep(2 * page._LATE)
        assert [pane._told.get("stale") for pane in panes] == [(True,)] * 3
        await played(session, answers=[ANSWER])
        assert [pane._told.get("stale") for pane in panes] == [(False,)] * 3

    look(talk)


def test_what_a_job_found_stands_in_the_line_until_the_state_moves_on() -> None:
    async def talk(user: User, session: PageSession) -> None:
        relief = {**ANSWER, "key": "relief", "apply": None, "text": "About 60 um.", "job": "relief", "figure": "5 um"}
        await played(session, answers=[relief])
        press(user, "Compute relief")
        job = session.started[0]
        found = {
            **relief,
            "text": "Grind 24 um.",
            "figure": "",
            "then": "24 um",
            "level": "good",
            "apply": ANSWER["apply"],
        }
        drawn = {"job": {"name": "relief", "text": "done"}, "answers": [{**found, "apply_label": "Draw it"}]}
        job.frame, job.status = PageFrame(rev=job.rev, kind="job", head=drawn, arrays={}), "done"
        session.tell("jobs")
        assert texts(user, data_answer="relief").startswith("✓ | 5 um | 24 um | 1.1 | Grind 24 um. | Draw it")
        await played(session, answers=[relief])  # of the same state
        assert "Grind 24 um." in texts(user, data_answer="relief")
        press(user, "Draw it")
        session.rev += 1
        session.tell("state")
        line = texts(user, data_answer="relief")
        assert line.startswith("! | 5 um | 1.000 | 1.1 | About 60 um. | Compute")
        assert "Draw it" not in line

    look(talk)


def test_a_job_runs_in_the_line_of_its_answer_and_is_marked_when_the_state_moves_on() -> None:
    async def talk(user: User, session: PageSession) -> None:
        relief = {**ANSWER, "key": "relief", "apply": None, "text": "About 60 um.", "job": "relief", "figure": ""}
        await played(session, answers=[relief])
        press(user, "Compute relief")
        assert session.calls == [("job", "relief", {})]
        job = session.started[0]
        job.progress, job.remaining = 0.5, 12.0
        session.tell("jobs")
        assert "About 60 um. (50 %, about 12 s left)" in texts(user, data_answer="relief")
        assert "50 %, about 12 s left" in texts(user, data_job="relief")
        assert tab(user, "Relief") == ("▸", "Tip relief for the least transmission error: runs")
        raise_in(levers(user)[MASS["path"]], "release", 900.0)  # a lever answers meanwhile
        job.status = "done"
        session.tell("jobs")
        assert "of another state: run again." in texts(user, data_job="relief")
        assert "Run again" in texts(user, data_job="relief")
        assert tab(user, "Relief")[0] == "↻"
        assert tab(user, "Sharing")[0] is tab(user, "Transient")[0] is None
        session.begin("tolerance", {})
        press(user, "Jobs")
        assert "tolerance | state 2 | 0 % | Cancel" in texts(user, aria_label="Evidence")
        press(user, "Cancel")
        assert session.started[1].status == "cancelled"
        assert "cancelled" in texts(user, aria_label="Evidence")

    look(talk)


def tab(user: User, words: str) -> tuple[Any, str]:
    """Mark of a tab, and its words beside the pointer."""
    (found,) = (
        one for one in user.find(kind=Element).elements if one.props.get("role") == "tab" and one._text == words
    )
    return found.props.get("data-mark"), found.props["title"]


def test_a_job_says_how_long_it_takes_of_this_train() -> None:
    kind, state = JOBS["contact_loss"], opened("ren2021")
    head = {"live_ms": 100.0, "mesh_frequencies": 1}
    assert time_words(kind, {}, {}, [], state) == ""
    assert time_words(kind, head, {}, [], state) == "About 1 to 4 s on this train."
    assert time_words(kind, head, {"points": 600}, [], state) == "About 10 to 40 s on this train."
    assert time_words(kind, head, {"shaft_orders": True}, [], state) == "About 20 to 80 s on this train."
    assert time_words(kind, head | {"mesh_frequencies": 2}, {}, [], state) == "About 3 to 11 s on this train."
    ran = Job(id=1, name="contact_loss", label="", rev=1, status="done", seconds=74.0, origin=state.origin)
    assert time_words(kind, head, {}, [ran], state) == "About 57 to 96 s: the last run took 74 s."
    assert time_words(kind, head, {"points": 120}, [ran], state) == "About 2 to 3 min: the last run took 74 s."
    assert time_words(kind, head, {}, [ran], opened("wind-stage")) == "About 1 to 4 s on this train."

    async def talk(user: User, session: PageSession) -> None:
        await played(session, state={"live_ms": 100.0, "mesh_frequencies": 1})
        press(user, "Contact loss")
        assert "About 1 to 4 s on this train." in texts(user, data_job="contact_loss")
        bar = next(one for one in user.find(kind=Element).elements if one.props.get("data-job") == "contact_loss")
        named = {one.props.get("aria-label"): one for one in bar.descendants()}
        raise_in(named["Points"], "change", "600")
        assert "About 10 to 40 s on this train." in texts(user, data_job="contact_loss")

    look(talk)


def test_command_line_and_script_of_a_job_have_what_was_typed() -> None:
    async def talk(user: User, session: PageSession) -> None:
        await played(session)
        press(user, "Contact loss")
        bar = next(one for one in user.find(kind=Element).elements if one.props.get("data-job") == "contact_loss")
        named = {one.props.get("aria-label"): one for one in bar.descendants()}
        raise_in(named["Points"], "change", "12")
        press(user, "Command line")
        await user.should_see("epicyclic sweep ren2021 --contact-loss --points 12 --no-shaft-orders")
        press(user, "Script")
        await user.should_see("epicyclic.sweep(")


def test_a_job_whose_process_died_is_run_again_with_its_options() -> None:
    async def talk(user: User, session: PageSession) -> None:
        press(user, "Contact loss")
        job = session.begin("contact_loss", {})
        job.options = {"points": 12, "shaft_orders": True}
        session.tell("jobs")
        job.status, job.died, job.message = "failed", True, "its process was killed (signal 9) at 40 %"
        session.rev += 1  # a lever has moved meanwhile
        session.tell("jobs")
        told = "stopped: its process was killed (signal 9) at 40 %"
        line = texts(user, data_job="contact_loss")
        assert line.startswith("Run again | Run | Options | ")
        assert line.endswith(told)
        press(user, "Jobs")
        assert f"contact_loss | state 1 | {told} | Run again" in texts(user, aria_label="Evidence")
        press(user, "Run again")
        assert session.calls[-1] == ("job", "contact_loss", {"points": 12, "shaft_orders": True})
        assert texts(user, role="tab", aria_selected="true") == "Contact loss"
        assert "Run again" not in texts(user, aria_label="Evidence")

    look(talk)


def test_what_was_refused_of_another_model_is_not_told_of_this_one() -> None:
    async def talk(user: User, session: PageSession) -> None:
        relief = {**ANSWER, "key": "relief", "apply": None, "text": "About 60 um.", "job": "relief", "figure": ""}
        await played(session, answers=[relief])
        press(user, "Compute relief")
        session.started[0].status, session.started[0].message = "failed", "no tooth is loaded"
        session.tell("jobs")
        assert "no tooth is loaded" in texts(user, data_answer="relief")
        assert "no tooth is loaded" in texts(user, data_job="relief")
        session.rev += 1
        await session.open(opened("wind-stage"))
        for place in ({"data_answer": "relief"}, {"data_job": "relief"}):
            assert "no tooth is loaded" not in texts(user, **place)
        assert "Run" in texts(user, data_job="relief")
        press(user, "Jobs")
        assert "ren2021, state 1 | failed: no tooth is loaded" in texts(user, aria_label="Evidence")

    look(talk)


def test_the_page_without_a_model_shows_the_ways_to_one() -> None:
    async def talk(user: User, session: PageSession) -> None:
        await user.should_see("Which gear train?")
        await user.should_see("xu2020")
        name = next(iter(user.find("lin1999-n4").elements))
        raise_in(next(iter(name.ancestors())), "click", {})
        await asyncio.sleep(0.3)
        assert session.now.drive == "lin1999-n4"
        assert "Which gear train?" not in texts(user, aria_label="No model is open")

    look(talk, PageSession(None))


def test_before_the_browser_has_said_what_it_kept_nothing_is_offered() -> None:
    async def talk(user: User, session: PageSession) -> None:
        await user.should_not_see("Which gear train?")

    session = PageSession(None)
    session.rev = 0
    look(talk, session)


def test_warnings_facts_speed_and_name_stand_in_the_header() -> None:
    async def talk(user: User, session: PageSession) -> None:
        await played(
            session,
            checks=[{"level": "warn", "code": "x", "text": "<b>bold</b>", "path": ""}],
            state={"ratio": 3.478, "speeds": [["sun", 100, "rpm"], ["ring", 0, "rpm"]], "torques": []},
        )
        await user.should_see("1 warning")
        await user.should_see("<b>bold</b>")  # a text of a model stays a text
        await user.should_see("ratio 3.478 · sun 100 rpm")
        session.operate_at(1.25)
        press(user, "at 125 % speed: back to 100 %")
        assert session.relative_speed == 1.0
        session.unsaved = True
        session.tell("state")
        assert texts(user, data_testid="edited") == "edited"
        assert texts(user, data_testid="name") == "ren2021"
        session.unsaved = False
        session.tell("state")
        assert texts(user, data_testid="edited") == ""

    look(talk)


def test_a_mode_that_is_chosen_is_marked_and_left() -> None:
    async def talk(user: User, session: PageSession) -> None:
        rows = [{"index": i, "frequency": 86.7 + i, "label": f"mode {i}", "body": "sun", "met_by": ""} for i in (0, 1)]
        await played(session, modes=rows)
        assert user.client is not None
        row = next(one for one in user.client.elements.values() if one.props.get("data-mode") == "1")
        raise_in(row, "click", {})
        assert row.props["aria-pressed"] == "true"
        raise_in(row, "click", {})
        assert row.props["aria-pressed"] == "false"
        await played(session, modes=rows[:1])
        assert "mode 1" not in texts(user, aria_label="Modes")

    look(talk)


def test_a_drag_sends_little_beside_its_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    async def talk(user: User, session: PageSession) -> None:
        lever = levers(user)[MASS["path"]]
        head = {"answers": [ANSWER], "checks": [], "modes": [], "state": {"ratio": 3.478}}
        raise_in(lever, "move", 800.0)
        await played(session, **head)
        sent: list[object] = []
        assert user.client is not None
        monkeypatch.setattr(user.client.outbox, "enqueue_update", sent.append)
        for mass in range(825, 1025, 25):
            raise_in(lever, "move", float(mass))
            await played(session, **head)
        assert len(sent) <= 8  # none of answers, modes, header and levers that has not changed

    look(talk)


def test_words_of_a_job() -> None:
    job = Job(id=1, name="relief", label="Tip relief", rev=3)
    assert progress_text(job, 3) == "waits for another job"
    job.status, job.progress, job.remaining = "runs", 0.25, 200.0
    assert progress_text(job, 3) == "25 %, about 3 min left"
    assert progress_text(job, 4) == "25 %, about 3 min left, of another state"
    job.status, job.message = "failed", "operation.speed: is missing"
    assert progress_text(job, 3) == "failed: operation.speed: is missing"


@pytest.mark.parametrize("name", list(JOBS))
def test_the_fields_of_a_job_are_options_of_its_verb(name: str) -> None:
    kind = JOBS[name]
    keywords = kind.keywords()
    assert set(keywords) == set(kind.options)
    for name_of, (usual, accepted, option) in keywords.items():
        shape = shape_of(accepted)
        assert option.help
        default = kind.defaults.get(name_of, usual)
        if isinstance(default, (bool, int, float)):  # what a field shows as usual may be typed into it
            typed = ("no", "yes")[default] if isinstance(default, bool) else str(default)
            read = shape.read(typed, name_of)
            assert (READERS[option.reads](read, name_of, Drive("ren2021"), option) if option.reads else read) == default


def test_what_stands_in_the_fields_of_a_job_is_what_it_runs_with() -> None:
    async def talk(user: User, session: PageSession) -> None:
        fields = next(one for one in user.find(kind=Element).elements if one.props.get("data-job") == "contact_loss")
        named = {one.props.get("aria-label"): one for one in fields.descendants()}
        raise_in(named["Points"], "change", " 12 ")
        raise_in(named["Shaft orders"], "change", "yes")
        raise_in(named["Shaft tones"], "change", "")
        run = next(one for one in fields.descendants() if getattr(one, "text", "") == "Run")
        raise_in(run, "click")
        assert session.calls[-1] == ("job", "contact_loss", {"points": 12, "shaft_orders": True})
        session.started.clear()
        raise_in(named["Points"], "change", "many")
        raise_in(run, "click")
        assert not session.started

    look(talk)


def test_a_text_of_a_field_is_read_by_the_type_of_its_option() -> None:
    assert Shape(str, (), True).read("lte; load;", "objectives") == ["lte", "load"]
    assert [Shape(bool, (), False).read(text, "corner") for text in ("yes", "no")] == [True, False]
    for shape, text, allowed in (
        (Shape(int, (), False), "2.5", "a whole number"),
        (Shape(float, (), False), "much", "a number"),
        (Shape(bool, (), False), "maybe", "yes, no"),
        (Shape(str, ("lte", "load"), True), "lte; speed", "lte, load"),
    ):
        with pytest.raises(ModelError, match=rf"^of = .*allowed: {allowed}"):
            shape.read(text, "of")
