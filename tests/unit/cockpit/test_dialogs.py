"""Opening, saving, undo, comparison and taking away, as a user meets them."""

from __future__ import annotations

import asyncio
import os
import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui")

from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import seen, until, visit

import epicyclic
from epicyclic.cockpit.page.controls import safe_name
from epicyclic.cockpit.page.file_panels import FieldsPanel, TextPanel
from epicyclic.cockpit.page.header import (
    VERBS,
    bytes_of_picture,
    compare_controls,
    figures,
    link_button,
    take_away_button,
    undo_buttons,
)
from epicyclic.cockpit.page.open_model import open_button, rexs_entries, save_buttons
from epicyclic.cockpit.processes.jobs import Job, compared_states, figure_of, jobs_done
from epicyclic.cockpit.state.state import PageState, from_fragment, from_text, opened, request_of, with_value
from epicyclic.document.document import drive_text
from epicyclic.errors import ModelError
from epicyclic.verbs.record import verbs

REXS = Path(os.environ.get("EPICYCLIC_DATA", Path(__file__).parents[4] / "shared" / "data")) / "rexs"
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


def knows_recent(user: User, paths: list[str]) -> None:
    """What the browser would have kept."""
    user.javascript_rules[re.compile("(?s)try .*epicyclic-recent.*")] = lambda _: paths


def test_a_ready_drive_opens_by_its_title() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        knows_recent(user, [])
        user.find("Open").click()
        await user.should_see("Herringbone planetary train, 100 kN m (Ren 2021)")
        with user:
            field(user, "Search").value = "five"
        await user.should_not_see("lin1999-n3")
        user.find(marker="drive-wind-five").click()
        await until(lambda: session.now.drive == "wind-five")
        assert session.history.undo_label == "open wind-five"

    visit(open_button, talk)


def test_a_file_opens_by_its_path_and_a_wrong_one_says_why(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(drive_text("ren2021"))

    async def talk(user: User, session: FakeSession) -> None:
        knows_recent(user, [str(file), "/gone.toml"])
        user.find("Open").click()
        await seen(user, "/gone.toml")
        typed = field(user, "File on this machine, .toml or REXS")
        for text, problem in (("mine.toml", "whole path"), ("/gone.toml", "no such file"), (str(tmp_path), "folder")):
            with user:
                typed.value = text
            user.find("Open file").click()
            await until(lambda: problem in str(typed.error))  # noqa: B023
            assert session.now.name == "ren2021"
        with user:
            typed.value = str(file)
        user.find("Open file").click()
        await until(lambda: session.now.path == file)
        assert session.now.trusted

    visit(open_button, talk)


async def drop(user: User, name: str, content: bytes) -> None:
    with user:
        (picker,) = (one for one in user._client.elements.values() if isinstance(one, ui.upload))
        await picker.handle_uploads([SmallFileUpload(name=name, content_type="", _data=content)])


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("mine.toml", b"format = = 2", "line 1"),
        ("mine.toml", b"\xff\xfe", "UTF-8"),
        ("big.toml", b"#" * 5_000_000, "too large"),
        ("files.toml", b'format = 2\n[deviations]\nsun.pitch = "/etc/passwd"', "names a file"),
        ("bad.rexs", b"<model", "bad.rexs"),
        ("../../etc/passwd.toml", b"format = = 2", "passwd.toml cannot be opened"),
    ],
)
def test_a_hostile_file_is_refused(name: str, content: bytes, problem: str) -> None:
    async def talk(user: User, session: FakeSession) -> None:
        before = session.now
        await drop(user, name, content)
        await until(lambda: problem in " ".join(map(str, user.notify.messages)))
        assert "../" not in " ".join(map(str, user.notify.messages))
        assert session.now is before

    visit(open_button, talk)


def test_a_dropped_model_opens_without_a_path() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        await drop(user, "C:\\train\\mine.toml", drive_text("xu2020").encode())
        await until(lambda: session.now.name == "mine.toml")
        assert session.now.path is None
        assert not session.now.trusted

    visit(open_button, talk)


def test_a_rexs_file_opens_with_its_lists() -> None:
    file = next(iter(sorted(REXS.glob("*.rexs"))), None)
    if file is None:
        pytest.skip("no REXS files")
    lists = rexs_entries(file.read_bytes())
    assert all(lists[kind] for kind in ("read", "assumed", "dropped"))

    async def talk(user: User, session: FakeSession) -> None:
        await drop(user, file.name, file.read_bytes())
        await seen(user, "Read from a REXS file")
        await user.should_see(f"Assumed, as the file does not say it ({len(lists['assumed'])})")
        assert session.now.name == file.name

    visit(open_button, talk)


