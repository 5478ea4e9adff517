"""Inheritance of keys: side, else member or mesh, else stage, else file."""

from __future__ import annotations

from typing import Any

import pytest

from epicyclic.document.schema import FlankTable, MemberTable, SideTable, StageTable
from epicyclic.document.schema_fields import SupportTable
from epicyclic.train.resolution import load, resolved_document
from epicyclic.train.stages import Level, Levels, origin_of, overlaid, stated, stated_value, subtables


def levels_of(side: Any = None, member: Any = None, stage: Any = None) -> Levels:
    return Level("side", "a.b.left", side), Level("member", "a.b", member), Level("stage", "a", stage)


def test_the_nearest_table_that_states_a_key_decides() -> None:
    side, member, stage = SideTable(), MemberTable(kind="sun", face_width=2.0), StageTable(face_width=3.0)
    found = stated(levels_of(side, member, stage), "face_width")
    assert found == (2.0, "member", "a.b.face_width")
    assert stated(levels_of(SideTable(face_width=1.0), member, stage), "face_width") == (
        1.0, "side", "a.b.left.face_width",
    )  # fmt: skip
    assert stated(levels_of(None, None, stage), "face_width") == (3.0, "stage", "a.face_width")
    assert stated(levels_of(), "face_width") is None
    assert stated_value(levels_of(), "face_width", 4.0) == 4.0


def test_a_stated_zero_counts() -> None:
    assert stated_value(levels_of(None, MemberTable(kind="sun", gap=0.0), StageTable(gap=1.0)), "gap", 2.0) == 0.0


def test_origins() -> None:
    stage = StageTable(gap=1.0)
    assert origin_of(stated(levels_of(None, None, stage), "gap")) == "stage"
    assert origin_of(stated(levels_of(None, MemberTable(kind="sun", gap=1.0), stage), "gap")) == "given"
    assert origin_of(None) == "default"


def test_keys_of_tables_are_inherited_one_by_one() -> None:
    member = MemberTable(kind="sun", flank=FlankTable(crown=1.0))
    levels = subtables(levels_of(None, member, StageTable(flank=FlankTable(crown=2.0, slope=3.0))), "flank")
    assert stated(levels, "crown") == (1.0, "member", "a.b.flank.crown")
    assert stated(levels, "slope") == (3.0, "stage", "a.flank.slope")


def test_tables_lie_over_each_other() -> None:
    member = MemberTable(kind="sun", support=SupportTable(x=1.0, y=2.0))
    table, path = overlaid(levels_of(SideTable(support=SupportTable(y=3.0)), member)[:2], "support")
    assert (table.x, table.y, path) == (1.0, 3.0, "a.b.left.support")
    assert overlaid(levels_of(None, member)[:2], "support") == (member.support, "a.b.support")
    assert overlaid(levels_of()[:2], "support") == (None, "a.b.support")


@pytest.mark.parametrize(
    ("overrides", "density"),
    [
        ({}, 7850.0),
        ({"material.density": 7000.0}, 7000.0),
        ({"material.density": 7000.0, "stages.main.material.density": 7100.0}, 7100.0),
        ({"stages.main.material.density": 7100.0, "stages.main.sun.material.density": 7200.0}, 7200.0),
    ],
)
def test_the_material_of_a_gear(overrides: dict[str, float], density: float) -> None:
    model = {
        "format": 2,
        "title": "pair",
        "stages": {
            "main": {
                "module": 0.004, "face_width": 0.04,
                "sun": {"teeth": 24}, "planet": {"teeth": 24}, "ring": {"teeth": 72, "rim": 0.03}, "planets": 3,
            }
        },
        "operation": {"held": ["ring"]},
    }  # fmt: skip
    mass = {b.name: b.mass for b in load(model, {"stages.main.carrier": {"mass": 1, "inertia": 1}, **overrides}).bodies}
    assert mass["main/sun"] == pytest.approx(density * 3.141592653589793 * 0.048**2 * 0.04, rel=1e-12)


def test_a_stated_phase_of_a_mesh_is_that_of_the_left_half_where_the_right_one_is_staggered() -> None:
    """By hand: the sun of xu2020 turns positive, so the right half leads by the stagger; a side states its own."""
    phase = {"stages.main.meshes.sun-planet.phase": [0.0, 0.7, 0.5, 0.2], "stages.main.stagger": 0.125}

    def leads(side: str, changes: dict[str, object]) -> list[float]:
        found = {mesh.name: float(mesh.lead) for mesh in load("xu2020", changes).meshes}
        return [found[f"main/sun-planet/{i}/{side}"] for i in (1, 2, 3, 4)]

    assert leads("left", phase) == pytest.approx([0.0, 0.7, 0.5, 0.2])
    assert leads("right", phase) == pytest.approx([0.125, 0.825, 0.625, 0.325])
    own = {**phase, "stages.main.meshes.sun-planet.right.phase": 0.4}
    assert leads("right", own) == [0.4] * 4
    again = resolved_document(load("xu2020", phase))
    assert [float(mesh.lead) for mesh in load(again).meshes] == [
        float(mesh.lead) for mesh in load("xu2020", phase).meshes
    ]
