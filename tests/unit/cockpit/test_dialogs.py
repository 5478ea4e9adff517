"""Opening, saving, undo, comparison and taking away, as a user meets them."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui")

from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing.user import User

from epicyclic.cockpit.dialogs.compare import compare_controls
from epicyclic.cockpit.dialogs.compared_states import compared_states
from epicyclic.cockpit.dialogs.fields_panel import fields_panel
from epicyclic.cockpit.dialogs.figure_of import VERBS, figure_of, figures
from epicyclic.cockpit.dialogs.link import link_button
from epicyclic.cockpit.dialogs.open_model import open_button
from epicyclic.cockpit.dialogs.parts import safe_name
from epicyclic.cockpit.dialogs.rexs_lists import rexs_entries
from epicyclic.cockpit.dialogs.save import save_buttons
from epicyclic.cockpit.dialogs.take_away import bytes_of_picture, take_away_button
from epicyclic.cockpit.dialogs.text_panel import text_panel
from epicyclic.cockpit.dialogs.undo import undo_buttons
from epicyclic.cockpit.state.links import from_fragment
from epicyclic.cockpit.state.state import State, from_text, opened, request_of, with_value
from epicyclic.studies.drives import drive_text
from epicyclic.verbs.record import verbs
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import visit

HOSTILE = '<img src=x onerror="alert(1)">````\n'


def field(user: User, label: str) -> Any:
    (found,) = (one for one in user.find(ui.input).elements if one.props.get("label") == label)
    return found


def test_undo_says_what_it_undoes() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await user.should_see("Nothing to undo")
        session.set("damping.modal", 0.05, released=True)
        await user.should_see("Undo: damping.modal")
        user.find("undo").click()
        assert not session.now.overrides
        await user.should_see("Redo: damping.modal")
        user.find("redo").click()
        assert session.now.overrides == {"damping.modal": 0.05}

    visit(undo_buttons, talk)


# open -----------------------------------------------------------------------------------------------------------------


def test_a_ready_drive_opens_by_its_title() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        user.javascript_rules[__import__("re").compile("(?s).*epicyclic-recent.*")] = lambda _: []
        user.find("Open").click()
        await user.should_see("wind-five")
        await user.should_see("Herringbone planetary train, 100 kN m (Ren 2021)")
        with user:
            field(user, "Search").value = "wind"
        await user.should_not_see("lin1999-n3")
        rows = [one for one in user.find(ui.item).elements if any("wind-five" in str(c.props) or getattr(c, "text", "") == "wind-five" for c in one.descendants())]
        with user:
            user.find("wind-five").trigger("click")
            for row in rows:
                for listener in row._event_listeners.values():
                    await listener.handler(None) if asyncio.iscoroutinefunction(listener.handler) else None
        await asyncio.sleep(0.2)

    visit(open_button, talk)
