"""New trains: teeth that assemble, a size by hand, contradictions by their keyword, the same bits from the file."""

from __future__ import annotations

import inspect
import math
import re
import tomllib
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import epicyclic
from epicyclic.document.document import read
from epicyclic.errors import ModelError
from epicyclic.train.layouts import (
    RATIO_BAND,
    Blank,
    assembles,
    counts_of_ratio,
    neighbour_gap,
    ratio_of,
    said,
    shifts_of,
)
from epicyclic.train.new_train import differential, new_train, planetary, star
from epicyclic.train.phasing import ToothedGear, ToothMesh, stage_leads

LOAD: dict[str, Any] = {"speed": "1000 rpm", "power": "750 kW"}
DIFFERENTIAL_LOAD: dict[str, Any] = {"speed": {"sun": "1000 rpm", "carrier": "9 rpm"}, "torque": {"sun": "5 N m"}}
BOX: dict[str, Any] = {"teeth": "21/39/99", "module": "10 mm", "helix_angle": "7.5 deg", "face_width": "200 mm"}


def of_ratio(ratio: float, planets: int, held: str = "ring", helix_angle: float = 0.0) -> tuple[dict[str, int], ...]:
    size: dict[str, Any] = dict.fromkeys(("module", "face_width", "pressure_angle"), 0.0)
    blank = Blank(teeth={}, planets=planets, held=held, helix_angle=helix_angle, **size)
    return counts_of_ratio(ratio, blank, RATIO_BAND)


def test_the_phases_decide_as_the_textbook_does() -> None:
    for sun in range(17, 40):
        for planet in range(17, 40, 3):
            for planets in (3, 4, 5):
                counts = {"sun": sun, "planet": planet, "ring": sun + 2 * planet}
                gears = (
                    ToothedGear(name="sun", teeth=counts["sun"], central=True),
                    ToothedGear(name="planet", teeth=counts["planet"]),
                    ToothedGear(name="ring", teeth=counts["ring"], central=True, internal=True),
                )
                angles = tuple(Fraction(i, planets) for i in range(planets))
                meshes = (
                    ToothMesh(pair="sun-planet", a="sun", b="planet", directions=angles, flank=1),
                    ToothMesh(pair="planet-ring", a="planet", b="ring", directions=angles, flank=-1),
                )
                assert assembles(counts, planets) == stage_leads(gears, meshes, sense=1).assembles
                assert assembles(counts, planets) == ((counts["sun"] + counts["ring"]) % planets == 0)


def test_21_39_99_as_known() -> None:
    counts = {"sun": 21, "planet": 39, "ring": 99}
    assert [n for n in range(2, 8) if assembles(counts, n)] == [2, 3, 4, 5, 6]
    assert neighbour_gap(counts, 4, 0.0) >= 1 > neighbour_gap(counts, 5, 0.0)
    # 2 a sin(pi/N) - d_a in modules: 60 sin 45 deg - 41
    assert neighbour_gap(counts, 4, 0.0) == pytest.approx(60 * math.sin(math.pi / 4) - 41)
    assert ratio_of(counts, "ring") == pytest.approx(120 / 21)
    assert ratio_of(counts, "sun") == pytest.approx(120 / 99)
    assert ratio_of(counts, "carrier") == pytest.approx(-99 / 21)


@settings(max_examples=25, deadline=None)
@given(ratio=st.floats(3.0, 9.0), planets=st.integers(3, 4), beta=st.sampled_from([0.0, 0.13]))
def test_teeth_of_a_ratio_assemble_fit_and_are_near(ratio: float, planets: int, beta: float) -> None:
    if planets == 4 and ratio > 6.2:
        return
    best, *_ = of_ratio(ratio, planets, helix_angle=beta)
    assert abs(ratio_of(best, "ring") / ratio - 1) <= 0.02
    assert (best["sun"] + best["ring"]) % planets == 0
    assert best["ring"] == best["sun"] + 2 * best["planet"]
    assert min(best["sun"], best["planet"]) >= 17
    assert neighbour_gap(best, planets, beta) >= 1