# save -----------------------------------------------------------------------------------------------------------------


def test_save_as_asks_before_it_overwrites(tmp_path: Path) -> None:
    file, other = tmp_path / "mine.toml", tmp_path / "other.toml"
    other.write_text("precious")

    async def talk(user: User, session: FakeSession) -> None:
        session.set("damping.modal", 0.05, released=True)
        user.find("save_as").click()
        typed = field(user, "File on this machine")
        for text, problem in (
            ("", "missing"),
            ("mine.toml", "whole path"),
            (str(tmp_path / "mine.txt"), ".toml"),
            (str(tmp_path / "nowhere" / "mine.toml"), "no folder"),
            (str(other), "is there already"),
        ):
            with user:
                typed.value = text
            user.find(content="Save", kind=ui.button).click()
            await until(lambda: problem in str(typed.error))  # noqa: B023
        assert other.read_text() == "precious"
        user.find(ui.checkbox).click()
        user.find(content="Save", kind=ui.button).click()
        await until(lambda: session.now.path == other)
        assert "0.05" in other.read_text()
        session.set("damping.modal", 0.06, released=True)
        user.find("save").click()
        await until(lambda: "0.06" in other.read_text())

    visit(save_buttons, talk)
    assert not file.exists()


def test_a_file_that_has_changed_on_disk_is_not_lost(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(drive_text("ren2021"))
    theirs = drive_text("ren2021").replace("750 kg", "751 kg")

    async def talk(user: User, session: FakeSession) -> None:
        session.set("damping.modal", 0.05, released=True)
        file.write_text(theirs)
        session.others = True
        (timer,) = (one for one in user._client.elements.values() if isinstance(one, ui.timer))
        assert timer.callback is not None
        with user:
            await timer.callback()
            await timer.callback()
        assert sum("has changed on disk" in text for text in user.notify.messages) == 1
        user.find("save").click()
        await seen(user, "Read the file again")
        assert file.read_text() == theirs
        user.find("Read the file again").click()
        await until(lambda: "751 kg" in session.now.base)
        assert file.read_text() == theirs
        session.undo()  # brings mine back
        user.find("save").click()
        await seen(user, "Overwrite the file")
        user.find("Overwrite the file").click()
        await until(lambda: "0.05" in file.read_text())

    visit(save_buttons, talk, FakeSession(opened(file)))


# compare --------------------------------------------------------------------------------------------------------------


def test_a_comparison_names_what_differs_and_swaps() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        user.find("Pin A").click()
        session.set("stages.main.sun.support.radial", "0", released=True)
        user.find("Compare").click()
        await seen(user, "A = lin1999-n3, pinned; B = lin1999-n3, present")
        (table,) = user.find(ui.table).elements
        texts = [" ".join(map(str, row.values())) for row in table.rows]
        assert any("sun.support" in text for text in texts)
        assert any("Hz" in text and "%" in text for text in texts)
        user.find("Swap A and B").click()
        await until(lambda: not session.now.overrides)
        assert session.pinned is not None
        assert session.pinned.overrides == {"stages.main.sun.support.radial": "0"}
        user.find("Unpin A").click()
        assert session.pinned is None
        await user.should_see("Pin A")

    visit(compare_controls, talk, FakeSession(opened("lin1999-n3")))


def test_the_comparison_is_that_of_the_command() -> None:
    first = opened("lin1999-n3")
    second = with_value(first, "damping.modal", 0.05)
    found = compared_states(request_of(first), request_of(second), ("one", "two"))
    assert found["lead"] == "A = one, pinned; B = two, present"
    paths = [row[1] for row in found["rows"] if row[0] == "drawing"]
    assert paths == ["damping.modal"]


# take away ------------------------------------------------------------------------------------------------------------


def test_the_model_and_results_are_downloaded() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        session.set("damping.modal", 0.05, released=True)
        user.find("Take away").click()
        user.find("Model file (.toml)").click()
        (response,) = [await user.download.next(timeout=10)]
        assert "0.05" in response.text
        user.find(".nc").click()
        response = await user.download.next(timeout=10)
        assert response.text == "nc of sharing"
        await user.should_see("epicyclic report ren2021 --set damping.modal=0.05")
        await user.should_see("import epicyclic")

    visit(take_away_button, talk)


def test_what_a_job_has_found_is_downloaded_while_its_state_stands(tmp_path: Path) -> None:
    result = epicyclic.stiffness("ren2021", samples=16)
    place = epicyclic.save_result(result, tmp_path / "job.nc")
    jobs = [
        Job(id=1, name="stiffness", label="Stiffness and phases", rev=1, status="done", dataset_path=place),
        Job(id=2, name="relief", label="Relief", rev=0, status="done", dataset_path=place),
        Job(id=3, name="transient", label="Transient", rev=1, status="failed"),
    ]
    assert list(jobs_done(jobs, 1)) == ["stiffness"]

    async def talk(user: User, session: FakeSession) -> None:
        session.jobs.visible = lambda: jobs
        user.find("Take away").click()
        # that of the results: the command line has a choice of jobs too
        choice = next(one for one in user.find(ui.select).elements if one.props.get("label") == "of")
        choice.set_value("job stiffness")
        for kind in ("nc", "csv", "xlsx"):
            user.find(kind=ui.button, content=f".{kind}").click()
            response = await user.download.next(timeout=10)
            taken = tmp_path / f"taken.{kind}"
            taken.write_bytes(response.content)
            if kind == "nc":
                assert epicyclic.load_result(taken).equals(result)
        assert "mesh_stiffness" in taken.with_suffix(".csv").read_text("utf-8")
        assert taken.read_bytes()[:2] == b"PK"
        assert not place.with_suffix(".xlsx").exists()

    visit(take_away_button, talk)


def test_the_report_is_a_job_that_can_be_cancelled(tmp_path: Path) -> None:
    file = tmp_path / "report.html"
    file.write_text("<html>the report</html>")

    async def talk(user: User, session: FakeSession) -> None:
        user.find("Take away").click()
        user.find("HTML report").click()
        await user.should_see("25 %, about 9 s left")
        user.find("Cancel").click()
        assert session.job.asked_to_end
        session.job.status = "cancelled"
        session.tell("jobs")
        await user.should_see("cancelled")
        session.job.status = "runs"
        user.find("HTML report").click()
        session.job.status, session.job.dataset_path = "done", file
        session.tell("jobs")
        response = await user.download.next(timeout=10)
        assert "the report" in response.text

    visit(take_away_button, talk)


def test_figures_are_those_of_the_report() -> None:
    assert set(figures()) <= set(VERBS) <= set(verbs())
    figure = figure_of(request_of(opened("ren2021")), "sharing", "sharing")
    assert figure["data"]
    with pytest.raises(ModelError):
        figure_of(request_of(opened("ren2021")), "sharing", "no such figure")


def test_a_picture_is_read_from_its_uri() -> None:
    assert bytes_of_picture("data:image/png;base64,aGVsbG8=") == b"hello"
    assert bytes_of_picture("data:image/svg+xml,%3Csvg%3E") == b"<svg>"


def test_names_of_downloads_are_clean() -> None:
    assert safe_name("../../etc/passwd", ".nc") == "etc-passwd.nc"
    assert safe_name(HOSTILE, ".nc").isascii()
    assert safe_name("...", ".toml") == "model.toml"
    assert len(safe_name("x" * 500, ".nc")) < 110


def test_a_link_reopens_the_state() -> None:
    links: list[str] = []

    async def talk(user: User, session: FakeSession) -> None:
        def copied(match: re.Match[str]) -> list[object]:
            links.append(match[1])
            return [len(match[1]), True]

        user.javascript_rules[re.compile(r"(?s).*/#\" \+ '(.*?)'.*")] = copied
        session.set("damping.modal", 0.05, released=True)
        user.find("link").click()
        await until(lambda: user.notify.messages)
        assert "Link copied" in " ".join(map(str, user.notify.messages))

    session = visit(link_button, talk)
    again = from_fragment(links[0])
    assert again.overrides == session.now.overrides
    assert again.path is None


# hostile models -------------------------------------------------------------------------------------------------------


def hostile() -> PageState:
    text = drive_text("ren2021").replace("Herringbone planetary train", HOSTILE.strip().replace('"', '\\"'))
    return from_text(HOSTILE, text)


def test_a_hostile_title_stays_text() -> None:
    """No element that takes markup holds a text of the model."""

    def build(session: FakeSession) -> None:
        for control in (open_button, save_buttons, undo_buttons, compare_controls, take_away_button):
            control(session)  # type: ignore[arg-type]
        FieldsPanel(session)  # type: ignore[arg-type]
        TextPanel(session)  # type: ignore[arg-type]

    async def talk(user: User, session: FakeSession) -> None:
        session.set("title", HOSTILE, released=True)
        session.pin()
        for words in ("Open", "Take away", "Compare", "save_as"):
            user.find(words).click()
        await asyncio.sleep(0.6)
        for element in user._client.elements.values():
            assert not isinstance(element, ui.html | ui.markdown | ui.code)
            assert "onerror" not in str(element.props.get("innerHTML", ""))

    visit(build, talk, FakeSession(hostile()))
