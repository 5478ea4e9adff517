"""States of a page: text in step with overrides, links, uploads, history, replay."""

from __future__ import annotations

import base64
import json
import re
import runpy
import shlex
import tomllib
import zlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.cockpit.state.model_file import text_of, written_value
from epicyclic.cockpit.state.state import (
    PageState,
    StateHistory,
    Step,
    at_speed,
    command_line,
    download_needed,
    fragment_of,
    from_fragment,
    from_text,
    opened,
    request_of,
    script,
    setting,
    tables_of,
    uploaded,
    with_text,
    with_value,
)
from epicyclic.document.document import parse_text, read, ready_drives
from epicyclic.document.overrides import parse_setting
from epicyclic.document.tables import leaves
from epicyclic.errors import ModelError

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


def changed(value: object) -> object:
    """Another value of the same form; None where there is none near."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return value + 1 if isinstance(value, int) else value * 1.01
    if isinstance(value, str):
        other = re.sub(r"\d+(\.\d+)?", lambda found: f"{float(found[0]) * 1.01:.6g}", value, count=1)
        return other if other != value else None
    return None


def paths_of(state: PageState) -> list[str]:
    """Paths of everything in a model, as its text spells them and as the document does."""
    document = read(*request_of(state)).data
    return [path for table in (tables_of(state.base), document) for path, _ in leaves(table)]


# every third path of three drives: a minute for all 1085 of all drives, of which each keeps its comments
@pytest.mark.parametrize("drive", ["wind-stage", "xu2020", "encased-differential"])
def test_every_value_can_be_changed_in_the_text(drive: str) -> None:
    state, tried = opened(drive), 0
    for path in paths_of(state)[::3]:
        value = changed(written_value(state, path))
        if value is None or path.startswith(("format", "assumed")):
            continue
        other = with_value(state, path, value)
        try:
            aim = read(*request_of(other)).data
        except ModelError:
            continue
        tried += 1
        text = text_of(other)
        assert read(parse_text(text, "text")).data == aim, path
        assert "written anew" not in text, path
    assert tried > 10


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_any_values_can_be_changed_together(data: st.DataObject) -> None:
    state = opened(data.draw(st.sampled_from(["ren2021", "lin1999-n4", "wind-stage"])))
    for path in data.draw(st.lists(st.sampled_from(paths_of(state)), max_size=4)):
        value = data.draw(st.sampled_from([None, changed(written_value(state, path))]))
        state = with_value(state, path, value)
    try:
        aim = read(*request_of(state)).data
    except ModelError:
        text_of(state)  # what is wrong can be saved and mended
        return
    assert read(parse_text(text_of(state), "text")).data == aim
    assert read(*request_of(from_fragment(fragment_of(state)))).data == aim


def test_masses_that_follow_the_teeth_are_saved() -> None:
    state = with_value(opened("ren2021"), "stages.main.sun.teeth", 27)
    state = with_value(with_value(state, "stages.main.planet.teeth", 37), "stages.main.ring.teeth", 101)
    followed = read(*request_of(state)).data["stages"]["main"]["sun"]
    before = read(*request_of(opened("ren2021"))).data["stages"]["main"]["sun"]
    assert followed["mass"] != before["mass"]
    same_train(state)
    assert read(parse_text(text_of(state), "text")).data["stages"]["main"]["sun"]["mass"] == followed["mass"]


def test_one_place_has_one_override_however_it_is_spelled() -> None:
    state = with_value(opened("ren2021"), "deviations.sun.run_out", "30 um")
    state = with_value(state, "deviations.main.sun.run_out", "40 um")
    assert dict(state.overrides) == {"deviations.main.sun.run_out": "40 um"}
    same_train(state)
    state = with_value(opened("lin1999-n4"), "damping", {"modal": 0.02})
    state = with_value(state, "damping.modal", 0.03)
    assert written_value(state, "damping.modal") == 0.03
    same_train(state)
    assert written_value(with_value(state, "damping", None), "damping.modal") is None
    state = with_value(with_value(opened("ren2021"), "deviations", None), "deviations.sun.run_out", "7 um")
    assert read(*request_of(state)).data["deviations"] == {"main": {"sun": {"run_out": {"amplitude": "7 um"}}}}
    same_train(state)


def test_a_table_added_below_dotted_keys_keeps_comments() -> None:
    state = with_value(opened("ren2021"), "deviations.planet.position.y", "[5, 0, 0] um")
    same_train(state)
    assert text_of(state).count("#") == state.base.count("#")


def test_the_value_of_the_file_is_no_override() -> None:
    state = with_value(opened("ren2021"), "stages.main.module", "30 mm")
    assert dict(state.overrides) == {"stages.main.module": "30 mm"}
    assert written_value(state, "stages.main.module") == "30 mm"
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


RIPPLES = {
    "operation.ripple.sun": '[operation.ripple]\nsun = [{ file = "/etc/passwd" }]\n',
    "operation.ripple.sun.a": '[operation.ripple.sun.a]\nfile = "/etc/passwd"\n',
    "cases.c.ripple.sun": '[[cases.c.ripple.sun]]\nfile = "/etc/passwd"\n',
}


@pytest.mark.parametrize("path", RIPPLES)
def test_models_of_others_name_no_files_of_ripple(path: str) -> None:
    base = opened("ren2021").base + RIPPLES[path]
    with pytest.raises(ModelError, match=rf"{re.escape(path)}.*names a file"):
        uploaded("x.toml", base.encode())
    value = tomllib.loads(RIPPLES[path])
    for key in path.split("."):
        value = value[key]
    with pytest.raises(ModelError, match="names a file"):
        from_fragment(link_of({"drive": "ren2021", "overrides": [[path, value]]}))


def test_a_file_of_this_machine_may_name_a_file_of_ripple(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "torque.csv").write_text("angle [deg], torque [N m]\n0, 5\n120, -5\n240, 0\n", encoding="utf-8")
    text = opened("ren2021").base + '[[operation.ripple.sun]]\nfile = "torque.csv"\n'
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir("/")
    made = epicyclic.load(*request_of(opened(tmp_path / "own.toml")))
    assert made.ripples
    assert made.ripples == epicyclic.load(tmp_path / "own.toml").ripples


def test_a_file_of_this_machine_may_name_files(tmp_path: Path) -> None:
    (tmp_path / "pitch.csv").write_text("pitch [um]\n" + "1\n" * 23, encoding="utf-8")
    text = opened("ren2021").base.replace("[deviations]\n", '[deviations]\nsun.pitch = "pitch.csv"\n')
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    state = opened(tmp_path / "own.toml")
    tables, overrides = request_of(state)
    assert epicyclic.load(tables, overrides=overrides) is not None
    state = with_value(state, "damping.modal", 0.0123)
    assert 'sun.pitch = "pitch.csv"' in text_of(state, tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    (other / "own.toml").write_text(text_of(state, other), encoding="utf-8")
    moved = opened(other / "own.toml")
    assert "0.0123" in moved.base
    assert str(tmp_path / "pitch.csv") in moved.base
    assert epicyclic.load(*request_of(moved)) is not None


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


def test_command_and_script_replay_the_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    state = opened("lin1999-n4")
    state = with_value(state, "stages.main.sun.mass", "0.5 kg")
    words = shlex.split(command_line(state, "modes"))
    assert words[:3] == ["epicyclic", "modes", "lin1999-n4"]
    told = CliRunner().invoke(app, [*words[1:], "--json"]).stdout
    expected = epicyclic.modes("lin1999-n4", overrides=dict(state.overrides)).frequency.to_numpy()
    found = json.loads(told)["data_vars"]["frequency"]["data"]
    assert found == pytest.approx(list(expected), rel=1e-12)
    (tmp_path / "page.py").write_text(script(state), encoding="utf-8")
    runpy.run_path("page.py", run_name="__main__")
    told = capsys.readouterr().out
    assert f"{expected[-1]:.6f}"[:8] in told
    assert "no sweep: damping: no damping is given" in told
    assert epicyclic.load_result(tmp_path / "modes.nc").frequency.to_numpy() == pytest.approx(list(expected))


def test_what_lies_in_no_file_is_said_to_need_one(tmp_path: Path) -> None:
    linked = from_fragment(link_of({"name": "a b; rm -rf.toml", "base": opened("ren2021").base}))
    assert download_needed(linked)
    assert shlex.split(command_line(linked))[2] == "a-b--rm--rf.toml"
    assert script(linked).startswith("# download the model as a-b--rm--rf.toml")
    file = tmp_path / "own.toml"
    file.write_text(linked.base, encoding="utf-8")
    own = opened(file)
    assert not download_needed(own)
    edited = with_text(own, own.base + "# mine\n")
    assert download_needed(edited)
    assert shlex.split(command_line(edited))[2] == "own.toml"


def test_the_speed_that_is_shown_goes_into_the_link() -> None:
    state = at_speed(opened("ren2021"), 1.25)
    assert from_fragment(fragment_of(state)) == state
    for speed in ("fast", True, [1]):
        with pytest.raises(ModelError, match="speed"):
            from_fragment(link_of({"drive": "ren2021", "speed": speed}))
