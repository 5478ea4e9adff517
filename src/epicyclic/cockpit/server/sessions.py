"""A session for each tab: begun when its browser has said what it kept, ended when the tab is gone.

What a tab keeps of its state comes back after a reload and after a restart of the server.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

from nicegui import Client, background_tasks, ui

from ...errors import ModelError
from ..dialogs.controls import literal
from ..page.page import cockpit_page
from ..processes.session import Session
from ..processes.worker import start_worker, stop_worker
from ..state.history import from_fragment
from ..state.state import PageState

# [s] between two writings: a drag has one, not one for each move
KEEP_SECONDS = 0.4
# [byte] of an entry: browsers give a site about 5 MB, of UTF-16
MOST_KEPT = 1_000_000


_BUILT = 10.0  # [s] a page may take to be built, on a machine that computes besides
_ANSWERED = 10.0  # [s] a browser may take to say what it kept
_CONNECTED = 30.0  # [s] a browser may take to connect: a page opened ahead of its reader never does


def mount(state: PageState | None) -> Callable[[Any], AbstractAsyncContextManager[None]]:
    """Register the page of the cockpit.

    Parameters
    ----------
    state : each tab begins with; None is the empty page.

    Returns
    -------
    lifespan : of the application: at its end every session is closed.
    """
    live: dict[str, Session] = {}
    recovery = Path(__file__).with_name("recovery.js").read_text(encoding="utf-8")  # window.cockpitRecovery

    @ui.page("/", response_timeout=_BUILT)
    async def cockpit() -> None:
        client = ui.context.client
        ui.add_head_html(f"<script>{recovery}</script>")
        session = live[client.id] = Session()
        client.on_delete(lambda: _end(live, client.id))
        client.on_exception(_tell)
        _keep(session, client)
        cockpit_page(session)
        await client.connected(timeout=_CONNECTED)
        await _begin(session, state)

    @asynccontextmanager
    async def lifespan(_: Any) -> AsyncIterator[None]:
        start_worker()  # it is warm when the first page asks
        try:
            yield
        finally:
            for name in list(live):
                await _end(live, name)
            await stop_worker()

    return lifespan


async def _end(live: dict[str, Session], name: str) -> None:
    if (session := live.pop(name, None)) is not None:
        await session.close()


async def _begin(session: Session, state: PageState | None) -> None:
    """Open what a link brings, as a step after what the tab had; else that, else what the command line named."""
    kept = await ui.run_javascript("return await cockpitRecovery.begin()", timeout=_ANSWERED)
    brought = kept if isinstance(kept, Mapping) else {}
    begun = False
    if snapshot := brought.get("snapshot"):
        try:
            await session.restore(_read(snapshot))
            begun = True
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
    """Have the browser keep the state a moment after it has changed."""
    waiting = False

    async def write() -> None:
        nonlocal waiting
        await asyncio.sleep(KEEP_SECONDS)
        waiting = False
        text = json.dumps(session.snapshot())
        if client.is_deleted or len(text) > MOST_KEPT:
            return
        title = session.state.name if session.state is not None else ""
        client.run_javascript(f"cockpitRecovery.keep({literal(text)}, {literal(title)}, {literal(session.unsaved)})")

    def changed(_: Session) -> None:
        nonlocal waiting
        if not waiting:
            waiting = True
            background_tasks.create(write())

    session.listen(state=changed)


def _tell(error: Exception) -> None:
    """Say what went wrong in a handler, where no pane did: nobody reads the terminal."""
    if isinstance(error, ModelError):
        ui.notify(str(error), type="negative", close_button="Close")
    else:
        ui.notify(f"A fault of epicyclic itself: {type(error).__name__}: {error}", type="negative", timeout=0)
