"""Gears that stand apart along the axis mesh where their faces overlap."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from epicyclic.errors import ModelError
from epicyclic.train.resolution import load
from epicyclic.train.train import Mesh

FACE = 0.020


def spur_pair(**changes: Any) -> dict[str, Any]:
    """Two gears on fixed axes, faces of 20 mm."""
    pair: dict[str, Any] = {
        "module": 0.003,
        "face_width": FACE,
        "g1": {"kind": "gear", "teeth": 20, "support": {"radial": 1e8, "tilt": 1e5}},
        "g2": {"kind": "gear", "teeth": 30, "support": {"radial": 1e8, "tilt": 1e5}},
    }
    for path, value in changes.items():
        member, key = path.split("_", 1)
        pair[member][key] = value
    return {"format": 2, "title": "pair", "stages": {"s": pair}}


def mesh_of(source: dict[str, Any], overrides: dict[str, object] | None = None) -> Mesh:
    (mesh,) = load(source, overrides).meshes
    return mesh


@pytest.mark.parametrize(
    ("places", "widths", "left", "right"),
    [
        ((0.0, 0.010), (0.020, 0.020), 0.0, 0.010),
        ((0.010, 0.0), (0.020, 0.020), 0.0, 0.010),
        ((0.0, 0.010), (0.060, 0.020), 0.0, 0.020),  # the narrow face lies within the wide one
        ((0.0, 0.030), (0.060, 0.020), 0.020, 0.030),
        ((0.005, 0.005), (0.020, 0.020), -0.005, 0.015),
    ],
)
def test_gears_mesh_where_their_faces_overlap(
    places: tuple[float, float], widths: tuple[float, float], left: float, right: float
) -> None:
    source = spur_pair(g1_station=places[0], g2_station=places[1], g1_face_width=widths[0], g2_face_width=widths[1])
    mesh, whole = mesh_of(source), mesh_of(spur_pair())
    assert mesh.station == pytest.approx((left + right) / 2, abs=1e-15)
    assert mesh.width == pytest.approx(right - left, rel=1e-12)
    # ISO 6336: stiffness per width times the width
    assert mesh.stiffness == pytest.approx(whole.stiffness * (right - left) / FACE, rel=1e-12)
    edges = np.linspace(left, right, len(mesh.slices) + 1)
    assert [piece.station for piece in mesh.slices] == pytest.approx(list((edges[1:] + edges[:-1]) / 2), abs=1e-15)


def test_tooth_contact_lies_on_the_common_face() -> None:
    teeth = mesh_of(spur_pair(g2_station=0.010)).teeth
    assert teeth is not None
    assert teeth.face_a == pytest.approx((-0.015, 0.005), abs=1e-15)
    assert teeth.face_b == pytest.approx((-0.005, 0.015), abs=1e-15)


def test_a_face_that_is_not_stated_covers_the_other() -> None:
    mesh = mesh_of(
        spur_pair(g1_face_width=None, g2_station=0.010), {"stages.s.face_width": None, "stages.s.g2.face_width": FACE}
    )
    assert (mesh.station, mesh.width) == pytest.approx((0.010, FACE))


def test_each_helix_has_its_own_common_face() -> None:
    """Faces of 20 mm beside gaps of 10 and 14 mm stand 2 mm apart on either side."""
    source = spur_pair()
    source["stages"]["s"] |= {"herringbone": True, "helix_angle": 0.3}
    source["stages"]["s"]["g1"]["gap"], source["stages"]["s"]["g2"]["gap"] = 0.010, 0.014
    left, right = load(source).meshes
    assert (left.station, right.station) == pytest.approx((-0.016, 0.016))
    assert (left.width, right.width) == pytest.approx((0.018, 0.018))
    assert left.overlap_ratio == pytest.approx(0.018 * np.sin(0.3) / (np.pi * 0.003), rel=1e-12)


@pytest.mark.parametrize("apart", [0.020, 0.035])
def test_faces_without_overlap_are_refused(apart: float) -> None:
    with pytest.raises(ModelError) as caught:
        load(spur_pair(g2_station=apart))
    said = str(caught.value)
    assert caught.value.path == "stages.s.meshes.g1-g2"
    assert "g1 -10 .. 10 mm" in said
    assert f"g2 {1e3 * apart - 10:g} .. {1e3 * apart + 10:g} mm" in said
