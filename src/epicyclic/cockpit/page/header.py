"""The header: which drive, what can be done with it, what it warns of, and the theme."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from ..dialogs.compare import compare_controls
from ..dialogs.link import link_button
from ..dialogs.open_model import open_button
from ..dialogs.parts import icon_button
from ..dialogs.save import save_buttons
from ..dialogs.take_away import take_away_button
from ..dialogs.undo import undo_buttons
from ..dialogs.wizard import new_button
from ..processes.session import Session
from .controls import Words, box, hide, prop

__all__ = ["Header"]

_THEMES = {None: ("brightness_auto", True), True: ("dark_mode", False), False: ("light_mode", None)}


class Header:
    """Controls over the whole page."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._told: object = None
        with box("ck-head", "header"):
            self._name = Words("h1", classes="ck-name")
            self._name.props["data-testid"] = "name"
            open_button(session)
            new_button(session)
            box("ck-split")
            undo_buttons(session)
            save_buttons(session)
            box("ck-split")
            with ui.button().props("flat dense no-caps size=sm").classes("ck-warnings") as self._warnings:
                self._list = ui.menu().classes("ck-wide")
            self._facts = Words(classes="ck-facts")
            compare_controls(session)
            link_button(session)
            take_away_button(session)
            self._dark = ui.dark_mode(None)
            self._theme = icon_button("brightness_auto", "Theme", self._next_theme)
        hide(self._warnings, True)

    def _next_theme(self) -> None:
        self._dark.value = _THEMES[self._dark.value][1]
        self._theme.props["icon"] = _THEMES[self._dark.value][0]
        self._theme.update()

    def follow(self) -> None:
        """Show the name of the state and whether it is saved."""
        state = self._session.state
        self._name.say("" if state is None else f"{state.name}{' *' if self._session.unsaved else ''}")
        prop(self._name, "title", "" if state is None else str(state.path or state.name))

    def frame(self, head: Mapping[str, Any]) -> None:
        """Show facts and warnings of a frame that brings them."""
        if isinstance(head.get("state"), Mapping):
            self._facts.say(_facts(head["state"]))
            prop(self._facts, "title", self._facts.text)
        if "checks" not in head:
            return
        checks = [(str(one.get("level")), str(one["text"])) for one in head["checks"]]
        if checks == self._told:
            return
        self._told = checks
        hide(self._warnings, not checks)
        self._warnings.set_text(f"{len(checks)} warning{'s' * (len(checks) != 1)}")
        self._list.clear()
        with self._list:
            for level, text in checks:
                with ui.item().props("dense"), ui.item_section():
                    Words(text=f"{'✗' if level == 'bad' else '!'} {text}")


def _facts(state: Mapping[str, Any]) -> str:
    """Ratio, speeds and torques in one line."""
    parts = [] if state.get("ratio") is None else [f"ratio {float(state['ratio']):.4g}"]
    for name in ("speeds", "torques"):
        for entry in state.get(name) or ():
            member, value, unit = entry
            if value:
                parts.append(f"{member} {float(value):.4g} {unit}")
    return " · ".join(parts)
