"""New trains beyond one simple set: kinds, shifted sets, several stages, servo reducers, and what is refused."""

from __future__ import annotations

import math
import re
import tomllib
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.document import read
from epicyclic.errors import ModelError
from epicyclic.teeth.geometry import involute
from epicyclic.train.layouts import LAYOUTS, Blank, assembles, nearest_teeth, pair_of_ratio, share_of_ratio
from epicyclic.train.new_train import new_train
from epicyclic.train.train import Train
from epicyclic.warning_codes import code_of

LOAD: dict[str, Any] = {"speed": "1000 rpm", "power": "75 kW"}
SERVO: dict[str, Any] = {"speed": "3000 rpm", "output_torque": "300 N m", "backlash": "3 arcmin"}
ARCMIN = math.radians(1 / 60)

# teeth, and the ratio of Willis from what drives to what is driven
SETS: dict[str, tuple[dict[str, Any], float]] = {
    "planetary": ({"teeth": "21/39/99"}, 1 + 99 / 21),
    "planetary, sun held": ({"kind": "planetary", "teeth": "21/39/99", "held": "sun"}, 1 + 21 / 99),
    "star": ({"teeth": "21/39/99"}, -99 / 21),
    "parallel": ({"teeth": "24/95"}, -95 / 24),
    "compound": ({"teeth": "21/60/24/105"}, 1 + 60 * 105 / (21 * 24)),
    "compound, carrier held": ({"kind": "compound", "teeth": "21/60/24/105", "held": "carrier"}, -60 * 105 / (21 * 24)),
    "compound, sun held": ({"kind": "compound", "teeth": "21/60/24/105", "held": "sun"}, 1 + 21 * 24 / (60 * 105)),
    "ravigneaux": ({"teeth": "27/33/21/24/81"}, 81 / 27),
    # w_s1 - w_c = (w_r - w_c) z_r/z_s1 and -w_c = -(w_r - w_c) z_r/z_s2
    "ravigneaux, sun2 held": (
        {"kind": "ravigneaux", "teeth": "27/33/21/24/81", "held": "sun2"},
        (81 / 27 + 81 / 33) / (1 + 81 / 33),
    ),
    "wolfrom": ({"teeth": "18/39/96/36/93"}, (1 + 96 / 18) / (1 - 96 * 36 / (39 * 93))),
}


def of_file(**keywords: Any) -> Train:
    """The train of the written file."""
    made = new_train(**keywords)
    text = made.text(("head",))
    assert read(tomllib.loads(text)).model == read(made.document).model
    return epicyclic.load(tomllib.loads(text))


@pytest.mark.parametrize("name", SETS)
def test_the_ratio_of_the_file_is_that_of_willis(name: str) -> None:
    given, ratio = SETS[name]
    keywords = {"kind": name, **given}
    train = of_file(**keywords, **LOAD)
    assert train.warnings == ()
    motion = train.kinematics
    held = motion.held[0].removeprefix("main.") if motion.held else None
    fast, slow = (f"main.{end}" for end in LAYOUTS[keywords["kind"]].ends(held))
    assert motion.speed is not None
    assert float(motion.speed[fast] / motion.speed[slow]) == pytest.approx(ratio, rel=1e-12)
    assert (motion.power or {})[fast] == pytest.approx(75e3)
    assert (motion.power or {})[slow] == pytest.approx(-75e3)


@pytest.mark.parametrize("kind", ["parallel", "compound", "ravigneaux", "wolfrom"])
@pytest.mark.parametrize("helix", ["0 deg", "18 deg"])
def test_every_kind_is_checked_and_has_modes(kind: str, helix: str, tmp_path: Path) -> None:
    path = tmp_path / "box.toml"
    words = ["--kind", kind, "--teeth", SETS[kind][0]["teeth"], "--power", "75 kW", "--speed", "1000 rpm"]
    made = CliRunner().invoke(app, ["new", str(path), *words, "--helix", helix])
    assert made.exit_code == 0, made.output
    checked = CliRunner().invoke(app, ["check", str(path)])
    assert checked.exit_code == 0, checked.output
    assert "can be assembled" in checked.output or kind == "parallel"
    assert epicyclic.load(path).warnings == ()
    assert epicyclic.modes(path, band="5 %").frequency.size


