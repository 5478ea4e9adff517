"""A link that reopens the state: the whole of it stands behind the `#`, which no server sees."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from ...errors import ModelError
from ..state.links import fragment_of
from .parts import icon_button, present, refused

if TYPE_CHECKING:
    from ..processes.session import Session

__all__ = ["link_button"]

# Characters that mail programs and chats leave whole; browsers take more.
_SURE = 8000
# [s] a browser may take to say its address and to copy
_ANSWER = 5.0


def link_button(session: Session) -> None:
    """A button that copies a link to the present state."""

    async def make() -> None:
        state = present(session)
        if state is None:
            return
        try:
            fragment = fragment_of(state)
        except ModelError as error:
            return refused(error, "No link: download the model instead. ")
        script = f"""
            const link = location.origin + "/#" + {fragment!r};
            try {{ await navigator.clipboard.writeText(link); return [link.length, true]; }}
            catch {{ window.prompt("Copy this link", link); return [link.length, false]; }}
        """
        found = await ui.run_javascript(script, timeout=_ANSWER)
        length, copied = found if isinstance(found, list) and len(found) == 2 else (len(fragment), False)
        words = f"Link {'copied' if copied else 'made'}, {length} characters"
        if length > _SURE:
            ui.notify(f"{words}: some mail programs and chats cut it. The model as a file is safer.", type="warning")
        else:
            ui.notify(f"{words}. It holds the whole model.", type="positive")

    icon_button("link", "Copy a link to this state", make)
