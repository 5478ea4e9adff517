"""Pin a state as A, and see what differs between it and the present one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from nicegui import ui

from ...errors import ConvergenceError, ModelError
from ..state.state import request_of
from .parts import heard, plain_button, present, show_model, window
from .worker_calls import compared_states

if TYPE_CHECKING:
    from ..processes.session import Session


def compare_controls(session: Session) -> None:
    """Buttons that pin the present state as A, unpin it, and open the comparison, where both can change places."""
    with ui.row().classes("items-center no-wrap q-gutter-xs") as root:
        pin = plain_button("Pin A", session.pin, icon="push_pin")
        with pin:
            ui.tooltip("Keep this state as A: its curves stay as dashed lines")
        compare = plain_button("Compare", lambda: _show(session), icon="compare_arrows")
        unpin = plain_button("Unpin A", session.unpin)

    def show(_: object = None) -> None:
        pinned = session.pinned is not None
        pin.set_visibility(not pinned)
        pin.set_enabled(present(session) is not None)
        compare.set_visibility(pinned)
        unpin.set_visibility(pinned)

    heard(session, root, state=show)
    show()


def _swap(session: Session) -> None:
    """A and the present state change places; undo takes back the change of the present one."""
    pinned = session.pinned
    if pinned is None:
        return
    session.pin()
    show_model(session, pinned, ui.context.client.layout)


async def _show(session: Session) -> None:
    """A window with what differs, computed while it is open."""
    first, second = session.pinned, present(session)
    if first is None or second is None:
        return
    with window("What differs: A is pinned, B is the present state", width=980) as dialog:
        place = ui.column().classes("w-full")
        with place:
            ui.linear_progress(show_value=False).props("indeterminate").classes("w-full")
            ui.label("Both trains are computed: modes, sharing, forces.").props('role="status"')

        def swap() -> None:
            dialog.close()
            _swap(session)

        def renew() -> None:
            dialog.close()
            session.pin()

        with ui.row().classes("w-full justify-end"):
            plain_button("Swap A and B", swap).tooltip("A becomes the present state; undo takes it back")
            plain_button("Pin the present state instead", renew)
            plain_button("Close", dialog.close, main=True)
    dialog.on("hide", dialog.delete)
    dialog.open()
    try:
        found = await session.call(compared_states, request_of(first), request_of(second), (first.name, second.name))
    except (ModelError, ConvergenceError) as error:
        found = error
    if place.is_deleted:
        return
    place.clear()
    with place:
        if isinstance(found, Exception):
            ui.label(str(found)).classes("text-negative").props('role="alert"')
        else:
            _table(found)
            if first.relative_speed != 1 or second.relative_speed != 1:
                ui.label("Both at the speed of their model, whatever speed the page shows.").classes("text-caption")


def _table(found: Mapping[str, Any]) -> None:
    headings: Sequence[str] = found["headings"]
    ui.label(found["lead"]).classes("text-caption")
    columns = [
        {"name": f"c{i}", "label": heading, "field": f"c{i}", "align": "left" if i < 2 else "right", "sortable": i < 2}
        for i, heading in enumerate(headings)
    ]
    rows = [{"id": number, **{f"c{i}": cell for i, cell in enumerate(row)}} for number, row in enumerate(found["rows"])]
    table = ui.table(columns=columns, rows=rows, row_key="id").classes("w-full").style("max-height: 62vh")
    table.props('dense flat wrap-cells hide-pagination virtual-scroll aria-label="Differences of model and results"')
    for note in found["notes"]:
        ui.label(note).classes("text-caption")
