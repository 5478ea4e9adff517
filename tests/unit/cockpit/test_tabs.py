"""Sessions of tabs that are loaded anew, closed, copied; what a browser keeps and what it does not."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest
from tests.unit.cockpit import fake_compute
from tests.unit.cockpit.test_processes import Seen, begun, quiet, run, until, worker

from epicyclic.cockpit.page import tabs
from epicyclic.cockpit.page.tabs import Tabs, lost_words
from epicyclic.cockpit.processes.session import Session
from epicyclic.cockpit.state.frames import PageFrame, pack
from epicyclic.cockpit.state.state import PageState

TEXT = 'format = 2\ntitle = "{}"\n'


@pytest.fixture(autouse=True)
def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs here import nothing."""
    monkeypatch.setattr("epicyclic.cockpit.processes.jobs.waiting", fake_compute.waiting)


class Browser:
    """The connection of a tab."""

    def __init__(self) -> None:
        self.has_socket_connection = True
        self._gone: list[Callable[[], Any]] = []

    def on_delete(self, call: Callable[[], Any]) -> None:
        self._gone.append(call)

    def close(self) -> None:
        self.has_socket_connection = False

    def delete(self) -> None:
        self.close()
        for call in self._gone:
            call()


def test_a_tab_that_is_loaded_anew_has_all_it_had() -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            session.set("damping.modal", 0.1, released=True)
            session.set("damping.modal", 0.2, released=True)
            session.undo()
            session.pin()
            session.looked(tab="relief", mode=3)
            done = session.jobs.start("call", {"function": fake_compute.sleep_for, "arguments": (0.01,)})
            await until(lambda: done.ended and not session.busy)
            runs = session.jobs.start("call", {"function": fake_compute.sleep_for, "arguments": (1.0,)})
            folder = session.jobs.folder
            other, seen = Session(one), None
            quiet(other)
            seen = Seen(other)
            views: list[Any] = []
            told: list[Any] = []
            other.listen(view=lambda page: views.append(dict(page.view)), jobs=told.append)
            other.take_over(session)
            assert [frame.kind for frame in seen.frames] == ["live", "sweep", "sharing"]
            assert (other.history.undo_label, other.history.redo_label) == (
                "damping.modal = 0.1",
                "damping.modal = 0.2",
            )
            assert other.state is not None
            assert dict(other.state.overrides) == {"damping.modal": 0.1}
            assert other.pinned == other.state
            assert views == [{"tab": "relief", "mode": 3}]
            assert other.jobs.visible() == [done, runs]
            assert (done.rev, done.value) == (other.rev, 0.01)  # it belongs to the present state
            assert session.jobs.all == []
            await session.close()
            assert folder.exists()  # with the results
            await asyncio.wait_for(runs.wait(), 20)
            assert runs.status == "done"
            assert told
            await until(lambda: not other.busy)
            assert seen.frames[-1].rev == other.rev
            other.redo()
            await until(lambda: not other.busy)
            assert seen.frames[-1].rev == other.rev
            await other.close()
            assert not folder.exists()

    run(test())


def test_a_secret_takes_one_session_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tabs, "_GOING", 0.1)

    async def test() -> None:
        async with worker() as one:
            kept = Tabs()
            (session, _), browser = await begun(one), Browser()
            secret = kept.open(session, browser)  # type: ignore[arg-type]
            assert len(secret) >= 32
            assert await kept.take(secret) is None  # the tab is there: that is a copy of it
            for wrong in (None, "", secret[:-1], 3, [secret]):
                assert await kept.take(wrong) is None
            browser.close()
            both = await asyncio.gather(kept.take(secret), kept.take(secret))
            assert [one for one in both if one is not None] == [session]
            assert await kept.take(secret) is None
            browser.delete()  # what the server says later of the page that was left
            assert not session.closed
            await session.close()
            await kept.close()

    run(test())


