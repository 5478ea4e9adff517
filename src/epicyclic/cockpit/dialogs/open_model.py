"""Open a model: a ready drive, a file of this machine, or one that is dropped on the page or picked."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import events, ui

from ...document.document import MAX_BYTES
from ...errors import ModelError
from ...rexs.file import is_rexs_name
from ...studies.drives import drive_titles
from ..state.state import opened, uploaded
from .parts import plain_button, present, refused, show_model, window
from .recent import recent_files, remember
from .rexs_lists import show_rexs

if TYPE_CHECKING:
    from ..processes.session import Session
    from ..state.state import PageState

__all__ = ["open_button", "open_window"]

_SUFFIXES = ".toml,.rexs,.rexsj,.rexsz"

# What takes the files of a page: one, so that a drop opens a model once.
_RECEIVERS: dict[Session, ui.upload] = {}


def open_button(session: Session) -> None:
    """A button with all ways to open a model; a file may be dropped anywhere on the page."""
    picker = _receiver_of(session)
    plain_button("Open", lambda: _show(session, picker), icon="folder_open").props('aria-label="Open a model"')


async def open_window(session: Session) -> None:
    """Open the window of `open_button` from another place of the page."""
    await _show(session, _receiver_of(session))


async def _show(session: Session, picker: ui.upload) -> None:
    with window("Open a model", width=760) as dialog:
        _from_file(session, dialog, picker)
        recent = ui.column().classes("w-full q-gutter-none")
        _ready_drives(session, dialog)
    dialog.on("hide", dialog.delete)
    dialog.open()
    paths = await recent_files()
    if not dialog.is_deleted and paths:
        with recent:
            _recent(session, dialog, paths)


async def _open(session: Session, make: Callable[[], PageState], what: str) -> ModelError | None:
    """Make a state beside the event loop and open it; the error where it cannot be read."""
    try:
        state = await asyncio.to_thread(make)
    except ModelError as error:
        return error
    before = present(session)
    show_model(session, state, ui.context.client.layout)
    if state.path is not None:
        remember(state.path)
    if before is not None:
        ui.notify(f"{what}. Undo brings back {before.name}.", timeout=3000, position="bottom-left")
    return None


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
            rows[name] = _drive(session, dialog, name, title)

    def narrow() -> None:
        words = str(search.value or "").lower().split()
        for name, row in rows.items():
            row.set_visibility(all(word in f"{name} {titles[name]}".lower() for word in words))

    search.on_value_change(narrow)


def _drive(session: Session, dialog: ui.dialog, name: str, title: str) -> ui.item:
    async def take() -> None:
        error = await _open(session, lambda: opened(name), f"{name} is open")
        if error is not None:
            return refused(error)
        dialog.close()

    with ui.item(on_click=take).mark(f"drive-{name}") as row, ui.item_section():
        ui.item_label(name)
        ui.item_label(title).props("caption")
    return row


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
            if await _open_path(session, text, field):
                dialog.close()

        field.on("keydown.enter", take)
        plain_button("Open file", take, main=True)

        def pick() -> None:
            dialog.close()
            picker.run_method("pickFiles")

        plain_button("Choose ...", pick, icon="upload_file").tooltip(
            "The browser's window of files; a drop does as well"
        )


async def _open_path(session: Session, text: str, field: ui.input | None = None) -> bool:
    """Open a file at a path as it was typed; whether it is open. A message stands beside the field, if there is one."""
    error = await _open(session, lambda: opened(_expanded(text)), f"{text} is open")
    if error is None:
        return True
    if field is None:
        refused(error)
    else:
        field.error = str(error)
    return False


def _expanded(text: str) -> str:
    path = Path(text)
    try:
        path = path.expanduser()
    except RuntimeError:
        raise ModelError("no such user", path=text, allowed="a whole path") from None
    if not path.is_absolute():
        raise ModelError("is no whole path", path=text, allowed="a path from the root on, or from ~")
    return str(path)


def _recent(session: Session, dialog: ui.dialog, paths: list[str]) -> None:
    ui.label("Recent").classes("text-subtitle1")
    with ui.list().props("dense").classes("w-full"):
        for path in paths:

            async def take(path: str = path) -> None:
                if await _open_path(session, path):
                    dialog.close()

            with ui.item(on_click=take), ui.item_section():
                ui.item_label(path)


# files of the browser -------------------------------------------------------------------------------------------------


def _receiver_of(session: Session) -> ui.upload:
    if session not in _RECEIVERS:
        _RECEIVERS[session] = _receiver(session)
        ui.context.client.on_delete(lambda: _RECEIVERS.pop(session, None))
    return _RECEIVERS[session]


def _receiver(session: Session) -> ui.upload:
    """What takes a file that was picked or dropped on the page; not seen itself."""

    async def take(event: events.UploadEventArguments) -> None:
        name, content = event.file.name, await event.file.read()
        picker.reset()
        error = await _open(session, lambda: uploaded(name, content), f"{_last(name)} is open")
        if error is not None:
            return refused(error, f"{_last(name)} cannot be opened. ")
        if is_rexs_name(name):
            await show_rexs(_last(name), content)

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


def _last(name: str) -> str:
    """The name of a file without folders, short enough for a message."""
    return name.replace("\\", "/").rsplit("/", 1)[-1][:80]
