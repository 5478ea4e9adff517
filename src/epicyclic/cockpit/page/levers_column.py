"""The levers: a slider and a number box each, which follow the state and ask for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from ..dialogs.fields_panel import fields_panel
from ..dialogs.text_panel import text_panel
from ..processes.session import Session
from .controls import Words, box
from .lever import LeverControl

__all__ = ["LeversColumn"]


class LeversColumn:
    """The levers of a session; built anew when another model brings other levers."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._shown: object = None  # levers and words that stand on the page
        self._levers: list[LeverControl] = []
        with box("ck-box ck-levers", "section") as root:
            root.props["aria-label"] = "Levers"
            with box("ck-title"):
                Words("h2", "Levers")
            self._list = box("ck-lever-list")
            with ui.expansion("All fields").classes("ck-fold").props("dense dense-toggle") as fields:
                pass
            with ui.expansion("Model text (TOML)").classes("ck-fold").props("dense dense-toggle") as text:
                pass
        self._fold(fields, fields_panel)
        self._fold(text, text_panel)

    def _fold(self, fold: ui.expansion, panel: Any) -> None:
        """Build a panel when it is first unfolded: its widgets cost a second."""
        built = False

        def opened(event: Any) -> None:
            nonlocal built
            if event.value and not built:
                built = True
                with fold:
                    panel(self._session)

        fold.on_value_change(opened)

    def follow(self) -> None:
        """Show the values of the present state, and the levers of the present model."""
        session = self._session
        wanted = (session.levers, _instead(session))
        if wanted != self._shown:
            self._shown = wanted
            self._list.clear()
            with self._list:
                self._levers = [LeverControl(session, one) for one in session.levers]
                if wanted[1]:
                    Words("div", wanted[1], classes="ck-lever ck-pale")
        for lever in self._levers:
            lever.follow()

    def refuse(self, failed: Mapping[str, Any] | None) -> bool:
        """Show a message beside the lever it is about; whether there is one."""
        found = [lever.refuse(failed) for lever in self._levers]
        return any(found)


def _instead(session: Session) -> str:
    """What stands in the place of levers that are not there."""
    if session.levers or session.state is None:
        return ""
    if session.failed is not None:
        return "Levers come as soon as the model computes."
    return "Choosing levers ..."