def test_the_limits_of_the_ratio_by_the_number_of_planets() -> None:
    for planets, most in ((3, 14.1), (4, 6.5), (5, 4.6), (6, 3.8), (7, 3.3)):
        with pytest.raises(ModelError, match="fewer planets or two stages"):
            of_ratio(1.12 * most, planets)
        assert of_ratio(0.93 * most, planets)


def test_six_with_three_planets_has_no_coprime_solution_and_is_answered_all_the_same() -> None:
    best, *_ = of_ratio(6.0, 3)
    assert ratio_of(best, "ring") == 6
    assert best["sun"] % 3 != 0
    assert math.gcd(best["sun"], best["planet"]) > 1 or math.gcd(best["planet"], best["ring"]) > 1


@pytest.mark.parametrize(
    ("ratio", "held", "teeth"),
    [
        (4.0, "ring", "18/18/54"),  # 101/100/301 has no common factors
        (8.0, "ring", "18/54/126"),
        (3.0, "carrier", "18/18/54"),
        (1.5, "sun", "34/17/68"),
        (5.0, "ring", "41/61/163"),  # without common factors, and no larger than rings are
        (5.7, "ring", "19/35/89"),
    ],
)
def test_large_rings_are_no_price_for_teeth_without_common_factors(ratio: float, held: Any, teeth: str) -> None:
    best, *_ = of_ratio(ratio, 3, held)
    assert said(best) == teeth


def test_module_by_hand() -> None:
    """T = 7162 N m: d^3 = 2 1.15 T (u + 1)/u / (N 0.8 4e6), u = 39/21, d = 140 mm, m = 6.7 -> 8 mm, b = 135 mm."""
    main = planetary(teeth="21/39/99", **LOAD)["stages"]["main"]
    assert (main["module"], main["face_width"]) == ("8 mm", "135 mm")
    torque = 750e3 / (1000 * math.tau / 60)
    diameter = (2 * 1.15 * torque * (60 / 39) / (3 * 0.8 * 4e6)) ** (1 / 3)
    assert 6e-3 < diameter / 21 <= 8e-3
    assert 0.8 * 168 == pytest.approx(134.4)


def test_what_was_given_stays_and_the_rest_is_listed() -> None:
    document = planetary(**BOX, **LOAD)
    main = document["stages"]["main"]
    assert (main["module"], main["face_width"], main["helix_angle"]) == ("10 mm", "200 mm", "7.5 deg")
    assert document["operation"] == {"held": ["ring"], "speed": {"sun": "1000 rpm"}, "power": {"sun": "750 kW"}}
    for path in ("stages.main.module", "stages.main.face_width", "stages.main.sun.teeth", "operation.power.sun"):
        assert path not in document["assumed"]
    for path in ("stages.main.carrier.inertia", "damping.modal", "deviations.planet.position", "tolerance"):
        assert path in document["assumed"]
    train = epicyclic.load(document)
    assert train.warnings == ()
    assert float((train.kinematics.mesh_frequency or {})["main"]) == pytest.approx(1000 / 60 * 99 / 120 * 21)
    assert (train.kinematics.torque or {})["main.carrier"] == pytest.approx(-750e3 / (1000 * math.tau / 60) * 120 / 21)


