"""Open a model (a ready drive, a file of this machine, one dropped on the page), and save it: never half written.

Files that were opened or saved last are kept in the browser: paths as a person types them, nothing more.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import events, ui

from ...document.document import MAX_BYTES, drive_titles
from ...errors import ModelError
from ...rexs.file import HEADINGS, is_rexs_name
from ..processes.session import Session
from ..state.state import PageState, file_name_of, opened, uploaded
from .controls import heard, icon_button, literal, on_key, plain_button, refused, rename, show_model, window

if TYPE_CHECKING:
    from ...rexs.stages import Entry

_KEY = "epicyclic-recent"
# Files that are listed: those of a week.
_MOST_RECENT = 8
# [s] a browser may take to answer
_ANSWER = 3.0


def remember(path: Path) -> None:
    """Put a file ahead of the list."""
    text = literal(str(path))
    ui.run_javascript(
        f"""try {{
            const old = JSON.parse(localStorage.getItem("{_KEY}") || "[]").filter((one) => one !== {text});
            localStorage.setItem("{_KEY}", JSON.stringify([{text}, ...old].slice(0, {_MOST_RECENT})));
        }} catch {{}}"""
    )


async def recent_files() -> list[str]:
    """Paths of the list, the newest first; what is no text is left out."""
    try:
        paths = await ui.run_javascript(
            f"try {{ return JSON.parse(localStorage.getItem('{_KEY}') || '[]') }} catch {{ return [] }}",
            timeout=_ANSWER,
        )
    except TimeoutError:
        return []
    return [path for path in paths if isinstance(path, str)][:_MOST_RECENT] if isinstance(paths, list) else []


_HEADINGS = {kind: HEADINGS[kind] for kind in ("assumed", "dropped", "read")}
_COLUMNS = [
    {"name": "what", "label": "in the file", "field": "what", "align": "left"},
    {"name": "became", "label": "in the model", "field": "became", "align": "left"},
]
# Lines of one list in the window; a file of hundreds of components says the same of many.
_MOST_LINES = 400


def rexs_entries(content: bytes) -> Mapping[str, Sequence[tuple[str, str]]]:
    """Lines of the three lists: attribute and component, and what became of it.

    Raises
    ------
    ModelError : no REXS file.
    """
    from ...rexs.import_train import read_rexs

    reading = read_rexs(content)
    types = {component.id: component.type for component in reading.file.components}

    def line(entry: Entry) -> tuple[str, str]:
        who = "" if entry.component is None else f"{types.get(entry.component, '')} {entry.component}: "
        return f"{who}{entry.attribute}", entry.where

    return {kind: [line(entry) for entry in getattr(reading, kind)] for kind in _HEADINGS}


async def show_rexs(name: str, content: bytes) -> None:
    """A window with the lists of a file that is open already."""
    lists = await asyncio.to_thread(rexs_entries, content)
    with window("Read from a REXS file", width=860) as dialog:
        ui.label(name).classes("text-caption")
        with ui.scroll_area().classes("w-full").style("height: 60vh"):
            for kind, heading in _HEADINGS.items():
                lines = lists[kind]
                with ui.expansion(f"{heading} ({len(lines)})", value=kind == "assumed").classes("w-full"):
                    rows = [{"id": i, "what": what, "became": to} for i, (what, to) in enumerate(lines[:_MOST_LINES])]
                    table = ui.table(columns=_COLUMNS, rows=rows, row_key="id").classes("w-full")
                    table.props("dense flat wrap-cells hide-pagination")
                    if len(lines) > _MOST_LINES:
                        ui.label(f"{len(lines) - _MOST_LINES} more: `epicyclic import` lists them all.")
        with ui.row().classes("w-full justify-end"):
            plain_button("Close", dialog.close, main=True)


_SUFFIXES = ".toml,.rexs,.rexsj,.rexsz"


def open_button(session: Session) -> Callable[[], Awaitable[None]]:
    """A button with all ways to open a model, and what opens its window from another place of the page.

    A file may be dropped anywhere on the page.
    """
    picker = _receiver(session)

    async def show() -> None:
        with window("Open a model", width=760) as dialog:
            _from_file(session, dialog, picker)
            recent = ui.column().classes("w-full q-gutter-none")
            _ready_drives(session, dialog)
        paths = await recent_files()
        if not dialog.is_deleted and paths:
            with recent:
                ui.label("Recent").classes("text-subtitle1")
                with ui.list().props("dense").classes("w-full"):
                    for path in paths:
                        take = partial(_take, session, dialog, partial(_at_path, path), path)
                        with ui.item(on_click=take), ui.item_section():
                            ui.item_label(path)

    plain_button("Open", show, icon="folder_open").props('aria-label="Open a model"')
    return show


async def _open(session: Session, make: Callable[[], PageState], what: str) -> ModelError | None:
    """Make a state beside the event loop and open it; the error where it cannot be read."""
    try:
        state = await asyncio.to_thread(make)
    except ModelError as error:
        return error
    before = session.state
    show_model(session, state, ui.context.client.layout)
    if state.path is not None:
        remember(state.path)
    if before is not None:
        ui.notify(f"{what}. Undo brings back {before.name}.", timeout=3000, position="bottom-left")
    return None


async def _take(session: Session, dialog: ui.dialog, make: Callable[[], PageState], name: str) -> None:
    """Open a model of a list and close the window, or say why it cannot be."""
    error = await _open(session, make, f"{name} is open")
    if error is not None:
        return refused(error)
    dialog.close()


# ready drives ---------------------------------------------------------------------------------------------------------


def _ready_drives(session: Session, dialog: ui.dialog) -> None:
    """The ready drives by title, with a field that narrows the list."""
    titles = drive_titles()
    ui.label("Ready drives").classes("text-subtitle1")
    search = ui.input("Search").props("dense clearable").classes("w-full")
    rows: dict[str, ui.item] = {}
    with (
        ui.scroll_area().classes("w-full").style("height: 320px"),
        ui.list().props("dense separator").classes("w-full"),
    ):
        for name, title in titles.items():
            take = partial(_take, session, dialog, partial(opened, name), name)
            with ui.item(on_click=take).mark(f"drive-{name}") as rows[name], ui.item_section():
                ui.item_label(name)
                ui.item_label(title).props("caption")

    def narrow() -> None:
        words = str(search.value or "").lower().split()
        for name, row in rows.items():
            row.set_visibility(all(word in f"{name} {titles[name]}".lower() for word in words))

    search.on_value_change(narrow)


# files of this machine ------------------------------------------------------------------------------------------------


def _from_file(session: Session, dialog: ui.dialog, picker: ui.upload) -> None:
    """A path to type, and the browser's own window of files."""
    with ui.row().classes("w-full items-start no-wrap"):
        field = ui.input("File on this machine, .toml or REXS").classes("col").props("dense spellcheck=false autofocus")

        async def take() -> None:
            text = str(field.value or "").strip()
            if not text:
                return
            field.error = None
            error = await _open(session, lambda: _at_path(text), f"{text} is open")
            if error is None:
                dialog.close()
            else:
                field.error = str(error)

        field.on("keydown.enter", take)
        plain_button("Open file", take, main=True)

        def pick() -> None:
            dialog.close()
            picker.run_method("pickFiles")

        plain_button("Choose ...", pick, icon="upload_file").tooltip(
            "The browser's window of files; a drop does as well"
        )


