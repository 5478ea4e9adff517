"""Bolts on a pitch circle, closed forms, turning frames, thin rims."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.system.system import System
from epicyclic.train.resolution import load, resolved_document

RADIAL, TANGENTIAL, AXIAL, RADIUS = 2e8, 5e8, 7e8, 0.3
BOLTS: dict[str, Any] = {"radius": RADIUS, "radial": RADIAL, "tangential": TANGENTIAL, "z": AXIAL}


def document(support: dict[str, Any], member: str = "ring", held: str = "ring", **stage: Any) -> dict[str, Any]:
    """A planetary set whose one member is supported as said."""
    main: dict[str, Any] = {
        "planets": 3,
        "module": 0.004,
        "face_width": 0.04,
        "sun": {"teeth": 24, "support": {"radial": 1e8}},
        "planet": {"teeth": 24, "bearing": {"radial": 1e8}},
        "ring": {"teeth": 72, "rim": 0.03, "support": {"radial": 1e9}},
        "carrier": {"mass": 20.0, "inertia": 0.2, "tilt_inertia": 0.1, "support": {"radial": 1e8}},
    }
    main[member]["support"] = support
    moving = next(name for name in ("sun", "ring") if name != held)
    return {
        "format": 2,
        "title": "bolts",
        "stages": {"main": main | stage},
        "operation": {"held": [held], "speed": {moving: 100.0}, "torque": {moving: 1000.0}},
    }


STANDING = {"operation.speed.sun": 0.0}
"""Beside a held carrier: bolts in the housing hold no ring that turns."""


def stiffness(system: System, body: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What the links of one body hold it with, (6, 6), nan in eliminated directions."""
    index = [system.dofs.names.index(f"{body}/{d}") for d in ("x", "y", "z", "rx", "ry", "rz")]
    return np.asarray(system.K[np.ix_(index, index)])


@pytest.mark.parametrize("count", [3, 4, 12])
def test_equal_bolts_are_the_closed_form(count: int) -> None:
    system = epicyclic.assemble(load(document({"bolts": {"count": count, **BOLTS}})))
    lateral, turn = count * (RADIAL + TANGENTIAL) / 2, count * TANGENTIAL * RADIUS**2
    tilt = count * AXIAL * RADIUS**2 / 2
    expected = np.diag([lateral, lateral, count * AXIAL, tilt, tilt, turn])
    np.testing.assert_allclose(stiffness(system, "main/ring"), expected, rtol=1e-14, atol=1e-6)  # rounding of 1e9
    assert [s.holds for s in system.symmetries] == [count % 3 == 0 or count > 2]


def test_bolts_are_the_links_of_the_file() -> None:
    train = load(document({"bolts": {"angles": [0.1, 2.0], **BOLTS}, "at": 0.05}))
    bolts = [link for link in train.links if link.path == "stages.main.ring.support.bolts"]
    assert [link.name for link in bolts] == ["main/ring/support/bolts/1", "main/ring/support/bolts/2"]
    assert [(link.angle, link.station, link.kind) for link in bolts] == [(0.1, 0.05, "support"), (2.0, 0.05, "support")]
    assert bolts[1].centre == pytest.approx((RADIUS * math.cos(2.0), RADIUS * math.sin(2.0)), rel=1e-15)
    assert bolts[0].stiffness == (RADIAL, TANGENTIAL, AXIAL, 0.0, 0.0, 0.0)
    assert not any(link.name == "main/ring/support" for link in train.links)


def test_a_single_bolt_couples_directions() -> None:
    """Force at r e_r for a unit motion, by hand: bolt at 90 deg, radial = y, tangential = -x."""
    system = epicyclic.assemble(load(document({"bolts": {"angles": [math.pi / 2], **BOLTS}}, held="carrier"), STANDING))
    x, y, z, r = TANGENTIAL, RADIAL, AXIAL, RADIUS
    expected = np.array(
        [
            [x, 0, 0, 0, 0, -x * r],
            [0, y, 0, 0, 0, 0],
            [0, 0, z, z * r, 0, 0],
            [0, 0, z * r, z * r * r, 0, 0],
            [0, 0, 0, 0, 0, 0],
            [-x * r, 0, 0, 0, 0, x * r * r],
        ]
    )
    np.testing.assert_allclose(stiffness(system, "main/ring"), expected, atol=1e-6)  # rounding of cos(pi/2) 1e9


