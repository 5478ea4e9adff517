"""The writer of commented model files: what is read back, units of a drawing, comments that cannot break out."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any

import pytest

from epicyclic.document.document import read, ready_drives
from epicyclic.document.writer import commented_text

PAIR: dict[str, Any] = {
    "format": 2,
    "title": "A pair",
    "damping": {"modal": 0.03},
    "stages": {
        "main": {
            "planets": 3,
            "module": 0.004,
            "helix_angle": "15 deg",
            "sun": {"teeth": 24, "support": {"radial": 5e7}},
            "planet": {"teeth": 30, "bearing": {"radial": "4e8 N/m"}},
            "ring": {"teeth": 84, "rim": 0.025},
            "carrier": {"mass": 40.0, "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": 157.07963267948966}, "torque": {"sun": 800.0}},
    "deviations": {"planet": {"run_out": 15e-6, "position": {"y": [20e-6, 0.0, 0.0]}}},
}


@pytest.mark.parametrize("drive", ready_drives())
def test_every_ready_drive_is_read_back_the_same(drive: str) -> None:
    raw = tomllib.loads(resources.files("epicyclic.systems").joinpath(f"{drive}.toml").read_text(encoding="utf-8"))
    again = tomllib.loads(commented_text(raw))
    assert again == raw
    assert list(again) == sorted(again, key=list(again).index)
    assert read(again).model == read(raw).model


def test_numbers_in_si_get_the_units_of_a_drawing_and_the_spelling_stays() -> None:
    text = commented_text(PAIR)
    for line in ('module      = "4 mm"', 'support.radial = "5e7 N/m"', 'speed.sun  = "1500 rpm"', "[deviations]"):
        assert line in text, text
    assert 'planet.run_out    = "15 um"' in text
    assert 'planet.position.y = "[20, 0, 0] um"' in text
    assert read(tomllib.loads(text)).model == read(PAIR).model


def test_comments_stand_behind_above_or_at_the_next_table() -> None:
    comments = {
        "stages.main.module": "normal module",
        "stages.main.sun": "the input",
        "operation.speed": "of the motor",
        "stages.main.planet.teeth": "x" * 30 + " " + "y" * 70,
        "stages.main.nowhere": "lost?",
    }
    document = {**PAIR, "assumed": {"damping.modal": "usual"}}
    text = commented_text(document, head=["Head line"], comments=comments)
    lines = text.splitlines()
    assert lines[0] == "# Head line"
    assert '"4 mm"' in next(line for line in lines if line.endswith("# normal module"))
    assert "[stages.main.sun]  # the input" in lines
    assert next(line for line in lines if "# of the motor" in line).startswith("speed.sun")
    assert lines[lines.index("# " + comments["stages.main.planet.teeth"]) + 1] == "teeth          = 30"
    assert "[stages.main]  # nowhere: lost?" in lines
    assert lines[-2:] == ["[assumed]", '"damping.modal" = "usual"']
    assert all(len(line) <= 120 for line in lines)


def test_no_text_of_a_stranger_becomes_a_key() -> None:
    evil = 'a"\nmodule = "1 m"\r\n\u2028x\x00\x1b[31m'
    text = commented_text({**PAIR, "title": 'quote " and \\ back'}, head=[evil], comments={"stages.main.module": evil})
    assert tomllib.loads(text)["title"] == 'quote " and \\ back'
    assert read(tomllib.loads(text)).model.stages == read(PAIR).model.stages
    assert "\x1b" not in text
    notes = 'first\nC:\\new\\\\n """ and\r\nlast\\'
    assert tomllib.loads(commented_text({**PAIR, "notes": notes}))["notes"] == notes


def test_tables_of_tables_with_headings_and_braces() -> None:
    cost = {"deviations.planet.run_out": {f"grade(ISO 1328-1:2013 {n}, 3 sigma)": 100.0 * n for n in (4, 5, 6, 7)}}
    tolerance = {
        "deviations.planet.run_out": "rayleigh(5 um)",
        "deviations.planet.position": {"own": "disc(40 um)", "common": "disc(10 um)"},
        "cost": cost,
    }
    couplings = {"shaft": {"between": ["sun", "out"], "rz": "1e6 N m/rad", "damping": {"rz": "10 N m s/rad"}}}
    document = {**PAIR, "bodies": {"out": {"inertia": "1 kg m^2"}}, "couplings": couplings, "tolerance": tolerance}
    text = commented_text(document)
    assert '"deviations.planet.position" = { own = "disc(40 um)", common = "disc(10 um)" }' in text
    assert '[tolerance.cost."deviations.planet.run_out"]' in text
    assert read(tomllib.loads(text)).model == read(document).model
