"""The table of attributes: each id once, each unit known, each row of a gear, flank or material carried both ways."""

from __future__ import annotations

from typing import Any

import pytest
from tests.unit.rexs.test_rexs_export import SPUR

import epicyclic
from epicyclic.rexs.export import left_out, rexs_of
from epicyclic.rexs.file import QUANTITIES, RELATIONS, ROW, RexsRow, number_in, rows_of
from epicyclic.rexs.import_train import import_file

TYPES = ("cylindrical_gear", "cylindrical_gear_flank", "material")
BOTH_WAYS = [row for kind in TYPES for row in rows_of(kind) if row.key and (row.of or row.default)]
HELICAL: dict[str, Any] = {
    **SPUR,
    "material": {"density": "7.7 g/cm^3", "youngs_modulus": "200 GPa", "poisson_ratio": 0.29},
    "stages": {
        "main": {
            **SPUR["stages"]["main"],
            "helix_angle": "12 deg",
            "pressure_angle": "20 deg",
            "sun": {**SPUR["stages"]["main"]["sun"], "face_width": "55 mm", "hand": "left", "profile_shift": 0.1},
            "planet": {**SPUR["stages"]["main"]["planet"], "profile_shift": -0.1},
        }
    },
}


def test_each_row_says_something_of_its_own() -> None:
    kinds = {row.type for row in ROW.values()}
    assert sum(len(rows_of(kind)) for kind in kinds) == len(ROW)
    assert {row.unit for row in ROW.values()} <= QUANTITIES.keys()
    for row in ROW.values():
        assert number_in(1.0, row.unit, QUANTITIES[row.unit], row.id).si > 0, row
    assert all(len(set(roles)) == len(roles) for roles in RELATIONS.values())


def test_rows_of_gears_flanks_and_materials() -> None:
    assert {row.key for row in BOTH_WAYS} == {
        *("teeth", "module", "helix_angle", "face_width", "tip_diameter", "root_diameter", "pressure_angle"),
        *("profile_shift", "density", "youngs_modulus", "poisson_ratio"),
    }


@pytest.mark.parametrize("row", BOTH_WAYS, ids=lambda row: row.id)
def test_a_row_is_written_and_read_back(row: RexsRow) -> None:
    file = rexs_of(epicyclic.load(HELICAL)).file
    imported = import_file(file)
    again = rexs_of(epicyclic.load(dict(imported.document))).file
    written = [c for c in file.components if c.type == row.type]
    back = [c for c in again.components if c.type == row.type]
    assert written
    for component, same in zip(written, back, strict=True):
        attribute = component.attributes[row.id]
        assert attribute.unit == row.unit
        assert same.attributes[row.id].value == pytest.approx(attribute.value, rel=1e-12)
    assert any(e.attribute == row.id and e.path.endswith(f".{row.key}") for e in imported.read)


@pytest.mark.parametrize("row", BOTH_WAYS, ids=lambda row: row.id)
def test_what_a_row_carries_is_not_left_out(row: RexsRow) -> None:
    table: Any = {row.key: 1.0}
    document = {"material": table} if row.type == "material" else {"stages": {"main": {"sun": table}}}
    assert list(left_out(document)) == []
