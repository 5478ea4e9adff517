"""Tolerances of a resolved train: grades with their sizes, and paths that only the train knows."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest

from epicyclic.document.document import read
from epicyclic.document.tolerances import Tolerance
from epicyclic.errors import ModelError
from epicyclic.train.resolution import costs_of, load, tolerances_of

PLAIN = read("ren2021", {"tolerance": None}).data
WIDE = read("wind-five").data
UM = 1e-6


def entries(table: Mapping[str, object]) -> dict[str, Tolerance]:
    return {entry.path: entry for entry in tolerances_of(load(PLAIN, {"tolerance": table}))}


def deviation(path: str, text: str) -> float:
    (entry,) = entries({path: text}).values()
    assert entry.own is not None
    assert entry.own.text == text
    return entry.own.std


COSINE = math.cos(math.radians(25))


@pytest.mark.parametrize(
    ("path", "text", "width"),
    # m_n 32 mm, 23, 17 and 57 teeth, 25 deg: d = 812.1, 600.2, 2012.6 mm, the pins at 706.2 mm
    [
        ("sun.run_out", "grade(ISO 1328-1:2013 5, 3 sigma)", 47),  # 0.9 (1.624 + 15.674 + 22.4 + 12) = 46.53
        ("planet.run_out", "grade(ISO 1328-1:2013 5, 3 sigma)", 44),  # 0.9 (1.200 + 13.475 + 34.4) = 44.17
        ("planet.run_out", "grade(ISO 1328-1:2013 6, 3 sigma)", 62),  # 62.46
        ("ring.run_out", "grade(ISO 1328-1:2013 5, 3 sigma)", 57),  # 0.9 (4.025 + 24.674 + 34.4) = 56.79
        ("sun.run_out.x", "grade(ISO 1328-1:2013 5, 3 sigma)", 47),
        ("sun.run_out.amplitude", "grade(ISO 1328-1:2013 5, 3 sigma)", 47),
        # sqrt((0.4 32 + 0.812 + 4)^2 + (0.55 32 + 5)^2) = 28.65 of the sun, 28.53 of the planet: 29 each
        ("meshes.sun-planet.profile", "grade(ISO 1328-1:2013 5, 3 sigma)", 29 * math.sqrt(2)),
        ("meshes.sun-planet.profile.amplitude", "grade(ISO 1328-1:2013 5, 3 sigma)", 29 * math.sqrt(2)),
        ("planet.position", "grade(IT6, 3 sigma)", 50),
        ("planet.position.y", "grade(IT8, 3 sigma)", 125),
    ],
)
def test_a_grade_takes_its_size_from_the_train(path: str, text: str, width: float) -> None:
    assert deviation(f"deviations.main.{path}", text) == pytest.approx(width / 6 * UM, rel=1e-9)
    assert deviation(f"deviations.main.{path}", text.replace("3 sigma", "2 sigma")) == pytest.approx(width / 4 * UM)


@pytest.mark.parametrize(
    ("path", "text", "problem", "allowed"),
    [
        ("sun.run_out", "grade(IT6, 3 sigma)", "has no size", "position of a planet"),
        ("sun.position", "grade(IT6, 3 sigma)", "has no size", "position of a planet"),
        ("planet.position.z", "grade(IT6, 3 sigma)", "has no size", "position of a planet"),
        ("planet.position", "grade(ISO 1328-1:2013 6, 3 sigma)", "no formula", "run_out of a gear"),
        ("carrier.run_out", "grade(ISO 1328-1:2013 6, 3 sigma)", "no formula", "run_out of a gear"),
        ("planet.bearing_run_out", "grade(ISO 1328-1:2013 6, 3 sigma)", "no formula", "run_out of a gear"),
        ("meshes.sun-planet.gap", "grade(ISO 1328-1:2013 6, 3 sigma)", "no formula", "profile of a mesh"),
        ("sun.run_out", "grade(ISO 1328-1:2013 12, 3 sigma)", "no grade 12", "1 to 11"),
        ("planet.position", "grade(IT12, 3 sigma)", "IT12 is none", "IT5 to IT11"),
        ("planet.position", "disc(3 m)", "wider than a module", "32 mm"),
        ("meshes.sun-planet.gap", "normal(0, 40 mm)", "wider than a module", "32 mm"),
        ("meshes.sun-ring.gap", "normal(0, 1 um)", "no main.meshes.sun-ring", "main.meshes.planet-ring"),
        ("sun.left.run_out", "disc(1 um)", "no main.sun.left", "main.ring.left"),
    ],
)
def test_what_the_train_has_not(path: str, text: str, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        entries({f"deviations.main.{path}": text})
    assert error.value.path == f"tolerance.deviations.main.{path}"
    assert problem in error.value.problem
    assert allowed in error.value.allowed
    assert text in str(error.value)


def test_halves_and_tables_of_a_stage_are_there() -> None:
    flank = {"stages.main.flank.crown": "5 um"}
    table = {
        "deviations.main.ring.left.run_out": "disc(1 um)",
        "deviations.main.meshes.sun-planet.left.gap": "normal(0, 1 um)",
        "stages.main.flank.crown": "normal(5 um, 1 um)",
        "stages.main.gap": "normal(20 mm, 1 mm)",
    }
    found = tolerances_of(load(PLAIN, flank | {"tolerance": table}))
    assert [entry.path for entry in found] == list(table)


def test_a_size_beyond_the_standards_is_refused() -> None:
    with pytest.raises(ModelError, match="beyond ISO 1328-1:2013") as error:
        load(
            PLAIN,
            {
                "stages.main.module": "80 mm",
                "tolerance": {"deviations.sun.run_out": "grade(ISO 1328-1:2013 5, 3 sigma)"},
            },
        )
    assert "0.5 to 70 mm" in error.value.allowed


def test_prices_of_grades_have_their_distributions() -> None:
    found = costs_of(load(WIDE))
    pins = found["deviations.main.planet.position"]
    assert [(grade.text, grade.price) for grade in pins] == [
        ("disc(32 um)", 2400),
        ("disc(44 um)", 1300),
        ("disc(70 um)", 700),
        ("disc(110 um)", 400),
    ]
    runs = found["deviations.main.planet.run_out"]
    assert [grade.distribution.std for grade in runs] == sorted(grade.distribution.std for grade in runs)
    with pytest.raises(ModelError, match="no size") as error:
        load(WIDE, {"tolerance.cost.deviations.main.planet.run_out": {"grade(IT6, 3 sigma)": 4}})
    assert error.value.path.startswith("tolerance.cost.deviations.main.planet.run_out")


@pytest.mark.parametrize("name", ["ren2021", "wind-five"])
def test_ready_drives_have_tolerances_that_are_assumed(name: str) -> None:
    train = load(name)
    found = tolerances_of(train)
    assert len(found) == 8
    assert "tolerance" in train.assumed
    planets = next(iter(train.planets.values()))
    assert {entry.count for entry in found} == {1, planets}
    assert any(entry.common is not None for entry in found)
    # a tolerance changes nothing but what is drawn from it
    plain = load(name, {"tolerance": None})
    assert plain.displacements == () or len(plain.displacements) == len(train.displacements)
    assert train.torques == plain.torques


def star_behind_a_pair(coupled: bool) -> dict[str, object]:
    """A star set, pins at 2 (24 + 24)/2 = 48 mm from its axis, which a coupling puts 250 mm beside the first gear."""
    gears = {"g1": {"kind": "gear", "teeth": 50}, "g2": {"kind": "gear", "teeth": 75}}
    star = {"sun": {"teeth": 24}, "planet": {"teeth": 24}, "ring": {"teeth": 72, "rim": 0.02}, "planets": 3}
    stages = {"pair": {"module": 0.004, **gears}, "star": {"module": 0.002, **star}}
    return {
        "format": 2,
        "title": "star behind a pair",
        "stages": {name: stage | {"face_width": 0.02} for name, stage in stages.items() if coupled or name == "star"},
        "couplings": {"c": {"between": ["pair.g2", "star.sun"]}} if coupled else {},
        "tolerance": {"deviations.star.planet.position": "grade(IT6, 3 sigma)"},
    }


def test_the_size_of_a_pin_is_its_distance_from_the_axis_of_its_stage() -> None:
    train = load(star_behind_a_pair(coupled=True))
    planet = next(body for body in train.bodies if body.kind == "planet")
    assert math.hypot(*planet.centre) > 0.2
    (entry,) = tolerances_of(train)
    assert entry.own is not None
    assert entry.own.std == pytest.approx(16 / 6 * UM)  # ISO 286-1, 30 to 50 mm: IT6 = 16 um
    assert tolerances_of(load(star_behind_a_pair(coupled=False))) == (entry,)
