"""The whole page of a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nicegui import ui

from ...studies.drives import drive_titles
from ..canvas.element import SweepPane, TrainPane, send
from ..dialogs.open_model import open_window
from ..dialogs.parts import heard
from ..dialogs.wizard import new_window
from ..processes.session import Session
from ..state.state import opened
from .answers_pane import AnswersPane
from .controls import Words, box, button, hide
from .evidence_tabs import EvidenceTabs
from .header import Header
from .levers_column import LeversColumn
from .modes_list import ModesList

__all__ = ["cockpit_page"]


def cockpit_page(session: Session) -> None:
    """Build the page of a session in the present slot; it follows the session until it is deleted."""
    ui.add_css(Path(__file__).with_name("page.css").read_text(encoding="utf-8"))
    with box("ck-page", "main") as root:
        page = _Page(session)
    heard(session, root, frame=page.frame, state=page.follow, failed=page.refuse, jobs=page.jobs)
    page.follow(session)


class _Page:
    """The parts of the page, and what each hears."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._pinned: object = None
        self._header = Header(session)
        with box("ck-banner") as self._banner:
            self._banner.props["role"] = "alert"
            Words(text="!", classes="ck-mark bad")
            self._message = Words()
        self._parts = [box("ck-box ck-train")]
        with self._parts[0], box("ck-grow"):
            self._train = TrainPane()
        self._levers = LeversColumn(session)
        self._evidence = EvidenceTabs(session)
        self._answers = AnswersPane(session, show=self._show, run=self._evidence.run)
        self._modes = ModesList(self._train.show_mode)
        with box("ck-box ck-sweep"), box("ck-grow"):
            self._sweep = SweepPane()
        self._empty = _empty_page(session)
        self._sweep.on_speed(session.operate_at)
        for pane in (self._train, self._sweep):
            pane.on_mode(self._chose)
        hide(self._banner, True)

    def _chose(self, index: int | None) -> None:
        """A mode was chosen in a pane: the drawing moves, the list marks it."""
        self._modes.chosen(index)
        self._train.show_mode(index)

    def _show(self, evidence: str) -> None:
        self._evidence.show(evidence)

    def frame(self, packed: bytes, frame: Any) -> None:
        send(self._train, packed)
        head: Mapping[str, Any] = frame.head
        self._answers.follow(head)
        self._header.frame(head)
        self._modes.follow(head)

    def follow(self, session: Session) -> None:
        self._header.follow()
        self._levers.follow()
        hide(self._empty, session.state is not None)
        if session.pinned is not self._pinned:
            self._pinned = session.pinned
            self._train.ghost(None)
            for packed in session.pinned_packed.values():
                self._train.ghost(packed)

    def refuse(self, failed: Mapping[str, Any] | None) -> None:
        """Show why a state does not compute, beside its lever or above the page; the last good curves stay."""
        beside = self._levers.refuse(failed)
        for pane in (self._train, self._sweep, self._evidence.pane):
            pane.stale(failed is not None)
        hide(self._banner, failed is None or beside)
        if failed is not None:
            words = [str(failed.get("path") or ""), str(failed.get("message") or "")]
            text = ": ".join(word for word in words if word)
            self._message.say(f"{text}; allowed: {failed['allowed']}" if failed.get("allowed") else text)

    def jobs(self, _: Session) -> None:
        self._evidence.follow()


def _empty_page(session: Session) -> Any:
    """What a page without a model shows: the ways to one."""
    with box("ck-box ck-empty-page") as root:
        Words("div", "Which gear train?", classes="text-h6")
        with box("row"):
            button("Open a model file ...", lambda: open_window(session), classes="ck-small ck-main")
            Words(text=" ")
            button("New train from teeth or ratio ...", lambda: new_window(session), classes="ck-small ck-main")
        Words("div", "or a ready drive, to look at and to change:", classes="ck-pale")
        with box("ck-drives"):
            for name, title in drive_titles().items():
                button(f"{name}: {title}", _opener(session, name), classes="ck-drive")
    return root


def _opener(session: Session, name: str) -> Callable[[], Any]:
    async def show() -> None:
        await session.open(opened(name))

    return show
