"""The whole model file in the page: as TOML, and as fields by table from the schema of the model file.

The text is in step with everything else, and what a person types there is never thrown away.  Readers of TOML keep no
places, so the line of an error is found by its path.  A table of fields is built when it is opened.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable, Mapping, Sequence
from itertools import takewhile
from typing import Any

from nicegui import ui

from ...document.tables import PlainTable
from ...document.units import KINDS
from ...errors import ModelError
from ...terms import Explanation
from ...train.resolution import load
from ..processes.session import Session
from ..state.model_file import (
    Field,
    FieldGroup,
    all_fields,
    current_tables,
    explanation_of,
    field_at,
    file_value,
    group_at,
    text_of,
    typed_value,
)
from ..state.state import PageState, request_of, with_text
from .controls import Later, enlarge_button, fold, heard, icon_button, plain_button, sentence

# text -----------------------------------------------------------------------------------------------------------------

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


# [s] after a change elsewhere until text and fields follow, and after a key of the search: a drag writes them once.
_FOLLOWS = 0.25


_WRONG_LINE = ".cockpit-wrong { background: rgb(220 60 60 / 25%); }"
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
                plain_button("Keep mine", lambda: self.conflict.set_visibility(False)).tooltip(
                    "Apply then replaces the model by your text"
                )
            self.message = ui.label("").classes("w-full text-negative").props('role="alert"')
            self.editor = ui.codemirror(
                language="TOML", on_change=self._typed, keymap={"Mod-Enter": self._apply}, line_wrapping=False
            )
            self.editor.classes("w-full cockpit-editor").style("height: 60vh; flex: 1 1 auto").props(
                'aria-label="Model as TOML" title="Tab indents; Escape, then Tab leaves the editor"'
            )
        ui.on("cockpit-dark", lambda event: self.editor.set_theme("vscodeDark" if event.args else "basicLight"))
        ui.add_css(_WRONG_LINE)
        ui.run_javascript(_WATCH)
        self.later = Later(self.root, self._follow, often=True)
        heard(session, self.root, state=self._changed)
        self.conflict.set_visibility(False)
        self._marks()
        self._changed()

    # text of the model ------------------------------------------------------------------------------------------------

    def _changed(self, _: object = None) -> None:
        """The state is another one: its text follows a moment later."""
        self.later.ask(_FOLLOWS if self.shown else 0)

    async def _follow(self) -> None:
        state = self.session.state
        if state is None or state is self.newest:
            return
        problem = ""
        try:
            text = await asyncio.to_thread(text_of, state)
        except ModelError as error:
            text, problem = self.shown, str(error)
        if self.root.is_deleted:
            return
        if problem:
            self.message.set_text(problem)
            return
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


# fields ---------------------------------------------------------------------------------------------------------------

# Fields that a search shows: more nobody reads, and every one is a control.
_MOST = 40
# Characters of a default beside a field: the rest stands in its explanation.
_SHORT = 28

# Tables within tables in a narrow column: little room to the left and between.
_LOOK = """
.cockpit-fields { gap: 0.25rem; }
.cockpit-fields .nicegui-column { gap: 0.25rem; }
.cockpit-fields .q-expansion-item__content { gap: 0.25rem !important; padding: 0 0 0.5rem 0.6rem !important; }
.cockpit-fields .cockpit-field { max-width: 36rem; }
.cockpit-fields .q-item { min-height: 28px; padding: 2px 4px; }
"""


class FieldsPanel:
    """The fields of the model by table, with a search over all of them and a message beside each that is refused."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.tables: PlainTable = {}
        self.base: str | None = None
        self.rows: dict[str, list[_Row]] = {}
        with ui.column().classes("w-full q-gutter-none cockpit-fields") as self.root:
            with ui.row().classes("w-full items-center no-wrap"):
                self.search = ui.input("Search all fields", on_change=self._typed)
                self.search.props("dense clearable spellcheck=false").classes("col").mark("fields-search")
                enlarge_button(self.root, "All fields")
            self.found = ui.column().classes("w-full q-gutter-none")
            self.tree = ui.column().classes("w-full q-gutter-none")
        ui.add_css(_LOOK)
        self.later = Later(self.root, self._follow, often=True)
        self.searching = Later(self.root, self._search)
        heard(session, self.root, state=self._changed, failed=self._failed)
        self._changed()

    # in step with the state -------------------------------------------------------------------------------------------

    def _changed(self, _: object = None) -> None:
        self.later.ask(_FOLLOWS if self.base is not None else 0)

    async def _follow(self) -> None:
        state = self.session.state
        if state is None:
            return
        self.tables = current_tables(state)
        if state.base != self.base:
            await self._renew(state)
        else:
            for path, rows in self.rows.items():
                for row in rows:
                    row.follow(field_at(self.tables, path), is_set=path in state.overrides)

    async def _renew(self, state: PageState) -> None:
        """Another model: build its tables anew, all closed."""
        self.base = state.base
        group = await asyncio.to_thread(group_at, self.tables)
        if self.root.is_deleted:
            return
        self.rows.clear()
        self.found.clear()
        self.tree.clear()
        with self.tree:
            await self._fill(group)
        if self.search.value:
            self._typed()

    def _failed(self, head: Mapping[str, Any] | None) -> None:
        """Say beside its field why the state does not compute; nothing where it does again."""
        path = str(head.get("path", "")) if head else ""
        words = sentence(str(head.get("message", "")), str(head.get("allowed", ""))) if head else ""
        for field, rows in self.rows.items():
            for row in rows:
                row.tell(words if path and _is_of(path, field) else "")

    # tables -----------------------------------------------------------------------------------------------------------

    async def _fill(self, group: FieldGroup) -> None:
        """Build what the model states of one table into the present slot; the rest folded behind it."""
        await self._build([field for field in group.fields if field.text])
        self._fold_tables(group, [key for key in group.tables if key in group.stated])
        rest = [field for field in group.fields if not field.text]
        tables = [key for key in group.tables if key not in group.stated]
        if not rest and not tables:
            return

        async def more() -> None:
            await self._build(rest)
            self._fold_tables(group, tables)

        words = [f"{len(rest)} field{'s' * (len(rest) != 1)}"] if rest else []
        words += [f"{len(tables)} table{'s' * (len(tables) != 1)}"] if tables else []
        self._fold(f"Not stated: {' and '.join(words)}", f"more-{group.path}", more)

    def _fold_tables(self, group: FieldGroup, keys: Sequence[str]) -> None:
        """Tables within a table, each built when it is opened."""
        for key in keys:
            path = f"{group.path}.{key}" if group.path else key

            async def build(path: str = path) -> None:
                await self._fill(group_at(self.tables, path))

            self._fold(key, f"table-{path}", build)

    def _fold(self, title: str, marker: str, build: Callable[[], Awaitable[None]]) -> None:
        fold(title, build).props("expand-separator").classes("w-full").mark(marker)

    async def _build(self, fields: Sequence[Field]) -> None:
        self._build_rows(fields, await asyncio.to_thread(_explained, fields))

    def _build_rows(
        self, fields: Sequence[Field], explained: Mapping[str, Explanation], *, whole: bool = False
    ) -> None:
        state = self.session.state
        overrides = state.overrides if state is not None else {}
        for field in fields:
            row = _Row(self.session, field, explained.get(field.path), whole=whole, is_set=field.path in overrides)
            self.rows.setdefault(field.path, []).append(row)

    # search -----------------------------------------------------------------------------------------------------------

    def _typed(self) -> None:
        self.searching.ask(_FOLLOWS)

    async def _search(self) -> None:
        typed = self.search.value
        words = str(typed or "").lower().split()
        fields = await asyncio.to_thread(_matching, self.tables, words) if words else []
        shown = fields[:_MOST]
        explained = await asyncio.to_thread(_explained, shown)
        if typed != self.search.value or self.root.is_deleted:
            return
        for rows in self.rows.values():
            rows[:] = [row for row in rows if not row.whole]
        self.found.clear()
        self.tree.set_visibility(not words)
        with self.found:
            self._build_rows(shown, explained, whole=True)
            if words and not shown:
                ui.label("No field has these words in its path or its meaning.").classes("text-caption")
            elif len(fields) > _MOST:
                ui.label(f"{len(fields) - _MOST} more: one more word narrows it.").classes("text-caption")