@pytest.mark.parametrize("kind", ["compound", "ravigneaux", "wolfrom"])
def test_assembly_by_teeth_is_that_of_the_phases(kind: str) -> None:
    """Sets about the example: `assembles` and the exact phases of the loaded train agree on each."""
    layout, verdicts = LAYOUTS[kind], []
    example = dict(zip(layout.gears, map(int, layout.example.split("/")), strict=True))
    example |= {"sun1": 27, "sun2": 32} if kind == "ravigneaux" else {}
    free = [name for name, one in layout.gears.items() if one.kind != "ring"]
    for more in product(range(2 if len(free) > 3 else 3), repeat=len(free)):
        teeth = layout.with_rings(example | {gear: example[gear] + k for gear, k in zip(free, more, strict=True)})
        members: dict[str, Any] = {
            name: {"kind": one.kind, "teeth": teeth[name], **({"on": one.on} if one.on else {})}
            for name, one in layout.gears.items()
        }
        meshes: dict[str, Any] = {f"{a}-{b}": {} for a, b in layout.pairs}
        stage = {"planets": 3, "module": "4 mm", "face_width": "40 mm", **members, "carrier": {}, "meshes": meshes}
        train = epicyclic.load({"format": 2, "title": "set", "stages": {"main": stage}})
        bad = {code_of(text) for text in train.warnings} & {"not-assembled", "shafts-not-alike"}
        assert assembles(teeth, 3, kind) == (not bad)
        verdicts.append(not bad)
    assert len(set(verdicts)) == 2


# shifts and centre distances ------------------------------------------------------------------------------------------


def distances(train: Train) -> dict[str, float]:
    """Centre distance of every pair by its base radii and working angle [m]; the involute relation is checked."""
    gears = {body.name: body.gear for body in train.bodies}
    found = {}
    for mesh in train.meshes:
        a, b, sign = gears[mesh.a], gears[mesh.b], -1 if mesh.internal else 1
        assert a is not None
        assert b is not None
        shifts = a.profile_shift + b.profile_shift
        reference = math.atan(math.tan(a.pressure_angle) / math.cos(a.helix_angle))
        right = involute(reference) + sign * 2 * math.tan(a.pressure_angle) * shifts / (b.teeth + sign * a.teeth)
        assert involute(mesh.pressure_angle) == pytest.approx(right, abs=1e-13)
        found[mesh.pair] = (b.base_radius + sign * a.base_radius) / math.cos(mesh.pressure_angle)
    return found


@pytest.mark.parametrize("helix", ["0 deg", "10 deg"])
@pytest.mark.parametrize(
    "more",
    [
        {},
        {"centre_distance": "157 mm", "module": "5 mm"},
        {"centre_distance": "160 mm"},
        {"profile_shift": {"sun": 0.3, "planet": 0.2}},
        {"profile_shift": ["sun=0.4"]},
    ],
)
def test_31_31_95_works_at_one_centre_distance(helix: str, more: dict[str, Any]) -> None:
    made = new_train(teeth="31/31/95", helix_angle=helix, **more, **LOAD)
    train = epicyclic.load(made.document)
    every = list(distances(train).values())
    assert max(every) == pytest.approx(min(every), rel=1e-12)
    assert {code_of(text) for text in train.warnings} <= {"formula-outside-limits"}
    assumed, stage = made.document["assumed"], made.document["stages"]["main"]
    if not more:
        module = float(stage["module"].removesuffix(" mm")) * 1e-3 / math.cos(math.radians(float(helix.split()[0])))
        assert every[0] == pytest.approx(31.5 * module, rel=1e-8)  # half way between 31 and 32
        assert stage["sun"]["profile_shift"] > 0
        assert {"stages.main.centre_distance", "stages.main.sun.profile_shift"} <= set(assumed)
    if "centre_distance" in more:
        assert stage["centre_distance"] == more["centre_distance"]
        assert "stages.main.centre_distance" not in assumed
        assert every[0] == pytest.approx(float(more["centre_distance"].split()[0]) * 1e-3, rel=1e-12)
    if "profile_shift" in more:
        assert "stages.main.sun.profile_shift" not in assumed
        assert stage["sun"]["profile_shift"] in (0.3, 0.4)


