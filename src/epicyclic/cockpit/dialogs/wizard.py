"""A new train without a model file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .parts import plain_button

if TYPE_CHECKING:
    from ..processes.session import Session

__all__ = ["new_button"]


def new_button(session: Session) -> None:
    """A button that opens the wizard of a new train."""
    plain_button("New", lambda: None, icon="add")
