"""The whole page of a session, and the page without a model: the ways to one."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from nicegui import ui
from nicegui.element import Element

from ...document.document import drive_titles
from ..canvas.element import SweepPane, TrainPane, send
from ..dialogs.controls import Words, box, button, heard, hide, prop, sentence, show_model
from ..processes.session import Session
from ..state.frames import PageFrame
from ..state.state import opened
from .answers_pane import AnswersPane
from .evidence import EvidenceTabs, ModesList
from .header import Header
from .levers_column import LeversColumn


def empty_page(session: Session, header: Header) -> Element:
    """Open a file, begin a train, or take a ready drive."""
    with box("ck-box ck-empty-page", "section") as root:
        root.props["aria-label"] = "No model is open"
        Words("h2", "Which gear train?", classes="ck-large")
        with box("ck-ways"):
            with button("", header.new_train, classes="ck-drive ck-way"):
                Words("b", "New train")
                Words(text="from teeth or a ratio, power and speed; one page")
            with button("", header.open_model, classes="ck-drive ck-way"):
                Words("b", "Open a model")
                Words(text="a .toml or REXS file; dropping it on the page does as well")
        Words("div", "A ready drive, to look at and to change", classes="ck-pale")
        with box("ck-drives") as drives:
            drives.props["data-keys"] = "go"
            for name, title in drive_titles().items():

                async def show(name: str = name) -> None:
                    show_model(session, await asyncio.to_thread(opened, name), root)

                with button("", show, classes="ck-drive"):
                    Words("b", name)
                    Words(text=title)
    return root


# [s] after which curves of the state before are drawn as such; a newer one is there sooner with nearly every train.
_LATE = 0.4
# [s] by which words follow the curves: the browser builds the whole page anew for a word, which keeps it from drawing.
_WORDS_AFTER = 0.03


def cockpit_page(session: Session) -> None:
    """Build the page of a session in the present slot; it follows the session until it is deleted."""
    ui.add_css(_file("page.css"))
    ui.add_head_html(f"<script>{_file('page.js')}</script>")
    with box("ck-page", "main") as root:
        page = _Page(session, root)
    heard(session, root, frame=page.frame, state=page.follow, failed=page.refuse, jobs=page.jobs)
    page.follow(session)


@cache
def _file(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


class _Page:
    """The parts of the page, and what each hears."""

    def __init__(self, session: Session, root: Element) -> None:
        self._session, self._root = session, root
        self._pinned: dict[str, bytes] = {}
        self._shown_rev = 0
        self._timer: asyncio.TimerHandle | None = None
        self._late = False
        self._head: dict[str, Any] = {}
        self._header = Header(session)
        with box("ck-banner") as self._banner:
            self._banner.props["role"] = "alert"
            Words(text="✗", classes="ck-mark bad")
            self._message = Words(classes="ck-answer-text")
            self._undo = button("Undo", session.undo)
        self._levers = LeversColumn(session)
        self._answers = AnswersPane(
            session,
            show=self._show,
            run=lambda name: self._evidence.run(name),
            cancel=lambda name: self._evidence.cancel(name),
        )
        with box("ck-box ck-train", "section") as train, box("ck-grow"):
            train.props["aria-label"] = "Train"
            self._train = TrainPane()
        with box("ck-box ck-sweep", "section") as sweep, box("ck-grow"):
            sweep.props["aria-label"] = "Sweep"
            self._sweep = SweepPane()
        self._modes = ModesList(self._train.show_mode)
        self._evidence = EvidenceTabs(session)
        self._empty: Element | None = None
        self._sweep.on_speed(session.operate_at)
        for pane in (self._train, self._sweep):
            pane.on_mode(self._chose)
        hide(self._banner, True)

    def _show(self, name: str, mode: int | None) -> None:
        """Show what an answer rests on: a mode where it is about one, with its peaks of the curve, else a tab."""
        if mode is not None:
            self._chose(mode)
        self._evidence.show(name)

    def _chose(self, index: int | None) -> None:
        """A mode was chosen in a pane: the drawing moves, the list marks it."""
        self._modes.chosen(index)
        self._train.show_mode(index)

    def frame(self, packed: bytes, frame: PageFrame) -> None:
        """Show a frame; the panes first, since they are what moves under a lever."""
        send(self._train, packed)
        self._shown_rev = max(self._shown_rev, frame.rev)
        self._draw_late(False)
        if not self._head:
            asyncio.get_running_loop().call_later(_WORDS_AFTER, self._show_words)
        self._head |= frame.head

    def _show_words(self) -> None:
        """Show what the frames say that came meanwhile."""
        head, self._head = self._head, {}
        if self._root.is_deleted:
            return
        session = self._session
        with self._root:
            self._answers.follow(head, moving=session.rev != session.released_rev)
            self._header.frame(head)
            self._modes.follow(head)
            self._show_busy()

    def follow(self, session: Session) -> None:
        """Show a state that has changed."""
        self._header.follow()
        self._levers.follow()
        self._show_busy()
        if self._shown_rev and self._timer is None:
            self._watch()
        self._show_empty(begun=session.rev > 0)
        self._show_pinned()
        self.jobs(session)

    def _watch(self) -> None:
        """Look after a while whether the present state, or a newer one, is shown."""
        rev, session = self._session.rev, self._session
        if self._shown_rev == rev or session.failed is not None:
            return

        def look() -> None:
            self._timer = None
            if self._root.is_deleted:
                return
            if self._shown_rev < rev:
                with self._root:
                    self._draw_late(True)
            self._watch()

        self._timer = asyncio.get_running_loop().call_later(_LATE, look)

    def _draw_late(self, late: bool) -> None:
        if late == self._late:
            return
        self._late = late
        for pane in (self._train, self._sweep, self._evidence.pane):
            pane.stale(late)
        prop(self._root, "data-loading", "true" if late else None)

    def refuse(self, failed: Mapping[str, Any] | None) -> None:
        """Show why a state does not compute, beside its lever or above the page; the last good curves stay."""
        beside = self._levers.refuse(failed)
        self._draw_late(False)
        for pane in (self._train, self._sweep, self._evidence.pane):
            pane.stale(failed is not None)
        prop(self._root, "data-failed", "true" if failed is not None else None)
        hide(self._banner, failed is None or beside)
        hide(self._undo, not self._session.history.undo_label)
        if failed is not None:
            words = [str(failed.get("path") or ""), str(failed.get("message") or "")]
            self._message.say(sentence(": ".join(filter(None, words)), str(failed.get("allowed") or "")))
        self._levers.follow()

    def jobs(self, _: Session) -> None:
        """Show the jobs as they stand."""
        self._evidence.follow()
        self._answers.jobs(self._evidence.newest)

    def _show_pinned(self) -> None:
        """Draw A dashed; its frames may come one after another."""
        frames = dict(self._session.pinned_packed)
        if frames == self._pinned:
            return
        self._pinned = frames
        self._train.ghost(None)
        for packed in frames.values():
            self._train.ghost(packed)

    def _show_busy(self) -> None:
        """A line runs over the page while everything of a released state is computed; a drag needs none."""
        session = self._session
        busy = session.busy and session.rev == session.released_rev
        prop(self._root, "data-busy", "true" if busy else None)

    def _show_empty(self, *, begun: bool) -> None:
        """The ways to a model, where there is none; they are built when they are first seen."""
        is_empty = begun and self._session.state is None
        if is_empty and self._empty is None:
            with self._root:
                self._empty = empty_page(self._session, self._header)
        if self._empty is not None:
            hide(self._empty, not is_empty)
        prop(self._root, "data-empty", "true" if is_empty else None)
        prop(self._root, "data-starting", None if begun else "true")
