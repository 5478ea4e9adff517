"""The levers: a slider and a number box over a value of the model, or over one entry of a list."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...document.units import Written, factor, written
from ...errors import ModelError
from ..dialogs.controls import Words, box, fold, prop, sentence
from ..dialogs.field_list import file_value
from ..dialogs.fields_panel import FieldsPanel
from ..dialogs.text_panel import TextPanel
from ..processes.session import Session
from ..state.state import PageState
from ..state.written_text import written_value


def entry_of(value: object, unit: str, entry: int) -> float | None:
    """Entry from 0 of a value as written, in a unit; 0 of a value that is missing, None of what is no number.

    One number stands for every entry.
    """
    if value is None:
        return 0.0
    numbers = written(value)
    if numbers is None or (numbers.many and entry >= len(numbers.values)):
        return None
    number = numbers.values[entry if numbers.many else 0]
    if numbers.unit == unit or not number:
        return _in_unit(number, "", unit)
    return _in_unit(number, numbers.unit, unit) if numbers.unit and unit else None


def _in_unit(number: float, written_in: str, unit: str) -> float | None:
    """A number in the unit of a lever; None where it has another dimension or is not finite."""
    scale = 1.0 if written_in in ("", unit) else factor(written_in, unit)
    return None if scale is None or not math.isfinite(number * scale) else number * scale


def with_entry(value: object, unit: str, entry: int, count: int, number: float) -> object:
    """Override of a list of `count` entries, with one of them, from 0, another number in the unit."""
    values = [entry_of(value, unit, i) or 0.0 for i in range(count)]
    values[entry] = number
    return Written(values=tuple(values), unit=unit, many=True).text(tuple(float(f"{value:.9g}") for value in values))


# Positions of a slider whose lever states no step.
_POSITIONS = 200
# Digits with which a value is written into the model: as many as the box shows.
_DIGITS = 6


class LeverControl(Element, component="lever.js"):
    """A lever of a session.

    lever : as the session gives it: path, label, value, unit, least, most, step, log, why, entry, count.
    """

    def __init__(self, session: Session, lever: Mapping[str, Any]) -> None:
        super().__init__()
        self._session, self.path = session, str(lever["path"])
        self._unit = str(lever.get("unit") or "")
        self._value, self._drags, self._shows = float(lever["value"]), 0, 0
        self._asked: PageState | None = None  # the state that this lever has made last
        self._entry, self._count = lever.get("entry"), int(lever.get("count") or 0)
        self._seen: object = None
        least, most = float(lever["least"]), float(lever["most"])
        # what holds where the model states nothing: it came with the lever, unless an override was there already
        state = session.state
        overridden = state is not None and self.path in state.overrides
        self._unstated = least if overridden else self._value
        self._props.update(
            path=self.path,
            label=str(lever["label"]),
            unit=self._unit,
            why=f"{lever.get('why') or lever['label']} ({self.path})",
            least=least,
            most=most,
            step=float(lever.get("step") or 0.0) or (most - least) / _POSITIONS,
            log=bool(lever.get("log")) and least > 0,
            changed=False,
            message="",
            shown=[0, self._value],
        )
        self.on("move", lambda event: self._moved(event, released=False))
        self.on("release", lambda event: self._moved(event, released=True))
        self.on("typed", lambda event: self._typed(str(event.args)))
        self.on("reset", lambda _: self._to_file())
        self.on("restore", lambda _: self._take_back())

    def follow(self) -> None:
        """Show the value of the present state, unless it is the one that this lever has asked for."""
        state = self._session.state
        if state is None or state is self._seen:
            return
        self._seen = state
        prop(self, "changed", self.path in state.overrides)
        stated = written_value(state, self.path)
        number = self._unstated if stated is None else self._read(stated)
        if number is None or math.isclose(number, self._value, rel_tol=1e-9, abs_tol=1e-300):
            return
        self._show(number)

    def refuse(self, failed: Mapping[str, Any] | None) -> bool:
        """Show the message of a failed state that is about this lever; whether it is."""
        if failed is None or str(failed.get("path")) != self.path:
            self._tell("")
            return False
        self._tell(sentence(str(failed.get("message") or ""), str(failed.get("allowed") or "")))
        return True

    def _moved(self, event: GenericEventArguments, *, released: bool) -> None:
        value = event.args
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return
        self._value = float(value)
        self._ask(self._written(self._value), released=released)
        self._drags += released

    def _typed(self, text: str) -> None:
        """Take a number in the unit of the lever, or a value with a unit of its own; nothing is the file's value."""
        if not text:
            self._to_file()
            return
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        value: object = self._written(number) if math.isfinite(number) else text
        self._value = math.nan  # whatever the model then has is shown, at the slider too
        self._ask(value, released=True)
        self._drags += 1

    def _read(self, stated: object) -> float | None:
        """The number of this lever in a value of the model, of a list its own entry."""
        if self._entry is not None:
            return entry_of(stated, self._unit, self._entry)
        number = written(stated)
        return None if number is None or number.many else _in_unit(number.values[0], number.unit, self._unit)

    def _written(self, value: float) -> object:
        """A value as the model file writes it."""
        text = f"{value:.{_DIGITS}g}"
        if self._entry is not None and (state := self._session.state) is not None:
            return with_entry(written_value(state, self.path), self._unit, self._entry, self._count, float(text))
        return f"{text} {self._unit}" if self._unit else float(text)

    def _ask(self, value: object, *, released: bool) -> None:
        try:
            self._session.set(self.path, value, released=released, key=f"{self.path} {self._drags}")
        except ModelError as error:
            self._tell(sentence(error.problem, error.allowed))
        else:
            self._asked = self._session.state
            if self._session.failed is None:
                self._tell("")

    def _take_back(self) -> None:
        """Undo a value that was refused, where nothing has changed since; what was no value is forgotten."""
        state = self._session.state
        if self._session.failed is not None and state is not None and state is self._asked:
            self._session.undo()
        self._tell("")

    def _to_file(self) -> None:
        state = self._session.state
        if state is not None:
            self._value = math.nan
            self._ask(file_value(state, self.path), released=True)

    def _show(self, value: float) -> None:
        self._value, self._shows = value, self._shows + 1
        prop(self, "shown", [self._shows, value])

    def _tell(self, text: str) -> None:
        prop(self, "message", text)


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
            fold("All fields", lambda: FieldsPanel(session)).classes("ck-fold")
            fold("Model text (TOML)", lambda: TextPanel(session)).classes("ck-fold")

    def follow(self) -> None:
        """Show the values of the present state, and the levers of the present model."""
        session = self._session
        instead = ""  # what stands in the place of levers that are not there
        if session.state is not None and not session.levers:
            fails = session.failed is not None
            instead = "Levers come as soon as the model computes." if fails else "Choosing levers ..."
        if (session.levers, instead) != self._shown:
            self._shown = session.levers, instead
            self._list.clear()
            with self._list:
                self._levers = [LeverControl(session, lever) for lever in session.levers]
                if instead:
                    Words("div", instead, classes="ck-lever ck-pale")
        for lever in self._levers:
            lever.follow()

    def refuse(self, failed: Mapping[str, Any] | None) -> bool:
        """Show a message beside the lever it is about; whether there is one."""
        return any([lever.refuse(failed) for lever in self._levers])