def test_a_stepped_set_of_two_distances_is_brought_to_one() -> None:
    """sun + planet 57, ring - planet 58: half a module apart, in the chain of the ring by its own shift."""
    train = of_file(kind="wolfrom", teeth="18/39/96/36/94", planets=2, module="2 mm", **LOAD)
    every = list(distances(train).values())
    assert every == pytest.approx([57.5e-3] * len(every), rel=1e-12)


def test_the_module_follows_the_centre_distance() -> None:
    made = new_train(teeth="21/39/99", centre_distance="308 mm", **LOAD)
    assert made.document["stages"]["main"]["module"] == "10 mm"  # 308 mm are 10.27 modules of it
    assert "nearest to the centre distance" in made.document["assumed"]["stages.main.module"]


@pytest.mark.parametrize(
    ("keywords", "path", "words"),
    [
        ({"teeth": "31/31/97"}, "teeth", "no profile shift brings"),
        ({"teeth": "31/31/96"}, "teeth", "ring of 93"),
        ({"teeth": "21/39/99", "centre_distance": "250 mm", "module": "10 mm"}, "centre_distance", "base circles"),
        (
            {"teeth": "21/39/99", "centre_distance": "308 mm", "profile_shift": {"sun": 0.3, "planet": 0.2}},
            "centre_distance",
            "say it already",
        ),
        (
            {"teeth": "21/39/99", "profile_shift": {"sun": 0.3, "planet": 0.2, "ring": 0.2}},
            "profile_shift",
            "different centre distances",
        ),
        ({"teeth": "21/39/99", "profile_shift": {"moon": 0.3}}, "profile_shift", "sun or planet or ring"),
        ({"teeth": "21/39/99", "profile_shift": ["sun=much"]}, "profile_shift", "no profile shift"),
        ({"teeth": "21/39/99", "profile_shift": ["sun=2.1"]}, "profile_shift", "within +-2"),
        ({"teeth": "21/39/99", "profile_shift": ["sun=nan"]}, "profile_shift", "nan"),
        ({"teeth": "21/39/99", "profile_shift": 0.3}, "profile_shift", "sun or planet or ring"),
        (
            {"kind": "ravigneaux", "teeth": "27/33/21/24/81", "centre_distance": "99 mm"},
            "centre_distance",
            "several axes",
        ),
        ({"kind": "wolfrom", "teeth": "18/39/96/39/96"}, "teeth", "ring2 does not turn"),
        ({"kind": "wolfrom", "ratio": 100.0}, "teeth", "sun/planet1/ring1/planet2/ring2"),
        ({"kind": "compound", "teeth": "21/39"}, "teeth", "2 numbers"),
        ({"kind": "parallel", "teeth": "24/95", "held": "wheel"}, "held", "nothing is held"),
        ({"kind": "planetary,differential", "ratio": 9.0}, "kind", "a differential alone"),
        ({"kind": "planetary,planetari", "ratio": 9.0}, "kind", "planetary"),
        ({"kind": "planetary,parallel", "ratio": 500.0}, "ratio", "more stages"),
        ({"kind": "planetary,parallel", "ratio": 20.0, "planets": "3,3,3"}, "planets", "3 entries of 2 stages"),
        ({"kind": "planetary,parallel", "teeth": "21/39/99,24/95", "ratio": 20.0}, "ratio", "22.619"),
        ({"kind": "planetary,planetary", "ratio": -25.0}, "ratio", "turns with the input"),
        ({"kind": "planetary,planetary", "ratio": 4.0}, "ratio", "4.0: 2 is left for stage1"),
        (
            {"kind": "parallel", "teeth": "20/60", "module": "2 mm", "centre_distance": "95 mm"},
            "centre_distance",
            "95 mm: asks for a profile shift of 5.",
        ),
        ({"teeth": "21/39/99", "output_torque": "9 N m"}, "output_torque", "given twice"),
        ({"teeth": "21/39/99", "backlash": "3 mm"}, "backlash", "angle"),
    ],
)
def test_what_is_refused_names_the_keyword(keywords: dict[str, Any], path: str, words: str) -> None:
    with pytest.raises(ModelError) as raised:
        new_train(**keywords, **LOAD)
    assert raised.value.path == path
    assert words in str(raised.value)


