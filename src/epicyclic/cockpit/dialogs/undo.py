"""Undo and redo over everything, as two buttons that say what they do and as keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .parts import heard, icon_button, on_key, rename

if TYPE_CHECKING:
    from ..processes.session import Session

__all__ = ["undo_buttons"]


def undo_buttons(session: Session) -> None:
    """Two buttons, and Ctrl+Z, Ctrl+Shift+Z and Ctrl+Y where no text field has the keys."""
    undo = icon_button("undo", "Undo", session.undo)
    redo = icon_button("redo", "Redo", session.redo)

    def show(_: object = None) -> None:
        labels = (session.history.undo_label, session.history.redo_label)
        for word, button, label in zip(("Undo", "Redo"), (undo, redo), labels, strict=True):
            button.set_enabled(bool(label))
            rename(button, f"{word}: {label}" if label else word, "" if label else f"Nothing to {word.lower()}")

    on_key("z", session.undo)
    on_key("z", session.redo, shift=True)
    on_key("y", session.redo)
    heard(session, undo, state=show)
    show()
