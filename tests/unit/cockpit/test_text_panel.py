"""The model as TOML: in step with the state, and what is typed is never thrown away."""

from __future__ import annotations

import asyncio

import pytest

pytest.importorskip("nicegui")

from nicegui import ui
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import seen, until, visit

from epicyclic.cockpit.page.controls import Later
from epicyclic.cockpit.page.file_panels import TextPanel, line_of, line_of_error
from epicyclic.cockpit.state.state import from_text, opened
from epicyclic.document.document import drive_text

TEXT = """format = 2
[stages.main]  # with a comment
planets = 3
sun.teeth = 21
[stages.main.planet]
teeth = 39
bearing = { radial = "2e9 N/m" }
[tolerance]
"deviations.planet.position" = "disc(40 um)"
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("format", 1),
        ("stages.main", 2),
        ("stages.main.sun.teeth", 4),
        ("stages.main.sun.mass", 4),
        ("stages.main.planet.teeth", 6),
        ("stages.main.planet.bearing.radial", 7),
        ("stages.main.planet.mass", 5),
        ("stages.main.ring.teeth", 2),
        ("tolerance.deviations.planet.position", 9),
        ("damping", None),
    ],
)
def test_the_line_of_a_path(path: str, line: int | None) -> None:
    assert line_of(TEXT, path) == line


def test_the_line_that_a_message_names_comes_first() -> None:
    assert line_of_error(TEXT, "is no TOML: at line 3, column 5", "gearbox.toml") == 3
    assert line_of_error(TEXT, "out of range", "stages.main.planet.teeth") == 6


def editor(user: User) -> ui.codemirror:
    (found,) = user.find(ui.codemirror).elements
    return found


async def type_text(user: User, text: str) -> ui.codemirror:
    with user:
        found = editor(user)
        found.value = text
    return found


def test_it_follows_the_state_and_applies() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        assert editor(user).value == drive_text("ren2021")
        session.set("stages.main.sun.mass", "700 kg", released=True)
        await until(lambda: "700 kg" in str(editor(user).value))
        mine = str(editor(user).value)
        await type_text(user, mine.replace("700 kg", "705 kg"))
        user.find("Apply").click()
        await until(lambda: "705 kg" in session.now.base)
        assert not session.now.overrides
        await user.should_see("ren2021")

    visit(TextPanel, talk)


def test_the_text_follows_while_changes_go_on() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        for mass in range(700, 1000):
            session.set("stages.main.sun.mass", f"{mass} kg", released=False)
            if editor(user).value != drive_text("ren2021"):
                break
            await asyncio.sleep(0.02)
        assert editor(user).value != drive_text("ren2021")

    visit(TextPanel, talk)


def test_what_was_asked_for_can_be_dropped() -> None:
    places: list[ui.column] = []
    done: list[str] = []

    async def work() -> None:
        done.append("once")

    async def talk(user: User, session: FakeSession) -> None:
        later = Later(places[0], work)
        later.ask(0.05)
        later.drop()
        await asyncio.sleep(0.2)
        assert not done
        later.ask(0)
        await until(lambda: done)
        assert done == ["once"]

    visit(lambda _: places.append(ui.column()), talk)


def test_a_wrong_text_stays_with_its_line_told() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        before = session.now
        wrong = drive_text("ren2021").replace('mass = "750 kg"', 'mass = "750 m"').replace("750 kg", "750 m")
        await type_text(user, wrong)
        user.find("Apply").click()
        await seen(user, "line ")
        assert session.now is before
        assert editor(user).value == wrong
        await type_text(user, "format = = 2")
        user.find("Apply").click()
        await seen(user, "line 1")
        assert session.now is before

    visit(TextPanel, talk)


def test_where_both_changed_both_are_offered() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        mine = drive_text("ren2021") + "\n# my remark\n"
        await type_text(user, mine)
        session.set("stages.main.sun.mass", "700 kg", released=True)
        await seen(user, "The model has changed elsewhere")
        assert editor(user).value == mine
        user.find("Show the model's text").click()
        await until(lambda: "my remark" not in str(editor(user).value))
        assert "700 kg" in str(editor(user).value)
        user.find("Bring back my text").click()
        await until(lambda: editor(user).value == mine)
        user.find("Apply").click()
        await until(lambda: "my remark" in session.now.base)

    visit(TextPanel, talk)


def test_a_text_of_anybody_names_no_file() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        await type_text(user, session.now.base + '\n[deviations]\nsun.pitch = "/etc/passwd"\n')
        user.find("Apply").click()
        await seen(user, "names a file")
        assert "passwd" not in session.now.base

    base = drive_text("ren2021").partition("[deviations]")[0]
    visit(TextPanel, talk, FakeSession(from_text("mine.toml", base)))


def test_a_new_model_replaces_the_text() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await until(lambda: editor(user).value)
        await session.open(opened("xu2020"))
        await until(lambda: editor(user).value == drive_text("xu2020"))

    visit(TextPanel, talk)