class _Row:
    """One field: its name, its value as text, its message, and a button that takes the file's value again.

    shown : the text of the model that the control was given.  whole : with its whole path, in a search.
    """

    def __init__(
        self, session: Session, field: Field, explained: Explanation | None, *, whole: bool, is_set: bool
    ) -> None:
        self.session, self.path, self.whole, self.shown = session, field.path, whole, field.text
        if whole:  # beside each other whole paths do not fit into a column
            ui.label(field.path).classes("text-caption w-full").style("overflow-wrap: anywhere; line-height: 1.1")
        with ui.row().classes("w-full items-start no-wrap cockpit-field"):
            self.control = self._control(field, "" if whole else field.key, explained)
            self.undo = icon_button("settings_backup_restore", f"{field.path}: back to the file's value", self._reset)
        self.undo.set_visibility(is_set)

    def _control(self, field: Field, name: str, explained: Explanation | None) -> ui.select | ui.input:
        control: ui.select | ui.input
        default = explained.default if explained else ""
        if field.choices and field.text in ("", *field.choices):
            control = ui.select(list(field.choices), value=field.text or None, label=name or None, clearable=True)
            control.on_value_change(self._chosen)
        else:
            control = ui.input(name or None, value=field.text, placeholder=default[:_SHORT])
            control.on("blur", self._left).on("keydown.enter", self._left).on("keydown.esc", self._escape)
            if explained and explained.unit:
                # units that a person may type for the first of some SI units
                first = explained.unit.partition(", ")[0]
                units = next((kind.spellings for kind in KINDS.values() if kind.unit == first), first)
                control.props["suffix"] = "" if field.text or default else units
        look = "dense options-dense hide-bottom-space spellcheck=false"
        control.props(f"{look} stack-label" if name else look).classes("col")
        control.mark(f"field-{field.path}")
        control.props["aria-label"] = field.path
        if explained:
            rows = explained.rows()
            with control, ui.tooltip().props("max-width=420px delay=400"):  # labels, never markup
                ui.label(field.path).classes("text-weight-bold")
                for label in ("meaning", "unit", "default", "allowed", "example"):
                    if label in rows:
                        ui.label(rows[label] if label == "meaning" else f"{label}: {rows[label]}")
        return control

    @property
    def text(self) -> str:
        return str(self.control.value or "").strip()

    def follow(self, field: Field, *, is_set: bool) -> None:
        """Show what the model says now, unless something else is being typed here."""
        if self.undo.visible != is_set:
            self.undo.set_visibility(is_set)
        if field.text != self.shown:
            typed, self.shown = self.text != self.shown, field.text
            if not typed:
                self._write(field.text)

    def tell(self, words: str) -> None:
        if self.control.error != (words or None):
            self.control.error = words or None

    def _write(self, text: str) -> None:
        if isinstance(self.control, ui.select):
            self.control.set_value(text if text in self.control.options else None)
        else:
            self.control.set_value(text)

    def _escape(self) -> None:
        self.tell("")
        self._write(self.shown)

    async def _chosen(self) -> None:
        if self.text != self.shown:
            await self._commit()

    async def _left(self) -> None:
        if self.text != self.shown:
            await self._commit()
        else:
            self.tell("")

    async def _commit(self) -> None:
        """Set what was typed, or say why it is refused. What is wrong elsewhere because of it is no refusal."""
        state, before, text, words = self.session.state, self.shown, self.text, ""
        if state is None:
            return
        self.shown = text  # the state follows by itself; leaving the field twice is one change
        try:
            value = typed_value(self.path, text)
            await asyncio.to_thread(_checked, state, self.path, value)
            self.session.set(self.path, value, released=True)
        except ModelError as error:
            self.shown, words = before, sentence(error.problem, error.allowed)
        self.tell(words)

    def _reset(self) -> None:
        """Take the value of the file again, which may be none."""
        self._escape()
        if (state := self.session.state) is not None:
            self.session.set(self.path, file_value(state, self.path), released=True)


