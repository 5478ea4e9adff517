"""A helix that mirrors another has its contact from the other end of the face; what differs along the face does not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.form import Flank, Relief
from epicyclic.teeth.gear_pair import ContactPair, Torsion
from epicyclic.teeth.loaded_contact import all_loaded, all_segments, first_images, loaded_segments, mirrored
from epicyclic.teeth.segments import contact_segments

SIGMA = np.arange(9) / 9 + 0.03
LOADS = (2e4, 1e5)
CROWNED = Flank(crown=8e-6, tip_relief=Relief(amount=6e-6, length=3e-3))
# all that may differ along the face
UNEVEN: dict[str, dict[str, Any]] = {
    "slope": {"flank_a": Flank(slope=9e-6)},
    "misalignment": {"misalignment": 6e-5},
    "gap": {"gap": ((-0.08, 0.0), (0.02, 5e-6), (0.08, 1e-6))},
    "torsion": {"torsion_b": Torsion(rigidity=2e8, end="left")},
    "corner": {"corner": True, "misalignment": 6e-5},
}


@pytest.fixture(scope="module")
def helices() -> list[ContactPair]:
    """Both helices of a herringbone pair, crowned and relieved."""
    train = epicyclic.load("ren2021")
    meshes = [mesh for mesh in train.meshes if mesh.name.startswith("main/sun-planet/1/")]
    assert [mesh.side for mesh in meshes] == ["left", "right"]
    return [replace(pair_of(train, mesh, slices=7), flank_a=CROWNED) for mesh in meshes]


def test_the_helices_of_a_herringbone_mirror_each_other(helices: list[ContactPair]) -> None:
    assert first_images(helices, [SIGMA, SIGMA]) == [0, 0]
    assert first_images(helices, [SIGMA, SIGMA + 0.5]) == [0, 1]  # staggered
    assert first_images([helices[0], helices[0]], [SIGMA, SIGMA]) == [0, 1]  # not the same: it leans to one side


@pytest.mark.parametrize("name", UNEVEN)
def test_the_same_change_on_both_helices_is_no_mirror_image(helices: list[ContactPair], name: str) -> None:
    assert first_images([replace(one, **UNEVEN[name]) for one in helices], [SIGMA, SIGMA]) == [0, 1]


@pytest.mark.parametrize("name", ["none", *UNEVEN])
def test_a_mirror_image_has_the_loads_from_the_other_end(helices: list[ContactPair], name: str) -> None:
    one = replace(helices[0], **UNEVEN.get(name, {}))
    other = mirrored(one)
    assert first_images([one, other], [SIGMA, SIGMA]) == [0, 0]
    left, right = all_loaded(all_segments([one, other], [SIGMA, SIGMA]), LOADS, tangents=True)
    alone = loaded_segments(contact_segments(other, SIGMA), LOADS)
    assert left.force[..., ::-1] == pytest.approx(alone.force, rel=1e-9, abs=1e-9 * alone.force.max())
    assert left.status[0, 0] == ""
    for field in ("force", "approach", "tangent", "corner", "no_load", "mean_load", "mean_pressure"):
        wanted = getattr(alone, field)
        np.testing.assert_allclose(
            getattr(right, field), wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max(), err_msg=field
        )
    lines = alone.segments.lines
    assert right.segments.lines.zeta == pytest.approx(lines.zeta, abs=1e-15)
    assert right.segments.lines.length == pytest.approx(lines.length, abs=1e-15)
    # each segment is where its line is, so that the segments can be solved by themselves
    found = right.segments
    for values, wanted in ((lines.zeta, found.zeta), (lines.length, found.length)):
        there = np.take_along_axis(values.reshape(len(SIGMA), -1), found.index, axis=1)
        assert np.where(found.valid, there, 0.0) == pytest.approx(np.where(found.valid, wanted, 0.0), abs=1e-15)
    assert loaded_segments(found, LOADS).force == pytest.approx(alone.force, rel=1e-9, abs=1e-9 * alone.force.max())
    # the load is uneven along the face, so that the two ends are told apart
    assert np.abs(left.force - left.force[..., ::-1]).max() > 1e-2 * left.force.max()


def test_equal_gears_may_change_places() -> None:
    """Of a spur pair of equal gears the contact is even about the pitch point: each stands for the other."""
    member = {"support": {"radial": "1e8 N/m"}}
    stage: dict[str, Any] = {"planets": 3, "module": "4 mm", "face_width": "40 mm", "sun": {"teeth": 30, **member}}
    stage |= {
        "planet": {"teeth": 30, "bearing": {"radial": "1e8 N/m"}},
        "ring": {"teeth": 90, "addendum": 0.9, **member},
    }
    stage |= {"carrier": {"mass": "20 kg", **member}}
    operation = {"held": ["ring"], "speed": {"sun": "1500 rpm"}, "torque": {"sun": "500 N m"}}
    train = epicyclic.load({"format": 2, "title": "equal gears", "stages": {"main": stage}, "operation": operation})
    mesh = next(mesh for mesh in train.meshes if mesh.name.startswith("main/sun-planet/1"))
    pair = pair_of(train, mesh, slices=3)
    pair = replace(pair, tooth_b=pair.tooth_a)
    there, back = (loaded_segments(contact_segments(pair, sigma), LOADS) for sigma in (SIGMA, -SIGMA))
    assert there.approach == pytest.approx(back.approach, rel=1e-9)
    assert np.ptp(there.approach, axis=-1).min() > 0.02 * there.approach.min()
