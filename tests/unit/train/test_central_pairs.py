"""Two central gears that mesh beside planets, and halves of a split member that take torque each for itself."""

from __future__ import annotations

import math
from typing import Any

import pytest

import epicyclic


def planetary(**operation: Any) -> dict[str, Any]:
    """A planetary set, three planets, its ring held."""
    return {
        "format": 2,
        "title": "a set",
        "damping": {"modal": 0.03},
        "stages": {
            "main": {
                "planets": 3,
                "module": "4 mm",
                "face_width": "40 mm",
                "sun": {"teeth": 21, "support": {"radial": "1e9 N/m"}},
                "planet": {"teeth": 39, "bearing": {"radial": "1e9 N/m"}},
                "ring": {"teeth": 99, "rim": "20 mm"},
                "carrier": {"mass": "20 kg", "inertia": "0.2 kg m^2"},
            }
        },
        "operation": {"held": ["main.ring"], **operation},
    }


def test_a_pair_of_central_gears_meshes_once() -> None:
    data = planetary(speed={"main.carrier": "100 rpm"}, torque={"main.pinion": "50 N m", "main.carrier": "balance"})
    data["stages"]["main"]["pinion"] = {"kind": "gear", "teeth": 20, "support": {"radial": "1e9 N/m"}}
    data["stages"]["main"]["meshes"] = {"pinion-sun": {"stiffness": "1e9 N/m"}, "planet-ring": {}, "sun-planet": {}}
    train = epicyclic.load(data)
    meshes = [mesh for mesh in train.meshes if mesh.pair == "stages.main.meshes.pinion-sun"]
    assert [(mesh.name, mesh.branch, mesh.stiffness) for mesh in meshes] == [("main/pinion-sun", None, 1e9)]
    assert len(train.meshes) == 7
    force = epicyclic.static(train, cycles=1).mesh_force.sel(mesh="main/pinion-sun").values
    # the whole torque over the base radius of the pinion, 20 teeth of 4 mm
    assert force == pytest.approx(50 / (0.04 * math.cos(math.radians(20))), rel=1e-9)


def split(**operation: Any) -> dict[str, Any]:
    data = planetary(**operation)
    main = data["stages"]["main"]
    main |= {"gap": "40 mm", "helix_angle": "20 deg"}
    main["sun"] |= {
        "split": True,
        "neck": {"radial": "1e9 N/m", "rz": "1e6 N m/rad"},
        "support": {"radial": "1e9 N/m", "z": "1e9 N/m"},
    }
    main["planet"]["herringbone"] = main["ring"]["herringbone"] = True
    main["planet"]["bearing"] |= {"z": "1e9 N/m", "tilt": "1e7 N m/rad"}
    return data


@pytest.mark.parametrize(
    ("operation", "left", "right"),
    [
        ({"power": {"main.sun.left": "100 kW", "main.sun.right": "50 kW"}}, 954.9297, 477.4648),
        ({"power": {"main.sun.left": "150 kW"}}, 1432.3945, 0.0),
        ({"torque": {"main.sun.left": "100 N m", "main.sun.right": "-100 N m"}}, 100.0, -100.0),
        ({"torque": {"main.sun.left": "100 N m", "main.sun": "300 N m"}}, None, None),
    ],
)
def test_halves_take_the_torque_that_is_stated_for_them(
    operation: dict[str, Any], left: float | None, right: float | None
) -> None:
    data = split(speed={"main.sun": "1000 rpm"}, **operation)
    if left is None:
        with pytest.raises(epicyclic.ModelError, match="given twice"):
            epicyclic.load(data)
        return
    train = epicyclic.load(data)
    found = [train.torques.get(f"main/sun/{side}", 0.0) for side in ("left", "right")]
    assert found == pytest.approx([left, right], rel=1e-6)


ONE_PIECE = "is a side of a member in one piece"


@pytest.mark.parametrize(
    ("herringbone", "changes", "message"),
    [
        (False, {"stages.main.sun.left.mass": "3 kg"}, rf"stages\.main\.sun\.left: {ONE_PIECE}"),
        (False, {"deviations.sun.left.run_out": "30 um"}, rf"deviations\.main\.sun\.left: {ONE_PIECE}"),
        (False, {"deviations.planet.right.position": "30 um"}, rf"deviations\.main\.planet\.right: {ONE_PIECE}"),
        (True, {"deviations.sun.left.run_out": "30 um"}, rf"deviations\.main\.sun\.left: {ONE_PIECE}"),
        (True, {"stages.main.sun.left.mass": "3 kg"}, r"stages\.main\.sun\.left\.mass: is of a half, and both helices"),
    ],
)
def test_a_side_of_a_member_in_one_piece_is_refused(herringbone: bool, changes: dict[str, str], message: str) -> None:
    data = planetary(speed={"main.sun": "1000 rpm"}, torque={"main.sun": "100 N m"})
    data["stages"]["main"] |= {"herringbone": herringbone, **({"helix_angle": "20 deg"} if herringbone else {})}
    epicyclic.load(data)
    with pytest.raises(epicyclic.ModelError, match=message):
        epicyclic.load(data, changes)


@pytest.mark.parametrize("key", ["torque", "power"])
def test_a_side_of_one_piece_is_named_where_it_stands(key: str) -> None:
    value = {"torque": "100 N m", "power": "10 kW"}[key]
    with pytest.raises(
        epicyclic.ModelError, match=rf"operation\.{key}\.main\.sun: names a side of a member in one piece"
    ):
        epicyclic.load(planetary(speed={"main.sun": "1000 rpm"}, **{key: {"main.sun.left": value}}))
