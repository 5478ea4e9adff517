"""Load spectra: sums, equivalent torque by hand, ASTM's cycles, turns of the members, load cases as text."""

from __future__ import annotations

import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.tables import leaves
from epicyclic.document.units import Bounds, read_quantity
from epicyclic.errors import ModelError
from epicyclic.questions.rating.load_spectrum import bin_edges, cases_text
from epicyclic.show.views import findings_of, tables_of

RPM = np.pi / 30


def of(torque: Any, speed: Any, step: float = 1.0, **options: Any) -> xr.Dataset:
    """Spectrum of torques [N m] and speeds [rpm], a row a step of time [s]."""
    torque = np.asarray(torque, dtype=float)
    columns = {"time [s]": step * np.arange(len(torque)), "torque [N m]": torque}
    return epicyclic.spectrum({**columns, "speed [rpm]": np.broadcast_to(speed, torque.shape)}, **options)


def of_bins(torque: Any, speed: Any, hours: Any, **options: Any) -> xr.Dataset:
    columns = {"torque [N m]": torque, "speed [rpm]": speed, "hours [h]": hours}
    return epicyclic.spectrum(columns, **options)


@pytest.fixture(scope="module")
def random() -> tuple[Any, Any, xr.Dataset]:
    """Torque of both signs and speed of both directions, a row in 0.5 s, with the planetary drive of ren2021."""
    draw = np.random.default_rng(4)
    torque, speed = 1e3 * draw.normal(2, 3, 5000), draw.normal(3, 8, 5000)
    return torque, speed, of(torque, speed, 0.5, train="ren2021", member="stages.main.carrier")


def test_sums_are_those_of_the_history(random: tuple[Any, Any, xr.Dataset]) -> None:
    torque, speed, result = random
    at = 0.5 * np.arange(len(torque))
    turns = scipy.integrate.trapezoid(np.abs(speed), at) / 60
    assert float(result.case_hours.sum()) == pytest.approx(at[-1] / 3600, rel=1e-12)
    assert float(result.case_revolutions.sum()) == pytest.approx(turns, rel=1e-12)
    assert float(result.case_share.sum()) == pytest.approx(1, rel=1e-12)
    assert float(result.case_damage.sum()) == pytest.approx(1, rel=1e-12)
    # the mean speed of a bin turns its revolutions in its time
    each = np.abs(result.case_speed) * 60 * result.case_hours
    np.testing.assert_allclose(each, result.case_revolutions, rtol=1e-12)
    # and the equivalent torques together do the damage of all rows
    weight = np.abs(speed) * np.r_[0.5, np.ones(len(at) - 2), 0.5]
    whole = (np.sum(weight * np.abs(torque) ** 6.61) / weight.sum()) ** (1 / 6.61)
    assert float(result.equivalent_torque) == pytest.approx(whole, rel=1e-12)


def test_signs_are_kept_apart(random: tuple[Any, Any, xr.Dataset]) -> None:
    torque, speed, result = random
    weight = 0.5 * np.r_[0.5, np.ones(len(torque) - 2), 0.5] / 3600
    for sign in (-1, 1):
        for way in (-1, 1):
            rows = (np.sign(torque) == sign) & (np.sign(speed) == way)
            own = result.where((np.sign(result.case_torque) == sign) & (np.sign(result.case_speed) == way), drop=True)
            assert own.sizes["case"] > 1
            assert float(own.case_hours.sum()) == pytest.approx(weight[rows].sum(), rel=1e-12)
    assert 0.0 in result.torque_edge
    assert 0.0 in result.speed_edge


def test_cases_are_named_by_torque_and_speed(random: tuple[Any, Any, xr.Dataset]) -> None:
    *_, result = random
    names = result.case.values.tolist()
    assert names == sorted(names)
    assert names[0] == "bin_01"
    places = list(zip(result.torque_bin.values, result.speed_bin.values, strict=True))
    assert places == sorted(places)
    low, high = (result.torque_edge.values[result.torque_bin.values + one] for one in (0, 1))
    assert ((low <= result.case_torque) & (result.case_torque <= high)).all()