def _at_path(text: str) -> PageState:
    """The state of the file at a path as it was typed. Raises ModelError."""
    return opened(_whole_path(text))


def _whole_path(text: str) -> Path:
    """A path as it was typed; `~` is the folder of the user. Raises ModelError."""
    if not text:
        raise ModelError("a path is missing")
    try:
        path = Path(text).expanduser()
    except RuntimeError:
        raise ModelError("no such user", path=text, allowed="a whole path") from None
    if not path.is_absolute():
        raise ModelError("is no whole path", path=text, allowed="a path from the root on, or from ~")
    return path


# files of the browser -------------------------------------------------------------------------------------------------


def _receiver(session: Session) -> ui.upload:
    """What takes a file that was picked or dropped on the page; not seen itself."""

    async def take(event: events.UploadEventArguments) -> None:
        name, content = event.file.name, await event.file.read()
        short = name.replace("\\", "/").rsplit("/", 1)[-1][:80]  # without folders, for a message
        picker.reset()
        error = await _open(session, lambda: uploaded(name, content), f"{short} is open")
        if error is not None:
            return refused(error, f"{short} cannot be opened. ")
        if is_rexs_name(name):
            await show_rexs(short, content)

    def too_large() -> None:
        ui.notify(f"Not opened: one file of .toml or REXS with at most {MAX_BYTES // 10**6} MB", type="negative")

    picker = ui.upload(on_upload=take, on_rejected=too_large, max_file_size=MAX_BYTES, auto_upload=True)
    picker.classes("hidden").props(f'accept="{_SUFFIXES}" aria-hidden=true')
    picker.on("failed", lambda: ui.notify("The file did not arrive: too large, or the server is gone", type="negative"))
    ui.on("cockpit-several", lambda: ui.notify("One file at a time: only the first one is opened.", type="warning"))
    ui.add_head_html(_DROP % picker.id)
    return picker