@pytest.mark.parametrize("more", [{"output_torque": "9 N m"}, {"backlash": "3 arcmin"}, {"driver": "sun"}])
def test_a_differential_has_no_one_output(more: dict[str, Any]) -> None:
    load = {"speed": {"sun": "1000 rpm", "carrier": "9 rpm"}, "torque": {"sun": "5 N m"}}
    with pytest.raises(ModelError) as raised:
        new_train(kind="differential", teeth="21/39/99", **load, **more)
    assert [raised.value.path] == list(more)


# planets that collide -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "teeth", "planets"),
    [
        ("planetary", "21/39/99", 5),
        ("planetary", "21/39/99", 7),
        ("star", "18/126/270", 3),
        ("compound", "21/60/24/105", 4),
        ("wolfrom", "18/39/96/36/93", 5),
    ],
)
def test_planets_without_room_name_teeth_that_have_it(kind: str, teeth: str, planets: int) -> None:
    with pytest.raises(ModelError) as raised:
        new_train(kind=kind, teeth=teeth, planets=planets, **LOAD)
    assert raised.value.path == "planets"
    most = re.search(r"at most (\d+) with these teeth", str(raised.value.allowed))
    proposed = re.findall(r"\d+(?:/\d+)+", str(raised.value.allowed))
    assert most
    assert len(proposed) == 3
    new_train(kind=kind, teeth=teeth, planets=int(most[1]), **LOAD)
    for other in proposed:
        assert of_file(kind=kind, teeth=other, planets=planets, **LOAD).warnings == ()


def test_a_differential_names_the_nearest_teeth_too() -> None:
    load: dict[str, Any] = {"speed": {"sun": "1000 rpm", "carrier": "9 rpm"}, "torque": {"sun": "5 N m"}}
    with pytest.raises(ModelError, match="cannot be assembled") as raised:
        new_train(kind="differential", teeth="22/39/100", **load)
    for other in re.findall(r"\d+(?:/\d+)+", str(raised.value.allowed)):
        new_train(kind="differential", teeth=other, **load)
    assert "21/39/99" in str(raised.value.allowed)


def test_planets_that_collide_with_those_of_another_axis_name_teeth_too() -> None:
    """Short planets of one branch and long ones of the next: found when the train is built."""
    with pytest.raises(ModelError, match="collide") as raised:
        new_train(kind="ravigneaux", teeth="25/35/21/23/81", planets=4, **LOAD)
    assert raised.value.path == "planets"


def test_the_nearest_teeth_are_the_nearest() -> None:
    """Every set of sun and planet within 12 teeth, looked through one by one."""
    given = {"sun": 21, "planet": 39, "ring": 99}
    size: dict[str, Any] = dict.fromkeys(("module", "face_width", "helix_angle", "pressure_angle"), 0.0)
    best = next(nearest_teeth(Blank(teeth=given, planets=5, held="ring", **size)))
    changes = [
        abs(s - 21) + abs(p - 39) + abs(s + 2 * p - 99)
        for s in range(17, 34)
        for p in range(27, 52)
        if (2 * s + 2 * p) % 5 == 0 and (s + p) * math.sin(math.pi / 5) - p - 2 >= 1
    ]
    assert sum(abs(best[name] - given[name]) for name in given) == min(changes)


# several stages -------------------------------------------------------------------------------------------------------

WIND = [
    *("--kind", "planetary,planetary,parallel", "--ratio", "97", "--planets", "5,3,", "--driver", "carrier"),
    *("--speed", "12.1 rpm", "--power", "5 MW", "--helix", "8 deg,8 deg,12 deg"),
]


