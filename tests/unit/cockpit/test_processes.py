"""The live process, its turns and its death; sessions on it."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest
from tests.unit.cockpit import fake_compute

from epicyclic.cockpit.computing.levers import levers_at
from epicyclic.cockpit.processes.session import Session
from epicyclic.cockpit.processes.worker import Client, Spare, Worker
from epicyclic.cockpit.state.frames import PageFrame, Request, pack, unpack
from epicyclic.cockpit.state.state import PageState, StateHistory, Step, opened, request_of, with_value
from epicyclic.errors import ModelError

TEXT = 'format = 2\ntitle = "{}"\n'


@pytest.fixture(autouse=True)
def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs here import nothing; a `Spare` does what it does, but where a test waits for it."""
    monkeypatch.setattr("epicyclic.cockpit.processes.jobs.waiting", fake_compute.waiting)


def run(test: Coroutine[Any, Any, None], seconds: float = 60.0) -> None:
    asyncio.run(asyncio.wait_for(test, seconds))


@asynccontextmanager
async def worker() -> AsyncIterator[Worker]:
    one = Worker(target=fake_compute.serve)
    one.start()
    await asyncio.wait_for(one.ready.wait(), 30)
    try:
        yield one
    finally:
        await one.stop()


async def until(found: Callable[[], object], seconds: float = 90.0) -> None:
    end = time.monotonic() + seconds
    while not found():
        assert time.monotonic() < end, "never"
        await asyncio.sleep(0.005)


class Seen:
    """Frames and failures of a session, in the order in which they came."""

    def __init__(self, session: Session) -> None:
        self.frames: list[PageFrame] = []
        self.failed: list[Any] = []
        session.listen(frame=lambda _, frame: self.frames.append(frame), failed=self.failed.append)


async def begun(one: Worker, title: str = "a") -> tuple[Session, Seen]:
    session = Session(one)
    seen = Seen(session)

    quiet(session)
    await session.start(PageState(name=title, base=TEXT.format(title)))
    return session, seen


def quiet(session: Session) -> None:
    """Have no levers chosen: the models here have no gears."""
    session._ask_levers = lambda: None  # type: ignore[method-assign]


def test_a_full_request_gives_all_its_frames() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            assert [frame.kind for frame in seen.frames] == ["live", "sweep", "sweep", "sharing", "sharing"]
            assert {frame.rev for frame in seen.frames} == {1}
            assert session.frames["sharing"].head["part"] == 3
            await session.close()

    run(test())


def test_a_curve_comes_ahead_of_its_live_frame_and_is_kept_nowhere() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            order: list[tuple[str, int]] = []
            session.listen(
                early=lambda packed: order.append((unpack(packed).kind, unpack(packed).rev)),
                frame=lambda _, frame: order.append((frame.kind, frame.rev)),
            )
            await until(lambda: not session.busy)
            assert order[0] == ("live", 1)  # nothing is shown yet that a curve could go ahead in
            order.clear()
            session.set("damping.modal", 0.5, released=False)
            await until(lambda: not session.busy)
            assert order == [("curve", 2), ("live", 2)]
            assert "curve" not in session.frames
            assert [frame.kind for frame in seen.frames].count("curve") == 0
            await session.close()

    run(test())


def test_a_preview_is_no_step_and_the_last_one_counts() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            shown: list[PageFrame] = []
            session.listen(preview=lambda packed: shown.append(unpack(packed)))
            await until(lambda: not session.busy)
            before = session.history, session.rev, len(seen.frames)
            session.preview({"damping.modal": 0.5})
            session.preview({"damping.modal": 0.6})
            await until(lambda: shown)
            session.preview({"damping.modal": 0.7})
            session.preview(None)  # the pointer has left before it was computed
            await asyncio.sleep(5 * fake_compute.LIVE)
            assert [(frame.kind, frame.rev) for frame in shown] == [("live", -2)]
            assert (session.history, session.rev, len(seen.frames)) == before
            assert not session.busy
            await session.close()

    run(test())


