"""What `check`, `static` and the report say of a ring that bends, against closed forms."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from tests.unit.elastic_ring_set import BENDING, RADIUS, ring_set

import epicyclic
from epicyclic.show.charts.train import ring_deflections
from epicyclic.show.part_tables import deflection_tables, ring_tables
from epicyclic.show.views import brief_of, sections_of, tables_of
from epicyclic.verbs import record

WIND = {"stages.main.ring.elastic": {"modes": 6}}


def test_check_tells_section_orders_and_free_frequencies() -> None:
    check = epicyclic.check(ring_set(4))
    table, every = ring_tables(check)
    assert table.title in [one.title for one in brief_of(check)]
    assert table.columns["ring"] == ["main/ring"]
    assert table.columns["centre line R [mm]"] == pytest.approx([1e3 * RADIUS], rel=1e-9)
    assert table.columns["E I [kN m2]"] == pytest.approx([1e-3 * BENDING], rel=1e-9)
    assert table.columns["mass [kg/m]"] == pytest.approx([2.35 / (2 * math.pi * RADIUS)], rel=1e-9)
    assert table.columns["orders up to n"] == [12]
    # free n = 2: 6/sqrt(5) sqrt(E I/(rho A R^4)); what is left out is logged with the values
    rate = math.sqrt(BENDING / (2.35 / (2 * math.pi * RADIUS) * RADIUS**4)) / (2 * math.pi)
    assert table.columns["free, n = 2 [Hz]"] == pytest.approx([6 / math.sqrt(5) * rate], rel=1e-9)
    assert table.columns["highest n [Hz]"] == pytest.approx([12 * 143 / math.sqrt(145) * rate], rel=1e-9)
    logged = {path: value for path, value, *_ in json.loads(check.attrs["values"])}
    assert table.columns["left out per mesh [%]"] == pytest.approx(
        [100 * logged["stages.main.ring.elastic.left_out"]], rel=1e-12
    )
    assert every.title in [one.title for one in tables_of(check)]
    assert every.columns["order n"] == list(range(2, 13))
    n = np.arange(2, 13)
    assert every.columns["main/ring [Hz]"] == pytest.approx(n * (n**2 - 1) / np.sqrt(n**2 + 1) * rate, rel=1e-9)
    rigid = epicyclic.check("lin1999-n4")
    assert not ring_tables(rigid)


def test_static_tells_how_far_each_order_bends_and_where() -> None:
    """Three planets push the ring outward and along: order 3 and its multiples stand still, and lead."""
    train = epicyclic.load("wind-stage", WIND | {"tolerance": None})
    static, check = epicyclic.static(train), epicyclic.check(train)
    (table,) = deflection_tables(static)
    assert table.title in [one.title for one in tables_of(static)]
    columns = {name: np.array(values) for name, values in table.columns.items()}
    a, b = (1e6 * static.displacement.sel(dof=f"main/ring/{part}3") for part in "ab")
    row = int(np.flatnonzero(columns["order n"] == 3)[0])
    assert columns["mean a [µm]"][row] == pytest.approx(float(a.mean()))
    assert columns["largest amplitude [µm]"][row] == pytest.approx(float(np.hypot(a, b).max()))
    assert np.argsort(columns["largest amplitude [µm]"])[::-1][:2].tolist() == [row, row + 3]
    # at the angle told the mean of the order is at its most
    at = math.radians(columns["outward at [deg]"][row])
    most = float(a.mean()) * math.cos(3 * at) + float(b.mean()) * math.sin(3 * at)
    assert most == pytest.approx(float(np.hypot(a.mean(), b.mean())), rel=1e-12)
    # the figure: sum of all orders, and the meshes at 0, 120, 240 deg
    drawn = ring_deflections(static, check)
    mean = next(trace for trace in drawn.data if trace.name == "main/ring")
    psi = np.radians(np.array(mean.x, float))
    wanted = sum(
        columns["mean a [µm]"][i] * np.cos(n * psi) + columns["mean b [µm]"][i] * np.sin(n * psi)
        for i, n in enumerate(columns["order n"])
    )
    np.testing.assert_allclose(np.array(mean.y, float), wanted, atol=1e-3 * np.abs(wanted).max())
    marks = sorted(float(shape.x0) for shape in drawn.layout.shapes if shape.x0 == shape.x1)
    assert marks == pytest.approx([0.0, 120.0, 240.0], abs=1e-6)
    (section,) = sections_of({"static": static, "check": check})[-1:]
    assert "ring-bending" in [getattr(part, "anchor", "") for part in section.parts]
    assert not deflection_tables(epicyclic.static("wind-stage", overrides={"tolerance": None}))


def test_steady_tells_it_too() -> None:
    steady = epicyclic.steady(epicyclic.load("wind-stage", WIND | {"tolerance": None}))
    assert "Bending of rings" in [table.title for table in tables_of(steady)]


def test_a_report_of_a_ring_that_bends_has_its_static_deflection(monkeypatch: pytest.MonkeyPatch) -> None:
    def only_check(steps: Mapping[str, Any], *_: object) -> list[Any]:
        return [step() if name == "check" else "not now" for name, step in steps.items()]

    monkeypatch.setattr(record, "_run_steps", only_check)
    for train, told in ((ring_set(4), True), (epicyclic.load("lin1999-n4"), False)):
        left_out = json.loads(record.run_report(train)["check"].attrs["not_run"])
        assert any(text.startswith("static,") for text in left_out) == told
