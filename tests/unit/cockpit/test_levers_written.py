"""What a lever writes into the model: the same train in every notation, and by every way out of the page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from itertools import pairwise
from typing import Any

import pytest
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.test_page import raise_in
from tests.unit.cockpit.visit import visit

from epicyclic.cockpit.computing.levers import levers_at
from epicyclic.cockpit.page.page import LeverControl, entries_of, number_in
from epicyclic.cockpit.state.model_file import text_of, written_value
from epicyclic.cockpit.state.state import (
    PageState,
    StateHistory,
    Step,
    command_line,
    fragment_of,
    from_fragment,
    opened,
    request_of,
    script,
    tables_of,
    with_value,
)
from epicyclic.document.document import ready_drives
from epicyclic.document.overrides import parse_setting
from epicyclic.train.resolution import load

# units of each kind beside the one of the lever, and how many of that one they are
OTHERS = {
    "um": (("mm", 1e-3), ("m", 1e-6), ("µm", 1.0)),
    "mm": (("m", 1e-3), ("um", 1e3)),
    "N/m": (("N/um", 1e-6), ("kN/mm", 1e-6)),
    "MN/m": (("N/um", 1.0), ("N/m", 1e6)),
    "kN m": (("N m", 1e3), ("MN m", 1e-3)),
    "MN m": (("kN m", 1e3),),
    "kW": (("W", 1e3), ("MW", 1e-3)),
    "MW": (("kW", 1e3),),
    "rpm": (("rad/s", 0.10471975511965977),),
    "deg": (("rad", 0.017453292519943295),),
    "kg": (("g", 1e3), ("t", 1e-3)),
    "": (),
}


@cache
def levers(drive: str) -> tuple[Mapping[str, Any], ...]:
    return tuple(asdict(lever) for lever in levers_at(*request_of(opened(drive))))


def resolved(source: object, overrides: Mapping[str, object]) -> dict[str, Any]:
    """Every number of the train by its path."""
    return {one.path: one.value for one in load(source, overrides=dict(overrides)).values}  # type: ignore[arg-type]


_known: dict[str, dict[str, Any]] = {}


def numbers(state: PageState) -> dict[str, Any]:
    """The same of a state; what is written alike is loaded once."""
    key = repr((state.drive, state.base, dict(state.overrides)))
    if key not in _known:
        _known[key] = resolved(*request_of(state))
    return _known[key]


def same(found: dict[str, Any], wanted: dict[str, Any]) -> bool:
    def near(one: Any, other: Any) -> bool:
        if isinstance(one, list | tuple) and isinstance(other, list | tuple):
            return len(one) == len(other) and all(map(near, one, other))
        return (
            bool(one == pytest.approx(other, rel=1e-9, abs=0, nan_ok=True))
            if isinstance(one, float)
            else bool(one == other)
        )

    return found.keys() == wanted.keys() and all(near(found[path], wanted[path]) for path in found)


@pytest.mark.parametrize("drive", ready_drives())
def test_every_notation_of_every_lever_gives_the_same_train(drive: str) -> None:
    """A slider, a number, texts with any unit, undo and redo; a lever with an index writes that index alone."""

    async def talk(user: User, session: FakeSession) -> None:
        first = session.now
        for lever in levers(drive):
            with user:
                control = LeverControl(session, lever)  # type: ignore[arg-type]
            number, unit = a_number_of(lever), str(lever["unit"])
            # what the drawing says of it: the number at the path, of a list at its entry
            wanted = numbers(with_value(first, lever["path"], as_a_person_would(first, lever, number)))
            notations = [f"{number:g}", f"{number!r}", f"{number:e}"]
            notations += [f"{number * size!r} {other}" for other, size in ((unit, 1.0), *OTHERS[unit]) if other]
            notations += [f"{number:g}{unit}"] if unit.isalpha() else []
            for kind, value in [("move", number), ("release", number), *(("typed", text) for text in notations)]:
                session.history = StateHistory(now=Step(state=first))
                raise_in(control, kind, value)
                control.follow()
                assert control.props["message"] == "", (lever["path"], value)
                assert same(numbers(session.now), wanted), (lever["path"], value, dict(session.now.overrides))
                assert control.props["changed"] is True
                session.undo()
                assert session.now == first
                session.redo()
                assert same(numbers(session.now), wanted), (lever["path"], value)
            every_way_out(session.now, wanted)
            raise_in(control, "reset")
            assert not session.now.overrides, lever["path"]

    visit(lambda _: None, talk, FakeSession(opened(drive)))


def a_number_of(lever: Mapping[str, Any]) -> float:
    """A number in the range of a lever, as its slider gives it, that it does not have."""
    least, most, step = lever["least"], lever["most"], lever["step"]
    if lever["log"]:
        return float(f"{(least * most) ** 0.5 * 1.1:.3g}")
    falls = lever["path"].startswith("stages") or lever["value"] > (least + most) / 2
    room = lever["value"] - least if falls else most - lever["value"]
    steps = max(1, round(room / step / 3))
    return float(f"{lever['value'] + (-steps if falls else steps) * step:.8g}")


def as_a_person_would(state: PageState, lever: Mapping[str, Any], number: float) -> object:
    """The value in the model file, written by hand."""
    if lever["entry"] is None:
        return f"{number!r} {lever['unit']}" if lever["unit"] else number
    stated = written_value(state, lever["path"])
    before = ["0"] * lever["count"] if stated is None else str(stated).strip("[] mu").split(",")
    before[lever["entry"]] = repr(number)
    return f"[{', '.join(before)}] {lever['unit']}"


def every_way_out(state: PageState, wanted: dict[str, Any]) -> None:
    """Link, command line, script and model text load the same train."""
    assert same(numbers(from_fragment("#" + fragment_of(state))), wanted)
    words = shlex.split(command_line(state))
    settings = dict(parse_setting(text) for flag, text in pairwise(words) if flag == "--set")
    assert same(resolved(words[2], settings), wanted)
    line = next(line for line in script(state).splitlines() if line.startswith("train = "))
    rest = script(state).partition("overrides=")[2].partition(")\nsystem")[0]
    assert line.startswith(f"train = epicyclic.load({words[2]!r}")
    assert same(resolved(words[2], eval(rest, {})), wanted)
    assert same(resolved(tables_of(text_of(state)), {}), wanted)


PIN: dict[str, Any] = {
    "path": "deviations.planet.position.y",
    "label": "pin of planet 2, tangential",
    "value": 0.0,
    "unit": "um",
    "least": 0.0,
    "most": 60.0,
    "step": 0.5,
    "entry": 1,
    "count": 4,
}


def test_a_lever_with_an_index_leaves_the_others_alone() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        with user:
            control = LeverControl(session, PIN)  # type: ignore[arg-type]
        session.listen(state=lambda _: control.follow())

        def pins() -> list[float]:
            found = entries_of(written_value(session.now, PIN["path"]), "um", 4)
            assert found is not None
            return list(found)

        # whatever notation the others have, and however the place is spelled
        for path, before, others in (
            (PIN["path"], "[10, 20, 30, 40] um", [10, 30, 40]),
            (PIN["path"], ["0.01 mm", "20 um", 0, "40e-6 m"], [10, 0, 40]),
            (PIN["path"], "7 um", [7, 7, 7]),
            ("deviations.main.planet.position.y", "[10, 20, 30, 40] um", [10, 30, 40]),
            ("deviations.planet.position", {"y": "[10, 20, 30, 40] um"}, [10, 30, 40]),
        ):
            state = with_value(opened("xu2020"), path, before)
            load(*request_of(state))
            session.history = StateHistory(now=Step(state=state))
            control.follow()
            assert control.props["shown"][1] == (7 if before == "7 um" else 20), path
            raise_in(control, "typed", "0.05 mm")
            assert pins() == [others[0], 50, *others[1:]], path
            raise_in(control, "release", 12.5)
            assert pins() == [others[0], 12.5, *others[1:]], path
            raise_in(control, "reset")  # its own entry alone
            assert pins() == [others[0], 0, *others[1:]], path
            assert control.props["changed"] is False

    visit(lambda _: None, talk, FakeSession(opened("xu2020")))


def test_what_is_no_entry_is_refused_with_what_is_allowed() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        with user:
            control = LeverControl(session, PIN)  # type: ignore[arg-type]
        for text, told in (
            ("[10, 20, 0, 0] um", "a list, and the lever has one entry of it; allowed: one number, as 40 um"),
            ("five um", "no number with a known unit; allowed: one number, as 40 um"),
            ("40 kg", "no number with a known unit"),
            ("inf", "no number with a known unit"),
        ):
            raise_in(control, "typed", text)
            assert control.props["message"].startswith(told), text
            assert not session.now.overrides
        session.history = StateHistory(now=Step(state=with_value(session.now, PIN["path"], "[1, 2] um")))
        raise_in(control, "move", 12.5)  # the others would be lost
        assert control.props["message"] == "its list cannot be read; allowed: 4 numbers, under All fields"
        assert session.now.overrides == {PIN["path"]: "[1, 2] um"}

    visit(lambda _: None, talk, FakeSession(opened("xu2020")))


def test_a_number_is_written_with_all_its_digits() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        mass = {**PIN, "path": "stages.main.sun.mass", "unit": "kg", "entry": None, "count": None}
        with user:
            control = LeverControl(session, mass)  # type: ignore[arg-type]
        for text in ("1234.56789", "1234.56789 kg", "1.23456789 t"):
            raise_in(control, "typed", text)
            assert number_in(written_value(session.now, mass["path"]), "kg") == 1234.56789

    visit(lambda _: None, talk, FakeSession(opened("xu2020")))