def test_a_drag_does_not_starve_the_picture() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            seen.frames.clear()
            for step in range(60):
                session.set("damping.modal", step / 1000, released=False)
                await asyncio.sleep(0.01)
            last = session.rev
            await until(lambda: not session.busy)
            revs = [frame.rev for frame in seen.frames]
            assert all(frame.kind == "live" for frame in seen.frames)
            assert revs == sorted(set(revs))
            assert revs[-1] == last
            # 0.6 s of a drag, 0.02 s a frame: some 25 pictures, with a slow machine in mind
            assert len(revs) >= 8
            assert len(session.history.behind) == 1
            session.undo()
            assert session.state is not None
            assert not session.state.overrides
            await session.close()

    run(test())


def test_what_is_newer_does_not_wait_for_a_long_frame_of_what_it_replaces() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one, "long")
            await until(lambda: len(seen.frames) == 1)
            await asyncio.sleep(0.1)  # its next frame takes three seconds
            start = time.monotonic()
            session.set("damping.modal", 0.5, released=False)
            await until(lambda: len(seen.frames) == 2)
            assert time.monotonic() - start < 0.9 * fake_compute.LONG * fake_compute.PART
            assert [(frame.rev, frame.kind) for frame in seen.frames] == [(1, "live"), (2, "live")]
            # what another client asks for while a frame is computed is answered after it
            session.set("damping.modal", 0.6, released=True)
            await until(lambda: len(seen.frames) == 3)
            given: list[bytes] = []
            client = Client(deliver=given.append, idle=lambda: None)
            one.join(client)
            one.ask(client, Request(rev=7, kind="levers", source={"title": "b"}))
            await asyncio.sleep(0.1)
            session.set("damping.modal", 0.7, released=False)
            await until(lambda: given, 2)
            await until(lambda: not session.busy)
            assert [unpack(packed).head for packed in given] == [{"levers": [{"path": "b"}]}]
            assert (seen.frames[-1].rev, seen.frames[-1].kind) == (4, "live")
            await session.close()


def test_of_a_page_that_leaves_the_rest_is_dropped_while_another_is_served() -> None:
    async def test() -> None:
        async with worker() as one:
            (first, seen), (other, other_seen) = await begun(one, "a"), await begun(one, "long")
            await until(lambda: seen.frames and len(other_seen.frames) == 1)
            await asyncio.sleep(0.2)  # the next frame of the other takes three seconds
            count = len(seen.frames)
            one.leave(first._client)
            other.set("damping.modal", 0.5, released=False)
            await until(lambda: not other.busy)
            await asyncio.sleep(3 * fake_compute.PART)
            assert len(seen.frames) == count < 5
            one.join(first._client)
            first.set("damping.modal", 0.5, released=True)
            await until(lambda: not first.busy)
            assert [frame.kind for frame in seen.frames[-5:]] == ["live", "sweep", "sweep", "sharing", "sharing"]
            await first.close()
            await other.close()

    run(test())


def test_what_is_newer_takes_the_place_of_the_rest() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: len(seen.frames) == 2)
            session.set("damping.modal", 0.5, released=False)
            await until(lambda: not session.busy)
            kinds = [(frame.rev, frame.kind) for frame in seen.frames]
            assert kinds[:2] == [(1, "live"), (1, "sweep")]
            # the frame at work may be finished, the rest of state 1 is not
            assert kinds[-1] == (2, "live")
            assert len(kinds) <= 4
            await session.close()

    run(test())


def test_two_sessions_take_turns_and_see_their_own() -> None:
    async def test() -> None:
        async with worker() as one:
            (first, one_seen), (second, two_seen) = await begun(one, "a"), await begun(one, "b")
            await until(lambda: not first.busy and not second.busy)
            assert [len(one_seen.frames), len(two_seen.frames)] == [5, 5]
            assert {frame.head.get("title", "a") for frame in one_seen.frames} == {"a"}
            assert {frame.head.get("title", "b") for frame in two_seen.frames} == {"b"}
            first.set("damping.modal", 0.1, released=False)
            assert second.rev == 1
            await first.close()
            await second.close()

    run(test())


def test_a_wrong_value_is_told_and_the_last_picture_stays() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            session.set_text(TEXT.format("refuse"))
            await until(lambda: session.failed is not None)
            assert session.failed is not None
            assert session.failed["path"] == "stages.main.sun.teeth"
            assert session.frames["live"].rev == 1
            session.undo()
            await until(lambda: session.failed is None)
            assert seen.failed[-1] is None
            await session.close()

    run(test())


