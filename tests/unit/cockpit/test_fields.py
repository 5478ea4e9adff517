"""Fields of the model: each is a path that the model file has, and what is typed there replays."""

from __future__ import annotations

import asyncio
import shlex

import pytest

pytest.importorskip("nicegui")

from nicegui import ui
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import put, seen, until, visit

from epicyclic.cockpit.page.file_panels import FieldsPanel
from epicyclic.cockpit.state.model_file import (
    all_fields,
    current_tables,
    explanation_of,
    file_value,
    group_at,
    typed_value,
)
from epicyclic.cockpit.state.state import command_line, opened, typed_text, with_value
from epicyclic.document.document import read, ready_drives
from epicyclic.document.overrides import parse_setting


@pytest.mark.parametrize("drive", ready_drives())
def test_every_field_is_a_real_path_and_replays(drive: str) -> None:
    """What a field shows may be typed there: the file then says the same.  Fields without a value are known paths."""
    state = opened(drive)
    tables = current_tables(state)
    fields = list(all_fields(tables))
    stated = [field for field in fields if field.text]
    assert len(stated) > 15
    overrides = {}
    for field in stated:
        value = typed_value(field.path, field.text)
        assert value == file_value(state, field.path)
        assert parse_setting(f"{field.path}={field.text}") == (field.path, value)
        overrides[field.path] = value
    own, again = read(drive).data, read(drive, overrides).data
    # what is set is assumed no more
    assert {k: v for k, v in again.items() if k != "assumed"} == {k: v for k, v in own.items() if k != "assumed"}


def test_a_member_is_offered_no_key_of_another_kind() -> None:
    """`check` refuses these: no key of a sun."""
    offered = {field.path for field in all_fields(current_tables(opened("ren2021")))}
    for member, has, has_not in (
        ("sun", "bore", "outer_diameter pin_radius rim.kind bearing.radial"),
        ("sun.left", "addendum", "bearing.radial"),
        ("planet", "pin_radius ahead bearing.radial", "support.radial outer_diameter"),
        ("ring", "outer_diameter support.radial", "bore bearing.radial"),
        ("carrier", "pin_radius support.radial mass", "teeth profile_shift bore"),
    ):
        named = {path.removeprefix(f"stages.main.{member}.") for path in offered if f"main.{member}." in path}
        assert set(has.split()) <= named, member
        assert not set(has_not.split()) & named, member


def test_fields_are_explained() -> None:
    tables = current_tables(opened("ren2021"))
    fields = [field for field in all_fields(tables) if not field.path.startswith("tolerance.")]
    assert len(fields) > 300
    assert [field.path for field in fields if explanation_of(field.path) is None] == []
    assert explanation_of("stages.main.sun.mass").unit == "kg"  # type: ignore[union-attr]


def test_a_group_has_what_the_model_states_and_may_state() -> None:
    tables = current_tables(with_value(opened("ren2021"), "stages.main.sun.mass", "700 kg"))
    sun = group_at(tables, "stages.main.sun")
    values = {field.key: field.text for field in sun.fields}
    assert values["mass"] == "700 kg"
    assert values["profile_shift"] == ""
    assert "support" in sun.stated
    assert "flank" in set(sun.tables) - sun.stated
    speed = group_at(tables, "operation.speed")
    assert {field.key: field.text for field in speed.fields}["sun"] == "100 rpm"
    assert {"ring", "carrier"} <= {field.key for field in speed.fields}
    assert group_at(tables, "nothing.like.this").fields == ()


@pytest.mark.parametrize("value", ["5", "true", "10 mm", [1, 2], 0.03, 21, True, "[20, 0, 0] um", 'a "b"', "", " x "])
def test_a_value_as_text_is_the_value(value: object) -> None:
    text = typed_text("a.b", value)
    assert typed_value("a.b", text) == value


def rows(user: User, path: str) -> list[ui.input]:
    return [one for one in user.find(marker=f"field-{path}").elements if isinstance(one, ui.input)]


async def leave(user: User, path: str, text: str) -> ui.input:
    """Type into a field and leave it."""
    put(user, f"field-{path}", text)
    user.find(marker=f"field-{path}").trigger("blur")
    return rows(user, path)[0]


def test_a_table_is_built_when_it_is_opened() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await seen(user, marker="table-damping")
        await user.should_not_see(marker="field-damping.modal")
        with user:
            for one in user.find(marker="table-damping").elements:
                one.open()  # type: ignore[attr-defined]
        await seen(user, marker="field-damping.modal")
        field = await leave(user, "damping.modal", "0.05")
        await until(lambda: session.now.overrides == {"damping.modal": 0.05})
        assert field.error is None
        session.undo()
        await until(lambda: field.value == "0.03")
        session.set("damping.modal", 0.07, released=True)
        await until(lambda: field.value == "0.07")
        put(user, "field-damping.modal", "0.0")  # half typed when something else moves
        session.set("damping.modal", 0.08, released=True)
        await asyncio.sleep(0.5)
        assert field.value == "0.0"

    visit(FieldsPanel, talk)


def test_a_refused_value_is_told_beside_its_field_and_stays() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        put(user, "fields-search", "sun mass")
        await seen(user, marker="field-stages.main.sun.mass")
        field = await leave(user, "stages.main.sun.mass", "700")
        await until(lambda: "unit" in str(field.error))
        assert field.value == "700"
        assert not session.now.overrides
        field = await leave(user, "stages.main.sun.mass", "heavy")
        await until(lambda: field.error and "unit:" not in field.error)
        assert not session.now.overrides
        field = await leave(user, "stages.main.sun.mass", "700 kg")
        await until(lambda: session.now.overrides)
        await until(lambda: field.error is None)
        assert shlex.split(command_line(session.now, "check"))[-2:] == ["--set", "stages.main.sun.mass=700 kg"]
        session.tell("failed", {"path": "stages.main.sun.mass", "message": "too light", "allowed": "more"})
        assert field.error == "too light; allowed: more"
        session.tell("failed", None)
        assert field.error is None
        await asyncio.sleep(0.4)  # the reset button follows the state
        user.find("settings_backup_restore").click()
        await until(lambda: not session.now.overrides)
        await until(lambda: field.value == "750 kg")

    visit(FieldsPanel, talk)


def test_the_search_finds_meanings_and_says_when_nothing_is_found() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        put(user, "fields-search", "modal damping ratio")
        await seen(user, marker="field-damping.modal")
        put(user, "fields-search", "zzz")
        await seen(user, "No field has these words")

    visit(FieldsPanel, talk)