def test_bolts_stand_beside_what_else_is_named() -> None:
    both = epicyclic.assemble(load(document({"radial": 3e8, "bolts": {"count": 6, **BOLTS}})))
    alone = epicyclic.assemble(load(document({"bolts": {"count": 6, **BOLTS}})))
    more = stiffness(both, "main/ring") - stiffness(alone, "main/ring")
    np.testing.assert_allclose(more, np.diag([3e8, 3e8, 0, 0, 0, 0]), atol=1e-6)
    named = {"front": {"at": -0.1, "bolts": {"count": 6, **BOLTS}}, "rear": {"at": 0.1, "bolts": {"count": 6, **BOLTS}}}
    tilt = stiffness(epicyclic.assemble(load(document(named))), "main/ring")[3, 3]
    # two planes of bolts: axial ones at their radius, lateral ones at +-0.1 m
    assert tilt == pytest.approx(2 * (6 * AXIAL * RADIUS**2 / 2 + 6 * (RADIAL + TANGENTIAL) / 2 * 0.1**2), rel=1e-14)


def test_directions_that_bolts_do_not_name_are_rigid() -> None:
    names = epicyclic.assemble(load(document({"bolts": {"count": 6, "radius": RADIUS}}))).dofs.names
    assert not any(name.startswith("main/ring/") for name in names)
    data = document({"bolts": {"count": 6, "radius": RADIUS, "radial": 0, "tangential": TANGENTIAL}})
    names = epicyclic.assemble(load(data)).dofs.names
    assert {n.rsplit("/", 1)[1] for n in names if n.startswith("main/ring/")} == {"x", "y", "rz"}


def test_a_held_ring_on_bolts_turns_with_its_reaction() -> None:
    """The torque of the ring over the torsional stiffness of its bolts is what it turns by."""
    data = document({"bolts": {"count": 8, **BOLTS}})
    result = epicyclic.static(data, cycles=1)
    torque = epicyclic.check(data).torque.sel(body="main/ring").item()
    turned = result.displacement.sel(dof="main/ring/rz").mean().item() / (0.072 * 2 * math.cos(math.radians(20)))
    assert turned == pytest.approx(-torque / (8 * TANGENTIAL * RADIUS**2), rel=1e-9)
    force = result.link_force.sel(link_row=[f"main/ring/support/bolts/{i}/y" for i in range(1, 9)]).mean("time")
    np.testing.assert_allclose(force.values, -torque / 8 / RADIUS, rtol=1e-9)


def test_a_displaced_ring_on_bolts_is_one_on_the_support_they_add_up_to() -> None:
    """The displaced seat enters every bolt's row; with the support of the closed form the whole train moves alike."""
    n = 5
    plain = {
        "radial": n * (RADIAL + TANGENTIAL) / 2,
        "z": n * AXIAL,
        "tilt": n * AXIAL * RADIUS**2 / 2,
        "rz": n * TANGENTIAL * RADIUS**2,
    }
    moved = []
    for support in ({"bolts": {"count": n, **BOLTS}}, plain):
        data = document(support)
        data["deviations"] = {"ring": {"position": {"x": 20e-6, "y": 10e-6}, "tilt": 1e-4}}
        moved.append(epicyclic.static(data, cycles=2).displacement)
    assert float(np.abs(moved[0]).sel(dof="main/ring/x").max()) > 1e-5
    # the solver's tolerance of 1e-10 on forces
    np.testing.assert_allclose(moved[0].values, moved[1].values, rtol=1e-7, atol=1e-12)


def turning(bolts: dict[str, Any]) -> dict[str, Any]:
    """The carrier turns and the ring is bolted to the housing: bolts go round in the carrier's frame."""
    return document({"bolts": {**BOLTS, **bolts}})


@pytest.mark.parametrize("count", [3, 5, 12])
def test_evenly_spaced_bolts_may_stand_in_a_turning_frame(count: int) -> None:
    ring = stiffness(epicyclic.assemble(load(turning({"count": count}))), "main/ring")
    assert ring[0, 0] == pytest.approx(ring[1, 1], rel=1e-14)


