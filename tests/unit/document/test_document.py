"""Reading: the document of good files, sources that are none, numpy values."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from epicyclic.document.document import read, ready_drives
from epicyclic.document.tables import value_text
from epicyclic.document.units import Quantity
from epicyclic.errors import ModelError

GOOD = Path(__file__).parents[2] / "files" / "good"
FILES = sorted(GOOD.glob("*.toml"))


def test_good_files_are_found() -> None:
    assert len(FILES) == 7
    assert "ren2021" in ready_drives()


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_written_document_is_the_same_document(path: Path) -> None:
    first = read(path)
    again = read(tomllib.loads(f"a = {value_text(first.data)}")["a"])
    assert again.model == first.model
    assert again.data == first.data
    assert value_text(again.data) == value_text(first.data)
    assert set(first.origin.values()) == {"given"}


@pytest.mark.parametrize("name", ready_drives())
def test_ready_drives_are_read(name: str) -> None:
    document = read(name)
    assert document.source == name
    assert document.model.title == document.data["title"]


def test_ren2021() -> None:
    model = read("ren2021").model
    stage = model.stages["main"]
    assert (stage.planets, stage.module, stage.herringbone) == (3, 0.032, True)
    assert [m.kind for m in stage.members.values()] == ["sun", "planet", "ring", "carrier"]
    assert stage.members["sun"].inertia == Quantity(value=663.0, unit="kg")
    assert stage.members["ring"].support is not None
    assert stage.members["ring"].support.rz == Quantity(value=1e10, unit="N/m")
    assert model.operation.held == ("main.ring",)
    # one rounding of pi / 30
    assert model.operation.speed == {"main.sun": pytest.approx(100 * math.pi / 30, rel=1e-15)}
    assert model.operation.torque == {"main.sun": 1e5}
    profile = model.deviations.meshes["main.meshes.sun-planet"].profile
    assert profile is not None
    assert (profile.amplitude, profile.order, profile.phase) == (2e-5, 1, "identical")
    assert set(model.assumed) == {"damping.modal", "stages.main.module", "operation.torque.main.sun", "tolerance"}


def test_encased_differential() -> None:
    model = read(GOOD / "encased-differential.toml").model
    assert {name: stage.branches for name, stage in model.stages.items()} == {"differential": 3, "encased": 5}
    assert model.couplings["ring-g1"].between == ("differential.ring", "g1")
    assert model.couplings["ring-g1"].rz == Quantity(value=1e10, unit="N/m")
    assert model.couplings["g1-f1"].rz == Quantity(value=2.7e9, unit="N m/rad")
    assert model.operation.gravity == (0.0, -9.81, 0.0)
    assert model.operation.torque == {"output": "balance"}
    run_out = model.deviations.members["differential.planet"].run_out
    assert run_out is not None
    # one rounding of pi / 180
    assert run_out.phase == pytest.approx((0, 2 * math.pi / 3, 4 * math.pi / 3), rel=1e-15)
    profile = model.deviations.meshes["differential.meshes.planet-ring"].profile
    assert profile is not None
    assert (profile.phase, profile.seed) == ("random", 2)


def test_special_features() -> None:
    stars = read(GOOD / "stepped-stars.toml").model
    star2 = stars.stages["main"].members["star2"]
    assert (star2.on, star2.clocking, star2.kind) == ("main.star1", "fit", "planet")
    position = stars.deviations.members["main.star1"].position
    assert position is not None
    assert position.y == (1.2e-5, 0.0, 0.0, 0.0, 0.0)
    split = read(GOOD / "split-herringbone.toml").model
    assert split.operation.torque == {"main.sun.right": -1.5e5}
    assert split.couplings["output-shaft"].between == ("main.sun.right", "output")
    neck = split.stages["main"].members["sun"].neck
    assert neck is not None
    assert (neck.torsional_rigidity, neck.x, neck.y, neck.z, neck.rz) == (5.2e7, 5e9, 5e9, 2e10, None)
    pinion = read(GOOD / "parallel.toml").model.stages["high"].members["pinion"]
    assert pinion.kind == "gear"
    assert pinion.support is not None
    assert {name: link.at for name, link in pinion.support.bearings.items()} == {"front": -0.3, "rear": 0.3}


def test_every_key() -> None:
    document = read(GOOD / "every-key.toml")
    stage = document.model.stages["main"]
    mesh = stage.meshes["sun-planet"]
    assert mesh.stiffness == Quantity(value=2e10, unit="N/m^2")
    assert mesh.variation is not None
    assert (mesh.variation.form, mesh.variation.cosine) == ("series", (0.1, 0.05))
    assert mesh.backlash == 2e-4
    assert mesh.right is not None
    assert mesh.right.variation is not None
    assert mesh.right.variation.form == "values"
    planet_ring = stage.meshes["planet-ring"]
    assert planet_ring.variation is not None
    assert (planet_ring.stiffness, planet_ring.variation.form) == ("energy", "none")
    bearing = stage.members["planet"].bearing
    assert bearing is not None
    assert (bearing.x, bearing.rx) == ((1e8, 2e8, 3e8), 0.0)
    assert bearing.damping is not None
    assert (bearing.damping.x, bearing.damping.z, bearing.damping.rz) == (500.0, None, 2.0)
    load = document.model.loads["rotor"]
    assert (load.on, load.force.z, load.moment.y, load.at) == ("output", -2000.0, 3000.0, 0.1)
    meshes = document.model.deviations.meshes
    assert meshes["main.meshes.sun-planet.left"].gap == 1e-6
    assert document.model.deviations.members["main.sun.left"].run_out is not None
    assert "stages.main.sun.support.y" in document.model.assumed


def test_numpy_values_in_a_dict() -> None:
    document = read(
        {
            "format": np.int64(2),
            "title": "numpy",
            "notes": None,
            "stages": {
                "a": {
                    "planets": 3,
                    "module": np.float64(0.002),
                    "sun": {"teeth": np.int32(20)},
                    "planet": {"teeth": 20},
                }
            },
            "deviations": {"planet": {"run_out": np.array([1e-6, 0.0, 0.0])}},
        }
    )
    assert document.source == "dict"
    run_out = document.model.deviations.members["a.planet"].run_out
    assert run_out is not None
    assert run_out.amplitude == (1e-6, 0.0, 0.0)


def test_pitch_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "pitch.csv").write_text("# measured\ntooth, pitch [um]\n" + "".join(f"{i}, {i}\n" for i in range(23)))
    text = (
        'format = 2\ntitle = "x"\n[stages.a]\nmodule = "1 m"\nsun = {teeth = 23}\n'
        '[deviations]\nsun.pitch = "pitch.csv"\n'
    )
    (tmp_path / "a.toml").write_text(text)
    pitch = read(tmp_path / "a.toml").model.deviations.members["a.sun"].pitch
    assert pitch is not None
    assert pitch[0] == tuple(float(f"{i}e-6") for i in range(23))
    # the document holds the numbers, not the name, in a list for each planet and in an override too
    found = read(tmp_path / "a.toml", {"deviations.sun.left.pitch": ["pitch.csv"]})
    assert "pitch.csv" not in str(found.data)
    (tmp_path / "pitch.csv").unlink()
    assert read(found.data).model == found.model
    (tmp_path / "pitch.csv").write_text("1\n2\nx\n")
    with pytest.raises(ModelError, match=r"deviations\.sun\.pitch = x: pitch\.csv, line 3: pitch is not"):
        read(tmp_path / "a.toml")


def test_sources_that_are_none(tmp_path: Path) -> None:
    (tmp_path / "loop.toml").symlink_to(tmp_path / "loop.toml")
    cases: list[tuple[object, str]] = [
        (tmp_path / "none.toml", "no such file"),
        ("ren2012", "did you mean 'ren2021'"),
        (tmp_path, "is a folder"),
        ("/dev/zero", "no regular file"),
        (tmp_path / "loop.toml", "cannot be read"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read"),
        (3, "not a model"),
        (None, "not a model"),
    ]
    for source, problem in cases:
        with pytest.raises(ModelError, match=problem):
            read(source)  # type: ignore[arg-type]


def test_tables_that_hold_themselves() -> None:
    table: dict[str, object] = {"format": 2, "title": "x"}
    table["stages"] = table
    with pytest.raises(ModelError, match="nested too deeply"):
        read(table)


def test_an_assumption_is_named_as_it_is_written() -> None:
    data = read("ren2021").data
    for path in ("deviations.planet.positon", "stages.main.carrier.bearing.tilt", "stages.main.sun.support.radil"):
        with pytest.raises(ModelError, match="no such path") as error:
            read(data, {"assumed": {path: "a guess"}})
        assert error.value.path == f"assumed.{path}"
        assert "assumed" not in str(error.value).partition(":")[2]  # it is not its own nearest path


@pytest.mark.parametrize("axes", [("rx",), ("ry",), ("rx", "ry")])
def test_a_body_that_tilts_needs_an_inertia_about_its_axis_of_tilt(axes: tuple[str, ...]) -> None:
    support = {"radial": "1e8 N/m"} | dict.fromkeys(axes, "1e6 N m/rad")
    flange = {"mass": "10 kg", "inertia": "1 kg m^2", "support": support}
    with pytest.raises(ModelError, match=r"^bodies\.flange\.tilt_inertia: missing"):
        read("ren2021", {"bodies": {"flange": flange}})
    assert read("ren2021", {"bodies": {"flange": {**flange, "tilt_inertia": "0.5 kg m^2"}}}).model.bodies


@pytest.mark.parametrize("version", [1, 0, 2.0, 1.0, 2.5, True, "2", [2]])
def test_a_format_is_the_one_that_is_described(version: object) -> None:
    allowed = r"; allowed: format = 2, described in docs/reference/model-file\.md$"
    with pytest.raises(ModelError, match=r"^format = .*: no version that this program reads" + allowed) as error:
        read(read("ren2021").data | {"format": version})
    assert (error.value.path, error.value.given) == ("format", version)
    with pytest.raises(ModelError, match=r"^format = "):
        read("ren2021", {"format": version})
    with pytest.raises(ModelError, match=r"^format: missing" + allowed):
        read({name: table for name, table in read("ren2021").data.items() if name != "format"})


def test_what_is_allowed_of_a_list() -> None:
    data = read("ren2021").data
    for path, value, allowed in (
        ("stages.main.planet_angles", "3 deg", "a list of angle (rad, deg)"),
        ("operation.gravity", "3 m/s^2", "a list of acceleration (m/s^2)"),
        ("deviations.main.sun.pitch", "5 um", "a list of length (m, mm, um), >= -1 and <= 1 m"),
        ("stages.main.sun.support.radial", "x", "stiffness (N/m, N/um, kN/mm), >= 0 and <= 1e+16 N/m or inf; a list "),
    ):
        with pytest.raises(ModelError) as error:
            read(data, {path: value})
        assert error.value.allowed.startswith(allowed)
        assert error.value.allowed.endswith("one value per planet") == path.endswith("radial")
