"""The verb and the command `contact` of a whole train: variables, table, figures, saving, what is refused."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.unit.packed_page import unpacked
from typer.testing import CliRunner

import epicyclic
from epicyclic.audits.audit import audit
from epicyclic.cli.main import app
from epicyclic.questions.flanks.views import contact_tables
from epicyclic.results.dataset import load_result, save_result
from epicyclic.show.charts.flanks import face_loads, load_factors


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return epicyclic.contact("ren2021", samples=9, slices=6, loads=[0.2])


def test_factors_follow_from_the_forces(result: xr.Dataset) -> None:
    assert result.torque_factor.values.tolist() == [0.2, 1.0]
    load = result.face_load  # of 6 slices, each more than a tenth of the face
    np.testing.assert_allclose(load.max("width") / load.mean("width"), result.face_load_factor, rtol=1e-12)
    # 170 mm of face; the forces of the slices are those of the mesh
    np.testing.assert_allclose(load.mean("width") * 0.17, result.mesh_force.mean("time"), rtol=1e-9)
    sun = result.mesh_force.sel(mesh=[name for name in result.mesh.values if "sun" in name]).mean("time").values
    branch = sun.reshape(2, 3, 2).sum(axis=2)
    np.testing.assert_allclose(result.branch_load_factor[:, 0], 3 * branch.max(axis=1) / branch.sum(axis=1), rtol=1e-12)
    np.testing.assert_allclose(result.side_share, 0.5, rtol=1e-9)  # mirror images, nothing displaced on one side
    assert (result.smallest_load_per_length <= result.largest_load_per_length).all()
    flank = result.flank_load_per_length
    assert float(flank.max()) <= float(result.largest_load_per_length.sel(torque_factor=1.0).max()) * (1 + 1e-12)
    assert float(result.contact_residual.max()) < 1e-11
    assert float(result.balance_residual.max()) <= 1e-12


def test_a_slide_that_is_held_loads_one_side() -> None:
    held = {"stages.main.sun.support.z": "inf", "stages.main.planet.bearing.z": "inf"}
    slid = epicyclic.contact(
        "xu2020", overrides={**held, "deviations.sun.position.z": "60 um"}, samples=4, slices=4, loads=[]
    )
    plain = epicyclic.contact("xu2020", overrides=held, samples=4, slices=4, loads=[])
    left = [name for name in plain.mesh.values if "sun" in name and name.endswith("left")]
    change = (slid.side_share - plain.side_share).sel(mesh=left, torque_factor=1.0)
    # to the right, with the left helix of the sun left-hand: the left side opens
    assert (change < -0.03).all()
    floating = epicyclic.contact("xu2020", samples=4, slices=4, loads=[])
    np.testing.assert_allclose(floating.side_share, 0.5, rtol=1e-9)  # sum F_z = 0


def test_table_figures_and_file(result: xr.Dataset, tmp_path: Path) -> None:
    meshes, torques = contact_tables(result)
    assert len(meshes.columns["mesh"]) == 12
    assert len(torques.columns["torque per operating"]) == 2
    save_result(result, tmp_path / "train.nc")
    again = load_result(tmp_path / "train.nc")
    xr.testing.assert_identical(again.face_load, result.face_load)
    drawn = face_loads(result)
    assert len(drawn.data) == 12
    factors = load_factors(result)
    assert [len(trace.x) for trace in factors.data] == [2] * 6


def test_the_command() -> None:
    words = ["ren2021", "--samples", "3", "--slices", "2", "--loads", "0.5", "--json"]
    answer = CliRunner().invoke(app, ["contact", *words])
    assert answer.exit_code == 0, answer.output
    found = json.loads(answer.stdout)
    assert found["coords"]["torque_factor"]["data"] == [0.5, 1.0]
    assert found["attrs"]["verb"] == "contact"


def test_audits_can_ask_for_it(tmp_path: Path) -> None:
    data = tmp_path / "ren2021.audit.toml"
    data.write_text(
        'format = 2\nsource = "none"\ndrive = "ren2021"\n[runs.teeth]\nverb = "contact"\n'
        "options = { samples = 3, slices = 2, loads = [] }\n[[rows]]\n"
        'quantity = "K_gamma"\nplace = "nowhere"\npublished = "1 .. 1.1"\nverdict = "reproduced"\n'
        'ours = { run = "teeth", take = "branch_load_factor", reduce = "max" }\n'
    )
    assert audit(data).outcome.values.tolist() == ["holds"]


def test_the_report(result: xr.Dataset) -> None:
    from epicyclic.show.report import report

    page = report({"contact": result})
    assert "Teeth in contact in the train" in page
    assert "Load factors over the torque" in "".join(unpacked(page).values())


def test_a_branch_that_carries_nothing_has_no_shares() -> None:
    """Five spur planets, one pin 0.3 mm back: its meshes stay open, without a warning from inside and with nan."""
    model = {
        "format": 2,
        "title": "five planets",
        "stages": {
            "main": {
                "planets": 5,
                "module": "4 mm",
                "face_width": "50 mm",
                "sun": {"teeth": 40, "support": {"radial": "1e9 N/m"}},
                "planet": {"teeth": 20, "bore": "30 mm", "bearing": {"radial": "4e8 N/m"}},
                "ring": {"teeth": 80, "rim": "25 mm", "addendum": 0.8},
                "carrier": {"mass": "40 kg", "inertia": "0.5 kg m^2"},
            }
        },
        "operation": {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "800 N m"}},
        "deviations": {"planet": {"position": {"y": "[300, 0, 0, 0, 0] um"}}},
    }
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = epicyclic.contact(model, samples=2, slices=2, loads=(0.1,))
        shown, _ = contact_tables(found)
        face_loads(found)
        load_factors(found)
    idle = np.array([name.endswith("/1") for name in found.mesh.values])
    assert (np.isnan(found.side_share.values) == idle).all()
    assert (np.isnan(found.face_load_factor.values) == idle).all()
    np.testing.assert_allclose(found.side_share.values[:, ~idle], 1.0)
    assert (found.branch_load_factor > 5 / 4).all()
    said = json.loads(found.attrs["warnings"])
    assert "meshes open at some instants: main/sun-planet/1, main/planet-ring/1 [contact-lost]" in said
    assert len(shown.columns["mesh"]) == 10