def test_a_process_that_dies_is_started_again(tmp_path: Path) -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            session.set_text(TEXT.format("die once") + f'doi = "{tmp_path / "died"}"\n')
            await until(lambda: seen.frames[-1].rev == 2)
            session.set_text(TEXT.format("die"))
            await until(lambda: session.failed is not None)
            assert session.failed is not None
            assert "ended" in session.failed["message"]
            session.undo()
            await until(lambda: seen.frames[-1].rev == session.rev)
            await session.close()

    run(test())


def test_a_session_that_is_closed_hears_nothing() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: len(seen.frames) == 1)
            await session.close()
            other, other_seen = await begun(one, "b")
            await until(lambda: not other.busy)
            assert len(seen.frames) == 1
            assert len(other_seen.frames) == 5
            await other.close()

    run(test())


def test_calls_come_back_and_go_with_their_session() -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            assert await session.call(fake_compute.sleep_for, 0.01) == 0.01
            with pytest.raises(ModelError, match=r"a\.b = 3: not so; allowed: 4"):
                await session.call(fake_compute.refuse)
            with pytest.raises(ModelError, match="ended by itself"):
                await session.call(lambda: 3)  # nobody can pickle that
            told: list[float] = []
            session.listen(jobs=lambda page: told.extend(job.progress for job in page.jobs.visible()))
            counted = session.jobs.begin("call", {"function": len, "arguments": ("",)}, model=({}, {}), rev=1)
            counted._task = fake_compute.tell
            await counted.wait()
            assert (counted.status, counted.value) == ("done", 3)
            assert 0.5 in told
            job = session.jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)})
            await until(lambda: job.status == "runs")
            before = time.monotonic()
            session.jobs.cancel(job)
            await asyncio.wait_for(job.wait(), 10)
            assert (job.status, time.monotonic() - before < 10) == ("cancelled", True)
            again = session.jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)})
            third = session.jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)})
            waits = session.jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)})
            await until(lambda: again.status == third.status == "runs")
            assert waits.status == "waits"
            folder = session.jobs.folder
            assert folder.stat().st_mode & 0o777 == 0o700
            await session.close()
            assert not folder.exists()
            assert {job.status for job in (again, third, waits)} == {"cancelled"}

    run(test())
    busy = [one for one in psutil.Process(os.getpid()).children(recursive=True) if one.status() != psutil.STATUS_ZOMBIE]
    names = [" ".join(one.cmdline()) for one in busy]
    assert not [name for name in names if "spawn_main" in name], names


def test_save_asks_before_it_overwrites(tmp_path: Path) -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            assert not session.unsaved
            session.set("damping.modal", 0.25, released=True)
            assert session.unsaved
            file = tmp_path / "a.toml"
            with pytest.raises(ModelError, match="no file yet"):
                await session.save()
            await session.save(file)
            assert "0.25" in file.read_text()
            assert not session.unsaved
            assert session.state is not None
            assert session.state.path == file
            other = tmp_path / "b.toml"
            other.write_text("mine")
            with pytest.raises(ModelError, match="is there already"):
                await session.save(other)
            assert other.read_text() == "mine"
            file.write_text(file.read_text() + "# by another program\n")
            assert session.changed_on_disk()
            session.set("damping.modal", 0.5, released=True)
            with pytest.raises(ModelError, match="changed on disk"):
                await session.save()
            assert "another program" in file.read_text()
            await session.save(force=True)
            assert "0.5" in file.read_text()
            await session.close()

    run(test())


