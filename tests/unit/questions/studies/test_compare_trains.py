"""`compare`: drawings, modes, load sharing and forces of several trains, and variables of saved results."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.document import drive_text
from epicyclic.questions.studies.compare import BY_KIND, BY_SHAPE, TrainModes, mode_pairs
from epicyclic.questions.studies.compare import modes_of as train_modes
from epicyclic.questions.studies.views import compared_tables as tables
from epicyclic.questions.studies.views import key_figures
from epicyclic.show.charts.effects import compared
from epicyclic.show.elements import ComparedRow, compared_rows, percent
from epicyclic.warning_codes import code_of

FLOAT = {"stages.main.sun.support.radial": 0}


@pytest.fixture(scope="module")
def floating() -> xr.Dataset:
    return epicyclic.compare("ren2021", variants=[FLOAT])


# modes ---------------------------------------------------------------------------------------------------------------


def modes_of(squared: list[float], vectors: np.ndarray, *, dofs: str = "abcd", kind: str = "mixed") -> TrainModes:
    n = len(squared)
    return TrainModes(
        squared=np.array(squared), vectors=vectors, mass=np.eye(n), kind=(kind,) * n, dofs=tuple(dofs[:n])
    )


def turned(angle: float, i: int, j: int, n: int = 4) -> np.ndarray:
    found = np.eye(n)
    found[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    return found


def test_shapes_that_change_places_are_followed() -> None:
    first = modes_of([1.0, 4.0, 9.0, 16.0], np.eye(4))
    second = modes_of([1.0, 8.0, 9.5, 16.0], np.eye(4)[:, [0, 2, 1, 3]] @ turned(0.2, 0, 3))
    place, criterion, how = mode_pairs(first, second)
    assert place.tolist() == [0, 2, 1, 3]
    np.testing.assert_allclose(criterion, [np.cos(0.2) ** 2, 1, 1, np.cos(0.2) ** 2], rtol=1e-12)
    assert how == BY_SHAPE


def test_any_basis_of_a_repeated_root_is_the_same_mode() -> None:
    first = modes_of([1.0, 4.0, 4.0, 16.0], turned(0.7, 1, 2))
    for second in (
        modes_of([1.0, 5.0, 5.0, 16.0], turned(-0.4, 1, 2)),
        modes_of([1.0, 4.9, 5.1, 16.0], np.eye(4)),  # the root has split
    ):
        place, criterion, _ = mode_pairs(first, second)
        assert sorted(place[1:3].tolist()) == [1, 2]
        np.testing.assert_allclose(criterion, 1.0, rtol=1e-12)


def test_other_coordinates_are_paired_by_kind_and_order() -> None:
    first, second = modes_of([1.0, 4.0, 9.0], np.eye(3)), modes_of([2.0, 5.0], np.eye(2), dofs="xy")
    place, criterion, how = mode_pairs(first, second)
    assert place.tolist() == [0, 1, -1]
    assert np.isnan(criterion).all()
    assert how == BY_KIND


def test_frequencies_are_those_of_each_train(floating: xr.Dataset) -> None:
    """Two routes: each train alone by `modes`, and followed along the stiffness by `track`."""
    for place, overrides in enumerate((None, FLOAT)):
        alone = epicyclic.modes("ren2021", overrides=overrides)
        np.testing.assert_allclose(np.sort(floating.frequency[:, place]), np.sort(alone.frequency), rtol=1e-9)
    assert floating.mode_pairing.values.tolist() == [BY_SHAPE, BY_SHAPE]
    assert floating.mode_kind[1:3].values.tolist() == [["translational"] * 2] * 2
    path = "stages.main.sun.support.radial"
    small = epicyclic.compare("ren2021", variants=[{path: "9e8 N/m"}])
    tracked = epicyclic.track("ren2021", over=path, start="1e9 N/m", stop="9e8 N/m", points=3)
    loci = tracked.frequency.sel(parameter=[1e9, 9e8]).transpose("mode", "parameter").values
    np.testing.assert_allclose(small.frequency.values, loci[np.argsort(loci[:, 0], kind="stable")], rtol=1e-6)


def test_kinds_pair_trains_of_another_number_of_planets() -> None:
    found = epicyclic.compare("lin1999-n3", "lin1999-n4")
    assert found.mode_pairing.values.tolist() == [BY_SHAPE, BY_KIND]
    own, other = epicyclic.modes("lin1999-n3"), epicyclic.modes("lin1999-n4")
    for kind in ("rotational", "translational"):
        mine, theirs = (
            one.frequency.values[(one.mode_kind.values == kind) & (one.frequency.values > 0)] for one in (own, other)
        )
        rows = (found.mode_kind[:, 0].values == kind) & (found.frequency[:, 0].values > 0)
        np.testing.assert_allclose(found.frequency[rows, 0], mine, rtol=1e-9)
        np.testing.assert_allclose(found.frequency[rows, 1], theirs[: mine.size], rtol=1e-9)


def test_shapes_pair_a_rigid_ring_with_one_that_bends() -> None:
    """Modes of the ring alone have no partner; a stiff ring has those of the rigid one."""
    stiff: dict[str, object] = {"stages.main.ring.elastic": {"radius": "155 mm", "bending": "7e9 N m^2", "modes": 3}}
    found = epicyclic.compare("lin1999-n4", variants=[stiff])
    assert found.mode_pairing.values.tolist() == [BY_SHAPE, BY_SHAPE]
    rigid = found.frequency[:, 0].values
    np.testing.assert_allclose(found.frequency[:, 1], rigid, rtol=1e-3, atol=1e-6)
    back = mode_pairs(modes_of_train(stiff), modes_of_train({}))
    assert sum(back[0] < 0) == 4  # a2, b2, a3, b3


def test_modes_without_likeness_have_no_partner() -> None:
    eye = np.eye(3)
    a, b = modes_of([1.0, 4.0], eye[:, :2], dofs="abc"), modes_of([1.0, 9.0], eye[:, [0, 2]], dofs="abc")
    a, b = (replace(one, mass=eye, dofs=("a", "b", "c")) for one in (a, b))
    place, criterion, pairing = mode_pairs(a, b)
    assert (place.tolist(), pairing) == ([0, -1], BY_SHAPE)
    assert criterion[0] == 1.0
    assert np.isnan(criterion[1])


def modes_of_train(changes: dict[str, object]) -> TrainModes:
    return train_modes(epicyclic.assemble(epicyclic.load("lin1999-n4", changes)))


# loads ---------------------------------------------------------------------------------------------------------------


def test_sharing_and_forces_are_those_of_each_train(floating: xr.Dataset) -> None:
    for place, overrides in enumerate((None, FLOAT)):
        alone = epicyclic.sharing("ren2021", overrides=overrides)
        own = floating.isel(train=place)
        assert own.k_gamma.item() == alone.system_load_sharing.sel(definition="mean-load").item()
        np.testing.assert_array_equal(own.mesh_force_mean, alone.mesh_force_mean)
        np.testing.assert_array_equal(own.mesh_force_peak, alone.mesh_force_peak)
    assert floating.k_gamma.values == pytest.approx([1.0344, 1.0], abs=1e-4)  # a sun that floats shares evenly
    assert floating.worst_mesh.values.tolist() == ["main/sun-planet/2/left", ""]
    # sun in, carrier out: 1 + 57/23
    assert floating.transmission_ratio.values == pytest.approx([1 + 57 / 23] * 2, rel=1e-12)
    assert floating.mesh_frequency.values == pytest.approx(27.3125)


def test_forces_are_at_rest_where_one_train_has_no_damping() -> None:
    """Like with like: the steady forces of one beside the forces at rest of the other would mislead."""
    found = epicyclic.compare("ren2021", variants=[{"damping": None}])
    assert found.force_method.values.tolist() == ["static", "static"]
    rest = epicyclic.sharing("ren2021", method="static")
    np.testing.assert_array_equal(found.mesh_force_peak[:, 0], rest.mesh_force_peak)
    np.testing.assert_array_equal(found.mesh_force_peak[:, 0], found.mesh_force_peak[:, 1])


def test_what_a_model_does_not_say_is_told() -> None:
    found = epicyclic.compare("lin1999-n3", "lin1999-n4")
    said = json.loads(found.attrs["warnings"])
    assert np.isnan(found.k_gamma.values).all()
    assert any(code_of(text) == "section-left-out" and "mesh forces" in text for text in said)
    assert all(code_of(text) for text in said)


def test_warnings_of_one_train_carry_its_name() -> None:
    found = epicyclic.compare("ren2021", variants=[{"stages.main.ring.rim": "20 mm"}])
    said = json.loads(found.attrs["warnings"])
    (thin,) = (text for text in said if code_of(text) == "thin-rim")
    assert thin.startswith("stages.main.ring.rim=20 mm: ")
    (both,) = (text for text in said if code_of(text) == "not-assembled")
    assert both.startswith("stages.main: planets")


# drawing -------------------------------------------------------------------------------------------------------------


def test_a_value_written_otherwise_is_no_difference() -> None:
    same = {"stages.main.sun.support.radial": "1000 N/um", "stages.main.module": "3.2 cm", "operation.held": ["ring"]}
    found = epicyclic.compare("ren2021", variants=[same])
    assert found.sizes["difference"] == 0
    assert [row for row in compared_rows(found) if row.largest] == []
    (table,) = tables(found)
    assert table.columns["what"][0] == "no difference"
    assert compared(found).layout.title.text == "Nothing changes"


def test_differences_carry_path_text_number_and_unit() -> None:
    changes = {
        "stages.main.sun.mass": "0.8 t",
        "stages.main.ring.rim": "200 mm",
        "stages.main.sun.support.x": "2e9 N/m",
        "stages.main.sun.profile_shift": 0.1,
        "damping.modal": None,
        "damping.mesh": 0.02,
    }
    found = epicyclic.compare("ren2021", variants=[changes])
    rows = {
        path: (*texts, *numbers, unit)
        for path, texts, numbers, unit in zip(
            found.difference.values.tolist(),
            found.difference_text.values.tolist(),
            found.difference_value.values.tolist(),
            found.difference_unit.values.tolist(),
            strict=True,
        )
    }
    assert rows["stages.main.sun.mass"] == ("750 kg", "0.8 t", 750.0, 800.0, "kg")
    assert rows["stages.main.sun.support.x"] == ("1e9 N/m", "2e9 N/m", 1e9, 2e9, "N/m")
    assert rows["stages.main.ring.rim"][1] == "200 mm"
    assert rows["stages.main.sun.profile_shift"][0].startswith("0 (")  # derived, and from what
    assert rows["stages.main.sun.profile_shift"][2:4] == (0.0, 0.1)
    assert rows["damping.modal"][:2] == ("0.03", "")
    assert set(rows) == set(changes)
    # a support that differs in x and y has no equations in a frame that turns: nothing stands beside the first modes
    assert np.isfinite(found.frequency.values[:, 0]).all()
    assert np.isnan(found.frequency.values[:, 1]).all()
    assert found.mode_pairing.values.tolist() == ["mode shapes (MAC)", ""]


def test_x_and_y_that_differ_alike_are_one_path(floating: xr.Dataset) -> None:
    assert floating.difference.values.tolist() == ["stages.main.sun.support.radial"]
    assert floating.difference_text.values.tolist() == [["1e9 N/m", "0"]]


# results -------------------------------------------------------------------------------------------------------------


def test_results_are_compared_by_variables(tmp_path: Path) -> None:
    first, second = epicyclic.sharing("ren2021", cycles=4), epicyclic.sharing("ren2021", cycles=4, overrides=FLOAT)
    files = [tmp_path / "first.nc", tmp_path / "second.json"]
    for result, file in zip((first, second), files, strict=True):
        epicyclic.save_result(result, file)
    found = epicyclic.compare(*map(str, files))
    assert found.train.values.tolist() == ["first", "second"]
    assert found.difference.values.tolist() == ["stages.main.sun.support.radial"]  # of the models that they carry
    assert "frequency" not in found  # nothing is computed anew
    row = found.sel(variable="mesh_force_peak", train="second")
    gap = np.abs(second.mesh_force_peak - first.mesh_force_peak)
    assert row.largest_difference.item() == pytest.approx(gap.max().item(), rel=1e-12)
    place = np.flatnonzero(gap.values >= 0.9999 * gap.values.max())[0]  # of flanks that carry alike the first
    assert row.difference_place.item() == f"mesh {gap.mesh.values[place]}"
    assert row.variable_unit.item() == "N"
    assert row.other_value.item() - row.first_value.item() == pytest.approx(
        (second.mesh_force_peak - first.mesh_force_peak)[place].item(), rel=1e-12
    )


def test_dims_without_common_labels_are_left_out() -> None:
    first = epicyclic.sweep("ren2021", points=3, start="20 Hz", stop="60 Hz")
    second = epicyclic.sweep("ren2021", points=3, start="70 Hz", stop="90 Hz")
    found = epicyclic.compare(first, second)
    assert "mesh_force_peak" not in found.variable.values.tolist()
    equal = epicyclic.compare(first, first)
    assert np.nanmax(equal.largest_difference.values) == 0.0
    assert [row for row in compared_rows(equal) if row.largest] == []


@pytest.mark.parametrize(
    ("sources", "more", "problem"),
    [
        (["ren2021"], {}, "not a number of trains"),
        (["ren2021"] * 13, {}, "not a number of trains"),
        (["ren2021", "nothing-here"], {}, "no such file"),
        (["ren2021", "nothing.nc"], {}, "no such file"),
    ],
)
def test_what_cannot_be_compared_is_refused(sources: list[str], more: dict[str, object], problem: str) -> None:
    with pytest.raises(epicyclic.ModelError, match=problem):
        epicyclic.compare(*sources, **more)  # type: ignore[arg-type]


def test_overrides_of_results_are_refused() -> None:
    result = epicyclic.modes("lin1999-n3")
    with pytest.raises(epicyclic.ModelError, match="not to a result"):
        epicyclic.compare(result, result, overrides={"stages.main.planets": 4})
    with pytest.raises(epicyclic.ModelError, match="varies a model alone"):
        epicyclic.compare(result, variants=[{"stages.main.planets": 4}])
    with pytest.raises(epicyclic.ModelError, match="System has no drawing"):
        epicyclic.compare("lin1999-n3", epicyclic.assemble(epicyclic.load("lin1999-n3")))
    with pytest.raises(epicyclic.ModelError, match="result without its model"):
        epicyclic.compare("lin1999-n3", result.assign_attrs(model="{}"))
    assert epicyclic.compare("lin1999-n3", result).sizes["difference"] == 0  # by the model that it carries


# what is shown -------------------------------------------------------------------------------------------------------


def test_the_table_and_the_figure_say_what_changes(floating: xr.Dataset) -> None:
    (table,) = tables(floating)
    cells = list(zip(*table.columns.values(), strict=True))
    what = {row[1]: row for row in cells}
    assert what["stages.main.sun.support.radial"][2:4] == ("1e9 N/m", "0")
    assert what["K_gamma"][-1] == "-3.33 %"
    assert what["natural frequency 2, translational"][2:] == ("86.68 Hz", "47.44 Hz MAC 0.75", "-45.3 %")
    assert table.lead == "A = ren2021; B = stages.main.sun.support.radial=0"
    drawn = compared(floating)
    (bars,) = drawn.data
    assert bars.x[0] == pytest.approx(-45.265, abs=1e-3)
    assert list(np.abs(bars.x)) == sorted(np.abs(bars.x), reverse=True)
    assert drawn.layout.title.text == "B: natural frequency 2, translational -45.3 %, the largest change from A"
    assert key_figures(floating)[0][0] == "-45.3 %"


def test_the_figure_is_json_without_nan() -> None:
    """A mode of A without a pair in C is no bar there."""
    drawn = compared(epicyclic.compare("lin1999-n4", "lin1999-n5", "lin1999-n3"))
    assert "NaN" not in drawn.to_json()
    assert drawn.layout.xaxis.title.text == "change from A [%]"
    assert [trace.name[0] for trace in drawn.data] == ["C", "B"]


def test_changes_in_words() -> None:
    row = ComparedRow(group="", name="", unit="", value=(2.0, 2.0 + 1e-9, 1.0, float("nan"), -2.0))
    assert list(map(percent, row.change)) == ["=", "=", "-50 %", "", "-200 %"]
    assert ComparedRow(group="", name="", unit="", value=(-2.0, -3.0)).change[1] == -50.0
    assert np.isnan(ComparedRow(group="", name="", unit="", value=(0.0, 1.0)).change[1])


def test_long_lists_are_summed_up() -> None:
    found = epicyclic.compare("xu2020", "wind-five")
    (table,) = tables(found)
    drawing = [what for group, what in zip(table.columns[""], table.columns["what"], strict=True) if group == "drawing"]
    assert len(drawing) == 12 < found.sizes["difference"]
    assert table.notes[0].startswith(f"{found.sizes['difference'] - 12} more differences of the drawings: ")
    counts = [
        int(part.split(" of ")[0].split()[-1]) for part in table.notes[0].split(": ")[1].split(";")[0].split(", ")
    ]
    assert sum(counts) == found.sizes["difference"] - 12
    rows = [row for row in compared_rows(found) if row.group == "modes" and row.largest]
    shown = [what for group, what in zip(table.columns[""], table.columns["what"], strict=True) if group == "modes"]
    assert len(shown) == 12 < len(rows)
    assert set(shown) == {row.name for row in sorted(rows, key=lambda row: -row.largest)[:12]}


def test_the_command_gives_the_same(floating: xr.Dataset, tmp_path: Path) -> None:
    run = CliRunner()
    told = run.invoke(app, ["compare", "ren2021", "--with", "stages.main.sun.support.radial=0", "--json"])
    assert told.exit_code == 0
    again = xr.Dataset.from_dict({k: v for k, v in json.loads(told.stdout).items() if k != "sha256"})
    np.testing.assert_array_equal(again.frequency.values.astype(float), floating.frequency.values)
    page = tmp_path / "compare.html"
    several = "stages.main.sun.mass=800 kg; stages.main.ring.rim=200 mm"
    written = run.invoke(app, ["compare", "ren2021", "lin1999-n3", "--with", several, "-o", str(page)])
    assert written.exit_code == 0
    assert 'id="figure-compared"' in page.read_text(encoding="utf-8")
    for words, problem in ((["ren2021"], "not a number"), (["ren2021", "--with", ";"], "--with")):
        wrong = run.invoke(app, ["compare", *words])
        assert wrong.exit_code == 2
        assert problem in wrong.output


def test_every_train_has_a_name_of_its_own(tmp_path: Path) -> None:
    text = drive_text("lin1999-n3")
    for name in ("set (2)", "set"):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    found = epicyclic.compare(*(tmp_path / f"{name}.toml" for name in ("set (2)", "set", "set")))
    assert found.train.values.tolist() == ["set (2)", "set", "set (3)"]
