"""The page without a model: the ways to one."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from nicegui.element import Element

from ...document.drives import drive_titles
from ..dialogs.open_model import open_window
from ..dialogs.parts import show_model
from ..dialogs.wizard import new_window
from ..processes.session import Session
from ..state.state import opened
from .controls import Words, box, button

__all__ = ["empty_page"]


def empty_page(session: Session) -> Element:
    """Open a file, begin a train, or take a ready drive."""
    with box("ck-box ck-empty-page", "section") as root:
        root.props["aria-label"] = "No model is open"
        Words("h2", "Which gear train?", classes="ck-large")
        with box("ck-ways"):
            _way("New train", "from teeth or a ratio, power and speed; one page", lambda: new_window(session))
            _way("Open a model", "a .toml or REXS file; dropping it on the page does as well", _open(session))
        Words("div", "A ready drive, to look at and to change", classes="ck-pale")
        with box("ck-drives") as drives:
            drives.props["data-keys"] = "go"
            for name, title in drive_titles().items():
                with button("", _drive(session, name, root), classes="ck-drive"):
                    Words("b", name)
                    Words(text=title)
    return root


def _way(name: str, words: str, go: Callable[[], object]) -> None:
    with button("", go, classes="ck-drive ck-way"):
        Words("b", name)
        Words(text=words)


def _open(session: Session) -> Callable[[], Awaitable[None]]:
    return lambda: open_window(session)


def _drive(session: Session, name: str, root: Element) -> Callable[[], Awaitable[None]]:
    async def show() -> None:
        show_model(session, await asyncio.to_thread(opened, name), root)

    return show
