"""Shafts that bend in the model file: what is refused, what they are made of, and what else does not see them."""

from __future__ import annotations

import copy
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic import check, life, modes, static, write_rexs
from epicyclic.cockpit.computing.train_view import train_head
from epicyclic.cockpit.state.frames import body_labels, mesh_labels
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError
from epicyclic.show.drawing.painter import train_front, train_section
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load, resolved_document

PAIR = """
format = 2
title = "a pinion shaft"

[stages.main]
module = "4 mm"
face_width = "50 mm"

[stages.main.pinion]
teeth = 24
bore = "60 mm"
shaft_sections = [{ from = "-200 mm", to = "-60 mm", diameter = "50 mm" }, { to = "300 mm", diameter = "60 mm" }]

[stages.main.pinion.support]
front = { at = "-180 mm", radial = "5e8 N/m" }
rear = { at = "120 mm", radial = "5e8 N/m" }

[stages.main.wheel]
teeth = 72
bore = "90 mm"
support.radial = "5e8 N/m"

[operation]
speed.pinion = "1500 rpm"
torque.pinion = "400 N m"
"""
SHAFT = "stages.main.pinion.shaft_sections"


@pytest.fixture(scope="module")
def pair() -> dict[str, Any]:
    return tomllib.loads(PAIR)


