"""Numbers without a unit: refused in a file and on the command line, SI in tables built in Python."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from epicyclic.document.document import Document, read, ready_drives
from epicyclic.document.overrides import parse_setting
from epicyclic.errors import ModelError

TEXT = """
format = 2
title  = "a planetary set"
damping.modal = 0.03
[stages.main]
planets        = 3
module         = "4 mm"
face_width     = "40 mm"
pressure_angle = "20 deg"
sun     = { teeth = 24, profile_shift = 0.1, support.radial = "1e8 N/m", support.z = 0 }
planet  = { teeth = 30, bearing.radial = inf }
ring    = { teeth = 84, rim = "25 mm", support.rz = "1e8 N m/rad" }
carrier = { mass = "40 kg", inertia = "0.5 kg m^2" }
[operation]
held = ["ring"]
speed.sun = "1500 rpm"
torque.sun = "800 N m"
gravity = true
[deviations]
planet.run_out = "15 um"
planet.position.y = "[20, 0, 0] um"
sun.pitch = "{pitch}"
""".replace("{pitch}", f"[{', '.join(map(str, range(24)))}] um")

# what stands in the file, the number in its place, its path, the likely unit, its value in SI
BARE = [
    ('module         = "4 mm"', "module = 10", "stages.main.module", "10 mm", "10 m"),
    ('module         = "4 mm"', "module = 0.004", "stages.main.module", "0.004 m", "0.004 m"),
    ('"40 mm"', "230", "stages.main.face_width", "230 mm", "230 m"),
    ('"20 deg"', "0.35", "stages.main.pressure_angle", "0.35 rad", "0.35 rad"),
    ('radial = "1e8 N/m"', "radial = 500", "stages.main.sun.support.radial", "500 N/um", "500 N/m"),
    ('radial = "1e8 N/m"', "radial = 1e8", "stages.main.sun.support.radial", "1e8 N/m", "1e8 N/m"),
    ('rz = "1e8 N m/rad"', "rz = 1e8", "stages.main.ring.support.rz", "1e8 N m/rad", "1e8 N m/rad"),
    ('"40 kg"', "40", "stages.main.carrier.mass", "40 kg", "40 kg"),
    ('"0.5 kg m^2"', "0.5", "stages.main.carrier.inertia", "0.5 kg m^2", "0.5 kg m^2"),
    ('"1500 rpm"', "1500", "operation.speed.sun", "1500 rpm", "1500 rad/s"),
    ('"800 N m"', "800", "operation.torque.sun", "800 N m", "800 N m"),
    ('"15 um"', "15", "deviations.planet.run_out", "15 um", "15 m"),
    ('"15 um"', "2e-5", "deviations.planet.run_out", "2e-5 m", "2e-5 m"),
    ('"[20, 0, 0] um"', "[2e-5, 0, 0]", "deviations.planet.position.y", "[2e-5, 0, 0] m", "[2e-5, 0, 0] m"),
    ('"[20, 0, 0] um"', '"[20, 0, 0]"', "deviations.planet.position.y", "[20, 0, 0] um", "[20, 0, 0] m"),
    ('"[20, 0, 0] um"', '["20 um", 0, 3e-5]', "deviations.planet.position.y", "3e-5 m", "3e-5 m"),
    ("gravity = true", "gravity = [0, -9.81, 0]", "operation.gravity", "[0, -9.81, 0] m/s^2", "[0, -9.81, 0] m/s^2"),
]


def written(folder: Path, text: str, name: str = "model.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def changed(stands: str, number: str) -> str:
    assert TEXT.count(stands) == 1
    before = stands.partition("=")[0] + "= " if "=" in stands and "=" not in number else ""
    return TEXT.replace(stands, before + number)


@pytest.mark.parametrize(("stands", "number", "path", "likely", "si"), BARE)
def test_a_number_without_a_unit(tmp_path: Path, stands: str, number: str, path: str, likely: str, si: str) -> None:
    text = changed(stands, number)
    with pytest.raises(ModelError) as error:
        read(written(tmp_path, text))
    assert error.value.path == path
    assert f'a number without a unit: "{likely}"?' in str(error.value)
    # in tables built in Python it is SI: as of the text with the SI unit
    if "[" not in number:
        stated = changed(stands, f'"{si}"' if "=" not in number else f'{number.partition("=")[0]}= "{si}"')
        assert read(tomllib.loads(text)).model == read(written(tmp_path, stated)).model


def test_tables_built_in_python_are_si_without_a_word() -> None:
    for stands, number, *_ in BARE:
        data = tomllib.loads(changed(stands, number))
        assert read(data).warnings == ()
        assert read(data, {"stages.main.sun.mass": 40.0}).warnings == ()
    assert read("ren2021", {"stages.main.sun.mass": 750.0}).model == read("ren2021").model


def test_a_file_with_units_says_nothing(tmp_path: Path) -> None:
    assert read(written(tmp_path, TEXT)).warnings == ()
    for name in ready_drives():
        document = read(name)
        assert document.model.format == 2
        assert document.warnings == ()


def test_all_are_named_at_once(tmp_path: Path) -> None:
    text = TEXT.replace('"40 kg"', "40").replace('"4 mm"', "4").replace('"20 deg"', "20").replace('"15 um"', "15")
    with pytest.raises(ModelError) as error:
        read(written(tmp_path, text))
    assert error.value.path == "stages.main.module"
    assert "(and 3 more, at stages.main.pressure_angle, stages.main.carrier.mass, deviations.planet.run_out)" in str(
        error.value
    )


def test_a_bare_number_comes_before_its_range(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r'pressure_angle = 20: a number without a unit: "20 deg"\?'):
        read(written(tmp_path, changed('"20 deg"', "20")))
    with pytest.raises(ModelError, match="pressure_angle = 20: out of range"):
        read(tomllib.loads(changed('"20 deg"', "20")))


def set_on_the_command_line(source: str | Path, *settings: str) -> Document:
    return read(source, dict(parse_setting(text) for text in settings))


@pytest.mark.parametrize(
    ("setting", "likely"),
    [
        ("stages.main.sun.module=10", "10 mm"),
        ("stages.main.sun.support.radial=1e9", "1e9 N/m"),
        ("stages.main.planet.bearing={ radial = 500 }", "500 N/um"),
        ("operation.torque.sun=100", "100 N m"),
        ("deviations.planet.run_out=[20, 0, 0]", "[20, 0, 0] um"),
    ],
)
def test_a_setting_states_its_unit(setting: str, likely: str) -> None:
    with pytest.raises(ModelError) as error:
        set_on_the_command_line("ren2021", setting)
    assert f'a number without a unit: "{likely}"?' in str(error.value)
    assert str(error.value).startswith(setting.partition("=")[0])


@pytest.mark.parametrize(
    "setting",
    [
        "stages.main.sun.support.radial=0",
        "stages.main.sun.support.radial=inf",
        "stages.main.sun.teeth=24",
        "stages.main.sun.profile_shift=0.2",
        "damping.modal=0.02",
        'stages.main.sun.mass="700 kg"',
        "stages.main.sun.mass=700 kg",
        "deviations.planet.run_out=[0, 0, 0]",
        "deviations.planet.run_out=",
    ],
)
def test_settings_that_need_no_unit(tmp_path: Path, setting: str) -> None:
    assert set_on_the_command_line(written(tmp_path, TEXT), setting).warnings == ()


def test_what_a_setting_replaces_is_not_told(tmp_path: Path) -> None:
    path = written(tmp_path, changed('"40 kg"', "40"))
    assert set_on_the_command_line(path, 'stages.main.carrier.mass="41 kg"').warnings == ()
    assert read(path, {"stages.main.carrier.mass": 41.0}).warnings == ()  # of Python, in place of what the file says
    with pytest.raises(ModelError, match=r"carrier\.mass"):
        set_on_the_command_line(path, 'stages.main.sun.mass="41 kg"')


def test_pitch_deviations_take_units(tmp_path: Path) -> None:
    of_text = read(written(tmp_path, TEXT)).model.deviations.members["main.sun"].pitch
    (tmp_path / "pitch.csv").write_text("pitch [um]\n" + "\n".join(map(str, range(24))), encoding="utf-8")
    start = TEXT.index("sun.pitch")
    of_file = read(written(tmp_path, TEXT[:start] + 'sun.pitch = "pitch.csv"\n')).model.deviations.members["main.sun"]
    numbers = ", ".join(f'"{i} um"' for i in range(24))
    of_list = read(written(tmp_path, TEXT[:start] + f"sun.pitch = [{numbers}]\n")).model.deviations.members["main.sun"]
    assert of_text == of_list.pitch
    assert of_file.pitch is not None
    assert of_text is not None
    assert of_file.pitch == of_text
    with pytest.raises(ModelError, match=r"sun.pitch = .*without a unit"):
        read(written(tmp_path, TEXT[:start] + f"sun.pitch = [{', '.join(map(str, range(24)))}]\n"))


@pytest.mark.parametrize(
    ("setting", "likely"),
    [
        ("stages.main.planet_angles='[0, 2, 4]'", "[0, 2, 4] deg"),
        ("stages.main.planet.bearing={radial='[4e8, 4e8, 4e5]'}", "[4e8, 4e8, 4e5] N/m"),
    ],
)
def test_a_list_in_quotes_on_the_command_line_states_its_unit(setting: str, likely: str) -> None:
    with pytest.raises(ModelError) as error:
        set_on_the_command_line("ren2021", setting)
    assert f'a number without a unit: "{likely}"?' in str(error.value)