def test_a_wind_gearbox_of_one_command_runs(tmp_path: Path) -> None:
    path = tmp_path / "wind.toml"
    made = CliRunner().invoke(app, ["new", str(path), *WIND])
    assert made.exit_code == 0, made.output
    train = epicyclic.load(path)
    assert train.warnings == ()
    motion = train.kinematics
    assert motion.speed is not None
    assert float(motion.speed["stage1.carrier"]) == pytest.approx(12.1)
    teeth = {body.member: body.gear.teeth for body in train.bodies if body.gear is not None}
    first, second = (1 + teeth[f"stage{i}.ring"] / teeth[f"stage{i}.sun"] for i in (1, 2))
    willis = -first * second * teeth["stage3.wheel"] / teeth["stage3.pinion"]
    ratio = float(motion.speed["stage3.pinion"] / motion.speed["stage1.carrier"])
    assert ratio == pytest.approx(willis, rel=1e-12)
    assert abs(ratio) == pytest.approx(97, rel=0.01)
    assert (motion.power or {})["stage3.pinion"] == pytest.approx(-5e6)
    assert train.planets["stage1"] == 5
    checked = CliRunner().invoke(app, ["check", str(path)])
    assert checked.exit_code == 0, checked.output
    assert checked.output.count("can be assembled") == 2
    assert epicyclic.modes(path, band="5 %").frequency.size
    sharing = epicyclic.sharing(path, method="static", cycles=1, samples=8)
    assert 1 < float(sharing.system_load_sharing.max()) < 1.5


@pytest.mark.parametrize("kind", ["parallel,planetary", "planetary,parallel", "star,planetary", "parallel,parallel"])
@pytest.mark.parametrize("slow", [True, False])
def test_stages_in_any_order_reduce_or_increase(kind: str, slow: bool) -> None:
    driver = LAYOUTS[kind.split(",")[0]].ends({"planetary": "ring", "star": "carrier"}.get(kind.split(",")[0]))[slow]
    train = of_file(kind=kind, ratio=15.0, driver=driver, **LOAD)
    assert train.warnings == ()
    speeds, powers = train.kinematics.speed or {}, train.kinematics.power or {}
    (begin,) = (name for name, power in powers.items() if power == pytest.approx(75e3))
    (end,) = (name for name, power in powers.items() if power == pytest.approx(-75e3))
    assert begin == f"stage1.{driver}"
    assert end.startswith("stage2.")
    assert abs(float(speeds[begin] / speeds[end])) == pytest.approx(1 / 15 if slow else 15, rel=0.01)


def test_teeth_that_are_given_leave_the_rest_of_the_ratio_to_the_others() -> None:
    document = new_train(kind="parallel,wolfrom", teeth=",18/39/96/36/93", ratio=400.0, **LOAD).document
    pair = document["stages"]["stage1"]
    assert pair["wheel"]["teeth"] / pair["pinion"]["teeth"] == pytest.approx(400 / SETS["wolfrom"][1], rel=0.0025)


def test_a_ratio_is_shared_by_what_the_stages_can_have() -> None:
    assert share_of_ratio(97.0, [("planetary", 3), ("planetary", 3), ("parallel", 3)]) == pytest.approx(97 ** (1 / 2.7))
    # five planets have room for about 2/(1 - sin 36 deg): 7 % less of it
    wide = 0.93 * 2 / (1 - math.sin(math.pi / 5))
    assert share_of_ratio(30.0, [("planetary", 5), ("planetary", 3)]) == pytest.approx(wide)
    # and what the second one cannot have is left to the first
    assert share_of_ratio(30.0, [("planetary", 3), ("planetary", 5)]) == pytest.approx(30 / wide)


@pytest.mark.parametrize("ratio", [1.7, 3.17, 5.9])
def test_pairs_of_a_ratio_are_near_and_without_common_factor(ratio: float) -> None:
    teeth = pair_of_ratio(ratio)
    assert teeth["wheel"] / teeth["pinion"] == pytest.approx(ratio, rel=0.0025)
    assert math.gcd(teeth["pinion"], teeth["wheel"]) == 1