# A file over the page draws a frame round it; released, it goes to the uploader.
_DROP = """<style>body.cockpit-drop::after { content: "Drop a model file: .toml or REXS"; position: fixed; inset: 0;
  z-index: 9999; display: grid; place-items: center; font-size: 1.4rem; pointer-events: none;
  border: 3px dashed var(--ck-accent, #1f77b4); color: var(--ck-accent, #1f77b4); background: rgb(127 127 127 / 25%%); }
</style><script>(() => {
  const files = (event) => event.dataTransfer?.types?.includes("Files");
  let over = 0;
  const mark = (count) => { over = Math.max(0, count); document.body.classList.toggle("cockpit-drop", over > 0); };
  document.addEventListener("dragenter", (event) => { if (files(event)) { event.preventDefault(); mark(over + 1); } });
  document.addEventListener("dragleave", (event) => { if (files(event)) mark(over - 1); });
  document.addEventListener("dragover", (event) => { if (files(event)) event.preventDefault(); });
  document.addEventListener("drop", (event) => {
    if (!files(event)) return;
    event.preventDefault();
    mark(0);
    if (event.dataTransfer.files.length > 1) emitEvent("cockpit-several");
    getElement(%d).$refs.qRef.addFiles([...event.dataTransfer.files].slice(0, 1));
  });
})();</script>"""


# [s] between two looks at the file: reading and hashing it takes a millisecond, beside the event loop
_LOOKS = 4.0


def save_buttons(session: Session) -> None:
    """Buttons that save to the file that is open, or to another one. Ctrl+S saves."""

    async def save() -> None:
        state = session.state
        if state is None:
            return
        if state.path is None:
            _save_as(session)
        elif await asyncio.to_thread(session.changed_on_disk):
            _changed(session, state.path)
        else:
            await _overwrite(session, state.path)

    with ui.row().classes("items-center no-wrap q-gutter-none"):
        button = icon_button("save", "Save", save)
        icon_button("save_as", "Save as", lambda: _save_as(session))

    def show(_: object = None) -> None:
        state = session.state
        where = "Save as a file" if state is None or state.path is None else f"Save to {state.path}"
        unsaved = session.unsaved
        rename(button, "Save", f"{where}; there are unsaved changes" if unsaved else where)
        button.props(add="color=warning" if unsaved else "", remove="" if unsaved else "color")

    told: Path | None = None

    async def look() -> None:
        """Warn once when another program writes the file; saving then asks what becomes of it."""
        nonlocal told
        path = None if session.state is None else session.state.path
        if path is None or not await asyncio.to_thread(session.changed_on_disk):
            told = None
        elif told != path:
            told = path
            words = f"{path} has changed on disk. Save asks which one stays; Open reads it again."
            ui.notify(words, type="warning", timeout=0, close_button="Close")

    ui.timer(_LOOKS, look, immediate=False)
    on_key("s", save, in_text=True)
    heard(session, button, state=show)
    show()


async def _overwrite(session: Session, path: Path) -> None:
    """Write the model to its file, or say why it cannot be."""
    try:
        await session.save(path, force=True)
    except ModelError as error:
        return refused(error, "Not saved. ")
    _saved(path)


def _saved(path: Path) -> None:
    remember(path)
    ui.notify(f"Saved: {path}", type="positive")


def _changed(session: Session, path: Path) -> None:
    """Ask what becomes of a file that somebody else has changed since it was opened."""
    with window("The file has changed on disk", width=560) as dialog:
        ui.label(f"{path} is not as it was opened or saved here: another program has written it.")

        async def over() -> None:
            dialog.close()
            await _overwrite(session, path)

        async def again() -> None:
            dialog.close()
            try:
                state = await asyncio.to_thread(opened, path)
            except ModelError as error:
                return refused(error)
            show_model(session, state, ui.context.client.layout)
            ui.notify("The file is read again; undo brings your model back.")

        def other() -> None:
            dialog.close()
            _save_as(session)

        with ui.row().classes("w-full justify-end"):
            plain_button("Save as another file", other)
            plain_button("Read the file again", again).tooltip("Undo brings your model back")
            plain_button("Overwrite the file", over, main=True)


def _save_as(session: Session) -> None:
    """The window of save as."""
    state = session.state
    if state is None:
        return
    with window("Save as", width=560) as dialog:
        proposed = state.path or Path.cwd() / file_name_of(state)
        field = ui.input("File on this machine", value=str(proposed)).classes("w-full")
        field.props("autofocus spellcheck=false")
        over = ui.checkbox("Overwrite the file that is there").classes("hidden")

        async def save() -> None:
            try:
                path = _whole_path(str(field.value or "").strip())
                path = path if path.suffix else path.parent / f"{path.name}.toml"
                if not path.parent.is_dir():
                    raise ModelError(f"no folder {path.parent}")
                await session.save(path, force=bool(over.value))
            except ModelError as error:
                field.error = f"{error.problem}; {error.allowed}" if error.allowed else error.problem
                if "overwrite" in error.allowed:
                    over.classes(remove="hidden")
                return
            dialog.close()
            _saved(path)

        def typed() -> None:
            field.error = None
            over.classes(add="hidden").set_value(False)

        field.on_value_change(typed)
        field.on("keydown.enter", save)
        with ui.row().classes("w-full justify-end"):
            plain_button("Cancel", dialog.close)
            plain_button("Save", save, main=True)
