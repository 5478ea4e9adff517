"""The header: which drive, undo, comparison with A, the link of its state, what it warns of, and the theme."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from nicegui import ui
from nicegui.element import Element

from ...errors import ConvergenceError, ModelError
from ..dialogs.controls import (
    Words,
    box,
    button,
    heard,
    hide,
    icon_button,
    on_key,
    plain_button,
    prop,
    refused,
    rename,
    show_model,
    window,
)
from ..dialogs.open_model import open_button, save_buttons
from ..dialogs.take_away import take_away_button
from ..dialogs.wizard import new_button
from ..processes.session import Session
from ..processes.tasks import compared_states
from ..state.history import fragment_of
from ..state.state import request_of


def compare_controls(session: Session) -> None:
    """Buttons that pin the present state as A, unpin it, and open the comparison, where both can change places."""
    with ui.row().classes("items-center no-wrap q-gutter-xs") as root:
        pin = plain_button("Pin A", session.pin, icon="push_pin")
        with pin:
            ui.tooltip("Keep this state as A: its curves stay as dashed lines")
        compare = plain_button("Compare", lambda: _show(session), icon="compare_arrows")
        unpin = plain_button("Unpin A", session.unpin)

    def show(_: object = None) -> None:
        pinned = session.pinned is not None
        pin.set_visibility(not pinned)
        pin.set_enabled(session.state is not None)
        compare.set_visibility(pinned)
        unpin.set_visibility(pinned)

    heard(session, root, state=show)
    show()


async def _show(session: Session) -> None:
    """A window with what differs, computed while it is open."""
    first, second = session.pinned, session.state
    if first is None or second is None:
        return
    with window("What differs: A is pinned, B is the present state", width=980) as dialog:
        with ui.column().classes("w-full") as outcome:
            ui.linear_progress(show_value=False).props("indeterminate").classes("w-full")
            ui.label("Both trains are computed: modes, sharing, forces.").props('role="status"')

        def swap() -> None:
            dialog.close()
            pinned = session.pinned
            if pinned is not None:  # undo takes back the change of the present state
                session.pin()
                show_model(session, pinned, ui.context.client.layout)

        def renew() -> None:
            dialog.close()
            session.pin()

        with ui.row().classes("w-full justify-end"):
            plain_button("Swap A and B", swap).tooltip("A becomes the present state; undo takes it back")
            plain_button("Pin the present state instead", renew)
            plain_button("Close", dialog.close, main=True)
    try:
        difference = await session.call(
            compared_states, request_of(first), request_of(second), (first.name, second.name)
        )
    except (ModelError, ConvergenceError) as error:
        difference = error
    if outcome.is_deleted:
        return
    outcome.clear()
    with outcome:
        if isinstance(difference, Exception):
            ui.label(str(difference)).classes("text-negative").props('role="alert"')
        else:
            _table(**difference)
            if first.relative_speed != 1 or second.relative_speed != 1:
                ui.label("Both at the speed of their model, whatever speed the page shows.").classes("text-caption")


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]], lead: str, notes: Sequence[str]) -> None:
    """A table of differences, of `compared_states`."""
    ui.label(lead).classes("text-caption")
    columns = [
        {"name": f"c{i}", "label": heading, "field": f"c{i}", "align": "left" if i < 2 else "right", "sortable": i < 2}
        for i, heading in enumerate(headings)
    ]
    cells = [{"id": number, **{f"c{i}": cell for i, cell in enumerate(row)}} for number, row in enumerate(rows)]
    table = ui.table(columns=columns, rows=cells, row_key="id").classes("w-full").style("max-height: 62vh")
    table.props('dense flat wrap-cells hide-pagination virtual-scroll aria-label="Differences of model and results"')
    for note in notes:
        ui.label(note).classes("text-caption")


def undo_buttons(session: Session) -> None:
    """Two buttons, and Ctrl+Z, Ctrl+Shift+Z and Ctrl+Y where no text field has the keys."""
    undo = icon_button("undo", "Undo", session.undo)
    redo = icon_button("redo", "Redo", session.redo)

    def show(_: object = None) -> None:
        labels = (session.history.undo_label, session.history.redo_label)
        for word, control, label in zip(("Undo", "Redo"), (undo, redo), labels, strict=True):
            control.set_enabled(bool(label))
            rename(control, f"{word}: {label}" if label else word, "" if label else f"Nothing to {word.lower()}")

    on_key("z", session.undo)
    on_key("z", session.redo, shift=True)
    on_key("y", session.redo)
    heard(session, undo, state=show)
    show()


# Characters that mail programs and chats leave whole; browsers take more.
_SURE = 8000
# [s] a browser may take to say its address and to copy
_ANSWER = 5.0


def link_button(session: Session) -> None:
    """A button that copies a link to the present state."""

    async def make() -> None:
        state = session.state
        if state is None:
            return
        try:
            fragment = fragment_of(state)
        except ModelError as error:
            return refused(error, "No link: download the model instead. ")
        script = f"""
            const link = location.origin + "/#" + {fragment!r};
            try {{ await navigator.clipboard.writeText(link); return [link.length, true]; }}
            catch {{ window.prompt("Copy this link", link); return [link.length, false]; }}
        """
        answer = await ui.run_javascript(script, timeout=_ANSWER)
        length, copied = answer if isinstance(answer, list) and len(answer) == 2 else (len(fragment), False)
        words = f"Link {'copied' if copied else 'made'}, {length} characters"
        if length > _SURE:
            ui.notify(f"{words}: some mail programs and chats cut it. The model as a file is safer.", type="warning")
        else:
            ui.notify(f"{words}. It holds the whole model.", type="positive")

    icon_button("link", "Copy a link to this state", make)


class ThemeButton(Element, component="theme_button.js"):
    """A button that goes through the themes; the browser keeps the choice."""


class Header:
    """Controls over the whole page.  open_model, new_train : open these windows from another place of the page."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._told: list[tuple[str, str]] | None = None
        self._title = ""
        with box("ck-head", "header"):
            self._name = Words("h1", "Cockpit", classes="ck-name")
            self._name.props["data-testid"] = "name"
            self.open_model = open_button(session)
            self.new_train = new_button(session)
            self._of_model = [box("ck-head-part"), box("ck-head-part ck-head-end")]
            with self._of_model[0]:
                box("ck-split")
                undo_buttons(session)
                save_buttons(session)
                box("ck-split")
                with ui.button().props("flat dense no-caps").classes("ck-warnings") as self._warnings:
                    self._list = ui.menu().classes("ck-wide")
                self._facts = Words(classes="ck-facts")
                self._speed = button("", lambda: session.operate_at(1.0), classes="ck-small ck-main")
            with self._of_model[1]:
                compare_controls(session)
                link_button(session)
                take_away_button(session)
            ThemeButton()
        hide(self._warnings, True)
        hide(self._speed, True)

    def follow(self) -> None:
        """Show the name of the state and whether it is saved; without a model, only the ways to one."""
        state = self._session.state
        for part in self._of_model:
            hide(part, state is None)
        if state is None:
            self._say("Cockpit", "epicyclic")
            return
        self._say(f"{state.name}{' *' if self._session.unsaved else ''}", f"{state.name} · epicyclic")
        saved = " (changed, not saved)" if self._session.unsaved else ""
        prop(self._name, "title", f"{state.path or state.name}{saved}")
        relative = self._session.relative_speed
        hide(self._speed, relative == 1.0)
        self._speed.say(f"at {100 * relative:.3g} % speed: back to 100 %")

    def _say(self, name: str, title: str) -> None:
        self._name.say(name)
        if title != self._title:
            self._title = title
            ui.page_title(title)

    def frame(self, head: Mapping[str, Any]) -> None:
        """Show facts and warnings of a frame that brings them."""
        state = head.get("state")
        if isinstance(state, Mapping):  # ratio, speeds and torques in one line
            facts = [] if state.get("ratio") is None else [f"ratio {float(state['ratio']):.4g}"]
            for member, value, unit in [*(state.get("speeds") or ()), *(state.get("torques") or ())]:
                if value:
                    facts.append(f"{member} {float(value):.4g} {unit}")
            self._facts.say(" · ".join(facts))
            prop(self._facts, "title", self._facts.text)
        checks = [(str(check.get("level")), str(check["text"])) for check in head.get("checks", ())]
        if "checks" not in head or checks == self._told:
            return
        self._told = checks
        hide(self._warnings, not checks)
        self._warnings.set_text(f"{len(checks)} warning{'s' * (len(checks) != 1)}")
        self._list.clear()
        with self._list:
            for level, text in checks:
                with box("ck-warning"):
                    mark = Words(text="✗" if level == "bad" else "!", classes=f"ck-mark {level}")
                    mark.props.update({"role": "img", "aria-label": "fails" if level == "bad" else "look at"})
                    Words(text=text)