def test_a_tab_that_has_gone_ends_its_jobs_then_its_session(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tabs, "_JOBS_STAY", 0.2)
    monkeypatch.setattr(tabs, "_SESSION_STAY", 1.5)

    async def test() -> None:
        async with worker() as one:
            kept = Tabs()
            (session, _), browser = await begun(one), Browser()
            secret = kept.open(session, browser)  # type: ignore[arg-type]
            job = session.jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)})
            await until(lambda: job.status == "runs")
            browser.delete()
            assert not job.ended
            await asyncio.wait_for(job.wait(), 10)
            assert (job.status, job.message) == ("cancelled", "its page was gone for more than 0.2 s")
            assert not session.closed
            await until(lambda: session.closed)
            assert await kept.take(secret) is None
            # one that comes back in between stays
            (again, _), browser = await begun(one), Browser()
            secret = kept.open(again, browser)  # type: ignore[arg-type]
            browser.delete()
            assert await kept.take(secret) is again
            await asyncio.sleep(1.7)
            assert not again.closed
            await again.close()
            await kept.close()

    run(test())


def test_few_sessions_wait_for_their_tabs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tabs, "_MOST_LEFT", 2)

    async def test() -> None:
        async with worker() as one:
            kept, sessions = Tabs(), []
            open_still, _ = await begun(one)
            kept.open(open_still, Browser())  # type: ignore[arg-type]
            for _ in range(4):
                (session, _), browser = await begun(one), Browser()
                kept.open(session, browser)  # type: ignore[arg-type]
                browser.delete()
                sessions.append(session)
            empty, browser = Session(one), Browser()
            kept.open(empty, browser)  # type: ignore[arg-type]
            browser.delete()  # there is nothing to come back to
            await until(lambda: empty.closed and sessions[1].closed)
            assert [session.closed for session in sessions] == [True, True, False, False]
            await kept.close()
            assert all(session.closed for session in [*sessions, open_still])

    run(test())


def test_a_snapshot_says_what_it_does_not_hold() -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            assert lost_words(session.snapshot()) == ""
            session.set("damping.modal", 0.1, released=True)
            assert lost_words(session.snapshot()).startswith(
                "The model is as it was. Not kept: 1 step of undo; the server"
            )
            session.set("damping.modal", 0.2, released=True)
            session.undo()
            for _ in range(2):
                job = session.jobs.start("call", {"function": fake_compute.sleep_for, "arguments": (0.01,)})
                await job.wait()
            told = "Not kept: 2 steps of undo and the results of 2 jobs; the server was started anew"
            assert told in lost_words(session.snapshot())
            session.looked(tab="relief", mode=1)
            other = Session(one)
            quiet(other)
            await other.restore(session.snapshot())
            assert other.view == {"tab": "relief", "mode": 1}
            await session.close()
            await other.close()
        for hostile in ({}, {"steps": True, "results": "many"}, {"steps": -3, "results": [1]}):
            assert lost_words(hostile) == ""

    run(test())


def test_figures_of_another_model_are_dropped_where_a_new_one_fails() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            assert not session.is_of_another_model
            # an edit of the same model that fails: the last good figures stay, and it is said whose they are
            session.set_text(TEXT.format("refuse"))
            await until(lambda: session.failed is not None)
            assert session.frames
            assert session.computed_words() == "The pale figures are those before “edit the text”"
            session.undo()
            await until(lambda: session.failed is None)
            # another file, even of the same name: nothing of the one before stands under its title
            await session.open(PageState(name="a", base=TEXT.format("refuse")))
            assert session.is_of_another_model
            await until(lambda: session.failed is not None)
            assert (session.frames, session.packed, session.computed_words()) == ({}, {}, "")
            count = len(seen.frames)
            late = PageFrame(rev=session.rev - 1, kind="live")
            session._deliver(pack(late))  # of the model before, computed meanwhile
            assert (len(seen.frames), session.frames) == (count, {})
            other = Session(one)
            quiet(other)
            other.take_over(session)
            assert other.is_of_another_model
            other.undo()
            await until(lambda: other.failed is None and not other.busy)
            assert not other.is_of_another_model
            await session.close()
            await other.close()

    run(test())
