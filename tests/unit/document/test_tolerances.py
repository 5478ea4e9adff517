"""`[tolerance]`: distributions of the quantity that stands at the path."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from epicyclic.document.document import Document, read
from epicyclic.document.tolerances import tolerances
from epicyclic.errors import ModelError
from epicyclic.train.resolution import load, tolerances_of

PLAIN = read("ren2021", {"tolerance": None}).data
RUN_OUT = "deviations.main.sun.run_out.amplitude"


def toleranced(path: str, text: object) -> Document:
    return read(PLAIN, {"tolerance": {path: text}})


@pytest.mark.parametrize(
    ("path", "text"),
    [
        (RUN_OUT, "normal(0, 12 um)"),
        (RUN_OUT, "normal(20 um, 0 um)"),
        (RUN_OUT, "normal( -20um , 0.012 mm )"),
        (RUN_OUT, "uniform(-5 um, 5 um)"),
        (RUN_OUT, "uniform(0, 0)"),
        ("deviations.main.planet.position.y", "normal(0, 12 um)"),  # not given, but could be
        ("deviations.main.meshes.sun-planet.profile.amplitude", "normal(0, 12 um)"),
        ("stages.main.sun.support.radial", "normal(1e9 N/m, 1e8 N/m)"),
        ("stages.main.sun.inertia", "normal(663 kg, 3 kg)"),
        ("stages.main.sun.inertia", "normal(90 kg m^2, 3 kg m^2)"),
        ("stages.main.meshes.sun-planet.stiffness", "normal(20 N/(mm um), 1 N/(mm um))"),
        ("stages.main.sun.profile_shift", "normal(0.1, 0.01)"),
        ("damping.modal", "uniform(1 %, 3 %)"),
        (RUN_OUT, "truncated(0, 12 um, -20 um, 20 um)"),
        (RUN_OUT, "triangular(0, 5 um, 20 um)"),
        (RUN_OUT, "grade(ISO 1328-1:2013 5, 3 sigma)"),
        ("deviations.main.planet.run_out", "rayleigh(5 um)"),
        ("deviations.main.planet.run_out", "normal(0, 5 um)"),  # of its amplitude
        ("deviations.main.planet.bearing_run_out", "disc(10 um)"),
        ("deviations.main.planet.position", "disc(10 um)"),
        ("deviations.main.planet.position", "grade(IT6, 3 sigma)"),
        ("deviations.main.planet.tilt", "rayleigh(0.1 mrad)"),
        ("deviations.main.meshes.sun-planet.gap", "normal(0, 8 um)"),
        ("deviations.main.meshes.sun-planet.profile", "normal(0, 8 um)"),
        ("operation.torque.main.sun", "normal(100 kN m, 5 kN m)"),
        ("stages.main.planet.bearing.radial", "uniform(0.9e9 N/m, 1.1e9 N/m)"),
    ],
)
def test_taken(path: str, text: str) -> None:
    document = toleranced(path, text)
    assert document.model.tolerance == {path: text}
    if "grade" not in text:
        (entry,) = tolerances(document)
        assert entry.path == path
        assert (entry.own.text if entry.own else "") == text


@pytest.mark.parametrize(
    ("path", "text", "problem", "allowed"),
    [
        (RUN_OUT, "normal(0, -12 um)", "its deviation is below zero", "deviation >= 0"),
        (RUN_OUT, "uniform(5 um, -5 um)", "wrong order", "low <= high"),
        (RUN_OUT, "normal(0, 12 kg)", "another kind of quantity", "length (m, mm, um)"),
        (RUN_OUT, "normal(20 kg, 12 um)", "another kind of quantity", "length (m, mm, um)"),
        (RUN_OUT, "normal(0, 12)", 'without a unit: "12 um"?', "length"),
        (RUN_OUT, "normal(0, inf)", "must be finite", "length"),
        (RUN_OUT, "normal(0, wide)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(0)", "not a distribution", "uniform(low, high)"),
        (RUN_OUT, "triangle(0, 1 um)", "not a distribution", "uniform(low, high)"),
        (RUN_OUT, 12, "not a distribution", "uniform(low, high)"),
        ("stages.main.sun.inertia", "normal(663 kg, 3 kg m^2)", "mixes kinds", "kg m^2 or kg"),
        ("stages.main.sun.profile_shift", "normal(0.1 mm, 0.01)", "another kind", "number"),
        ("deviations.main.sun.position.q", "normal(0, 1 um)", "no such path", "a path a number can stand at"),
        ("stages.main.sun.hand", "normal(0, 1 um)", "no such path", "a path a number can stand at"),
        (RUN_OUT, "normal(nan, 1 um)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(+., 1 um)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(.e5, 1 um)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(1.2.3, 1 um)", "unit not known", "length"),
        (RUN_OUT, "normal(1e9999, 1 um)", "must be finite", "length"),
        (RUN_OUT, "normal((((0, 1 um)", "not a number with a unit", "length"),
        (RUN_OUT, "normal(0, 1e400 um)", "too large", "length"),
        (RUN_OUT, "truncated(0, 1 um, 2 um, 1 um)", "wrong order", "low <= high"),
        (RUN_OUT, "truncated(0, 1 um, 20 um, 21 um)", "leave nothing", "1e-6"),
        (RUN_OUT, "triangular(0, 3 um, 2 um)", "wrong order", "low <= mode <= high"),
        (RUN_OUT, "disc(10 um)", "of a vector", "a vector is the table of x and y"),
        (RUN_OUT, True, "not a distribution", "normal"),
        (RUN_OUT, [1, 2], "not a distribution", "normal"),
        ("deviations.main.planet.run_out", "disc(10)", 'without a unit: "10 um"?', "length"),
        ("deviations.main.planet.run_out", "disc(10 kg)", "another kind", "length"),
        ("deviations.main.planet.run_out", "disc(-10 um)", "its diameter is below zero", "diameter >= 0"),
        ("deviations.main.planet.run_out", "rayleigh(-1 um)", "its deviation is below zero", "deviation >= 0"),
        ("deviations.main.planet.run_out", "grade(IT6)", "not a grade known here", "3 sigma"),
        ("deviations.main.planet.run_out", "grade(AGMA 5, 3 sigma)", "not a grade known here", "ISO 1328-1:2013"),
        ("deviations.main.planet.position", "grade(IT6, 0.1 sigma)", "standard deviations", "0.5 to 10 sigma"),
        ("stages.main.sun.support.radial", "grade(IT6, 3 sigma)", "a grade of a length", "stiffness"),
        ("operation.torque.main.sun", "normal(100 kN m, 5 kN)", "another kind of quantity", "torque"),
        # counts, and what no number of the model is
        ("stages.main.sun.teeth", "uniform(20, 30)", "a count", "varies"),
        ("stages.main.planets", "uniform(3, 5)", "a count", "varies"),
        ("deviations.main.meshes.sun-planet.profile.order", "uniform(1, 3)", "a count", "varies"),
        ("stages.main.meshes.sun-planet.slices", "uniform(1, 3)", "a count", "varies"),
        ("deviations.main.meshes.sun-planet.errors.mine.amplitude", "normal(0, 1 um)", "turns_with: missing", "a path"),
        ("loads.mine.force.x", "normal(1 kN, 5 N)", "loads.mine.on: missing", "a path"),
        ("couplings.mine.x", "normal(1 N/m, 5 N/m)", "between: missing", "a path"),
        ("bodies.mine.mass", "normal(1 kg, 5 g)", "bodies is not given", "a path"),
        ("stages.main.sun.support.front.x", "normal(1 N/m, 0 N/m)", "front is not given", "a path"),
        ("stages.main.sun.shaft.x", "normal(1 N/m, 0 N/m)", "shaft is not given", "a path"),
        ("operation.torque.main.carrier", "normal(1 kN m, 0)", "carrier is not given", "a path"),
        ("operation.held", "normal(1, 0)", "no such path", "a path"),
        ("title", "normal(1, 0)", "no such path", "a path"),
        ("stages.main.bun.mass", "normal(1 kg, 0)", "no such path", "a path"),
        # what the value at the path may be
        ("damping.modal", "normal(2, 0.1)", "2 in SI, cannot stand there", "below 1"),
        ("damping.modal", "uniform(-1, 0.1)", "-0.45 in SI, cannot stand there", "at least 0"),
    ],
)
def test_refused_with_its_path(path: str, text: object, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        toleranced(path, text)
    assert error.value.path.startswith("tolerance.")
    assert problem in str(error.value)
    assert allowed in error.value.allowed
    assert str(text) in str(error.value)


@pytest.mark.parametrize(
    ("overrides", "path"),
    [
        ({"operation.torque.carrier": "balance"}, "operation.torque.main.carrier"),
        ({"stages.main.meshes.sun-planet.stiffness": "energy"}, "stages.main.meshes.sun-planet.stiffness"),
    ],
)
def test_a_word_is_no_number(overrides: dict[str, object], path: str) -> None:
    text = "normal(1 kN m, 0)" if "torque" in path else "normal(1e9 N/m, 0 N/m)"
    with pytest.raises(ModelError, match="a word stands there") as error:
        read(PLAIN, overrides | {"tolerance": {path: text}})
    assert error.value.path == f"tolerance.{path}"


def test_a_text_or_path_of_200_kB_is_no_page_of_a_message() -> None:
    for table in ({RUN_OUT: "normal(" * 30_000}, {"a" * 200_000: "normal(0, 1 um)"}, {RUN_OUT: {"own": "(" * 200_000}}):
        with pytest.raises(ModelError) as error:
            read(PLAIN, {"tolerance": table})
        assert len(str(error.value)) < 1000


PIECES = [*"normal disc grade rayleigh ( ) , . + - e 0 1 12 um kg IT6 sigma".split(), " "]


@settings(max_examples=60, deadline=None)
@given(st.one_of(st.text(max_size=40), st.lists(st.sampled_from(PIECES), max_size=12).map("".join)))
def test_any_text_is_read_or_refused(text: str) -> None:
    for path in (RUN_OUT, "deviations.main.planet.run_out"):
        refused, read_as = "", [text]
        try:
            read_as = [
                one.own.text for one in tolerances_of(load(PLAIN, {f"tolerance.{path}": {"own": text}})) if one.own
            ]
        except ModelError as error:
            refused = error.path
        assert read_as == [text]
        assert refused.startswith("tolerance") or not refused


SHARED = "deviations.main.planet.run_out"


@pytest.mark.parametrize(
    ("value", "at", "problem", "allowed"),
    [
        ({}, "", "says nothing", "own"),
        ({"own": 3}, ".own", "not a distribution", "normal"),
        ({"own": "disc(1 um)", "comon": "disc(1 um)"}, ".comon", "did you mean 'common'", "own, common, phase"),
        ({"own": "disc(1 um)", "common": "normal(0, 1 um)"}, ".common", "of a number, where a vector", "disc"),
        ({"own": "normal(0, 1 um)", "common": "normal(0, 1 kg)"}, ".common", "another kind", "length"),
        ({"own": "disc(1 um)", "phase": "best"}, ".phase", "no phase of assembly", "random or marked"),
        ({"own": "normal(0, 1 um)", "phase": "marked"}, ".phase", "no tooth to mark", "run_out"),
        ({"own": {"mean": 1}}, ".own.mean", "no such path", "a path"),
    ],
)
def test_wrong_own_and_common(value: dict[str, object], at: str, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        toleranced(SHARED, value)
    assert error.value.path == f"tolerance.{SHARED}{at}"
    assert problem in error.value.problem
    assert allowed in error.value.allowed


PIN = "deviations.main.planet.position"


@pytest.mark.parametrize(
    "value",
    ["uniform(-20 um, 20 um)", "normal(0, 7 um)", {"own": "normal(0, 7 um)"}, {"common": "triangular(0, 1 um, 2 um)"}],
)
def test_a_pin_takes_no_distribution_of_a_number(value: object) -> None:
    with pytest.raises(ModelError, match="along the radius") as error:
        toleranced(PIN, value)
    assert error.value.path == f"tolerance.{PIN}"
    assert '"disc(diameter)"' in error.value.allowed
    assert f"{PIN}.y" in error.value.allowed
    fixed = read(PLAIN, {PIN: "20 um"})  # one number keeps its meaning, along the radius
    assert fixed.data["deviations"]["main"]["planet"]["position"] == {"amplitude": "20 um"}


@pytest.mark.parametrize("path", [PIN, RUN_OUT])
def test_a_wrong_distribution_names_all_kinds(path: str) -> None:
    with pytest.raises(ModelError) as error:
        toleranced(path, "triangel(1 um)")
    for kind in ("normal(", "uniform(", "truncated(", "triangular(", "rayleigh(", "disc(", "grade("):
        assert f'"{kind}' in error.value.allowed


@pytest.mark.parametrize("path", ["deviations.main.sun.run_out", "deviations.main.planet.position"])
def test_only_teeth_of_planets_are_marked(path: str) -> None:
    with pytest.raises(ModelError, match="no tooth to mark"):
        toleranced(path, {"own": "disc(1 um)", "phase": "marked"})


def test_a_single_member_has_no_common_part() -> None:
    with pytest.raises(ModelError, match="a single one") as error:
        toleranced("deviations.main.sun.run_out", {"own": "disc(1 um)", "common": "disc(1 um)"})
    assert error.value.path == "tolerance.deviations.main.sun.run_out.common"


def test_each_planet_draws_for_itself_and_a_common_part_once() -> None:
    table = {
        SHARED: {"own": "disc(4 um)", "common": "rayleigh(1 um)", "phase": "marked"},
        "deviations.main.meshes.sun-planet.gap": {"common": "uniform(-1 um, 1 um)"},
        "deviations.main.sun.run_out": "disc(2 um)",
        "stages.main.planet.bearing.radial": "normal(1e9 N/m, 1e7 N/m)",
        "stages.main.planet.mass": "normal(525 kg, 2 kg)",  # one number for all planets
        "operation.torque.main.sun": "normal(100 kN m, 5 kN m)",
    }
    found = {entry.path: entry for entry in tolerances(read(PLAIN, prefixed(table)))}
    assert list(found) == list(table)
    planet = found[SHARED]
    assert planet.own is not None
    assert planet.common is not None
    assert (planet.own.kind, planet.own.std, planet.common.std) == ("disc", 1e-6, 1e-6)
    assert (planet.phase, planet.unit, planet.count, planet.vector) == ("marked", "m", 3, True)
    assert [entry.count for entry in found.values()] == [3, 3, 1, 3, 1, 1]
    assert [entry.vector for entry in found.values()] == [True, False, True, False, False, False]
    assert [entry.unit for entry in found.values()] == ["m", "m", "m", "N/m", "kg", "N m"]
    assert found["deviations.main.meshes.sun-planet.gap"].own is None


def prefixed(table: Mapping[str, object]) -> dict[str, object]:
    return {f"tolerance.{path}": value for path, value in table.items()}


def test_a_document_and_its_tables_have_the_same_entries() -> None:
    document = toleranced(SHARED, {"own": "disc(4 um)", "common": "rayleigh(1 um)"})
    assert tolerances(document) == tolerances(document.data)
    assert tolerances(read("lin1999-n4")) == ()
    with pytest.raises(ModelError, match="size of this grade is not known"):
        tolerances(toleranced(RUN_OUT, "grade(IT6, 3 sigma)"))


def test_pitch_deviations_in_a_file_do_not_matter(tmp_path: Path) -> None:
    (tmp_path / "pitch.csv").write_text("\n".join(["1e-6"] * 23))
    text = resources.files("epicyclic.systems").joinpath("ren2021.toml").read_text()
    model = tmp_path / "model.toml"
    model.write_text(text.replace("[deviations]", '[deviations]\nsun.pitch = "pitch.csv"'))
    assert tolerances(read(model, {"tolerance": None, f"tolerance.{SHARED}": "disc(1 um)"}).data)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("planet.run_out", "main.planet.run_out"),
        ("planet.run_out", "planet.run_out.x"),
        ("planet.run_out.y", "planet.run_out.amplitude"),
    ],
)
def test_a_number_is_drawn_once(first: str, second: str) -> None:
    texts = {name: "disc(1 um)" if name.endswith("run_out") else "normal(0, 1 um)" for name in (first, second)}
    with pytest.raises(ModelError, match=r"given twice|draws what") as error:
        toleranced_all({f"deviations.{name}": text for name, text in texts.items()})
    assert error.value.path.startswith("tolerance.deviations.")


def test_a_tolerance_beside_that_of_the_file_says_how_the_other_is_removed() -> None:
    """What the refusal of a number for a pin names is taken once the zone of the file is removed."""
    filed = toleranced_all({PIN: "disc(40 um)"}).data
    tangential = {f"tolerance.{PIN}.y": "uniform(-20 um, 20 um)"}
    with pytest.raises(ModelError, match="draws what") as error:
        read(filed, tangential)
    assert "an empty value removes" in str(error.value.allowed)
    (entry,) = tolerances(read(filed, {**tangential, f"tolerance.{PIN}": ""}))
    assert entry.path == f"{PIN}.y"


def toleranced_all(table: Mapping[str, object]) -> Document:
    return read(PLAIN, {"tolerance": table})


def test_radial_is_one_number_of_two_directions() -> None:
    radial = {"stages.main.sun.support.radial": "normal(1e9 N/m, 1e8 N/m)"}
    (entry,) = tolerances(toleranced_all(radial))
    assert entry.path == "stages.main.sun.support.radial"
    with pytest.raises(ModelError, match="draws what"):
        toleranced_all(radial | {"stages.main.sun.support.y": "normal(1e9 N/m, 1e8 N/m)"})


def test_an_override_replaces_removes_and_completes_an_entry() -> None:
    base = {f"tolerance.{SHARED}": {"own": "disc(1 um)", "common": "disc(2 um)"}}
    document = read(PLAIN, base)
    assert document.model.tolerance == {SHARED: {"own": "disc(1 um)", "common": "disc(2 um)"}}
    source = document.data
    assert read(source, {f"tolerance.{SHARED}.common": "disc(3 um)"}).model.tolerance[SHARED]["own"] == "disc(1 um)"
    assert read(source, {f"tolerance.{SHARED}": "disc(3 um)"}).model.tolerance == {SHARED: "disc(3 um)"}
    assert read(source, {f"tolerance.{SHARED}": None}).model.tolerance == {}


@pytest.mark.parametrize(
    "overrides",
    [
        {"operation.power.sun": "1 MW"},
        {"operation.torque.sun": "balance", "operation.torque.carrier": "500 kN m"},
        {"operation.torque.sun": None, "operation.torque.carrier": "500 kN m"},
    ],
)
def test_an_override_takes_the_tolerance_of_a_number_that_it_removes(overrides: dict[str, object]) -> None:
    torque = "operation.torque.main.sun"
    table = {torque: "normal(100 kN m, 0)", "operation.speed.sun": "normal(100 rpm, 1 rpm)", SHARED: "disc(1 um)"}
    more = {
        "cost": {torque: {"normal(100 kN m, 0)": 3}},
        "correlation": {torque: {"operation.speed.sun": 0.5}},
    }
    source = toleranced_all(table | more).data
    assert set(source["tolerance"]) == {torque, "operation.speed.main.sun", SHARED, "cost", "correlation"}
    left = {"operation.speed.main.sun": "normal(100 rpm, 1 rpm)", SHARED: "disc(1 um)", "cost": {}, "correlation": {}}
    assert read(source, overrides).model.tolerance == left
    with pytest.raises(ModelError, match="no such path"):  # not of a tolerance that is stated with them
        read(source, overrides | {f"tolerance.{torque}": "normal(1 kN m, 0)"})


# prices --------------------------------------------------------------------------------------------------------------


def priced(grades: object, path: str = SHARED) -> Document:
    return toleranced_all({SHARED: "disc(4 um)", "cost": {path: grades}})


def test_prices_in_the_order_of_the_file() -> None:
    (entry,) = tolerances(priced({"disc(2 um)": 30, "rayleigh(1 um)": 12.5}, "deviations.planet.run_out"))
    assert [(grade.text, grade.distribution.kind, grade.price) for grade in entry.grades] == [
        ("disc(2 um)", "disc", 30.0),
        ("rayleigh(1 um)", "rayleigh", 12.5),
    ]


@pytest.mark.parametrize(
    ("grades", "problem", "allowed"),
    [
        ({}, "no grades", "prices"),
        (3, "no grades", "prices"),
        ({"disc(2 um)": -1}, "not a price", "currency"),
        ({"disc(2 um)": "3 EUR"}, "not a price", "currency"),
        ({"disc(2 um)": True}, "not a price", "currency"),
        ({"disc(2 um)": 1e20}, "not a price", "currency"),
        ({"disk(2 um)": 1}, "no 'disk'", "disc"),
        ({"disc(2 kg)": 1}, "another kind", "length"),
        ({"normal(0, 2 um)": 1}, "where a vector stands", "disc"),
    ],
)
def test_what_is_no_price(grades: object, problem: str, allowed: str) -> None:
    with pytest.raises(ModelError) as error:
        priced(grades)
    assert error.value.path.startswith(f"tolerance.cost.{SHARED}")
    assert problem in error.value.problem
    assert allowed in error.value.allowed


def test_prices_belong_to_a_tolerance() -> None:
    with pytest.raises(ModelError, match="no tolerance at this path; did you mean") as error:
        priced({"disc(2 um)": 1}, "deviations.main.planet.run_ou")
    assert error.value.path == "tolerance.cost.deviations.main.planet.run_ou"
    for name in ("cost", "correlation"):
        with pytest.raises(ModelError, match="not a table"):
            load(PLAIN, {"tolerance": {name: 3}})


def test_an_error_of_a_mesh_has_its_tolerance() -> None:
    path = "deviations.main.meshes.sun-planet.errors.mine"
    error = {"turns_with": "sun", "amplitude": "20 um", "phase": "[0, 120, 240] deg"}
    spreads = {f"{path}.amplitude": "normal(20 um, 5 um)", f"{path}.phase": "uniform(0 deg, 360 deg)"}
    document = read(PLAIN, {"deviations.meshes.sun-planet.errors.mine": error, "tolerance": spreads})
    assert dict(document.model.tolerance) == spreads


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("stages.main.planet_angles", "normal(0, 1 deg)"),
        ("stages.main.meshes.sun-planet.variation.cosine", "normal(0, 0.1)"),
        ("deviations.sun.pitch", "normal(0, 1 um)"),
    ],
)
def test_a_list_is_no_number_that_varies(path: str, text: str) -> None:
    with pytest.raises(
        ModelError, match=r"^tolerance\..*: a list, no number; allowed: a quantity that is one"
    ) as error:
        toleranced(path, text)
    assert error.value.path.startswith(f"tolerance.{path.split('.')[0]}.")
    assert error.value.given == text


@pytest.mark.parametrize("table", ["tolerance", "assumed"])
@pytest.mark.parametrize(
    "path",
    [
        "stages.main.meshes.sun-foo.backlash",
        "deviations.meshes.foo-sun.gap",
        "operation.torque.foo",
        "deviations.foo.run_out.x",
        "stages.main.sun.on.left",
    ],
)
def test_a_path_that_is_none_is_named_in_its_table(table: str, path: str) -> None:
    with pytest.raises(ModelError) as error:
        read(PLAIN, {table: {path: "normal(0, 1 um)"}})
    assert error.value.path.replace(".main.", ".") == f"{table}.{path}".replace(".main.", ".")
    assert error.value.given in ("normal(0, 1 um)", path)
