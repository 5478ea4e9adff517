"""Load cases as the load spectrum of a REXS file: values by hand in the XML, factors as computed, and read back."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.unit.rexs.test_rexs_export import SPUR
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.writer import model_text
from epicyclic.errors import ModelError
from epicyclic.rexs.encodings import read_rexs_file
from epicyclic.rexs.export import rexs_of, write_rexs
from epicyclic.rexs.import_train import import_file, read_rexs

DUTY: dict[str, Any] = {
    **SPUR,
    "cases": {
        "full": {"duration": "900 h"},
        "part": {"speed": {"sun": "700 rpm"}, "torque": {"sun": "300 N m"}, "duration": "9000 h"},
        "back-1": {"torque": {"carrier": "1600 N m"}, "duration": "100 h"},
    },
    "deviations": {"planet": {"position": {"y": "[30, 0, 0] um"}}},
}


@pytest.fixture(scope="module")
def factors() -> xr.Dataset:
    """Of all cases, with a K_Halpha of deviations in place of that of contact, which would take long."""
    found = epicyclic.load_factors(DUTY, overrides={"case": "all"})
    return found.assign(accuracy_load_factor=1.0 + 0.1 * found.branch_load)


@pytest.fixture(scope="module")
def file(factors: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("spectrum") / "duty.rexs"
    write_rexs(factors, target)
    return target


def values(file: Path) -> list[dict[str, dict[str, tuple[str, str]]]]:
    """Of each load case: name of a component -> attribute -> text and unit; by the XML, not by our reader."""
    cases = ElementTree.parse(file).getroot().findall("load_spectrum/load_case")
    return [
        {part.get("name", ""): {a.get("id", ""): (a.text or "", a.get("unit", "")) for a in part} for part in case}
        for case in cases
    ]


def test_times_speeds_and_torques_by_hand(file: Path) -> None:
    full, part, back = values(file)
    assert [case["Spur stage"]["custom_load_case_name"][0] for case in (full, part, back)] == ["full", "part", "back-1"]
    assert part["Spur stage"]["operating_time"] == ("9000.0", "h")
    assert part["Spur stage"]["operating_time_fraction"] == ("90.0", "%")
    assert part["main.sun"] == {"rotational_speed": ("700.0", "1 / min"), "defines_speed": ("true", "none")}
    # ratio 1 + 60 / 20 = 4
    assert part["main.carrier"] == {"rotational_speed": ("175.0", "1 / min"), "defines_speed": ("false", "none")}
    assert float(part["main.carrier torque"]["torque_around_u_axis"][0]) == pytest.approx(-1200)
    assert back["main.carrier torque"] == {
        "torque_around_u_axis": ("1600.0", "N m"),
        "defines_torque": ("true", "none"),
    }
    assert back["main.sun torque"]["defines_torque"] == ("false", "none")
    total = ElementTree.parse(file).getroot().findall("load_spectrum/accumulation/component/attribute")
    assert [(one.get("id"), one.text) for one in total] == [("operating_time", "10000.0")]


def test_factors_and_load_cycles_of_every_mesh(file: Path, factors: xr.Dataset) -> None:
    ids = {
        "mesh_load_factor_iso_6336_2019": "k_gamma",
        "dynamic_factor_iso_6336_2019": "dynamic_factor",
        "face_load_factor_contact_stress_iso_6336_2019": "face_load_factor",
        "transverse_load_factor_contact_stress_iso_6336_2019": "accuracy_load_factor",
    }
    for case, found in zip(factors.case.values, values(file), strict=True):
        for mesh in factors.mesh.values:
            of_mesh = factors.sel(case=case, mesh=mesh)
            expected = {name: (repr(float(of_mesh[own])), "none") for name, own in ids.items()}
            assert found[str(mesh)] == expected
        gears = [own for name, own in found.items() if name.startswith("main/sun-planet/2 gear")]
        cycles = [float(own["number_of_load_cycles"][0]) for own in gears]
        # a tooth of the sun meets three planets in a turn relative to the carrier, one of a planet the sun once
        turns = {"full": 1500 * 900, "part": 700 * 9000, "back-1": 1500 * 100}[case] * 60 * 3 / 4
        np.testing.assert_allclose(cycles, [3 * turns, turns], rtol=1e-12)
        torque = {"full": 800, "part": 300, "back-1": -400}[case]
        np.testing.assert_allclose([float(own["torque"][0]) for own in gears], -torque / 3, rtol=1e-12)


def test_a_face_load_factor_that_is_not_known_is_not_written(factors: xr.Dataset) -> None:
    basis = factors.face_load_basis.copy()
    basis[:, 0] = "not known without slices"
    case = rexs_of(epicyclic.load(DUTY), factors=factors.assign(face_load_basis=basis)).file.load_cases[0]
    found = [part.name for part in case.components if any(name.startswith("face_load") for name in part.attributes)]
    assert found == [str(name) for name in factors.mesh.values[1:]]


@pytest.mark.parametrize("end", [".rexs", ".rexsj", ".rexsz"])
def test_the_file_is_read_back_equal(end: str, factors: xr.Dataset, tmp_path: Path) -> None:
    written = write_rexs(factors, tmp_path / f"duty{end}")
    again = read_rexs_file(tmp_path / f"duty{end}")
    assert replace(again, encoding="xml") == written.file
    paths = [entry.path for entry in written.dropped]
    assert {"load_factors.flank_equivalent_torque", "load_factors.flank_cycles"} <= set(paths)
    assert not any(path.startswith("cases") for path in paths)


def test_load_cases_are_read_as_they_were_written(file: Path) -> None:
    found = read_rexs(file)
    assert found.document["cases"] == DUTY["cases"]
    for case in DUTY["cases"]:
        here, there = (epicyclic.load(one, overrides={"case": case}) for one in (DUTY, dict(found.document)))
        assert here.kinematics.torque == pytest.approx(there.kinematics.torque)
        assert here.kinematics.speed == there.kinematics.speed
    assert any(entry.path == "cases.part" and entry.text == "speed, torque, duration" for entry in found.read)


def test_export_writes_load_cases_without_factors() -> None:
    document = copy.deepcopy(DUTY)
    for name, share in (("full", 0.5), ("part", 0.25), ("back-1", 0.125)):
        document["cases"][name] = {**document["cases"][name], "share": share}
        del document["cases"][name]["duration"]
    exported = rexs_of(epicyclic.load(document))
    assert exported.file.accumulations == ()
    kinds = {part.type for case in exported.file.load_cases for part in case.components}
    assert kinds == {"gear_unit", "shaft", "external_load"}
    assert import_file(exported.file).document["cases"] == document["cases"]


def test_what_a_load_case_cannot_say_is_listed() -> None:
    document = copy.deepcopy(DUTY)
    document["cases"]["part"]["loads"] = {"pull": {"on": "sun", "force": {"x": "1 N"}}}
    document["cases"]["overdrive"] = {"held": ["sun"], "speed": {"ring": "100 rpm"}, "torque": {"ring": "100 N m"}}
    document["cases"]["wrong"] = {"torque": {"sun": "1 N m", "carrier": "1 N m"}}
    exported = rexs_of(epicyclic.load(document))
    told = {entry.path: entry.text for entry in exported.dropped}
    assert "held members of a load case have no place" in told["cases.overdrive"]
    assert "not determined" in told["cases.wrong"]
    assert any(path.startswith("cases.part.loads.pull") for path in told)
    assert len(exported.file.load_cases) == 3


def test_a_model_without_cases_is_one_load_case(tmp_path: Path) -> None:
    alone = {name: table for name, table in DUTY.items() if name != "cases"}
    write_rexs(epicyclic.load_factors(alone), tmp_path / "one.rexs")
    (case,) = values(tmp_path / "one.rexs")
    assert "operating_time" not in case["Spur stage"]
    assert "dynamic_factor_iso_6336_2019" in case["main/planet-ring/3"]
    assert "cases" not in read_rexs(tmp_path / "one.rexs").document


def times(draft: Any, *cases: Mapping[str, tuple[Any, str]]) -> Any:
    """What the load cases of a file become; the first has the speed of the file."""
    draft.components[1] = ("gear_unit", "unit", draft.components.get(1, ("", "", {}))[2])
    draft.load_cases = {i: {1: dict(case)} for i, case in enumerate(cases, start=1)}
    return import_file(read_rexs_file(draft.xml().encode()))


def test_times_of_older_versions_and_rounded_shares(draft: Any) -> None:
    found = times(draft, {"load_duration": (30.0, "min")}, {"load_duration_fraction": (40.0, "%")})
    assert found.document["cases"] == {"case1": {"duration": "30 min"}}
    found = times(draft, {"load_duration_fraction": (40.0, "%")}, {"operating_time_fraction": (60.0, "%")})
    assert found.document["cases"] == {"case1": {"share": 0.4}, "case2": {"share": 0.6}}
    found = times(draft, *[{"operating_time_fraction": (33.4, "%")}] * 3)
    assert found.document["cases"] == {f"case{i}": {} for i in (1, 2, 3)}
    assert any("add up to 1.002" in entry.text for entry in found.dropped)


def test_names_that_are_none_or_taken_are_those_of_the_ids(draft: Any) -> None:
    one = {"operating_time": (1.0, "h")}
    names = ("rated", "rated", "all", "two words", 'x"]')
    found = times(draft, *({**one, "custom_load_case_name": (name, "none")} for name in names))
    assert list(found.document["cases"]) == ["rated", "case2", "case3", "case4", "case5"]


def test_the_command_writes_the_file_and_says_what_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "duty.toml").write_text(model_text(DUTY), encoding="utf-8")
    words = ["load-factors", str(tmp_path / "duty.toml"), "--case", "part", "-o", str(tmp_path / "duty.rexs")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "not carried: load_factors.flank_equivalent_torque: follows from" in done.stderr
    full, part, _ = values(tmp_path / "duty.rexs")
    assert "main/sun-planet/1" in part
    assert "main/sun-planet/1" not in full


def test_a_result_of_another_verb_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"check: no load factors; allowed: a result of load_factors"):
        write_rexs(epicyclic.check(DUTY), tmp_path / "check.rexs")
    assert not (tmp_path / "check.rexs").exists()
