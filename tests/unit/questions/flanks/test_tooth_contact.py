"""The verb and command `contact`: loads, sides, named meshes, table, figures, JSON, what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.unit.packed_page import unpacked

import epicyclic
from epicyclic.cli.main import app
from epicyclic.errors import ModelError
from epicyclic.questions.flanks.pair_contact import helices_of
from epicyclic.results.dataset import load_result, save_result
from epicyclic.show.charts.flanks import contact_curves, contact_map
from epicyclic.system.tooth_pairs import mean_force, pair_of


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return epicyclic.contact("ren2021", mesh="sun-planet", samples=24, slices=10)


def test_variables_that_scripts_rely_on(result: xr.Dataset) -> None:
    assert result.load_per_length.dims == ("mesh", "width", "mesh_phase")
    assert result.transmission_error.dims == ("mesh_phase",)
    for name, values in result.variables.items():
        assert "long_name" in values.attrs or name in ("mesh", "line", "tooth_pair", "end"), name
    assert result.transmission_error.attrs["units"] == "m"
    assert result.load_per_length.attrs["units"] == "N/m"


def test_the_load_is_that_of_static_equilibrium(result: xr.Dataset) -> None:
    static = epicyclic.static("ren2021")
    mean = float(static.mesh_force.sel(mesh=[m for m in static.mesh.values if "sun-planet" in str(m)]).mean())
    # the mean over branches and time: errors shift load between branches but the torque is one
    assert result.attrs["force"] == pytest.approx(mean, rel=1e-6)


def test_tips_that_would_bear_name_their_mesh(result: xr.Dataset) -> None:
    (said,) = [text for text in json.loads(result.attrs["warnings"]) if "tip edge" in text]
    overlap = 1e6 * float(result.corner_overlap.sel(torque_factor=1.0).max())
    assert said.startswith("main/sun-planet/1: a tip edge would bear on its mate")
    assert f"overlap by {overlap:.3g} µm" in said
    assert "option `corner`" in said
    left = epicyclic.contact("ren2021", mesh="main/planet-ring/2/left", samples=24, slices=10)
    assert all(
        text.startswith("main/planet-ring/2/left:") for text in json.loads(left.attrs["warnings"]) if "tip edge" in text
    )
    bearing = epicyclic.contact("ren2021", mesh="sun-planet", samples=24, slices=10, corner=True)
    assert "tip edge" not in bearing.attrs["warnings"]


def test_torque_is_the_lever_of_all_helices(result: xr.Dataset) -> None:
    torques = epicyclic.load("ren2021").kinematics.torque
    assert torques is not None
    torque = abs(torques["main.sun"])
    now = int(np.argmin(np.abs(result.mesh_load.values - result.attrs["force"])))
    assert 3 * float(result.load_torque[now]) == pytest.approx(torque, rel=1e-9)
    again = epicyclic.contact(
        "ren2021", mesh="sun-planet", torque=float(result.load_torque[now]), loads=[], samples=4, slices=2
    )
    assert again.attrs["force"] == pytest.approx(result.attrs["force"], rel=1e-12)


def test_halves_are_mirror_images(result: xr.Dataset) -> None:
    left, right = result.load_per_length.values
    assert right[::-1] == pytest.approx(left, rel=1e-7, abs=1e-3)
    assert result.side_transmission_error.values[1] == pytest.approx(result.side_transmission_error.values[0], rel=1e-9)
    assert result.transmission_error.values == pytest.approx(result.side_transmission_error.values[0], rel=1e-9)
    assert result.pair_share.sum("tooth_pair").values == pytest.approx(1.0, rel=1e-9)
    assert float(result.contact_residual.max()) < 1e-11


def test_a_side_of_its_own_differs() -> None:
    crowned = epicyclic.contact(
        "ren2021",
        mesh="sun-planet",
        overrides={"stages.main.sun.left.flank.crown": "30 um"},
        loads=[],
        samples=12,
        slices=10,
    )
    left, right = crowned.face_load_factor.values[0]
    assert left > 1.2 * right
    assert crowned.transmission_error.values == pytest.approx(crowned.side_transmission_error.values.mean(axis=0))


def test_mesh_phase_is_time() -> None:
    train = epicyclic.load("ren2021")
    result = epicyclic.contact(train, mesh="sun-planet", loads=[], samples=24, slices=4)
    second = epicyclic.contact(train, mesh="main/sun-planet/2", loads=[], samples=24, slices=4)
    leads = [float(next(m for m in train.meshes if m.name == f"main/sun-planet/{n}/left").lead) for n in (1, 2)]
    shift = (leads[1] - leads[0]) * 24
    if abs(shift - round(shift)) < 1e-9:
        rolled = np.roll(result.transmission_error.values, -round(shift))
        assert second.transmission_error.values == pytest.approx(rolled, rel=1e-9)
    assert second.transmission_error.values.mean() == pytest.approx(result.transmission_error.values.mean(), rel=2e-3)


@pytest.mark.parametrize("name", [None, "sun-planet", "main/sun-planet", "main/sun-planet/1"])
def test_a_mesh_has_several_names(name: str | None) -> None:
    found = helices_of(epicyclic.load("ren2021"), name)
    assert [m.name for m in found] == ["main/sun-planet/1/left", "main/sun-planet/1/right"]


def test_one_helix_alone() -> None:
    found = helices_of(epicyclic.load("ren2021"), "main/planet-ring/2/right")
    assert [m.name for m in found] == ["main/planet-ring/2/right"]
    spur = epicyclic.contact("yue2014-i", mesh="p-d", torque="43 N m", loads=[], samples=8, slices=2)
    assert spur.side.values.tolist() == ["face"]


@pytest.mark.parametrize(("member", "slide"), [("sun", 8), ("sun", -8), ("planet", 8), ("planet", -8), ("sun", 4)])
def test_a_slide_takes_from_the_face(member: str, slide: int) -> None:
    still, train = (
        epicyclic.load("xu2020", overrides={f"deviations.main.{member}.right.position.z": f"{z} mm"})
        for z in (0, slide)
    )
    before, after = (
        pair_of(one, next(m for m in one.meshes if m.name == "main/sun-planet/1/right")).plane for one in (still, train)
    )
    # 175 mm of the planet inside 185 mm of the sun: 5 mm to spare either side
    assert after.width == pytest.approx(0.175 - max(0, abs(slide) - 5) / 1e3, abs=1e-9)
    # the end that is left free: of the planet's face where the sun goes away from it, and the ends of a planet go along
    moved = np.array([8.0, 5.0]) / 1e3 if slide > 0 else np.array([-5.0, -8.0]) / 1e3
    expected = {"sun": np.clip(np.array([slide, slide]) / 1e3 - [0.005, -0.005], [0, -9], [9, 0]), "planet": moved}
    np.testing.assert_allclose(np.array(after.face) - before.face, expected[member], atol=1e-9)
    right = next(m for m in train.meshes if m.name == "main/sun-planet/1/right")
    assert mean_force(train, right) > 0


def test_misalignment_and_twist_load_one_end() -> None:
    cases: list[dict[str, Any]] = [{}, {"misalignment": "0.1 mrad"}, {"torque_end_a": "left"}]
    plain, open_, twisted = (
        epicyclic.contact("ren2021", mesh="sun-planet", loads=[], samples=8, slices=10, **more) for more in cases
    )
    ends = [one.load_per_length.mean("mesh_phase").values[:, [0, -1]] for one in (plain, open_, twisted)]
    assert ends[0][:, 0] == pytest.approx(ends[0][::-1, 1], rel=1e-6)  # mirror images
    assert (ends[1][:, 0] > ends[0][:, 0]).all()
    assert (ends[1][:, 1] < ends[0][:, 1]).all()
    # where the torque leaves the body is stiffest
    assert (ends[2][:, 0] > ends[0][:, 0]).all()
    assert (ends[2][:, 1] < ends[0][:, 1]).all()


def test_relief_flattens_the_error() -> None:
    plain = epicyclic.contact("yue2014-i", mesh="p-d", torque="43 N m", loads=[], samples=48, slices=2)
    relief = {"amount": "6 um", "length": "2.44 mm"}
    overrides = {f"stages.main.{gear}.flank.tip_relief": relief for gear in ("p", "d")}
    better = epicyclic.contact(
        "yue2014-i", mesh="p-d", torque="43 N m", loads=[], samples=48, slices=2, overrides=overrides
    )
    peak = [float(one.transmission_error_peak_to_peak[0]) for one in (plain, better)]
    assert peak[1] < 0.5 * peak[0]


def test_saved_and_reopened(result: xr.Dataset, tmp_path: Path) -> None:
    save_result(result, tmp_path / "contact.nc")
    again = load_result(tmp_path / "contact.nc")
    assert again.transmission_error.values.tolist() == result.transmission_error.values.tolist()


def test_figures(result: xr.Dataset) -> None:
    flank = contact_map(result)
    assert [trace.type for trace in flank.data].count("heatmap") == 2
    peak = max(float(np.nanmax(np.array(t.z, dtype=float))) for t in flank.data if t.type == "heatmap")
    assert peak == pytest.approx(float(np.nanmax(result.flank_load_per_length)) / 1e3, rel=1e-3)
    curves = contact_curves(result)
    names = [trace.name for trace in curves.data]
    assert "peak to peak" in names
    assert sum("operation" in str(name) for name in names) == 1


def run(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        app(words)
    out = capsys.readouterr()
    return int(stop.value.code or 0), out.out, out.err


def test_command_prints_tables_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["contact", "ren2021", "--mesh", "sun-planet", "--samples", "8", "--slices", "3"]
    words += ["--loads", "0..1", "--load-points", "2"]
    code, out, _ = run(words, capsys)
    assert code == 0
    assert "Loaded transmission error" in out
    code, out, _ = run([*words, "--json"], capsys)
    again = xr.Dataset.from_dict(json.loads(out))
    assert code == 0
    assert again.mesh_load.values[0] == 0
    assert float(again.transmission_error_peak_to_peak[0]) == 0  # unloaded involutes without modification


def test_html_shows_the_flanks(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    target = tmp_path / "teeth.html"
    code, _, _ = run(
        ["contact", "ren2021", "--mesh", "sun-planet", "--samples", "8", "--slices", "3", "-o", str(target)], capsys
    )
    assert code == 0
    figures = "".join(unpacked(target.read_text(encoding="utf-8")).values())
    assert "Load over the flank" in figures
    assert "Harris map" in figures


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mesh": "sun-moon"}, "no such mesh"),
        ({"torque": "5"}, "unit"),
        ({"torque": "5 kg"}, "torque"),
        ({"samples": 1}, "samples"),
        ({"torque_end_a": "middle"}, "torque_end_a = 'middle'.*left.*right"),
        ({"misalignment": "0.1"}, "misalignment"),
        ({"loads": [-1.0]}, "loads = .*relative loads"),
        ({"overrides": {"stages.main.face_width": None, "stages.main.meshes.sun-planet.stiffness": "1e9 N/m"}}, "face"),
        ({"overrides": {"stages.main.sun.addendum": 2.3}}, "pointed|interfere|root"),
        ({"overrides": {"stages.main.addendum": 0.3}}, "do not keep contact"),
        ({"overrides": {"deviations.main.sun.position.z": "1 m"}}, "do not overlap"),
    ],
)
def test_what_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        epicyclic.contact("ren2021", **{"mesh": "sun-planet", "samples": 4, "slices": 2, **options})


def test_no_torque_is_said() -> None:
    with pytest.raises(ModelError, match="no torque passes the mesh main/sun-p"):
        epicyclic.contact("yue2014-i", mesh="sun-p")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"torque": "5 N m"}, "torque = 5 N m: goes with one mesh"),
        ({"misalignment": "0.1 mrad"}, "misalignment = 0.1 mrad: goes with one mesh"),
        ({"torque_end_b": "left"}, "goes with one mesh"),
        ({"deviations": True}, "deviations = True: goes with one mesh"),
        ({"pitch_error": "10 um"}, "goes with one mesh"),
        ({"profile_error": "10 um"}, "goes with one mesh"),
        ({"profile_phase": "10 deg"}, "goes with one mesh"),
        ({"cycle": 1.0}, "goes with one mesh"),
        ({"mesh": "sun-planet", "cycles": 2}, "goes with all meshes"),
        ({"mesh": "sun-planet", "turns": 2, "of": "main/sun"}, "goes with all meshes"),
    ],
)
def test_what_means_nothing_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        epicyclic.contact("ren2021", samples=4, slices=2, **options)


def test_a_mesh_and_the_train_have_the_same_variables_in_the_same_dims(result: xr.Dataset) -> None:
    train = epicyclic.contact("ren2021", samples=4, slices=3, loads=[0.5])
    both = set(result.variables) & set(train.variables)
    of_teeth = {"face_load", "face_load_factor", "largest_load_per_length", "smallest_load_per_length", "shared_face"}
    assert both >= of_teeth | {"largest_root_stress", "lowest_root_stress", "flank_load_per_length", "path_place"}
    assert both >= {"averaging_length", "contact_residual", "side", "mesh", "torque_factor", "width", "flank_place"}
    for name in both:
        assert (result[name].dims, result[name].attrs) == (train[name].dims, train[name].attrs), name
    assert result.mesh.values.tolist() == train.mesh.values.tolist()[:2]
    assert train.side.values.tolist()[:2] == result.side.values.tolist() == ["left", "right"]
    # the places of the maps, which are those of the path of contact
    for one in (result, train):
        assert (one.flank_place.values[[0, -1]] == [0, 1]).all()
        low, high = one.path_place.values[:, [0, -1]].T
        np.testing.assert_allclose(
            one.path_place, low[:, None] + (high - low)[:, None] * one.flank_place.values, rtol=1e-9, atol=1e-12
        )


def test_faces_of_a_mesh_alone_bear_its_force(result: xr.Dataset) -> None:
    force = result.face_load.mean("width") * result.shared_face
    np.testing.assert_allclose(force, np.tile(result.mesh_load.values[:, None], 2), rtol=1e-9)
    load = result.face_load  # of 10 slices, each a tenth of the face
    np.testing.assert_allclose(load.max("width") / load.mean("width"), result.face_load_factor, rtol=1e-9)
    assert (result.smallest_load_per_length <= result.largest_load_per_length).all()
