"""The modes as a list: a row chosen animates in the drawing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .controls import Words, box, hide, prop

__all__ = ["ModesList"]


class ModesList:
    """Rows of natural frequencies.  choose : called with the index of a mode, None where it is left."""

    def __init__(self, choose: Callable[[int | None], None]) -> None:
        self._choose = choose
        self._rows: list[_Row] = []
        with box("ck-box ck-modes", "section") as root:
            root.props["aria-label"] = "Modes"
            with box("ck-title"):
                Words("h2", "Modes")
                self._count = Words(classes="ck-pale")
            self._list = box("ck-mode-list")
            self._list.props["data-keys"] = "go"
        self._chosen_index: int | None = None

    def follow(self, head: Mapping[str, Any]) -> None:
        """Show the modes of a frame that brings them."""
        modes = head.get("modes")
        if modes is None:
            return
        self._count.say("number, frequency [Hz]; a row swings in the drawing")
        with self._list:
            while len(self._rows) < len(modes):
                self._rows.append(_Row(self._on_row))
        for row, mode in zip(self._rows, modes, strict=False):
            row.follow(mode, self._chosen_index)
        for row in self._rows[len(modes) :]:
            row.end()

    def chosen(self, index: int | None) -> None:
        """Mark the mode that another pane has chosen."""
        self._chosen_index = index
        for row in self._rows:
            row.press(index)

    def _on_row(self, index: int) -> None:
        index_or_none = None if index == self._chosen_index else index
        self.chosen(index_or_none)
        self._choose(index_or_none)


class _Row:
    def __init__(self, click: Callable[[int], None]) -> None:
        self._index = -1
        self._row = box("ck-mode", "button").on("click", lambda _: click(self._index))
        self._row.props["type"] = "button"
        with self._row:
            self._number = Words("small")
            self._frequency, self._label, self._met = Words("b"), Words(), Words("i")

    def follow(self, mode: Mapping[str, Any], chosen: int | None) -> None:
        self._index = int(mode["index"])
        prop(self._row, "data-mode", str(self._index))
        self._number.say(str(self._index))
        self._frequency.say(f"{float(mode['frequency']):.4g}")
        self._label.say(str(mode["label"]))
        prop(self._row, "title", f"{mode['label']}{': met by ' + str(mode['met_by']) if mode.get('met_by') else ''}")
        self._met.say(str(mode.get("met_by") or "").replace(" mesh order", " order"))
        self.press(chosen)
        hide(self._row, False)

    def press(self, chosen: int | None) -> None:
        prop(self._row, "aria-pressed", "true" if chosen == self._index else "false")

    def end(self) -> None:
        hide(self._row, True)