def test_equivalent_torque_of_three_values_by_hand() -> None:
    # 100, 200, 400 N m at 1, 2, 1 rpm for 6, 3, 1 h: 360, 360 and 60 turns, exponent 3
    result = of_bins([100, 200, 400], [1, 2, 1], [6, 3, 1], exponent=3, torque_bins=[0, 500], speed_bins=[0, 3 * RPM])
    (torque,), (speed,) = result.case_torque.values, result.case_speed.values
    assert torque == pytest.approx(((360 * 1 + 360 * 8 + 60 * 64) / 780) ** (1 / 3) * 100, rel=1e-12)
    assert float(result.equivalent_torque) == pytest.approx(torque, rel=1e-12)
    assert speed == pytest.approx(1.3, rel=1e-12)
    apart = of_bins([100, 200, 400], [1, 2, 1], [6, 3, 1], exponent=3, torque_bins=[0, 150, 250, 500])
    np.testing.assert_allclose(apart.case_torque, [100, 200, 400], rtol=1e-12)
    np.testing.assert_allclose(apart.case_damage, np.array([360, 2880, 3840]) / 7080, rtol=1e-12)
    # negative ones of the same sizes have the same value with their sign
    braked = of_bins([-100, -200, -400], [1, 2, 1], [6, 3, 1], exponent=3, torque_bins=1, speed_bins=1)
    assert braked.case_torque.values == pytest.approx([-torque], rel=1e-12)


def test_a_bin_that_stands_is_weighted_by_time() -> None:
    result = of_bins(
        [100, 200, 300], [0, 0, 5], [1, 3, 1], exponent=2, torque_bins=[0, 400], speed_bins=[0, RPM, 9 * RPM]
    )
    standing, turning = result.case_torque.values
    assert standing == pytest.approx(np.sqrt((1 + 3 * 4) / 4) * 100, rel=1e-12)
    assert turning == pytest.approx(300, rel=1e-12)
    assert result.case_damage.values.tolist() == [0, 1]
    assert float(of_bins([100, 200], [0, 0], [1, 3], exponent=2).equivalent_torque) == pytest.approx(
        np.sqrt(13 / 4) * 100, rel=1e-12
    )


def test_large_exponents_and_torques_stay_finite() -> None:
    result = of([1e9, 1e-3, 3e9, 0.0, 0.0], 10.0, exponent=100)
    assert np.isfinite(result.case_torque).all()
    assert float(result.equivalent_torque) == pytest.approx(3e9 * 0.25**0.01, rel=1e-3)
    assert of([0.0, 0.0, 0.0], 1.0).case_torque.values.tolist() == [0.0]


def test_cycles_are_those_of_astm() -> None:
    """ASTM E1049-85, figure 6: 0.5 of 3, 1.5 of 4, 0.5 of 6, 1 of 8 and 0.5 of 9; of 4 one full, E-F."""
    result = of([-2, 1, -3, 5, -1, 3, -4, 4, -2], 10.0)
    found = zip(result.cycle_range.values, result.cycle_mean.values, result.cycle_count.values, strict=True)
    assert sorted(tuple(map(float, one)) for one in found) == [
        *((3, -0.5, 0.5), (4, -1, 0.5), (4, 1, 1.0), (6, 1, 0.5)),
        *((8, 0, 0.5), (8, 1, 0.5), (9, 0.5, 0.5)),
    ]
    assert result.cycle_range.values.tolist() == sorted(result.cycle_range.values, reverse=True)


