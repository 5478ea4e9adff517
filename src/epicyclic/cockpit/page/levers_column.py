"""The levers: a slider and a number box each, which follow the state and ask for it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from nicegui import ui
from nicegui.element import Element

from ...errors import ModelError
from ...model.units import factor
from ..dialogs.field_list import file_value
from ..dialogs.fields_panel import fields_panel
from ..dialogs.text_panel import text_panel
from ..processes.session import Session
from ..state.written_text import value_at
from .controls import Words, box, button, hide, prop

__all__ = ["LeversColumn"]

# Moves of a drag that are sent, and positions of a slider: a change of one pixel and less is no move.
_THROTTLE, _POSITIONS = 0.05, 400
_QUANTITY = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(.*)")


class LeversColumn:
    """The levers of a session; built anew when another model brings other levers."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._shown: object = None
        self._levers: list[_Lever] = []
        with box("ck-box ck-levers"):
            with box("ck-title"):
                Words(text="Levers")
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
        levers = self._session.levers
        if levers is not self._shown:
            self._shown = levers
            self._list.clear()
            with self._list:
                self._levers = [_Lever(self._session, one) for one in levers]
                if not levers and self._session.state is not None:
                    Words("div", "Choosing levers ...", classes="ck-lever ck-pale")
        for lever in self._levers:
            lever.follow()

    def refuse(self, failed: Mapping[str, Any] | None) -> bool:
        """Show a message beside the lever it is about; whether there is one."""
        found = [lever.refuse(failed) for lever in self._levers]
        return any(found)


class _Lever:
    """One value with its unit.  A slider runs over positions, of the logarithm where the lever is logarithmic."""

    def __init__(self, session: Session, lever: Mapping[str, Any]) -> None:
        self._session, self._path, self._unit = session, str(lever["path"]), str(lever.get("unit") or "")
        self._label = str(lever["label"])
        self._log, self._integer = bool(lever.get("log")), bool(lever.get("integer"))
        self._least, self._most = float(lever["least"]), float(lever["most"])
        self._step = float(lever.get("step") or 0.0)
        self._value, self._drags = float(lever["value"]), 0
        with box("ck-lever") as self._row:
            self._row.props["data-lever"] = self._path
            with box("ck-lever-line"):
                name = Words(text=self._label, classes="ck-lever-name")
                name.props["title"] = f"{self._label}: {lever.get('why') or self._path}"
                self._reset = button("↺", self._to_file, classes="ck-reset", label=f"{self._label}: value of the file")
                self._number = self._number_box()
                Words(text=self._unit, classes="ck-unit")
            self._slider = self._range()
            self._message = Words("div", classes="ck-message")
            self._message.props["role"] = "alert"
            hide(self._message, True)

    def _number_box(self) -> Element:
        made = box("ck-box-number", "input")
        made.props["aria-label"] = f"{self._label} value"
        made.props["autocomplete"] = "off"
        made.props["value"] = _text(self._value)
        made.on("change", lambda event: self._typed(str(event.args)), js_handler="(e) => emit(e.target.value)")
        return made

    def _range(self) -> Element:
        made = box("ck-range", "input")
        low, high = self._position(self._least), self._position(self._most)
        step = 1.0 if self._integer else (high - low) / _POSITIONS
        made.props.update(
            {"type": "range", "role": "slider", "aria-label": self._label, "min": low, "max": high, "step": step}
        )
        made.props["value"] = self._position(self._value)
        emit = "(e) => emit(Number(e.target.value))"
        made.on("input", self._dragged, throttle=_THROTTLE, js_handler=emit)
        made.on("change", self._released, js_handler=emit)
        return made

    def _position(self, value: float) -> float:
        return math.log10(max(value, 1e-300)) if self._log else value

    def _at(self, position: float) -> float:
        value = 10.0**position if self._log else position
        if self._integer:
            return float(round(value))
        if self._log:
            return float(f"{value:.3g}")
        return round(value / self._step) * self._step if self._step else value

    def _dragged(self, event: Any) -> None:
        self._set(self._at(float(event.args)), released=False)

    def _released(self, event: Any) -> None:
        self._set(self._at(float(event.args)), released=True)
        self._drags += 1

    def _set(self, value: float, *, released: bool) -> None:
        self._value = value
        prop(self._number, "value", _text(value))
        self._ask(self._written(value), released=released)

    def _typed(self, text: str) -> None:
        """Take a number in the unit of the lever, or a value with a unit of its own."""
        try:
            value: object = self._written(float(text))
        except ValueError:
            value = text.strip() or None
        prop(self._number, "value", text)
        self._ask(value, released=True)

    def _written(self, value: float) -> object:
        if self._integer:
            return round(value)
        return f"{_text(value)} {self._unit}" if self._unit else float(_text(value))

    def _ask(self, value: object, *, released: bool) -> None:
        try:
            self._session.set(self._path, value, released=released, key=f"{self._path} {self._drags}")
        except ModelError as error:
            self._tell(f"{error.problem}; allowed: {error.allowed}" if error.allowed else error.problem)

    def _to_file(self) -> None:
        state = self._session.state
        if state is not None:
            self._ask(file_value(state, self._path), released=True)

    def follow(self) -> None:
        """Show the value of the state, unless it is the one that this lever has asked for."""
        state = self._session.state
        if state is None:
            return
        hide(self._reset, self._path not in state.overrides)
        number = _number(value_at(state, self._path), self._unit)
        if number is None or math.isclose(number, self._value, rel_tol=1e-9, abs_tol=1e-300):
            return
        self._value = number
        prop(self._number, "value", _text(number))
        prop(self._slider, "value", self._position(number))

    def refuse(self, failed: Mapping[str, Any] | None) -> bool:
        if failed is None or str(failed.get("path")) != self._path:
            hide(self._message, True)
            return False
        allowed = failed.get("allowed")
        self._tell(f"{failed['message']}; allowed: {allowed}" if allowed else str(failed["message"]))
        return True

    def _tell(self, text: str) -> None:
        self._message.say(text)
        hide(self._message, False)


def _text(value: float) -> str:
    return f"{value:.6g}"


def _number(value: object, unit: str) -> float | None:
    """A value as written in the unit of a lever; None where it is no single number."""
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, int | float):
        return float(value)
    match = _QUANTITY.fullmatch(str(value))
    if match is None:
        return None
    try:
        number = float(match[1])
        scale = 1.0 if match[2].strip() in ("", unit) else factor(match[2].strip(), unit)
    except (ValueError, ModelError):
        return None
    return None if scale is None else number * scale