@pytest.mark.parametrize(
    "keywords",
    [
        {"kind": "planetary", **BOX, **LOAD},
        {"kind": "planetary", "ratio": 4.2, "planets": 4, "torque": "2 kN m", "speed": "300 rpm", "driver": "carrier"},
        {"kind": "planetary", "ratio": 1.4, "held": "sun", "torque": "2 kN m", "speed": "300 rpm"},
        {"kind": "star", "ratio": -3.2, "planets": 4, "torque": 200.0, "speed": 314.0, "helix_angle": 0.26},
        {"kind": "differential", "teeth": (21, 39, 99), "speed": {"sun": "9 rpm", "ring": 1.0}, "torque": {"sun": 9.0}},
        {"kind": "differential", "teeth": "21/39", "speed": {"sun": "9 rpm", "ring": 1.0}, "power": {"sun": "9 kW"}},
        {"kind": "planetary", "teeth": "14/40/94", "torque": "2 kN m", "power": "30 kW"},
    ],
)
def test_the_file_is_the_document(keywords: dict[str, Any]) -> None:
    train = new_train(**keywords)
    text = train.text(("head",))
    assert read(tomllib.loads(text)).model == read(train.document).model
    assert epicyclic.load(tomllib.loads(text)).warnings == ()
    assert all(len(line) <= 120 for line in text.splitlines() if not line.startswith(("title", '"')))
    assert "ratio" in train.comments["stages.main"] or keywords["kind"] == "differential"


def test_what_the_file_leaves_out_stands_beside_the_keys() -> None:
    """Tip relief that the mesh stiffness would ignore, and weights: with the key that counts them."""
    text = new_train(kind="planetary", teeth="21/39/99", power="3 MW", speed="20 rpm", driver="carrier").text()
    assert 'tip relief would count with meshes.*.stiffness = "contact"' in text
    assert "[operation]  # without weights; gravity = true counts them" in text
    document = tomllib.loads(text)
    heavy = epicyclic.static(document, overrides={"operation.gravity": True})
    assert float(abs(heavy.mesh_force - epicyclic.static(document).mesh_force).max()) > 1e3


def test_a_train_of_few_words_runs() -> None:
    document = star(ratio=3.2, torque="200 N m", speed="3000 rpm")
    assert epicyclic.modes(document, band="5 %").frequency.size
    assert float(epicyclic.sharing(document, method="static", cycles=2, samples=8).system_load_sharing.max()) > 1


@pytest.mark.parametrize(
    ("keywords", "path", "words"),
    [
        ({"teeth": "22/39/100", **LOAD}, "teeth", "21/39/99"),
        ({"teeth": "22/39/99", **LOAD}, "teeth", "ring of 100"),
        ({"teeth": "21/39/99", "ratio": 6.0, **LOAD}, "ratio", "5.7143"),
        ({"teeth": "21/39/99", "ratio": -5.714, **LOAD}, "ratio", "5.7143"),
        ({"teeth": "21/39/99", "kind": "differential", "ratio": 5.714, **DIFFERENTIAL_LOAD}, "ratio", "leave it out"),
        ({"teeth": "21/39/99", "planets": 5, **LOAD}, "planets", "at most 4"),
        ({"teeth": "9/39/87", **LOAD}, "teeth", "12 or more"),
        ({"teeth": "a/b", **LOAD}, "teeth", "21/39/99"),
        ({**LOAD}, "teeth", "or a ratio"),
        ({"teeth": "21/39/99", "power": "1 kW"}, "speed", "both torque and power"),
        ({"teeth": "21/39/99", "speed": "1 rpm"}, "torque", "or power"),
        ({"teeth": "21/39/99", "torque": "9 kN m", **LOAD}, "power", "two of power, torque and speed"),
        ({"teeth": "21/39/99", "module": "10", **LOAD}, "module", "length"),
        ({"teeth": "21/39/99", "module": 10, **LOAD}, "module", "<= 0.1 m"),
        ({"teeth": "21/39/99", "held": "carrier", **LOAD}, "held", "a star"),
        ({"teeth": "21/39/99", "driver": "ring", **LOAD}, "driver", "sun or carrier"),
        ({"teeth": "21/39/99", "kind": "planetry", **LOAD}, "kind", "planetary"),
        ({"ratio": 20.0, **LOAD}, "ratio", "two stages"),
        ({"ratio": 1.5, **LOAD}, "ratio", "above 2"),
        ({"ratio": 5.0, "speed": "1 rpm", "torque": "900 MN m"}, "torque", "more planets"),
    ],
)
def test_contradictions_name_the_keyword(keywords: dict[str, Any], path: str, words: str) -> None:
    with pytest.raises(ModelError) as raised:
        new_train(**({"kind": "planetary"} | keywords))
    assert raised.value.path == path
    assert words in str(raised.value)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_ratio_of_a_star_has_either_sign_beside_its_teeth(sign: int) -> None:
    assert new_train(kind="star", teeth="21/39/99", ratio=sign * 99 / 21, **LOAD).document["title"]


