"""`check` says which mesh order drives which kind of mode: the rule of the tooth numbers, from the leads."""

from __future__ import annotations

import pytest

import epicyclic
from epicyclic.show.brief_check import brief_tables, driven_kinds

DRIVES = ("wind-stage", "wind-five", "dong2019")


@pytest.mark.parametrize("name", DRIVES)
def test_an_order_drives_what_the_teeth_of_the_sun_leave(name: str) -> None:
    result = epicyclic.check(name)
    (table,) = driven_kinds(result)
    words = f"mesh orders {table.columns['rotational modes'][0]} drive rotational modes"
    assert any(words in one.lead for one in brief_tables(result))
    gears = dict(zip(result.gear.values, result.teeth.values, strict=True))
    teeth = next(int(count) for gear, count in gears.items() if str(gear).split("/")[1] == "sun")
    count = int(result.mesh_branch.values.max())
    expected: dict[str, list[str]] = {kind: [] for kind in ("rotational", "translational", "planet")}
    for order in range(1, 13):
        left = order * teeth % count
        kind = "rotational" if left == 0 else "translational" if left in (1, count - 1) else "planet"
        expected[kind].append(str(order))
    for kind, orders in expected.items():
        assert table.columns[f"{kind} modes"] == [", ".join(orders) or "none"]


def test_nothing_is_said_of_planets_that_are_not_evenly_spaced() -> None:
    result = epicyclic.check("wind-five")
    result["axes_angle"][{"body": [str(one).endswith("planet/2") for one in result.body.values].index(True)}] += 0.01
    assert driven_kinds(result) == []