def test_a_snapshot_restores_the_state_and_its_file_by_a_seal(tmp_path: Path) -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            session.set("damping.modal", 0.25, released=True)
            session.pin()
            session.operate_at(1.5)
            await session.save(tmp_path / "a.toml")
            assert not (await restored(one, session.snapshot())).unsaved
            session.set("damping.modal", 0.125, released=True)
            snapshot = json.loads(json.dumps(session.snapshot()))
            other = await restored(one, snapshot)
            assert (other.state, other.unsaved, other.relative_speed) == (session.state, True, 1.5)
            assert other.pinned is not None
            assert dict(other.pinned.overrides) == {"damping.modal": 0.25}
            await until(lambda: "sharing" in other.pinned_packed)
            other.set("damping.modal", 0.25, released=True)
            assert not other.unsaved  # as it lies in the file
            (tmp_path / "a.toml").write_text("# another\n")
            late = await restored(one, snapshot)
            assert late.changed_on_disk()
            for name, wrong in {"file": "/etc/passwd", "trusted": False, "digest": "0", "seal": "\ud800"}.items():
                without = await restored(one, snapshot | {name: wrong})
                assert without.state is not None
                assert (without.state.path, without.state.trusted) == (None, False)
                await without.close()
            for hostile in ({}, {"state": 3}, {"state": "state=x"}):
                with pytest.raises(ModelError):
                    await other.restore(hostile)
            for done in (session, other, late):
                await done.close()

    run(test())


def test_what_was_opened_with_overrides_is_not_kept_as_its_text_alone() -> None:
    async def test() -> None:
        async with worker() as one:
            for overrides, alone in (({}, True), ({"damping.modal": 0.25}, False)):
                session = Session(one)
                quiet(session)
                await session.start(PageState(name="a", base=TEXT.format("a"), overrides=overrides))
                session.set("damping.modal", 0.125, released=True)
                assert session.snapshot()["base_kept"] == alone
                await session.close()

    run(test())


async def restored(one: Worker, snapshot: dict[str, Any]) -> Session:
    session = Session(one)
    quiet(session)
    await session.restore(snapshot)
    return session


def test_a_process_that_cannot_start_is_told_not_tried_for_ever() -> None:
    async def test() -> None:
        one = Worker(target=fake_compute.serve_nothing)
        one.start()
        session = Session(one)
        quiet(session)
        await session.start(PageState(name="a", base=TEXT.format("a")))
        await until(lambda: session.failed is not None)
        assert session.failed is not None
        assert "cannot be started" in session.failed["message"]
        assert not session.busy
        await session.close()
        await one.stop()
        assert own_processes() == []

    run(test())


def own_processes() -> list[psutil.Process]:
    """Processes of the cockpit below this one, with theirs."""
    below = psutil.Process().children(recursive=True)
    return [one for one in below if one.status() != psutil.STATUS_ZOMBIE and "resource_tracker" not in said(one)]


def said(process: psutil.Process) -> str:
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""


def processor_time(of: list[psutil.Process]) -> float:
    """[s] that processes have computed."""
    times = [one.cpu_times() for one in of if one.is_running()]
    return float(sum(time.user + time.system for time in times))


def test_a_closed_page_computes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.cockpit.processes.worker._GONE", 0.5)

    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one, "burn")
            job = session.jobs.start("call", {"function": fake_compute.burn_with_a_helper, "arguments": (120.0,)})
            await until(lambda: job.status == "runs" and len(own_processes()) == 3)
            at_work = {process.pid for process in own_processes()}

            def started_anew() -> bool:
                """Whether the process for other pages stands alone, and the one that computed for this page is gone."""
                now = {process.pid for process in own_processes()}
                return one.ready.is_set() and len(now) == 1 and not now & at_work

            await session.close()
            await until(started_anew)
            before = processor_time(own_processes())
            await asyncio.sleep(0.5)
            assert processor_time(own_processes()) - before < 0.1
            other, seen = await begun(one, "b")
            await until(lambda: len(seen.frames) == 5)
            await other.close()

    run(test())


def test_a_job_is_cancelled_while_levers_answer(tmp_path: Path) -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            await until(lambda: not session.busy)
            marker = tmp_path / "begun"
            job = session.jobs.start("call", {"function": fake_compute.burn_marked, "arguments": (str(marker),)})
            await until(marker.exists)
            assert job.rev == session.rev
            seen.frames.clear()
            session.jobs.cancel(job)
            begin = time.monotonic()
            while not job.ended:
                session.set("damping.modal", time.monotonic(), released=False)
                await asyncio.sleep(0.02)
            assert time.monotonic() - begin < 10
            assert job.status == "cancelled"
            await until(lambda: not session.busy)
            assert len(seen.frames) > 5
            assert seen.frames[-1].rev == session.rev
            await session.close()

    run(test())


