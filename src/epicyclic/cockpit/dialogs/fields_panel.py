"""All fields of the model by table, from the schema of the model file; a table is built when it is opened."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

from nicegui import background_tasks, ui

from ...document.tables import PlainTable
from ...document.units import KINDS
from ...errors import ModelError
from ...terms import Explanation
from ...train.resolution import load
from ..processes.session import Session
from ..state.state import PageState, request_of
from .controls import enlarge_button, fold, heard, icon_button, sentence
from .field_list import (
    Field,
    FieldGroup,
    all_fields,
    current_tables,
    explanation_of,
    field_at,
    file_value,
    group_at,
    typed_value,
)

# Fields that a search shows: more nobody reads, and every one is a control.
_MOST = 40
# [s] after a change elsewhere until the fields follow, and after a key of the search: a drag writes them once.
_FOLLOWS = 0.25
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
        self.waiting = False
        self.searches = 0
        with ui.column().classes("w-full q-gutter-none cockpit-fields") as self.root:
            with ui.row().classes("w-full items-center no-wrap"):
                self.search = ui.input("Search all fields", on_change=self._typed)
                self.search.props("dense clearable spellcheck=false").classes("col").mark("fields-search")
                enlarge_button(self.root, "All fields")
            self.found = ui.column().classes("w-full q-gutter-none")
            self.tree = ui.column().classes("w-full q-gutter-none")
        ui.add_css(_LOOK)
        heard(session, self.root, state=self._changed, failed=self._failed)
        self._changed()

    # in step with the state -------------------------------------------------------------------------------------------

    def _changed(self, _: object = None) -> None:
        if not self.waiting and self.session.state is not None:
            self.waiting = True
            background_tasks.create(self._follow())

    async def _follow(self) -> None:
        await asyncio.sleep(_FOLLOWS if self.base is not None else 0)
        self.waiting = False
        state = self.session.state
        if state is None or self.root.is_deleted:
            return
        self.tables = current_tables(state)
        with self.root:
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
        explained = await asyncio.to_thread(_explained, fields)
        self._build_rows(fields, explained)

    def _build_rows(
        self, fields: Sequence[Field], explained: Mapping[str, Explanation], *, whole: bool = False
    ) -> None:
        state = self.session.state
        overrides = state.overrides if state is not None else {}
        for field in fields:
            row = _Row(self, field, explained.get(field.path), whole=whole, is_set=field.path in overrides)
            self.rows.setdefault(field.path, []).append(row)

    # search -----------------------------------------------------------------------------------------------------------

    def _typed(self) -> None:
        self.searches += 1
        background_tasks.create(self._search(self.searches))

    async def _search(self, number: int) -> None:
        await asyncio.sleep(_FOLLOWS)
        if number != self.searches or self.root.is_deleted:
            return
        words = str(self.search.value or "").lower().split()
        fields = await asyncio.to_thread(_matching, self.tables, words) if words else []
        shown = fields[:_MOST]
        explained = await asyncio.to_thread(_explained, shown)
        if number != self.searches or self.root.is_deleted:
            return
        for rows in self.rows.values():
            rows[:] = [row for row in rows if not row.whole]
        self.found.clear()
        self.tree.set_visibility(not words)
        with self.root, self.found:
            self._build_rows(shown, explained, whole=True)
            if words and not shown:
                ui.label("No field has these words in its path or its meaning.").classes("text-caption")
            elif len(fields) > _MOST:
                ui.label(f"{len(fields) - _MOST} more: one more word narrows it.").classes("text-caption")

    # values -----------------------------------------------------------------------------------------------------------

    async def commit(self, path: str, text: str) -> str:
        """Set what was typed; the message where it is refused. What is wrong elsewhere because of it is no refusal."""
        state = self.session.state
        if state is None:
            return ""
        try:
            value = typed_value(path, text)
            await asyncio.to_thread(_checked, state, path, value)
            self.session.set(path, value, released=True)
        except ModelError as error:
            return sentence(error.problem, error.allowed)
        return ""

    def reset(self, path: str) -> None:
        """Take the value of the file again, which may be none."""
        state = self.session.state
        if state is not None:
            self.session.set(path, file_value(state, path), released=True)


class _Row:
    """One field: its name, its value as text, its message, and a button that takes the file's value again.

    shown : the text of the model that the control was given.  whole : with its whole path, in a search.
    """

    def __init__(
        self, panel: FieldsPanel, field: Field, explained: Explanation | None, *, whole: bool, is_set: bool
    ) -> None:
        self.panel, self.path, self.whole, self.shown = panel, field.path, whole, field.text
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
                control.props["suffix"] = "" if field.text or default else _units(explained.unit)
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
        before, text = self.shown, self.text
        self.shown = text  # the state follows by itself; leaving the field twice is one change
        words = await self.panel.commit(self.path, text)
        if words:
            self.shown = before
        self.tell(words)

    def _reset(self) -> None:
        self.tell("")
        self._write(self.shown)
        self.panel.reset(self.path)


def _units(unit: str) -> str:
    """Units that a person may type for the first of some SI units."""
    first = unit.partition(", ")[0]
    return next((kind.spellings for kind in KINDS.values() if kind.unit == first), first)


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
