"""The model as TOML, in step with everything else; what a person types here is never thrown away.

Readers of TOML keep no places, so the line of an error is found by its path.
"""

from __future__ import annotations

import asyncio
import re
from itertools import takewhile

from nicegui import background_tasks, ui

from ...errors import ModelError
from ...train.resolution import load
from ..processes.session import Session
from ..state.state import PageState, request_of, with_text
from ..state.written_text import text_of
from .controls import enlarge_button, heard, plain_button

_HEADING = re.compile(r"\s*\[{1,2}([^\]]+)\]{1,2}\s*(?:#.*)?$")
_KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
_SAID = re.compile(r"\bline (\d+)")


def line_of(text: str, path: str) -> int | None:
    """Number of the line, from 1, that states a path, or else the table that would hold it; None where neither does."""
    wanted = _words(path)
    best, line_of_best = 0, None
    heading: tuple[str, ...] = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if title := _HEADING.match(line):
            keys = heading = _words(title[1])
        elif entry := _KEY.match(line):
            keys = (*heading, *_words(entry[1]))
        else:
            continue
        # words in common with the path, from the beginning on
        alike = (key == word for key, word in zip(keys, wanted, strict=False))
        shared = sum(1 for _ in takewhile(bool, alike))
        if shared > best:
            best, line_of_best = shared, number
    return line_of_best


def line_of_error(text: str, message: str, path: str) -> int | None:
    """Line of an error: the one that its message names, else that of its path."""
    stated = _SAID.search(message)
    return int(stated[1]) if stated else line_of(text, path)


def _words(path: str) -> tuple[str, ...]:
    return tuple(word for part in path.split(".") if (word := part.strip().strip("\"'").strip()))


# [s] after a change elsewhere until the text follows: a drag writes it once, not at every move.
_FOLLOWS = 0.25


_LOOK = ".cockpit-wrong { background: rgb(220 60 60 / 25%); }"
# Tells whether the page is dark, at once and whenever that changes.
_WATCH = """(() => {
  let dark = null;
  const tell = () => {
    const now = document.body.classList.contains("body--dark");
    if (now !== dark) { dark = now; emitEvent("cockpit-dark", now); }
  };
  new MutationObserver(tell).observe(document.body, { attributes: true, attributeFilter: ["class"] });
  tell();
  // the tab key indents there, which a reader of the page has to be told
  const name = (left) => {
    const text = document.querySelector(".cockpit-editor .cm-content");
    if (text) text.setAttribute("aria-label", "Model as TOML. Escape, then Tab leaves the editor");
    else if (left) setTimeout(name, 200, left - 1);
  };
  name(50);
})()"""


class TextPanel:
    """An editor of the model text, with apply (Ctrl+Enter), the line of an error, and both texts where both changed.

    shown : the text that the editor was given last.  kept : a text of the user's that gave way to that of the model.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.shown = ""
        self.kept: str | None = None
        self.waiting = False
        self.newest: PageState | None = None
        with ui.column().classes("w-full q-gutter-none cockpit-text").style("min-width: 0") as self.root:
            with ui.row().classes("w-full items-center"):
                self.status = (
                    ui.label("")
                    .classes("text-caption")
                    .style("flex: 1 1 100%")
                    .props('role="status" aria-live="polite"')
                )
                self.back = plain_button("Bring back my text", self._bring_back)
                self.drop = plain_button("Discard my changes", self._take_theirs)
                enlarge_button(self.root, "Model text")
                self.apply = plain_button("Apply", self._apply, main=True).tooltip("Ctrl+Enter")
            with ui.row().classes("w-full items-center cockpit-conflict") as self.conflict:
                ui.label("The model has changed elsewhere since you began to type here.").classes("col")
                plain_button("Show the model's text", self._take_theirs).tooltip("Yours can be brought back")
                plain_button("Keep mine", self._keep_mine).tooltip("Apply then replaces the model by your text")
            self.message = ui.label("").classes("w-full text-negative").props('role="alert"')
            self.editor = ui.codemirror(
                language="TOML", on_change=self._typed, keymap={"Mod-Enter": self._apply}, line_wrapping=False
            )
            self.editor.classes("w-full cockpit-editor").style("height: 60vh; flex: 1 1 auto").props(
                'aria-label="Model as TOML" title="Tab indents; Escape, then Tab leaves the editor"'
            )
        ui.on("cockpit-dark", lambda event: self.editor.set_theme("vscodeDark" if event.args else "basicLight"))
        ui.add_css(_LOOK)
        ui.run_javascript(_WATCH)
        heard(session, self.root, state=self._changed)
        self.conflict.set_visibility(False)
        self._marks()
        self._changed()

    # text of the model ------------------------------------------------------------------------------------------------

    def _changed(self, _: object = None) -> None:
        """The state is another one: its text follows a moment later."""
        if not self.waiting and self.session.state is not None:
            self.waiting = True
            background_tasks.create(self._follow())

    async def _follow(self) -> None:
        await asyncio.sleep(_FOLLOWS if self.shown else 0)
        self.waiting = False
        state = self.session.state
        if state is None or state is self.newest or self.root.is_deleted:
            return
        try:
            text = await asyncio.to_thread(text_of, state)
        except ModelError as error:
            if not self.root.is_deleted:
                self.message.set_text(str(error))
            return
        if self.root.is_deleted:
            return
        with self.root:
            self.newest = state
            if text == self.shown:
                return
            if (self.editor.value or "") in (self.shown, text):
                self._show(text)
            else:
                self.shown = text
                self.conflict.set_visibility(True)
                self._marks()

    def _show(self, text: str) -> None:
        self.shown = text
        if self.editor.value != text:
            self.editor.set_value(text)
        self.conflict.set_visibility(False)
        self.message.set_text("")
        self._marks()

    # text of the user -------------------------------------------------------------------------------------------------

    @property
    def edited(self) -> bool:
        return (self.editor.value or "") != self.shown

    def _typed(self) -> None:
        if self.editor.decorations:
            self.editor.decorations.clear()
        self._marks()

    def _marks(self) -> None:
        """Say whether the editor shows the model, and what can be done."""
        state = self.session.state
        words = "" if state is None else state.name
        if state is not None and state.overrides:
            words += ", with what was set on the page"
        if self.edited:
            words = "Changed here, not applied"
        if self.status.text != words:
            self.status.set_text(words)
        self.apply.set_enabled(self.edited)
        self.drop.set_visibility(self.edited)
        self.back.set_visibility(self.kept is not None and not self.edited)

    def _take_theirs(self) -> None:
        self.kept = self.editor.value
        self._show(self.shown)

    def _keep_mine(self) -> None:
        self.conflict.set_visibility(False)

    def _bring_back(self) -> None:
        if self.kept is not None:
            text, self.kept = self.kept, None
            self.editor.set_value(text)
            self._marks()

    async def _apply(self) -> None:
        state, text = self.session.state, self.editor.value or ""
        if state is None or not self.edited:
            return
        try:
            await asyncio.to_thread(lambda: load(*request_of(with_text(state, text))))  # a train can be made of it
            self.session.set_text(text)
        except ModelError as error:
            line = line_of_error(text, error.problem, error.path)
            self.message.set_text(f"line {line}: {error}" if line and "line" not in error.problem else str(error))
            if line:
                self.editor.reveal_line(line)
                self.editor.decorations[:] = [{"kind": "line", "line": line, "class": "cockpit-wrong"}]
            return
        self.kept = None
        self._show(text)