def test_memory_stays_flat_over_many_requests() -> None:
    async def test() -> None:
        async with worker() as one:
            session, seen = await begun(one)
            sizes: list[int] = []
            for step in range(200):
                seen.frames.clear()
                session.set("damping.modal", step / 1000, released=False, key="one drag")
                await until(lambda: not session.busy)
                if step in (50, 199):
                    sizes.append(psutil.Process().memory_info().rss)
            assert len(session.history.behind) == 1
            # frames of 80 kB: 150 of them kept would be 12 MB
            assert sizes[1] - sizes[0] < 4e6
            await session.close()

    run(test())


def test_all_pages_together_hold_four_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Five pages with two jobs each and a call: the live process, and three that a job, a call or nobody has."""
    monkeypatch.setattr("epicyclic.cockpit.processes.worker.waiting", fake_compute.waiting)

    async def test() -> None:
        one = Worker(target=fake_compute.serve)
        one.spare = Spare(one.queue)
        one.start()
        pages = [(await begun(one, str(i)))[0] for i in range(5)]
        for page in pages:
            for _ in range(2):
                page.jobs.start("call", {"function": fake_compute.sleep_for, "arguments": (0.3,)})
        jobs = [job for page in pages for job in page.jobs.visible()]
        told: list[Session] = []
        pages[4].listen(waits=told.append)
        calls = [asyncio.create_task(pages[4].call(fake_compute.sleep_for, 0.01 + i / 1000)) for i in range(2)]
        call = calls[0]
        most = 0
        while not all(job.ended for job in jobs):
            most = max(most, len(own_processes()))
            assert sum(job.status == "runs" for job in jobs) <= 2
            if not call.done():  # what a window waits for does not wait for all those jobs
                assert sum(job.ended for job in jobs) < 6
            await asyncio.sleep(0.02)
        assert 3 <= most <= 4, most
        assert {job.status for job in jobs} == {"done"}
        assert await asyncio.gather(*calls) == [0.01, 0.011]
        assert told == [pages[4]]  # the second call had no place, and its window says so
        assert [job.id for job in jobs] == [1, 2] * 5
        first_done = [min(job._begun for job in page.jobs.visible()) for page in pages]
        assert first_done == sorted(first_done)
        # a page that is closed gives its places to the others
        held = [pages[0].jobs.start("call", {"function": fake_compute.burn, "arguments": (60.0,)}) for _ in range(2)]
        waits = pages[1].jobs.start("call", {"function": fake_compute.sleep_for, "arguments": (0.01,)})
        await until(lambda: {job.status for job in held} == {"runs"})
        assert not waits._begun
        await pages[0].close()
        await asyncio.wait_for(waits.wait(), 40)
        assert waits.value == 0.01
        for page in pages[1:]:
            await page.close()
        await one.stop()
        assert own_processes() == []

    run(test(), 200)


def test_a_job_whose_process_dies_says_so() -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            options = {"function": fake_compute.burn, "arguments": (60.0,)}
            job = session.jobs.start("call", options)
            await until(lambda: job._process is not None)
            assert job._process is not None
            os.kill(job._process.pid or 0, 9)
            await asyncio.wait_for(job.wait(), 10)
            assert (job.status, job.died, job.options) == ("failed", True, options)
            assert job.message == "its process was killed (signal 9) at 0 %"
            quit_early = session.jobs.start("call", {"function": os._exit, "arguments": (3,)})
            await asyncio.wait_for(quit_early.wait(), 10)
            assert (quit_early.died, quit_early.message) == (True, "its process ended by itself at 0 %")
            refused = session.jobs.start("call", {"function": fake_compute.refuse, "arguments": ()})
            await asyncio.wait_for(refused.wait(), 10)
            assert (refused.status, refused.died) == ("failed", False)
            await session.close()

    run(test())


def test_a_process_that_waits_takes_the_next_call(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.cockpit.processes.worker.waiting", fake_compute.waiting)

    async def test() -> None:
        spare = Spare()
        one = Worker(target=fake_compute.serve, spare=spare)
        one.start()
        await asyncio.wait_for(one.ready.wait(), 30)
        await until(lambda: spare._process is not None)
        assert spare._process is not None
        waits = spare._process[0].pid
        session, _ = await begun(one)
        assert await session.call(os.getpid) == waits
        assert session.jobs.all == []
        await session.close()
        await one.stop()
        assert own_processes() == []

    run(test())


SERVER = """
import asyncio, time, psutil
from tests.unit.cockpit import fake_compute
from epicyclic.cockpit.state.frames import Request
from epicyclic.cockpit.processes.worker import Client, Worker

