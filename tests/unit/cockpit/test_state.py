"""States of a page: text in step with overrides, links, uploads, history, replay."""

from __future__ import annotations

import base64
import json
import shlex
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import epicyclic
from epicyclic.cockpit.state.history import StateHistory, Step
from epicyclic.cockpit.state.links import fragment_of, from_fragment
from epicyclic.cockpit.state.replay import command_line, script, setting
from epicyclic.cockpit.state.state import PageState, from_text, opened, request_of, uploaded, with_text, with_value
from epicyclic.cockpit.state.written_text import text_of, value_at
from epicyclic.errors import ModelError
from epicyclic.model.document import parse_text, read, ready_drives
from epicyclic.model.overrides import parse_setting

CHANGES: dict[str, dict[str, object]] = {
    "ren2021": {"stages.main.sun.support.radial": "5e8 N/m", "deviations.sun.run_out": "30 um", "damping.modal": 0.02},
    "wind-stage": {"stages.main.sun.teeth": 23, "deviations.main.sun.run_out": "4 um"},
}


def same_train(state: PageState) -> None:
    text = text_of(state)
    tables, overrides = request_of(state)
    assert read(parse_text(text, "text")).data == read(tables, overrides).data


@pytest.mark.parametrize("drive", ready_drives())
def test_text_of_every_drive_with_another_damping(drive: str) -> None:
    state = with_value(opened(drive), "damping", {"modal": 0.0123})
    same_train(state)
    assert "0.0123" in text_of(state)


@pytest.mark.parametrize("drive", ["ren2021", "wind-stage"])
def test_text_keeps_comments(drive: str) -> None:
    state = opened(drive)
    for path, value in CHANGES[drive].items():
        state = with_value(state, path, value)
    same_train(state)
    comments = [line.partition("#")[2] for line in state.base.splitlines() if "#" in line]
    kept = text_of(state)
    assert comments
    lost = [one for one in comments if one not in kept]
    assert len(lost) <= 1, lost  # that of a reason for an assumed value that is set now


def test_the_value_of_the_file_is_no_override() -> None:
    state = with_value(opened("ren2021"), "stages.main.module", "30 mm")
    assert dict(state.overrides) == {"stages.main.module": "30 mm"}
    assert value_at(state, "stages.main.module") == "30 mm"
    assert with_value(state, "stages.main.module", "32 mm") == opened("ren2021")


@settings(max_examples=25, deadline=None)
@given(
    values=st.dictionaries(
        st.sampled_from(
            ["deviations.sun.run_out", "stages.main.sun.mass", "stages.main.helix_angle", "operation.speed.sun"]
        ),
        st.integers(1, 40),
        max_size=4,
    )
)
def test_text_and_link_give_the_same_document(values: dict[str, int]) -> None:
    units = {"run_out": "um", "mass": "kg", "helix_angle": "deg", "sun": "rpm"}
    state = opened("ren2021")
    for path, value in values.items():
        state = with_value(state, path, f"{value} {units[path.rsplit('.', 1)[1]]}")
    same_train(state)
    again = from_fragment("#" + fragment_of(state))
    assert request_of(again) == request_of(state)


