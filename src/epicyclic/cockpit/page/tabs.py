"""The tabs of a browser, and the session of each.

A session begins when a browser has said what it kept.  A tab that is loaded anew takes its session over whole, by a
secret that it alone has: states, frames, jobs.  So a session stays for some minutes after its tab has gone; its jobs
end after some seconds, since nobody may come back.  Beside that the browser keeps the state itself, which comes back
after a restart of the server, with words on what does not.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from nicegui import Client, ui

from ...errors import ModelError
from ..processes.session import Session
from ..processes.worker import start_worker, stop_worker
from ..state.state import PageState, from_fragment
from .controls import Later, literal
from .page import cockpit_page

# [s] between two writings: a drag has one, not one for each move
KEEP_SECONDS = 0.4
# [byte] of an entry: browsers give a site about 5 MB, of UTF-16
MOST_KEPT = 1_000_000
_BUILT = 10.0  # [s] a page may take to be built, on a machine that computes besides
_ANSWERED = 10.0  # [s] a browser may take to say what it kept
_CONNECTED = 30.0  # [s] a browser may take to connect: a page opened ahead of its reader never does
# [s] after the server has given up a tab, which takes `reconnect_timeout` of it: its jobs end, its session ends
_JOBS_STAY, _SESSION_STAY = 6.0, 300.0
_MOST_LEFT = 8  # sessions that wait for their tab, the newest
_SECRET = 24  # [byte], not to be guessed
_GOING = 2.0  # [s] that the connection of a page that is loaded anew may take to be known as closed


@dataclass
class _Tab:
    session: Session
    client: Client
    timers: list[asyncio.TimerHandle] = field(default_factory=list)


class Tabs:
    """Sessions by the secret of their tab: of those that are open, then of those that have gone, the oldest first."""

    def __init__(self) -> None:
        self._tabs: dict[str, _Tab] = {}
        self._ending: set[asyncio.Task[None]] = set()

    def open(self, session: Session, client: Client) -> str:
        """The secret of a tab that is opened with a session."""
        secret = secrets.token_urlsafe(_SECRET)
        self._tabs[secret] = _Tab(session, client)
        client.on_delete(lambda: self._left(secret))
        return secret

    async def take(self, secret: object) -> Session | None:
        """The session of a tab that has gone, once; None where there is none, or the tab is there still."""
        tab = self._tabs.get(secret) if isinstance(secret, str) else None
        if tab is None:
            return None
        end = asyncio.get_running_loop().time() + _GOING
        while (is_there := tab.client.has_socket_connection) and asyncio.get_running_loop().time() < end:
            await asyncio.sleep(0.05)
        if is_there or self._tabs.pop(str(secret), None) is None:
            return None
        for timer in tab.timers:
            timer.cancel()
        return tab.session

    def _left(self, secret: str) -> None:
        """A tab has gone, perhaps to come back."""
        if (tab := self._tabs.pop(secret, None)) is None:
            return  # it has come back already
        self._tabs[secret] = tab  # behind those that went before
        if tab.session.state is None and not tab.session.history.ahead:  # there is nothing to come back to
            self._forget(secret)
            return
        tab.session.leave()
        why = f"its page was gone for more than {_JOBS_STAY:g} s"
        loop = asyncio.get_running_loop()
        tab.timers = [
            loop.call_later(_JOBS_STAY, tab.session.jobs.cancel_all, why),
            loop.call_later(_SESSION_STAY, self._forget, secret),
        ]
        left = [name for name, other in self._tabs.items() if other.timers]
        for name in left[: max(0, len(left) - _MOST_LEFT)]:
            self._forget(name)

    def _forget(self, secret: str) -> None:
        ending = asyncio.get_running_loop().create_task(self._end(secret))
        self._ending.add(ending)
        ending.add_done_callback(self._ending.discard)

    async def _end(self, secret: str) -> None:
        if (tab := self._tabs.pop(secret, None)) is not None:
            for timer in tab.timers:
                timer.cancel()
            await tab.session.close()

    async def close(self) -> None:
        """End all."""
        await asyncio.gather(*self._ending, *(self._end(secret) for secret in list(self._tabs)))


def mount(state: PageState | None) -> Callable[[Any], AbstractAsyncContextManager[None]]:
    """Register the page of the cockpit.

    Parameters
    ----------
    state : each tab begins with; None is the empty page.

    Returns
    -------
    lifespan : of the application: at its end every session is closed.
    """
    tabs = Tabs()
    recovery = Path(__file__).with_name("recovery.js").read_text(encoding="utf-8")  # window.cockpitRecovery

    @ui.page("/", response_timeout=_BUILT)
    async def cockpit() -> None:
        client = ui.context.client
        ui.add_head_html(f"<script>{recovery}</script>")
        session = Session()
        secret = tabs.open(session, client)
        client.on_exception(_tell)
        _keep(session, client)
        cockpit_page(session)
        await client.connected(timeout=_CONNECTED)
        await _begin(session, state, tabs, secret)

    @asynccontextmanager
    async def lifespan(_: Any) -> AsyncIterator[None]:
        worker = start_worker()  # it is warm when the first page asks
        try:
            yield
        finally:
            worker.queue.stop()
            await tabs.close()
            await stop_worker()

    return lifespan


async def _begin(session: Session, state: PageState | None, tabs: Tabs, secret: str) -> None:
    """Open what a link brings, as a step after what the tab had; else that, else what the command line named."""
    call = f"return await cockpitRecovery.begin({literal(secret)})"
    try:
        kept = await ui.run_javascript(call, timeout=_ANSWERED)
    except TimeoutError:  # the tab is gone, or too busy: it begins anew when it can
        ui.navigate.reload()
        return
    brought = kept if isinstance(kept, Mapping) else {}
    begun = False
    held = brought.get("secrets")
    for former in held if isinstance(held, list) else ():
        if (before := await tabs.take(former)) is None:
            continue
        if before.rev and not begun:
            session.take_over(before)
            begun = True
        await before.close()  # it has nothing more
    if not begun and (snapshot := brought.get("snapshot")):
        try:
            content = _read(snapshot)
            await session.restore(content)
            begun = True
            if held and (lost := lost_words(content)):
                ui.notify(lost, type="warning", timeout=0, multi_line=True, close_button="Close")
        except ModelError as error:
            ui.notify(f"What this tab had cannot be restored: {error}", type="warning", close_button="Close")
    if link := brought.get("link"):
        try:
            linked = from_fragment(str(link))
            # what the tab had is one undo away
            await (session.open(linked, unsaved=True) if begun else session.start(linked))
            return
        except ModelError as error:
            ui.notify(f"The link cannot be opened: {error}", type="negative", timeout=0, close_button="Close")
    if begun:
        return
    await session.start(state)
    for entry in brought.get("left") or []:
        _offer(session, entry)


def lost_words(snapshot: Mapping[str, object]) -> str:
    """What a snapshot says that the session had, and no browser keeps; empty where there was nothing."""
    steps, results = (
        number if isinstance(number := snapshot.get(name), int) and not isinstance(number, bool) else 0
        for name in ("steps", "results")
    )
    lost = [f"{steps} step{'s' * (steps != 1)} of undo"] if steps > 0 else []
    lost += [f"the result{'s' * (results != 1)} of {results} job{'s' * (results != 1)}"] if results > 0 else []
    if not lost:
        return ""
    why = f"the server was started anew, or the page was gone for more than {_SESSION_STAY / 60:.0f} min"
    return f"The model is as it was. Not kept: {' and '.join(lost)}; {why}."


def _offer(session: Session, entry: object) -> None:
    """Offer the unsaved changes of a tab that is gone."""
    if not isinstance(entry, Mapping):
        return
    name, title, when = (json.dumps(str(entry.get("name"))), str(entry.get("title"))[:60], entry.get("time"))
    clock = f" of {datetime.fromtimestamp(when / 1000):%d %b %H:%M}" if isinstance(when, int | float) else ""

    async def restore() -> None:
        snapshot = await ui.run_javascript(f"return cockpitRecovery.take({name})", timeout=_ANSWERED)
        try:
            await session.restore(_read(snapshot))
        except ModelError as error:
            ui.notify(f"It cannot be restored: {error}", type="negative", close_button="Close")
        else:
            forget()

    def forget() -> None:
        ui.run_javascript(f"cockpitRecovery.drop({name})")
        bar.delete()

    with ui.row().classes("cockpit-offer fixed-bottom items-center q-pa-sm").props('role="status"') as bar:
        ui.label(f"{title}: unsaved changes{clock} were left in a closed tab.")
        ui.button("Restore", on_click=restore).props("dense flat no-caps")
        ui.button("Forget", on_click=forget).props("dense flat no-caps")


def _read(snapshot: object) -> dict[str, object]:
    """A snapshot as the browser gives it back: its values are asked by the session.

    Raises
    ------
    ModelError : it is none.
    """
    try:
        read = json.loads(str(snapshot))
    except (ValueError, RecursionError):
        read = None
    if not isinstance(read, dict):
        raise ModelError("is no snapshot", path="kept state")
    return read


def _keep(session: Session, client: Client) -> None:
    """Have the browser keep the state a moment after it has changed; say once where it cannot."""
    told, results = False, 0

    async def write() -> None:
        nonlocal told
        if not session.rev:
            return
        text = json.dumps(session.snapshot())
        title = session.state.name if session.state is not None else ""
        kept = "" if len(text) > MOST_KEPT or session.state is None else text
        call = f"cockpitRecovery.keep({literal(kept)}, {literal(title)}, {literal(session.unsaved)})"
        try:
            is_kept = await client.run_javascript(f"return {call}", timeout=_ANSWERED)
        except TimeoutError:  # the tab is gone, or does not answer
            return
        if is_kept is False and session.state is not None and not told and not client.is_deleted:
            told = True
            with client:
                words = f"The browser cannot keep this model ({len(text) / 1e6:.1f} MB)"
                ui.notify(f"{words}: save it, a restart of the server would lose it.", type="warning", timeout=0)

    later = Later(client.layout, write)

    def changed(_: Session) -> None:
        later.ask(KEEP_SECONDS)

    def of_jobs(_: Session) -> None:
        nonlocal results
        done = sum(job.status == "done" for job in session.jobs.visible())
        if done != results:
            results = done
            changed(session)

    session.listen(state=changed, jobs=of_jobs, looked=changed)


def _tell(error: Exception) -> None:
    """Say what went wrong in a handler, where no pane did: nobody reads the terminal."""
    if isinstance(error, ModelError):
        ui.notify(str(error), type="negative", close_button="Close")
    else:
        ui.notify(f"A fault of epicyclic itself: {type(error).__name__}: {error}", type="negative", timeout=0)
