"""The limit of K_gamma beside the answer that is held against it, and the window that sets it in the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from ...errors import ModelError
from ...limits import TABLES, stated_limit
from ..processes.session import Session
from .controls import applied, plain_button, prop, window
from .controls import button as native_button


class LimitButton:
    """The number of a limit; a click opens the window that sets another one, where the model states it."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._limit: Mapping[str, Any] = {}
        self.root = native_button("", self._open, classes="ck-figure ck-limit")
        self.follow(None)

    def follow(self, limit: Mapping[str, Any] | None) -> None:
        """Show the limit of an answer; None leaves its column empty."""
        self._limit = limit or {}
        number = f"{limit['value']:g}" if limit else ""
        words = f"Limit of K_gamma {number}: {limit['source']}. A click sets another one." if limit else ""
        settable = bool(limit and limit["path"])
        self.root.say(number)
        prop(self.root, "disabled", None if settable else True)
        prop(self.root, "title", words if settable else None)
        prop(self.root, "aria-label", words if settable else f"limit {number}")

    def _open(self) -> None:
        path = str(self._limit["path"])
        with window("Limit of K_gamma", width=440) as dialog:
            ui.label(f"Now {self._limit['value']:g}: {self._limit['source']}.")
            field = ui.input("Limit of K_gamma", value=f"{self._limit['value']:g}").classes("w-full").props("autofocus")
            tables = " or ".join(TABLES)
            ui.label(f"A number from 1 on, or a table by the number of planets: {tables}. Written to {path}.")

            def put(value: object) -> None:
                if applied(self._session, {path: value}, "limit of K_gamma"):
                    dialog.close()

            def take() -> None:
                try:
                    limit = stated_limit(str(field.value or "").strip(), path)
                except ModelError as error:
                    field.error = f"allowed: {error.allowed}"
                else:
                    put(limit)

            field.on("keydown.enter", take)
            with ui.row().classes("w-full justify-end"):
                plain_button("As the table has it", lambda: put(None))
                plain_button("Set the limit", take, main=True)