def test_equal_cycles_are_counted_together() -> None:
    result = of([0, 2, 0, 2, 0, 2, 0], 10.0, exponent=4)
    assert (result.cycle_range.values.tolist(), float(result.cycle_count.sum())) == ([2.0], 3.0)
    assert float(result.equivalent_range) == pytest.approx(2.0, rel=1e-12)
    repeated = of([0, 2, 0, 2, 0, 2, 0], 10.0, life="0.1 h")
    assert float(repeated.case_hours.sum()) == pytest.approx(0.1, rel=1e-12)
    assert float(repeated.cycle_count.sum()) == pytest.approx(3 * 360 / 6, rel=1e-12)
    ranges = of([0, 1, -1, 3], 10.0, exponent=3)  # half cycles of 1, 2 and 4
    assert float(ranges.equivalent_range) == pytest.approx(((1 + 8 + 64) / 3) ** (1 / 3), rel=1e-12)


def test_a_table_of_bins_has_no_cycles_and_a_constant_torque_neither() -> None:
    assert "cycle_range" not in of_bins([1, 2], [1, 1], [1, 1])
    assert of([5.0, 5.0, 5.0], 1.0).sizes["cycle"] == 0


def test_members_turn_as_the_kinematics_says(random: tuple[Any, Any, xr.Dataset]) -> None:
    """ren2021: ring held; sun, planet, ring of z teeth, by Willis' equation."""
    *_, result = random
    gears = epicyclic.check("ren2021")
    teeth = {
        str(name).split("/")[1]: float(count) for name, count in zip(gears.gear.values, gears.teeth.values, strict=True)
    }
    sun, planet, ring = (teeth[name] for name in ("sun", "planet", "ring"))
    turns = float(result.case_revolutions.sum())
    expected = {
        "main.carrier": (1.0, 1.0),
        "main.sun": (1 + ring / sun, ring / sun),
        "main.planet": (ring / planet - 1, ring / planet),
        "main.ring": (0.0, 1.0),
    }
    for member, (housing, frame) in expected.items():
        own = result.sel(member=member)
        assert float(own.member_revolutions) == pytest.approx(turns * housing, rel=1e-12), member
        assert float(own.member_frame_revolutions) == pytest.approx(turns * frame, rel=1e-12), member
        assert float(own.member_hours) == pytest.approx(float(result.case_hours.sum()), rel=1e-12)
    assert float(result.member_speed_ratio.sel(member="main.planet")) == pytest.approx(1 - ring / planet, rel=1e-12)


def test_a_member_that_says_nothing_of_the_others_is_refused() -> None:
    with pytest.raises(ModelError, match=r"^member: is missing.*main\.carrier"):
        of([1, 2], 1.0, train="ren2021")
    with pytest.raises(ModelError, match=r"member = ring: does not turn"):
        of([1, 2], 1.0, train="ren2021", member="ring")
    with pytest.raises(ModelError, match=r"member = carrie: no such member; did you mean 'carrier'"):
        of([1, 2], 1.0, train="ren2021", member="carrie")
    free = epicyclic.differential(
        teeth="24/30/84", speed={"sun": "100 rpm", "carrier": "10 rpm"}, torque={"sun": "9 N m"}
    )
    with pytest.raises(ModelError, match=r"train = .*several speeds are free"):
        of([1, 2], 1.0, train=free, member="sun")
    with pytest.raises(ModelError, match=r"overrides = .*: go with a train"):
        of([1, 2], 1.0, overrides={"title": "x"})


@pytest.mark.parametrize(
    ("values", "bins", "edges"),
    [
        ([0, 480], 10, np.arange(0, 501, 50)),
        ([-30, 480], 10, np.arange(-100, 501, 100)),
        ([1480, 1520], 4, [1400, 1500, 1600]),
        ([12.0, 12.0], 4, [12, 13]),
        ([0, 0], 4, [0, 1]),
        ([-7, -7], 4, [-7, -6.5]),
        ([-5, 5], [-10, 10], [-10, 0, 10]),
        ([5, 8], [9, 5], [5, 9]),
    ],
)
def test_edges_are_round_and_have_zero(values: list[float], bins: Any, edges: list[float]) -> None:
    np.testing.assert_allclose(bin_edges(np.array(values, dtype=float), bins, "torque_bins"), edges, rtol=1e-12)


