"""Save and save as: a file of this machine at a typed path, never lost and never half written."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from ...errors import ModelError
from ..state.replay import file_name_of
from ..state.state import opened
from .parts import heard, icon_button, on_key, plain_button, present, refused, rename, show_model, window
from .recent import remember

if TYPE_CHECKING:
    from ..processes.session import Session
    from ..state.state import PageState

__all__ = ["save_buttons"]

# [s] between two looks at the file: reading and hashing it takes a millisecond, beside the event loop
_LOOKS = 4.0


def save_buttons(session: Session) -> None:
    """Buttons that save to the file that is open, or to another one. Ctrl+S saves."""
    save_as = _save_as(session)

    async def save() -> None:
        state = present(session)
        if state is None:
            return
        if state.path is None:
            return save_as()
        if await asyncio.to_thread(session.changed_on_disk):
            return _changed(session, state.path, save_as)
        await _write(session, state.path, force=True)

    with ui.row().classes("items-center no-wrap q-gutter-none"):
        button = icon_button("save", "Save", save)
        icon_button("save_as", "Save as", save_as)

    def show(_: object = None) -> None:
        state = present(session)
        where = "Save as a file" if state is None or state.path is None else f"Save to {state.path}"
        unsaved = session.unsaved
        rename(button, "Save", f"{where}; there are unsaved changes" if unsaved else where)
        button.props(add="color=warning" if unsaved else "", remove="" if unsaved else "color")

    told: Path | None = None

    async def look() -> None:
        """Warn once when another program writes the file; saving then asks what becomes of it."""
        nonlocal told
        state = present(session)
        path = None if state is None else state.path
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


async def _write(session: Session, path: Path, *, force: bool) -> bool:
    """Write the model; whether it is written. Says what went wrong otherwise."""
    try:
        await session.save(path, force=force)
    except ModelError as error:
        refused(error, "Not saved. ")
        return False
    remember(path)
    ui.notify(f"Saved: {path}", type="positive")
    return True


def _changed(session: Session, path: Path, save_as: Callable[[], None]) -> None:
    """Ask what becomes of a file that somebody else has changed since it was opened."""
    with window("The file has changed on disk", width=560) as dialog:
        ui.label(f"{path} is not as it was opened or saved here: another program has written it.")

        async def over() -> None:
            dialog.close()
            await _write(session, path, force=True)

        async def again() -> None:
            dialog.close()
            await _reopen(session, path)

        def other() -> None:
            dialog.close()
            save_as()

        with ui.row().classes("w-full justify-end"):
            plain_button("Save as another file", other)
            plain_button("Read the file again", again).tooltip("Undo brings your model back")
            plain_button("Overwrite the file", over, main=True)
    dialog.on("hide", dialog.delete)
    dialog.open()


async def _reopen(session: Session, path: Path) -> None:
    try:
        state: PageState = await asyncio.to_thread(opened, path)
    except ModelError as error:
        return refused(error)
    show_model(session, state, ui.context.client.layout)
    ui.notify("The file is read again; undo brings your model back.")


def _save_as(session: Session) -> Callable[[], None]:
    """The window of save as; it is built when it is first asked for, and keeps what was typed."""

    def open_window() -> None:
        state = present(session)
        if state is None:
            return
        with window("Save as", width=560) as dialog:
            proposed = state.path or Path.cwd() / file_name_of(state)
            field = (
                ui.input("File on this machine", value=str(proposed))
                .classes("w-full")
                .props("autofocus spellcheck=false")
            )
            over = ui.checkbox("Overwrite the file that is there").classes("hidden")

            async def save() -> None:
                problem = _target_problem(field.value or "")
                if problem:
                    field.error = problem
                    return
                path = _path_of(field.value)
                try:
                    await session.save(path, force=bool(over.value))
                except ModelError as error:
                    field.error = f"{error.problem}{f'; {error.allowed}' if error.allowed else ''}"
                    if path.exists():
                        over.classes(remove="hidden")
                    return
                dialog.close()
                remember(path)
                ui.notify(f"Saved: {path}", type="positive")

            def typed() -> None:
                field.error = None
                over.classes(add="hidden").set_value(False)

            field.on_value_change(typed)
            field.on("keydown.enter", save)
            with ui.row().classes("w-full justify-end"):
                plain_button("Cancel", dialog.close)
                plain_button("Save", save, main=True)
        dialog.on("hide", dialog.delete)
        dialog.open()

    return open_window


def _path_of(text: str) -> Path:
    """A path as it was typed; `~` is the folder of the user."""
    path = Path(text.strip()).expanduser()
    return path if path.suffix else path.with_suffix(".toml")


def _target_problem(text: str) -> str:
    """What is wrong with a path to write; empty where nothing is."""
    if not text.strip():
        return "a path is missing"
    if "\0" in text:
        return "no path"
    try:
        path = _path_of(text)
    except (RuntimeError, ValueError):
        return "no path"
    if path.suffix.lower() != ".toml":
        return f"no model file: a name that ends in .toml, not {path.suffix}"
    if not path.is_absolute():
        return "the whole path, from the root on"
    if not path.parent.is_dir():
        return f"no folder {path.parent}"
    return ""