def test_values_of_stages_stand_between_commas() -> None:
    keywords: dict[str, Any] = {
        "kind": "planetary,parallel",
        "teeth": "21/39/99,24/95",
        "profile_shift": ["stage2.pinion=0.2"],
    }
    stages = new_train(**keywords, module="8 mm,", face_width="90 mm", **LOAD).document["stages"]
    assert stages["stage1"]["module"] == "8 mm"
    assert stages["stage2"]["module"].endswith("mm")
    assert stages["stage1"]["face_width"] == stages["stage2"]["face_width"] == "90 mm"
    assert stages["stage2"]["pinion"]["profile_shift"] == 0.2
    assert "profile_shift" not in stages["stage1"]["sun"]


# servo reducers -------------------------------------------------------------------------------------------------------


def play(train: Train, fixed: set[str], output: str) -> float:
    """How far the output turns between both ends of all gaps [rad], by a linear programme over the speeds of members.

    fixed : members at rest.  Of a mesh |(w_a - w_c) r_a +- (w_b - w_c) r_b| cos beta_b <= j/2.
    """
    members = list(train.kinematics.ratio)
    number = {name: members.index(name) for name in members}
    of_body = {body.name: body for body in train.bodies}
    rows, right = [], []
    for mesh in train.meshes:
        a, b = of_body[mesh.a], of_body[mesh.b]
        assert a.gear is not None
        assert b.gear is not None
        row = np.zeros(len(members))
        r_a, r_b = a.gear.base_radius, -b.gear.base_radius if mesh.internal else b.gear.base_radius
        row[number[a.member]] += r_a
        row[number[b.member]] += r_b
        carrier = f"{mesh.stage.split('/')[0]}.carrier"
        if carrier in number:
            row[number[carrier]] -= r_a + r_b
        rows.append(row * math.cos(mesh.base_helix))
        right.append(mesh.backlash / 2)
    equal = []
    for tie in train.kinematics.ties:
        row = np.zeros(len(members))
        row[number[tie.a]], row[number[tie.b]] = 1, -1
        equal.append(row)
    goal = np.zeros(len(members))
    goal[number[output]] = -1
    found = linprog(
        goal,
        A_ub=np.array(rows + [-row for row in rows]),
        b_ub=np.array(right * 2),
        A_eq=np.array(equal) if equal else None,
        b_eq=np.zeros(len(equal)) if equal else None,
        bounds=[(0, 0) if name in fixed else (None, None) for name in members],
    )
    assert found.success
    return float(-2 * found.fun)


def test_a_servo_reducer_has_its_output_torque_and_backlash_by_hand() -> None:
    made = new_train(ratio=10.0, **SERVO)
    document = made.document
    assert document["operation"] == {"held": ["ring"], "speed": {"sun": "3000 rpm"}, "torque": {"carrier": "-300 N m"}}
    train = epicyclic.load(document)
    assert train.warnings == ()
    assert (train.kinematics.torque or {})["main.sun"] == pytest.approx(30)
    gaps = {mesh.backlash for mesh in train.meshes}
    assert len(gaps) == 1
    # each of both meshes lets the carrier turn by j/(2 a cos alpha)
    distance = (18 + 72) / 2 * 1.25e-3
    assert gaps.pop() == pytest.approx(3 * ARCMIN * distance * math.cos(math.radians(20)), rel=1e-5)
    assert "3 arcmin at carrier" in document["assumed"]["stages.main.meshes.sun-planet.backlash"]