async def main():
    one = Worker(target=fake_compute.serve)
    one.start()
    await one.ready.wait()
    client = Client(deliver=print, idle=print)
    one.join(client)
    one.ask(client, Request(rev=1, kind="live", source={"title": "burn"}))
    await asyncio.sleep(0.5)
    print(one._process.pid, flush=True)
    await asyncio.sleep(60)

asyncio.run(main())
"""


def test_the_process_ends_with_a_server_that_is_killed() -> None:
    server = subprocess.Popen([sys.executable, "-c", SERVER], stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    with server.stdout:
        process = psutil.Process(int(server.stdout.readline()))
        server.kill()
        server.wait()
    assert psutil.wait_procs([process], timeout=10)[1] == []


def test_a_click_on_a_speed_is_a_step_and_the_file_is_that_of_all_steps(tmp_path: Path) -> None:
    async def test() -> None:
        session = Session(Worker(target=fake_compute.serve))
        quiet(session)
        session.history = StateHistory(now=Step(state=PageState(name="a", base=TEXT.format("a"))))
        session.operate_at(1e9)
        session.set("damping.modal", 0.25, released=True)
        assert (session.relative_speed, session.history.undo_label) == (100.0, "damping.modal = 0.25")
        await session.save(tmp_path / "a.toml")
        session.undo()
        assert session.unsaved
        assert session.state is not None
        assert (session.state.path, session.relative_speed) == (tmp_path / "a.toml", 100.0)
        session.undo()
        assert session.relative_speed == 1.0
        await session.save()
        assert (tmp_path / "a.toml").read_text() == TEXT.format("a")
        session.redo()
        session.redo()
        assert dict(session.state.overrides) == {}
        assert session.unsaved
        await session.close()

    run(test())


def test_a_page_that_is_opened_again_has_the_same_levers() -> None:
    first = levers_at(*request_of(opened("ren2021")))
    moved = with_value(opened("ren2021"), "deviations.carrier.run_out", "90 um")
    again = levers_at(*request_of(with_value(moved, first[0].path, "[0, 0, 0] um")))
    assert [one.path for one in again] == [one.path for one in first]


def test_undo_shows_no_levers_of_the_other_model() -> None:
    async def test() -> None:
        async with worker() as one:
            asked: list[str] = []
            session = Session(one)
            deliver = session._client_of_levers.deliver

            def told(packed: bytes) -> None:
                asked.append(unpack(packed).head["levers"][0]["path"])
                deliver(packed)

            session._client_of_levers.deliver = told
            await session.start(PageState(name="a", base=TEXT.format("a")))
            await until(lambda: session.levers)
            await session.open(PageState(name="b", base=TEXT.format("b")))
            assert session.levers == ()
            await until(lambda: session.levers)
            shown: list[Any] = []
            session.listen(state=lambda one: shown.append((one.state and one.state.name, one.levers)))
            session.undo()
            session.redo()
            assert shown == [("a", ({"path": "a"},)), ("b", ({"path": "b"},))]
            assert asked == ["a", "b"]
            await session.close()

    run(test())


def test_a_result_belongs_to_every_state_of_its_model() -> None:
    async def test() -> None:
        async with worker() as one:
            session, _ = await begun(one)
            await until(lambda: not session.busy)
            session.set("damping.modal", 0.5, released=True)
            job = session.jobs.start("relief")
            session.jobs.cancel(job)  # nothing is computed here
            frame = PageFrame(rev=session.rev, kind="job", head={"job": {"name": "relief"}})
            job.frame, job.packed = frame, pack(frame)
            session.set("damping.modal", 0.6, released=True)
            assert job.rev == session.rev - 1
            session.undo()
            assert job.rev == session.rev
            assert job.packed is not None
            assert unpack(job.packed).rev == session.rev
            await session.close()

    run(test())