def test_speeds_on_an_edge_are_above_it() -> None:
    speed = 10.0 * np.arange(201)  # [rpm]; in rad/s and back some are 1e-16 of them below
    assert (speed * RPM / RPM < speed).any()
    result = of(np.ones(201), speed, speed_bins=200)
    assert result.speed_bin.values.tolist() == list(range(200))
    assert result.case_hours.values[-1] == pytest.approx(1.5 / 3600)  # the last bin has both of its edges


def test_a_row_of_no_time_is_no_load_case() -> None:
    result = of_bins([100, 900], [1, 99], [1, 0])
    assert result.case_hours.values.tolist() == [1.0]
    assert float(result.torque_edge.max()) < 200


def test_bins_are_said_with_units() -> None:
    result = of([1e3, 2e3, 3e3], 10.0, torque_bins="0, 2.5, 5 kN m", speed_bins="2")
    assert result.torque_edge.values.tolist() == [0, 2500, 5000]
    for bins, said in (
        ("0, 5", "a number without a unit"),
        ("0", "out of range"),
        ("0, 2 kN m", "do not reach"),
        ("x", "not values"),
    ):
        with pytest.raises(ModelError, match=f"torque_bins = .*{said}"):
            of([1e3, 2e3, 3e3], 10.0, torque_bins=bins)


def test_load_cases_are_tables_of_a_model_file(random: tuple[Any, Any, xr.Dataset]) -> None:
    *_, result = random
    text = cases_text(result)
    assert [line.partition("]")[0] for line in text.splitlines() if line.startswith("[")] == [
        f"[cases.{name}" for name in result.case.values
    ]
    found = tomllib.loads(text)
    assert list(found) == ["cases"]
    assert list(found["cases"]) == result.case.values.tolist()
    for name, table in found["cases"].items():
        row = result.sel(case=name)
        assert {path for path, _ in leaves(table)} == {"speed.main.carrier", "torque.main.carrier", "duration"}
        for path, kind, value in (
            ("speed.main.carrier", "speed", float(row.case_speed) * RPM),
            ("torque.main.carrier", "torque", float(row.case_torque)),
            ("duration", "time", float(row.case_hours) * 3600),
        ):
            said = dict(leaves(table))[path]
            assert read_quantity(said, (kind,), Bounds(), listed=True) == pytest.approx(value, rel=1e-6)
    with pytest.raises(ModelError, match=r"^member: is missing"):
        cases_text(of([1, 2], 1.0))


def test_operation_takes_what_is_written() -> None:
    """Speed and torque of a load case, put into the model, are those of its kinematics."""
    result = of_bins([9e4, 9e4], [12.1, 12.1], [812, 100], train="ren2021", member="carrier")
    (table,) = tomllib.loads(cases_text(result))["cases"].values()
    assert table["duration"] == "912 h"
    (case,) = ({f"operation.{path}": text for path, text in leaves(table) if path != "duration"},)
    train = epicyclic.load("ren2021", overrides={"operation.speed.sun": "", "operation.torque.sun": "", **case})
    assert train.kinematics.speed is not None
    assert float(train.kinematics.speed["main.carrier"]) == pytest.approx(12.1, rel=1e-12)


def test_findings_say_where_the_hours_and_the_damage_are() -> None:
    result = of_bins([100, 200, 900], [10, 10, 10], [80, 18, 2], torque_bins=[0, 500, 1000], speed_bins=[0, 20 * RPM])
    (found,) = findings_of({"spectrum": result})
    assert found.text.startswith(
        "98 % of the hours below 0.5 kN m; most damaging is bin_02, 0.5 to 1 kN m at 0 to 20 rpm"
    )
    assert found.text.endswith("100 % of the damage in 2.0 % of the hours.")