@pytest.fixture(scope="module", params=[True, False], ids=["bent", "rigid"])
def shaft(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Overrides with which the shaft of the pinion bends, or not."""
    return {} if request.param else {SHAFT: None}


@pytest.mark.parametrize(
    ("overrides", "path", "problem", "allowed"),
    [
        ({f"{SHAFT}.1.from": None}, f"{SHAFT}.1.from", "is missing", "where the first section begins"),
        ({f"{SHAFT}.2.from": "-80 mm"}, f"{SHAFT}.2.from", "overlaps the section before it", "-60 mm, or nothing"),
        ({f"{SHAFT}.2.from": "-40 mm"}, f"{SHAFT}.2.from", "leaves a gap", "-60 mm, or nothing"),
        ({f"{SHAFT}.1.to": "-210 mm"}, f"{SHAFT}.1.to", "has no length", "more than -200 mm"),
        ({f"{SHAFT}.2.bore": "60 mm"}, f"{SHAFT}.2.bore", "bore not below diameter", "bore < diameter"),
        ({f"{SHAFT}.2.diameter": 0}, f"{SHAFT}.2.diameter", "", "> 0"),
        ({f"{SHAFT}.2.to": "100 mm"}, SHAFT, "does not reach", "reach rear at 120 mm"),
        ({f"{SHAFT}.1.from": "-150 mm"}, SHAFT, "does not reach", "reach front at -180 mm"),
        ({f"{SHAFT}.9.diameter": "60 mm"}, f"{SHAFT}.9.to", "missing", "a section that the list has, counted from 1"),
        ({SHAFT: []}, SHAFT, "no sections", "a list of one section or more"),
        ({f"{SHAFT}.2.length": "20 mm"}, f"{SHAFT}.2.length", "unknown key", ""),
        ({"loads.belt": {"on": "pinion", "at": "310 mm"}}, SHAFT, "does not reach", "load/belt at 310 mm"),
    ],
)
def test_what_is_refused(
    pair: dict[str, Any], overrides: dict[str, Any], path: str, problem: str, allowed: str
) -> None:
    with pytest.raises(ModelError) as caught:
        load(pair, overrides=overrides)
    assert caught.value.path == path
    assert problem in caught.value.problem
    assert allowed in caught.value.allowed


PLANETS: dict[str, Any] = {
    "format": 2,
    "title": "planets",
    "stages": {
        "main": {
            **{"planets": 3, "module": "4 mm", "face_width": "50 mm", "gap": "20 mm"},
            "sun": {"teeth": 24},
            "planet": {"teeth": 30, "bearing": {"front": {"at": "-30 mm"}, "rear": {"at": "30 mm"}}},
            "ring": {"teeth": 84},
            "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
        }
    },
    "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}},
}
ROLLER = {
    **{"type": "cylindrical roller", "elements": 14, "element_diameter": "10 mm", "element_length": "10 mm"},
    **{"pitch_diameter": "60 mm"},
}
SECTION = [{"from": "-40 mm", "to": "40 mm", "diameter": "40 mm"}]


def test_members_without_such_a_shaft() -> None:
    """Halves have a neck; a planet on rolling bearings by their parts turns on a pin that stands in the carrier."""
    halves, pins = copy.deepcopy(PLANETS), copy.deepcopy(PLANETS)
    halves["stages"]["main"]["herringbone"] = True
    halves["stages"]["main"]["sun"] |= {"split": True, "neck": {"diameter": "40 mm"}, "shaft_sections": SECTION}
    with pytest.raises(ModelError) as caught:
        load(halves)
    assert (caught.value.path, caught.value.given) == ("stages.main.sun.shaft_sections", "split")
    planet = pins["stages"]["main"]["planet"]
    planet |= {"shaft_sections": SECTION, "bearing": {"front": {"at": "-30 mm", **ROLLER}, "rear": {"at": "30 mm"}}}
    with pytest.raises(ModelError, match="pin of the carrier") as caught:
        load(pins)
    assert (caught.value.path, caught.value.given) == (
        "stages.main.planet.shaft_sections",
        "main/planet/1/bearing/front",
    )


def test_places_spans_and_masses(pair: dict[str, Any]) -> None:
    """Two supports away from the gear are two bodies; with the gear they have the mass of all, by the lever rule."""
    train, rigid = load(pair), load(pair, overrides={SHAFT: None})
    places = [body for body in train.bodies if body.shaft_of]
    assert [(body.name, body.station, body.member) for body in places] == [
        ("main/pinion/shaft/front", -0.18, "main.pinion"),
        ("main/pinion/shaft/rear", 0.12, "main.pinion"),
    ]
    assert [(span.name, span.start, span.end) for span in train.spans] == [
        ("main/pinion/shaft/front/span", -0.18, 0.0),
        ("main/pinion/shaft/rear/span", 0.0, 0.12),
    ]
    gear = {
        name: next(body for body in one.bodies if body.name == "main/pinion")
        for name, one in (("bent", train), ("rigid", rigid))
    }
    masses = [
        (7850 * np.pi / 4 * d**2 * (b - a), (a + b) / 2, d) for a, b, d in ((-0.2, -0.06, 0.05), (-0.06, 0.3, 0.06))
    ]
    own = {"bent": gear["bent"].mass - gear["rigid"].mass}
    assert own["bent"] + sum(body.mass for body in places) == pytest.approx(sum(m for m, _, _ in masses))
    turned = gear["bent"].inertia - gear["rigid"].inertia + sum(body.inertia for body in places)
    assert turned == pytest.approx(sum(m * d**2 / 8 for m, _, d in masses))
    # the centre of mass between the places is that of the sections; what projects moves with the last place
    beyond = 7850 * np.pi / 4 * np.array([0.05**2 * 0.02, 0.06**2 * 0.18])
    centre = sum(body.mass * body.station for body in places)
    sections = sum(m * z for m, z, _ in masses) + beyond @ [0.19 - 0.18, 0.12 - 0.21]
    assert centre == pytest.approx(sections)
    # in front half of the span, with the inertia of its slices, and the stub, which tilts about the place
    slices = 7850 * np.pi / 64 * np.array([0.05**4 * 0.12 * (1 - 0.06 / 0.18), 0.06**4 * 0.06 * 0.03 / 0.18])
    stub = beyond[0] * (0.05**2 / 16 + 0.02**2 / 12 + 0.01**2)
    assert places[0].tilt_inertia == pytest.approx(slices.sum() + stub)


def test_nothing_else_counts_the_places(pair: dict[str, Any], tmp_path: Path) -> None:
    """Tables of members, drawings, transmission error, labels and REXS are those of the member in one piece."""
    bent, rigid = check(pair), check(pair, overrides={SHAFT: None})
    assert bent.body.values.tolist() == rigid.body.values.tolist() == ["main/pinion", "main/wheel"]
    ends = bent.link_first.sel(link=rigid.link).values
    assert ends.tolist() == rigid.link_first.values.tolist()
    for draw in (train_front, train_section):
        shapes = [[trace.type for trace in draw(one).data] for one in (bent, rigid)]
        assert shapes[0] == shapes[1]
    assert set(static(pair).shaft.values) == set(static(pair, overrides={SHAFT: None}).shaft.values)
    assert body_labels(load(pair))["main/pinion/shaft/front"] == "pinion shaft front"
    path = tmp_path / "pair.rexs"
    written = []
    for overrides in ({}, {SHAFT: None}):
        write_rexs(load(pair, overrides=overrides), path)
        written.append(re.findall(r'type="shaft"|u_coordinate_on_shaft[^<]*', path.read_text()))
    assert written[0] == written[1]
    names = ["main/pinion/rz", "main/wheel/rz"]
    system = assemble(load(pair))
    (row,) = system.errors.B.T[-len(system.errors.shaft) :]
    assert [name for name, weight in zip(system.dofs.names, row, strict=True) if weight] == names
    head = train_head(load(pair), body_labels(load(pair)), mesh_labels(load(pair)))
    assert [body["name"] for body in head["bodies"]][:2] == ["main/pinion", "main/wheel"]


def test_check_lists_the_spans_and_warns_of_their_modes(pair: dict[str, Any]) -> None:
    """The lowest mode of a span, with clamped ends, against three times the highest mesh frequency, here 600 Hz."""
    result = check(pair)
    assert result.span.values.tolist() == ["main/pinion/shaft/front/span", "main/pinion/shaft/rear/span"]
    assert result.span_frequency_ratio.values == pytest.approx(result.span_frequency.values / 600)
    choice = result.choice.values.tolist().index(SHAFT)
    assert str(result.choice_value.values[choice]) == "bends"
    assert not any("shaft-span-resonates" in text for text in load(pair).warnings)
    speed = 1500 * result.span_frequency.values.min() / 600 / 3
    for factor, said in ((0.99, 0), (1.01, 1)):
        fast = load(pair, overrides={"operation.speed.pinion": f"{factor * speed} rpm"})
        assert sum("shaft-span-resonates" in text for text in fast.warnings) == said


def test_a_resolved_file_is_the_same_train(pair: dict[str, Any]) -> None:
    again = load(tomllib.loads(model_text(resolved_document(load(pair)))))
    assert again.bodies == load(pair).bodies
    assert again.spans == load(pair).spans


def test_a_gear_on_the_shaft_and_one_without_supports_away(pair: dict[str, Any]) -> None:
    """A further gear without a shaft of its own sits at its station; a support at the centre makes no place."""
    second = {"kind": "gear", "teeth": 20, "module": "3 mm", "on": "pinion", "station": "60 mm"}
    mate = {"kind": "gear", "teeth": 60, "module": "3 mm", "station": "60 mm"}
    tables = {"other": second, "mate": mate, "meshes": {"pinion-wheel": {}, "other-mate": {}}}
    overrides = {f"stages.main.{name}": table for name, table in tables.items()}
    train = load(pair, overrides=overrides | {"operation.torque.wheel": "balance"})
    bodies = {body.name: body for body in train.bodies}
    assert bodies["main/pinion/shaft/main/other"].station == 0.06
    train = load(pair, overrides={"stages.main.wheel.shaft_sections": SECTION})
    assert [body.name for body in train.bodies if body.shaft_of == "main/wheel"] == []


def test_a_place_without_a_bearing(pair: dict[str, Any]) -> None:
    """A support with radial = 0, named behind the others, is a place with mass alone: statics stays as it is."""
    more = {"stages.main.pinion.support.half": {"at": "-90 mm", "radial": 0}}
    one, other = (static(pair, overrides=overrides) for overrides in ({}, more))
    same = [row for row in one.link_row.values if "/support/" in row]
    forces = [result.link_force.sel(link_row=same).values for result in (one, other)]
    assert np.abs(forces[0] - forces[1]).max() < 1e-6 * np.abs(forces[0]).max()
    assert modes(pair, overrides=more).sizes["dof"] == modes(pair).sizes["dof"] + 6


def test_as_many_places_as_a_train_has_room_for(pair: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.train.shafts.MOST_BODIES", 3)
    load(pair, overrides={SHAFT: None})
    with pytest.raises(ModelError, match="4 bodies") as caught:
        load(pair)
    assert caught.value.allowed == "at most 3 bodies"


def test_a_gear_on_rigid_bearings_tilts_as_its_shaft_bends(pair: dict[str, Any], shaft: dict[str, Any]) -> None:
    """Rigid bearings at a distance hold a rigid member in tilt: its mesh is one row; not so a shaft that bends."""
    rigid = {f"stages.main.pinion.support.{name}.radial": "inf" for name in ("front", "rear")}
    (mesh,) = load(pair, overrides=rigid | shaft).meshes
    assert len(mesh.slices) == (0 if shaft else 10)


def test_friction_and_torque_are_those_of_the_member(pair: dict[str, Any], shaft: dict[str, Any]) -> None:
    """Friction of a bearing by the whole torque of its member; a held member has all of its reaction."""
    friction = {"friction": {"coefficient": 0.1, "radius": "40 mm"}, "clearance": "10 um"}
    bearing = {f"stages.main.pinion.support.front.{key}": value for key, value in friction.items()}
    (group,) = assemble(load(pair, overrides=bearing | shaft)).groups
    assert group.law.friction == pytest.approx(0.1 * 400 / 0.04)
    held = copy.deepcopy(PLANETS)
    held["operation"]["torque"] = {"sun": "100 N m"}
    ring = held["stages"]["main"]["ring"]
    ring["support"] = {name: {"at": at, "radial": "1e9 N/m"} for name, at in (("front", "-30 mm"), ("rear", "30 mm"))}
    ring |= {} if shaft else {"shaft_sections": [SECTION[0] | {"diameter": "500 mm", "bore": "400 mm"}]}
    result = check(held)
    assert float(result.torque.sel(body="main/ring")) == pytest.approx(100 * 84 / 24)


def test_the_life_says_which_thrust_it_does_not_count(pair: dict[str, Any], shaft: dict[str, Any]) -> None:
    """Helical teeth push along z, which the first bearing holds rigidly, wherever it stands on the shaft."""
    large = ROLLER | {
        "elements": 20,
        "element_diameter": "20 mm",
        "element_length": "20 mm",
        "pitch_diameter": "160 mm",
    }
    supports = {"front": {"at": "-180 mm", **large}, "rear": {"at": "120 mm", **large}}
    overrides = {"stages.main.helix_angle": "10 deg", "stages.main.pinion.support": supports}
    result = life(pair, overrides=overrides | shaft)
    (text,) = [text for text in result.attrs["warnings"].split('", "') if "thrust-not-counted" in text]
    assert "main/pinion/support/front" in text


def test_a_shaft_as_thin_as_a_thread_has_a_mode(pair: dict[str, Any]) -> None:
    """Beside a thick section its stiffness is rounding, of either sign."""
    sections = {"1.from": "-260 mm", "1.to": "-140 mm", "1.diameter": "150 mm", "2.diameter": "0.1 um"}
    places = {f"{SHAFT}.{key}": value for key, value in sections.items()}
    train = load(pair, overrides={**places, "stages.main.pinion.support.front.at": "-250 mm"})
    assert all(np.isfinite(span.frequency) and span.frequency >= 0 for span in train.spans)