@pytest.mark.parametrize(("teeth", "planets"), [("18/29/76", 4), ("19/17/53", 5), ("18/29/77", 4), ("20/17/54", 5)])
def test_what_is_proposed_for_a_small_module_is_accepted(teeth: str, planets: int) -> None:
    """Of a module of 0.5 mm tips must stand 1 mm apart, which is two modules."""
    keywords: dict[str, Any] = {"kind": "planetary", "module": "0.5 mm", **LOAD}
    with pytest.raises(ModelError) as raised:
        new_train(teeth=teeth, planets=planets, **keywords)
    assert raised.value.path == "teeth"
    counts = re.findall(r"\d+/\d+/\d+", str(raised.value.allowed))
    numbers = re.search(r"these teeth with (.*) planets", str(raised.value.allowed))
    for proposal in counts:
        new_train(teeth=proposal, planets=planets, **keywords)
    for number in re.findall(r"\d+", numbers[1] if numbers else ""):
        new_train(teeth=teeth, planets=int(number), **keywords)
    assert counts or numbers


def test_shifts_against_undercut_keep_the_centre_distance() -> None:
    blank = Blank(
        teeth={"sun": 14, "planet": 40, "ring": 94},
        planets=3,
        module=2e-3,
        face_width=20e-3,
        helix_angle=0.0,
        pressure_angle=math.radians(20),
        held="ring",
    )
    assert shifts_of(blank) == {"sun": 0.19, "planet": -0.19, "ring": 0.19}  # 1 - 14 sin^2 20 deg / 2 = 0.181


@pytest.mark.parametrize(
    ("sun", "planets", "torque", "sideways"),
    [
        (24, 3, "adds up", "cancel"),
        (23, 4, "cancels", "add up"),
        (25, 4, "cancels", "add up"),
        (22, 4, "cancels", "cancel"),
    ],
)
def test_what_the_meshes_with_the_sun_do_together(sun: int, planets: int, torque: str, sideways: str) -> None:
    """Sums over the planets of exp(2 pi i z_s k/N), and of that across the axis of the sun."""
    turn = np.exp(2j * np.pi * np.arange(planets) / planets)
    assert (abs((turn**sun).sum()) > 0.5) == (torque == "adds up")
    assert any(abs((turn ** (sun + way)).sum()) > 0.5 for way in (1, -1)) == (sideways == "add up")
    teeth = next(f"{sun}/{n}/{sun + 2 * n}" for n in range(33, 60) if (2 * sun + 2 * n) % planets == 0)
    (words,) = (text for text in new_train(teeth=teeth, planets=planets, **LOAD).remarks if "z_s/N" in text)
    assert ("torque adds up" in words) == (torque == "adds up")
    assert ("across its axis add up" in words) == (sideways == "add up")


@pytest.mark.parametrize("shift", [np.float32(0.25), np.int64(0), np.array([0.25, 0.5], np.float32)[1]])
def test_a_profile_shift_may_be_a_number_of_numpy(shift: Any) -> None:
    one, other = (new_train(**BOX, **LOAD, profile_shift={"sun": value}) for value in (shift, float(shift)))
    assert one.document == other.document
    assert one.document["stages"]["main"]["sun"]["profile_shift"] == float(shift)


def test_signatures_are_typed_and_documented() -> None:
    for function in (planetary, star, differential):
        assert function.__doc__
        for parameter in inspect.signature(function).parameters.values():
            assert parameter.kind is inspect.Parameter.KEYWORD_ONLY
            assert parameter.annotation is not inspect.Parameter.empty


def test_names_of_the_package() -> None:
    assert epicyclic.planetary is planetary
    assert epicyclic.star is star
    assert epicyclic.differential is differential
