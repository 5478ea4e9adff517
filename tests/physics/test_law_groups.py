"""Links with laws through the assembly: rows that leave the stiffness, the force of friction, where errors enter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.statics.tangent import linear
from epicyclic.system.system import System

Array = NDArray[np.float64]


def model(**changes: Any) -> dict[str, Any]:
    """A reducer whose sun is driven through a coupling from a body."""
    return {
        "format": 2,
        "title": "a reducer",
        "damping": {"mass": 0.1, "stiffness": 1e-5},
        "stages": {
            "main": {
                "planets": 3,
                "module": 4e-3,
                "face_width": 0.04,
                "sun": {"teeth": 24, "support": {"radial": 0, "z": 0}},
                "planet": {"teeth": 24, "bearing": {"radial": 2e8, "damping": 300.0} | changes.get("bearing", {})},
                "ring": {"teeth": 72, "rim": 0.03},
                "carrier": {"mass": 20.0, "inertia": 0.2},
            }
        },
        "bodies": {"input": {"mass": 5.0, "inertia": 0.01}},
        "couplings": {
            "shaft": {
                "between": ["main.sun", "input"],
                "rz": 1e6,
                "radial": 3e7,
                **changes.get("coupling", {}),
            }
        },
        "operation": {"held": ["carrier"], "speed": {"input": 100.0}, "torque": {"input": 500.0}},
        "deviations": changes.get("deviations", {}),
        "loads": changes.get("loads", {}),
    }


def system(**changes: Any) -> System:
    return epicyclic.assemble(epicyclic.load(model(**changes)))


def test_only_the_lateral_rows_leave_the_stiffness() -> None:
    plain = system()
    lawful = system(bearing={"clearance": [1e-5, 0, 2e-5], "tilt": 1e5, "z": 1e7})
    assert [group.name for group in lawful.groups] == ["main/planet/1/bearing", "main/planet/3/bearing"]
    assert [group.law.clearance for group in lawful.groups] == [1e-5, 2e-5]
    group = lawful.groups[0]
    assert group.rows == ("main/planet/1/bearing/x", "main/planet/1/bearing/y")
    assert "main/planet/1/bearing/x" not in lawful.links.name
    assert {"main/planet/1/bearing/z", "main/planet/1/bearing/rx", "main/planet/2/bearing/x"} <= set(lawful.links.name)
    assert plain.groups == ()
    together = system(bearing={"tilt": 1e5, "z": 1e7})
    rows, k = lawful.group_rows, lawful.laws.row_stiffness
    np.testing.assert_allclose(lawful.K + (rows * k) @ rows.T, together.K, rtol=1e-12, atol=1e-6)
    # what is damped by a damper stays, what is damped by its stiffness comes with the tangent
    np.testing.assert_allclose(lawful.C + 1e-5 * (rows * k) @ rows.T, together.C, rtol=1e-12, atol=1e-9)


def test_linearised_beyond_the_play_is_the_link() -> None:
    """One row of exponent 1 under load: its tangent is the stiffness of the link, and the train damps it as that."""
    push = {"push": {"on": "sun", "force": {"z": 100.0}}}
    lawful, plain = (
        system(coupling={"radial": None, "z": 3e7, "clearance": play}, loads=push) for play in (1e-9, None)
    )
    tangents = linear(lawful)
    for name in ("K", "C"):
        np.testing.assert_allclose(getattr(tangents, name), getattr(plain, name), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(tangents.links.damping[-1], plain.links.damping[plain.links.name.index("shaft/z")])
    assert tangents.links.name[-1] == "shaft/z"


def test_a_single_row_and_an_axial_one() -> None:
    # a joint soft in x alone would turn with the sun; at rest it is a row like any other
    at_rest = model(coupling={"radial": None, "x": 3e7, "clearance": 1e-5})
    with pytest.raises(ModelError, match="although it turns"):
        epicyclic.assemble(epicyclic.load(at_rest))
    at_rest["operation"] = {"held": ["carrier"]}
    (radial,) = epicyclic.assemble(epicyclic.load(at_rest)).groups
    assert radial.rows == ("shaft/x",)
    (axial,) = system(coupling={"radial": None, "z": 3e7, "clearance": 1e-5}).groups
    assert axial.rows == ("shaft/z",)


def test_friction_of_a_coupling_comes_from_the_torque_through_it() -> None:
    friction = {"coefficient": 0.15, "radius": 0.03, "law": "coulomb"}
    (group,) = system(coupling={"clearance": 1e-5, "friction": friction}).groups
    assert group.law.friction == pytest.approx(0.15 * 500 / 0.03, rel=1e-12)
    assert group.law.kind == "coulomb spline"
    # and of a support from the torque that its member passes on, though none acts on it from outside
    changed = model()
    changed["stages"]["main"]["sun"]["support"] = {"radial": 1e7, "clearance": 1e-5, "friction": friction}
    (sun,) = epicyclic.assemble(epicyclic.load(changed)).groups
    assert sun.law.friction == pytest.approx(0.15 * 500 / 0.03, rel=1e-12)


def test_errors_of_the_member_enter_the_rows_of_its_law() -> None:
    """A seat displaced by E opens the rows of the body by -E, in the law as in the link."""
    errors = {"main": {"planet": {"position": {"y": [2e-5, 0, 0]}, "bearing_run_out": 3e-6}}}
    lawful, plain = (system(bearing=b, deviations=errors) for b in ({"clearance": 1e-5}, {}))
    for line, other in zip(lawful.lines, plain.lines, strict=True):
        pins = [i for i, link in enumerate(plain.links.link) if "bearing" in link]
        np.testing.assert_allclose(line.group_gap, other.link_gap[pins], rtol=1e-15)
        rows, k = lawful.group_rows, lawful.laws.row_stiffness
        # a linear link pushes with its error; a law does not, it is asked at the stretch less the error
        np.testing.assert_allclose(line.force[0] + rows @ (k * line.group_gap), other.force[0], atol=1e-9)
        assert not line.force[0].any()


def test_a_damper_in_a_law_keeps_acting_on_its_errors() -> None:
    errors = {"main": {"planet": {"bearing_run_out": 3e-6}}}
    lawful, plain = (system(bearing=b, deviations=errors) for b in ({"clearance": 1e-5}, {}))
    line, other = lawful.lines[-1], plain.lines[-1]
    rows, k = lawful.group_rows, lawful.laws.row_stiffness
    lag = 2j * np.pi * float(line.frequency) * 1e-5 * (rows @ (k * line.group_gap))
    np.testing.assert_allclose(line.force[1] + lag, other.force[1], atol=1e-12)
    assert np.abs(line.force[1]).max() > 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"bearing": {"clearance": 1e-5, "radial": None}}, r"planet\.bearing = x, y, z = inf.*radial"),
        ({"bearing": {"clearance": 1e-5, "radial": None, "x": 1e8, "y": 2e8}}, r"x, y, z = 1e\+08, 2e\+08"),
        ({"coupling": {"clearance": 1e-5, "radial": 0}}, r"couplings\.shaft = x, y, z = 0, 0, 0"),
        (
            {"bearing": {"clearance": 1e-5, "friction": {"coefficient": 0.1, "radius": 0.01}}},
            r"planet\.bearing\.friction\.coefficient = 0\.1: no torque.*friction\.force",
        ),
        ({"bearing": {"clearance": [1e-5, 2e-5]}}, r"planet\.bearing\.clearance.*3, one per planet"),
    ],
)
def test_laws_that_nothing_can_follow_are_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        system(**change)


def test_torque_of_a_side_of_a_member_in_one_piece_is_refused() -> None:
    changed = model()
    changed["operation"]["torque"] = {"main": {"sun": {"right": 500.0}}}
    with pytest.raises(ModelError, match=r"operation\.torque\.main\.sun.*one piece"):
        epicyclic.load(changed)