def test_tables_and_figures(random: tuple[Any, Any, xr.Dataset]) -> None:
    *_, result = random
    cases, members = tables_of(result)
    assert len(cases.columns["case"]) == min(40, result.sizes["case"])
    assert members.columns["member"] == result.member.values.tolist()
    heat = epicyclic.plot("load-spectrum", result).data[0]
    hours = np.array([[np.nan if one is None else 10**one for one in row] for row in heat.z])
    assert hours.shape == (len(heat.y) - 1, len(heat.x) - 1)
    assert np.nansum(hours) == pytest.approx(float(result.case_hours.sum()), rel=1e-3)
    curve = epicyclic.plot("rainflow", result).data[0]
    assert curve.x[-1] == pytest.approx(float(result.cycle_count.sum()), rel=1e-4)
    assert list(curve.y) == sorted(curve.y, reverse=True)
    with pytest.raises(ModelError, match="nothing to draw"):
        epicyclic.plot("rainflow", of_bins([1], [1], [1]))


def test_the_command_writes_load_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("history.csv").write_text("time [s], torque [kN m], speed [rpm]\n0,1,12\n3600,2,12\n7200,2,12\n")
    run = CliRunner()
    done = run.invoke(app, ["spectrum", "history.csv", "--member", "main.carrier", "-o", "cases.toml"])
    assert done.exit_code == 0, done.output
    assert "of the hours below" in done.output
    cases = tomllib.loads(Path("cases.toml").read_text())["cases"]
    assert [table["duration"] for table in cases.values()] == ["1800 s", "1.5 h"]
    assert cases["bin_02"]["torque"] == {"main": {"carrier": "2000 N m"}}
    Path("cases.toml").unlink()
    refused = run.invoke(app, ["spectrum", "history.csv", "-o", "cases.toml"])
    assert refused.exit_code == 2
    assert "--member: is missing" in refused.output
    assert not Path("cases.toml").exists()
    assert run.invoke(app, ["spectrum", "history.csv", "--json"]).exit_code == 0


def test_a_result_is_saved_and_read_again(random: tuple[Any, Any, xr.Dataset], tmp_path: Path) -> None:
    *_, result = random
    for name in ("spectrum.nc", "spectrum.json"):
        epicyclic.save_result(result, tmp_path / name)
        xr.testing.assert_equal(epicyclic.load_result(tmp_path / name), result)


def test_time_grows_with_the_rows(tmp_path: Path) -> None:
    """100 000 rows of a file in a few seconds of processor: a square of their number would take minutes."""
    draw = np.random.default_rng(1)
    rows = np.column_stack([0.1 * np.arange(100_000), draw.normal(100, 50, 100_000), draw.normal(12, 1, 100_000)])
    path = tmp_path / "history.csv"
    np.savetxt(path, rows, fmt="%.6g", delimiter=",", header="time [s], torque [kN m], speed [rpm]", comments="")
    clock = time.process_time()
    result = epicyclic.spectrum(path)
    spent = time.process_time() - clock
    print(f"100 000 rows: {spent:.2f} s, {result.sizes['cycle']} cycles")
    assert spent < 10


def test_two_rows_are_half_a_cycle() -> None:
    result = of([0.0, 200.0], 10.0)
    assert result.cycle_count.values.tolist() == [0.5]
    assert result.cycle_range.values.tolist() == [200.0]
    assert result.cycle_mean.values.tolist() == [100.0]


def test_what_is_read_of_a_text_is_within_its_bounds() -> None:
    with pytest.raises(ModelError, match=r"life = 0 h: out of range; allowed: time .*, > 0 and"):
        of([1.0, 2.0], 10.0, life="0 h")


def test_a_part_of_a_model_is_not_written_over_a_whole_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("history.csv").write_text("time [s], torque [N m], speed [rpm]\n0, 1, 9\n1, 2, 9\n", encoding="utf-8")
    Path("model.toml").write_text('format = 2\ntitle = "mine"\n', encoding="utf-8")
    words = ["spectrum", "history.csv", "--member", "carrier", "-o", "model.toml"]
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2
    assert "--output = model.toml: is a model file" in refused.output
    assert Path("model.toml").read_text(encoding="utf-8").startswith("format")
    every = CliRunner().invoke(app, [*words[:2], "--train", "ren2021", "--member", "carrier", "--set", "case=all"])
    assert every.exit_code == 2
    assert "has no load cases, it gives them" in every.output
