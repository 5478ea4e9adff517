"""`check`: what it says about trains whose figures are known."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.views import tables_of
from epicyclic.train.new_train import new_train


@pytest.fixture(scope="module")
def ren2021() -> xr.Dataset:
    return epicyclic.check("ren2021")


def test_speeds_and_mesh_frequency(ren2021: xr.Dataset) -> None:
    speed = ren2021.speed.groupby(ren2021.member).mean() * math.pi / 30
    # printed with three to five digits: 10.472, 3.0107, -7.0840 rad/s; half a unit of the last
    assert float(speed.sel(member="main.sun")) == pytest.approx(10.472, abs=5e-4)
    assert float(speed.sel(member="main.carrier")) == pytest.approx(3.0107, abs=5e-5)
    assert float(speed.sel(member="main.planet")) == pytest.approx(-7.0840, abs=5e-5)
    assert float(ren2021.mesh_frequency.sel(stage="main")) == 27.3125  # 437/16, exact in binary
    assert float(ren2021.hunting_period.sel(stage="main")) == 23 * 17 * 57


@pytest.mark.parametrize(
    ("kind", "teeth", "cycles"),
    [
        ("planetary", "24/12/48", 48),
        # n/21, n/60 and (n/60)(24/105) whole
        ("compound", "21/60/24/105", math.lcm(21, 60, 525)),
    ],
)
def test_hunting_period_counts_mesh_cycles(kind: str, teeth: str, cycles: int) -> None:
    model = new_train(kind=kind, teeth=teeth, speed="1000 rpm", torque="100 N m").document
    assert float(epicyclic.check(model).hunting_period.sel(stage="main")) == cycles


def test_torques_balance(ren2021: xr.Dataset) -> None:
    assert float(ren2021.torque.sum()) == pytest.approx(0.0, abs=1e-6)  # N m; rounding of 1e5 N m
    assert float(ren2021.power.sum()) == pytest.approx(0.0, abs=1e-5)  # W; rounding of 1 MW
    ring = ren2021.torque.sel(body=["main/ring/left", "main/ring/right"])
    assert ring.values == pytest.approx([100e3 * 57 / 23 / 2] * 2, rel=1e-12)  # half of the held member's each


def test_shaft_orders_are_those_of_the_teeth(ren2021: xr.Dataset) -> None:
    order = ren2021.order
    for member, teeth in (("sun", 23), ("planet", 17), ("ring", 57)):
        name = f"main.{member} in the carrier's frame"
        assert float(order.sel(order_name=name)) == pytest.approx(1 / teeth, rel=1e-15)  # one turn in `teeth` cycles


def test_geometry(ren2021: xr.Dataset) -> None:
    sun = ren2021.sel(gear="main/sun")
    transverse = 0.032 / math.cos(math.radians(25))
    angle = math.atan(math.tan(math.radians(20)) / math.cos(math.radians(25)))
    assert float(sun.base_radius) == pytest.approx(23 * transverse / 2 * math.cos(angle), rel=1e-14)  # rounding
    assert float(ren2021.centre_distance.item()) == pytest.approx(40 * transverse / 2, rel=1e-12)  # rounding
    assert ren2021.base_radius.attrs["units"] == "m"


def test_every_value_has_an_origin(ren2021: xr.Dataset) -> None:
    values = {path: (value, unit, origin) for path, value, unit, origin in json.loads(ren2021.attrs["values"])}
    assert values["stages.main.sun.mass"] == (750.0, "kg", "given")
    assert values["stages.main.module"][2] == "assumed"
    assert all(origin for _, _, origin in values.values())
    assert "stages.main.module" in json.loads(ren2021.attrs["assumed"])


def test_drawing_radii(ren2021: xr.Dataset) -> None:
    outer = ren2021.outer_radius
    assert np.isfinite(outer).all()
    assert float(outer.sel(body="main/ring/left")) > float(ren2021.root_radius.sel(gear="main/ring/left"))
    assert float(outer.sel(body="main/carrier")) > float(ren2021.centre_distance.item())


def test_a_ring_is_drawn_as_wide_as_it_is_given() -> None:
    """`outer_diameter` or `rim`; two modules beyond the roots where neither is."""

    def outer(**given: str) -> tuple[float, float]:
        overrides = {f"stages.main.ring.{name}": value for name, value in given.items()}
        found = epicyclic.check("xu2020", overrides=overrides)
        root = float(found.root_radius.sel(gear="main/ring/left"))
        return float(found.outer_radius.sel(body="main/ring/left")), root

    assert outer()[0] == pytest.approx(0.825, rel=1e-12)  # 1650 mm
    radius, root = outer(outer_diameter="", rim="70 mm")
    assert radius == pytest.approx(root + 0.070, rel=1e-12)
    radius, root = outer(outer_diameter="", mass="3000 kg", inertia="1800 kg m^2")
    module = epicyclic.load("xu2020").bodies[1].gear
    assert module is not None
    assert radius == pytest.approx(root + 2 * module.module, rel=1e-12)


def test_without_speeds() -> None:
    result = epicyclic.check("lin1999-n4")
    assert np.isnan(result.speed).all()
    assert np.isnan(result.mesh_frequency).all()
    assert result.sizes["order_name"] == 0
    assert result.sizes["mesh"] == 8


def test_saved_and_reopened(ren2021: xr.Dataset, tmp_path: object) -> None:
    path = epicyclic.save_result(ren2021, f"{tmp_path}/check.nc")
    xr.testing.assert_identical(epicyclic.load_result(path)["speed"], ren2021["speed"])


def test_phases_of_deviations_are_shown_in_degrees(ren2021: xr.Dataset) -> None:
    (table,) = (one for one in tables_of(ren2021) if "phase [deg]" in one.columns)
    assert table.columns["phase [deg]"] == pytest.approx(np.degrees(ren2021.deviation_phase.values))
    assert np.abs(ren2021.deviation_phase).max() > 1
