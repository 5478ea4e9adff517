"""All fields of the model, from the schema of the model file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

if TYPE_CHECKING:
    from ..processes.session import Session

__all__ = ["fields_panel"]


def fields_panel(session: Session) -> None:
    """The fields of the model by table, with a search."""
    ui.input("Search all fields").props("dense clearable").classes("w-full")