@pytest.mark.parametrize("bolts", [{"count": 1}, {"count": 2}, {"angles": [0.0, 1.0, 2.0]}], ids=str)
def test_other_bolts_may_not(bolts: dict[str, Any]) -> None:
    with pytest.raises(ModelError, match=r"main\.ring\.support\.bolts.*although the frame turns.*evenly spaced"):
        epicyclic.assemble(load(turning(bolts)))


def test_other_bolts_may_in_a_frame_that_stands_still() -> None:
    data = document({"bolts": {"count": 2, **BOLTS}}, held="carrier")
    system = epicyclic.assemble(load(data, STANDING))
    assert stiffness(system, "main/ring")[0, 0] == pytest.approx(2 * RADIAL, rel=1e-14)


def test_unequal_supports_that_add_up_evenly() -> None:
    """Two supports at one place, one stiff in x and one in y, are round together; at two places they are not."""
    together = {"a": {"x": 1e8, "y": 2e8}, "b": {"x": 2e8, "y": 1e8}}
    system = epicyclic.assemble(load(document(together)))
    assert system.K[0, 0] == pytest.approx(1e8)  # the sun's
    apart = {name: {**table, "at": at} for (name, table), at in zip(together.items(), (-0.1, 0.1), strict=True)}
    apart["a"]["tilt"] = 1e6
    with pytest.raises(ModelError, match="although the frame turns"):
        epicyclic.assemble(load(document(apart)))


@pytest.mark.parametrize("key", ["x", "y"])
def test_a_damper_in_one_direction_only_is_refused_in_a_turning_frame(key: str) -> None:
    with pytest.raises(ModelError, match="although the frame turns"):
        epicyclic.assemble(load(document({"radial": 1e9, "damping": {key: 100.0}})))


def test_a_coupling_that_turns_in_its_frame_is_alike_all_round() -> None:
    data = document({"radial": 1e9}, held="carrier")
    data["bodies"] = {"shaft": {"mass": 1.0, "inertia": 0.1, "support": {"radial": 1e7}}}
    data["couplings"] = {"flange": {"between": ["sun", "shaft"], "bolts": {**BOLTS, "count": 6}}}
    data["stages"]["main"]["sun"]["support"] = {"radial": 1e8, "z": 1e8, "tilt": 1e6}
    data["bodies"]["shaft"] |= {"tilt_inertia": 0.1}
    data["bodies"]["shaft"]["support"] |= {"z": 0, "tilt": 0}
    system = epicyclic.assemble(load(data))
    assert stiffness(system, "shaft")[5, 5] == pytest.approx(6 * TANGENTIAL * RADIUS**2, rel=1e-14)
    data["couplings"]["flange"]["bolts"]["count"] = 2
    with pytest.raises(ModelError, match=r"couplings\.flange\.bolts.*although it turns in the frame"):
        epicyclic.assemble(load(data))


def test_resolved_document_keeps_bolts() -> None:
    train = load(document({"at": 0.01, "bolts": {"count": 5, **BOLTS}}))
    again = load(resolved_document(train))
    assert [(k.name, k.stiffness, k.centre) for k in again.links] == [
        (k.name, k.stiffness, k.centre) for k in train.links
    ]


# thin rims -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rim", "thin"), [(1.19, True), (1.21, False)])
@pytest.mark.parametrize("key", ["rim", "outer_diameter"])
def test_a_thin_rim_is_warned_of(rim: float, thin: bool, key: str) -> None:
    height = 2.25 * 0.004  # addendum 1, dedendum 1.25 modules
    root = 0.072 * 4 / 2 + 1.25 * 0.004
    value = rim * height if key == "rim" else 2 * (root + rim * height)
    data = copy.deepcopy(document({"radial": 1e9}))
    ring = data["stages"]["main"]["ring"]
    del ring["rim"]
    ring[key] = value
    found = [text for text in load(data).warnings if f"ring.{key}" in text]
    assert len(found) == int(thin)
    if thin:
        assert "1.19 tooth heights" in found[0]
        assert "computed as rigid" in found[0]
