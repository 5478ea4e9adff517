"""Short reprs of a Train and its parts, and the front view that notebooks show."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree import ElementTree

import pytest

import epicyclic
from epicyclic.train.train import Train, driving_member

SVG = "{http://www.w3.org/2000/svg}"
DRIVES = ("ren2021", "xu2020", "dong2019", "encased-differential", "lin1999-n3", "yue2014-iii")


@pytest.fixture(params=DRIVES)
def train(request: pytest.FixtureRequest) -> Train:
    return epicyclic.load(request.param)


def test_reprs_are_one_short_line(train: Train) -> None:
    assert len(repr(train)) < 250
    for part in (*train.bodies, *train.meshes, *train.links, *train.displacements, train.kinematics):
        assert len(repr(part)) < 250
        assert "\n" not in repr(part)
        assert "nan" not in repr(part)
    assert all(len(repr(mesh.teeth)) < 100 for mesh in train.meshes)


def test_repr_holds_the_key_numbers() -> None:
    text = repr(epicyclic.load("ren2021"))
    assert text.startswith("Train('Herringbone planetary train, 100 kN m (Ren 2021)': main (3 planets)")
    assert "7 bodies, 12 meshes, 7 links" in text
    assert text.endswith("main.sun 100 rpm, 1e+05 N m)")


def test_a_tabulated_mesh_says_so() -> None:
    train = epicyclic.load("ren2021", overrides={"stages.main.meshes.sun-planet.stiffness": "contact"})
    table = train.meshes[0].table
    assert "tabulated" in repr(train.meshes[0])
    assert table is not None
    assert repr(table).startswith("ContactTable(50 phases x 21 loads")


def test_the_driver_is_where_power_enters() -> None:
    assert driving_member(epicyclic.load("xu2020")) == "main.carrier"
    assert driving_member(epicyclic.load("lin1999-n3")) == "main.sun"  # no torque: the first freedom


def test_html_is_well_formed_and_complete(train: Train) -> None:
    text = train._repr_html_()
    assert len(text) < 20_000
    root = ElementTree.fromstring(text)
    cells = [cell.text or "" for cell in root.iter("td")]
    assert not {"nan", "inf", "None"} & set(cells)
    for body in train.bodies:
        assert any(cell.startswith(body.member) for cell in cells)
        if body.gear is not None:
            assert str(body.gear.teeth) in cells
    for rate in (train.kinematics.mesh_frequency or {}).values():
        assert f"{float(rate):.5g}" in cells


def test_front_view_is_to_scale() -> None:
    train = epicyclic.load("ren2021")
    circles = {
        (title.text or "").split(",")[0]: circle
        for circle in ElementTree.fromstring(train._repr_html_()).iter(f"{SVG}circle")
        if (title := circle.find(f"{SVG}title")) is not None
    }
    place = {
        name: (float(c.get("cx", "")), float(c.get("cy", "")), float(c.get("r", ""))) for name, c in circles.items()
    }
    sun, planet, ring = place["main/sun"], place["main/planet/1"], place["main/ring/left"]
    apart = math.hypot(planet[0] - sun[0], planet[1] - sun[1])
    # pitch circles touch outside and inside; coordinates carry one decimal
    assert apart == pytest.approx(sun[2] + planet[2], abs=0.3)
    assert apart == pytest.approx(ring[2] - planet[2], abs=0.3)
    assert sum(name.startswith("main/planet") for name in place) == 3
    assert place["main/planet/2"][1] < sun[1]  # y points upward


def test_unknown_values_leave_their_cells_empty() -> None:
    train = epicyclic.load("lin1999-n3")
    bodies = tuple(replace(body, mass=math.nan) for body in train.bodies)
    assert "nan" not in repr(bodies[0])
    assert "nan" not in replace(train, bodies=bodies, title="<a & b>")._repr_html_()


def test_a_stage_beside_the_first_axis_is_drawn_about_its_own() -> None:
    gears = {"g1": {"kind": "gear", "teeth": 50}, "g2": {"kind": "gear", "teeth": 75}}
    star = {"sun": {"teeth": 24}, "planet": {"teeth": 24}, "ring": {"teeth": 72, "rim": 0.02}, "planets": 3}
    document = {
        "format": 2,
        "title": "star behind a pair",
        "stages": {
            "pair": {"module": 0.004, "face_width": 0.02, **gears},
            "star": {"module": 0.002, "face_width": 0.02, **star},
        },
        "couplings": {"c": {"between": ["pair.g2", "star.sun"]}},
    }
    assert "pin circle, radius 48 mm" in epicyclic.load(document)._repr_html_()