def test_a_link_holds_no_path(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(opened("ren2021").base, encoding="utf-8")
    again = from_fragment(fragment_of(opened(file)))
    assert again.path is None
    assert not again.trusted
    assert request_of(again) == request_of(opened(file))


HOSTILE = [
    "",
    "state=",
    "state=%%%",
    "state=" + "A" * 70_000,
    "state=" + base64.urlsafe_b64encode(b"no zlib").decode(),
    "state=" + base64.urlsafe_b64encode(zlib.compress(b"[1, 2]")).decode(),
    "state=" + base64.urlsafe_b64encode(zlib.compress(b"[" * 100_000)).decode(),
    "state=" + base64.urlsafe_b64encode(zlib.compress(b" " * 30_000_000)).decode(),
    "state=" + base64.urlsafe_b64encode(zlib.compress(b'{"drive": "../../etc/passwd"}')).decode(),
    "state=" + base64.urlsafe_b64encode(zlib.compress(b'{"drive": "ren2021", "overrides": {"a": 1}}')).decode(),
]


@pytest.mark.parametrize("fragment", HOSTILE)
def test_hostile_links_are_refused(fragment: str) -> None:
    with pytest.raises(ModelError):
        from_fragment(fragment)


def link_of(content: dict[str, object]) -> str:
    return "state=" + base64.urlsafe_b64encode(zlib.compress(json.dumps(content).encode())).decode()


NAMING = '[deviations]\nsun.pitch = "/etc/passwd"\n'
FORCE = 'planets = 3\n[stages.main.sun]\nteeth = 23\nsupport.radial = { file = "/etc/passwd" }\n'


def test_models_of_others_name_no_files() -> None:
    base = opened("ren2021").base.replace("[deviations]\n", NAMING)
    assert "/etc/passwd" in base
    with pytest.raises(ModelError, match=r"deviations\.sun\.pitch"):
        uploaded("x.toml", base.encode())
    with pytest.raises(ModelError, match=r"deviations\.sun\.pitch"):
        from_fragment(link_of({"name": "x", "base": base}))
    with pytest.raises(ModelError, match="names a file"):
        from_fragment(link_of({"drive": "ren2021", "overrides": [["deviations.sun.pitch", "/etc/passwd"]]}))
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.support\.radial\.file"):
        from_text("x", "format = 2\n[stages.main]\n" + FORCE)
    with pytest.raises(ModelError, match="names a file"):
        with_text(opened("ren2021"), base)


def test_a_file_of_this_machine_may_name_files(tmp_path: Path) -> None:
    (tmp_path / "pitch.csv").write_text("pitch [um]\n" + "1\n" * 23, encoding="utf-8")
    text = opened("ren2021").base.replace("[deviations]\n", '[deviations]\nsun.pitch = "pitch.csv"\n')
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    tables, overrides = request_of(opened(tmp_path / "own.toml"))
    assert epicyclic.load(tables, overrides=overrides) is not None


@pytest.mark.parametrize("content", [b"", b"\0\1", b"\xff\xfe", b"x" * 5_000_000, b"= no toml", b"[a]\n[a]\n"])
def test_wrong_uploads_are_refused(content: bytes) -> None:
    with pytest.raises(ModelError):
        uploaded("../../x.toml", content)


def test_names_are_no_paths() -> None:
    base = opened("ren2021").base.encode()
    assert uploaded("../../etc/x.toml", base).name == "x.toml"
    assert uploaded("C:\\a\\x.toml", base).name == "x.toml"
    assert uploaded("a\nb\x1b[31m.toml", base).name == "ab[31m.toml"


def test_undo_and_redo_with_a_drag_as_one_step() -> None:
    first = opened("ren2021")
    history = StateHistory(now=Step(state=first))
    for um in range(5):
        history = history.push(with_value(first, "deviations.sun.run_out", f"{um} um"), "run-out", "drag 1")
    dragged = history.present
    assert dragged is not None
    history = history.closed().push(with_value(dragged, "damping.modal", 0.02), "damping")
    assert (len(history.behind), history.undo_label) == (2, "damping")
    assert history.undo().present == dragged
    back = history.undo().undo()
    assert back.present == first
    assert (back.undo_label, back.redo_label) == ("", "run-out")
    assert back.redo().redo().present == history.present
    assert back.push(dragged, "other").redo().present == dragged


@pytest.mark.parametrize(
    "value", ["750 kg", "5", "true", 'it\'s "x"', 3, 0.25, True, [1, 2], ["1 um", "2 um"], "[1, 2] um", None]
)
def test_settings_read_back(value: object) -> None:
    assert parse_setting(setting("a.b", value)) == ("a.b", value)


def test_command_and_script_replay_the_state(tmp_path: Path) -> None:
    state = opened("lin1999-n4")
    state = with_value(state, "stages.main.sun.mass", "0.5 kg")
    words = shlex.split(command_line(state, "modes"))
    assert words[:3] == ["epicyclic", "modes", "lin1999-n4"]
    told = subprocess.run(
        [sys.executable, "-m", *words, "--json"], capture_output=True, text=True, check=True, cwd=tmp_path
    ).stdout
    expected = epicyclic.modes("lin1999-n4", overrides=dict(state.overrides)).frequency.to_numpy()
    found = json.loads(told)["data_vars"]["frequency"]["data"]
    assert found == pytest.approx(list(expected), rel=1e-12)
    wished = {"overrides": {"stages.main.sun.mass": "0.5 kg"}}
    assert str(wished["overrides"]) in script(state)
