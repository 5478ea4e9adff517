"""What was read of a REXS file, assumed and dropped, as three lists."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence

from nicegui import ui

from .parts import plain_button, window

__all__ = ["rexs_entries", "show_rexs"]

_HEADINGS = {
    "assumed": "Assumed, as the file does not say it",
    "dropped": "Dropped, as the model has no place for it",
    "read": "Read from the file",
}
# Lines of one list in the window; a file of hundreds of components says the same of many.
_MOST = 400


def rexs_entries(content: bytes) -> Mapping[str, Sequence[tuple[str, str]]]:
    """Lines of the three lists: attribute and component, and what became of it.

    Raises
    ------
    ModelError : no REXS file.
    """
    from ...rexs.import_train import read_rexs

    found = read_rexs(content)
    types = {component.id: component.type for component in found.file.components}
    lists = {}
    for kind in _HEADINGS:
        lines = []
        for entry in getattr(found, kind):
            who = "" if entry.component is None else f"{types.get(entry.component, '')} {entry.component}: "
            where = f"{entry.path} = {entry.text}" if entry.path and entry.text else entry.path or entry.text
            lines.append((f"{who}{entry.attribute}", where))
        lists[kind] = lines
    return lists


async def show_rexs(name: str, content: bytes) -> None:
    """A window with the lists of a file that is open already."""
    lists = await asyncio.to_thread(rexs_entries, content)
    with window("Read from a REXS file", width=860) as dialog:
        ui.label(name).classes("text-caption")
        with ui.scroll_area().classes("w-full").style("height: 60vh"):
            for kind, heading in _HEADINGS.items():
                lines = lists[kind]
                with ui.expansion(f"{heading} ({len(lines)})", value=kind == "assumed").classes("w-full"):
                    _table(lines[:_MOST])
                    if len(lines) > _MOST:
                        ui.label(f"{len(lines) - _MOST} more: `epicyclic import` lists them all.")
        with ui.row().classes("w-full justify-end"):
            plain_button("Close", dialog.close, main=True)
    dialog.on("hide", dialog.delete)
    dialog.open()


def _table(lines: Sequence[tuple[str, str]]) -> None:
    columns = [
        {"name": "what", "label": "in the file", "field": "what", "align": "left"},
        {"name": "became", "label": "in the model", "field": "became", "align": "left"},
    ]
    rows = [{"id": i, "what": what, "became": became} for i, (what, became) in enumerate(lines)]
    ui.table(columns=columns, rows=rows, row_key="id").props("dense flat wrap-cells hide-pagination").classes("w-full")