@pytest.mark.parametrize(
    ("keywords", "fixed", "output"),
    [
        ({"teeth": "18/72/162"}, {"main.sun", "main.ring"}, "main.carrier"),
        ({"teeth": "21/39/99", "helix_angle": "12 deg"}, {"main.sun", "main.ring"}, "main.carrier"),
        ({"kind": "star", "teeth": "21/39/99"}, {"main.sun", "main.carrier"}, "main.ring"),
        ({"kind": "parallel", "teeth": "24/95"}, {"main.pinion"}, "main.wheel"),
        ({"kind": "compound", "teeth": "21/60/24/105"}, {"main.sun", "main.ring"}, "main.carrier"),
        ({"kind": "wolfrom", "teeth": "18/39/96/36/93"}, {"main.sun", "main.ring1"}, "main.ring2"),
        (
            {"kind": "planetary,planetary", "ratio": 30.0},
            {"stage1.sun", "stage1.ring", "stage2.ring"},
            "stage2.carrier",
        ),
    ],
)
def test_the_gaps_of_the_file_are_the_backlash_at_the_output(
    keywords: dict[str, Any], fixed: set[str], output: str
) -> None:
    """By a linear programme: torques of the meshes, by which the gaps are split, do not stand in it."""
    train = of_file(**keywords, **SERVO)
    assert play(train, fixed, output) == pytest.approx(3 * ARCMIN, rel=1e-5)
    modules = {body.name: body.gear.module for body in train.bodies if body.gear is not None}
    shares = [mesh.backlash / modules[mesh.a] for mesh in train.meshes]
    assert shares == pytest.approx([shares[0]] * len(shares), rel=1e-5)
    torque = train.kinematics.torque or {}
    assert abs(torque[output]) == pytest.approx(300)


def test_a_high_load_is_told_by_the_limit_of_the_preselection(monkeypatch: pytest.MonkeyPatch) -> None:
    small: dict[str, Any] = {"teeth": "21/39/99", "module": "2 mm", "face_width": "30 mm"}
    assert any("is above 4: rate the strength" in text for text in new_train(**small, **LOAD).remarks)
    assert not any("is above" in text for text in new_train(teeth="21/39/99", **LOAD).remarks)
    monkeypatch.setattr("epicyclic.train.new_train.LOAD_FIGURE", 3e6)
    assert any("is above 3: rate the strength" in text for text in new_train(**small, **LOAD).remarks)


def test_gears_of_two_planes_stand_beside_each_other() -> None:
    """Two modules between the faces; the long planets of a Ravigneaux set reach over both."""
    size: dict[str, Any] = {"module": "3 mm", "face_width": "40 mm"}
    stage = new_train(kind="wolfrom", teeth="18/39/96/36/93", **size, **LOAD).document["stages"]["main"]
    assert stage["planet2"]["station"] == stage["ring2"]["station"] == "46 mm"
    assert "station" not in stage["planet1"]
    stage = new_train(kind="ravigneaux", teeth="27/33/21/24/81", **size, **LOAD).document["stages"]["main"]
    assert (stage["planet2"]["station"], stage["planet2"]["face_width"]) == ("23 mm", "86 mm")
    assert stage["ring"]["station"] == stage["sun2"]["station"] == "46 mm"


def test_shafts_between_stages_have_the_stiffness_of_their_torque() -> None:
    """T = 75 kW/(1000 rpm) 120/21 between both; d^3 = 16 T/(pi 40 MPa), G I_p/(4 d), G = 80.8 GPa."""
    made = new_train(kind="planetary,parallel", teeth="21/39/99,24/95", **LOAD)
    torque = 75e3 / (1000 * math.tau / 60) * 120 / 21
    stiffness = 80.8e9 * math.pi / 32 * (16 * torque / (math.pi * 40e6)) / 4
    (shaft,) = made.document["couplings"].values()
    assert shaft["between"] == ["stage1.carrier", "stage2.pinion"]
    assert float(shaft["rz"].split()[0]) == pytest.approx(stiffness, rel=0.05)
    assert "couplings.stage1-stage2.rz" in made.document["assumed"]


def test_a_ring_without_a_gap_at_its_root_is_said() -> None:
    made = new_train(teeth="21/39/99", centre_distance="65 mm", module="2 mm", speed="1000 rpm", torque="100 N m")
    needs = [str(text) for text in epicyclic.check(made.document).verb_needs.values]
    assert any("stages.main.ring: the gap of the ring is closed at its root" in text for text in needs)