def _explained(fields: Sequence[Field]) -> dict[str, Explanation]:
    explained = {field.path: explanation_of(field.path) for field in fields}
    return {path: explanation for path, explanation in explained.items() if explanation is not None}


def _matching(tables: PlainTable, words: Sequence[str]) -> list[Field]:
    """Fields with all the words in their path, then those with them in path and meaning; stated ones first."""
    fields = list(all_fields(tables))
    matches = [field for field in fields if all(word in field.path.lower() for word in words)]
    if len(matches) < _MOST:
        known = {field.path for field in matches}
        for field in fields:
            explanation = explanation_of(field.path) if field.path not in known else None
            if explanation is not None:
                text = f"{field.path} {explanation.meaning}".lower()
                matches += [field] if all(word in text for word in words) else []
    return sorted(matches, key=lambda field: not field.text)


def _checked(state: PageState, path: str, value: object) -> None:
    """Raise ModelError where the value itself is wrong, also for a number without its unit."""
    source, overrides = request_of(state)
    try:
        load(source, overrides={**{k: v for k, v in overrides.items() if k != path}, path: value})
    except ModelError as error:
        if _is_of(error.path, path) or path.startswith(f"{error.path}."):
            raise


def _is_of(path: str, field: str) -> bool:
    """Whether a message at `path` is of a field: its own, one within it, or of what it is a shorthand for."""
    table, _, key = field.rpartition(".")
    shorthand = key in ("radial", "tilt") and path.rpartition(".")[0] == table
    return path == field or path.startswith(f"{field}.") or shorthand
