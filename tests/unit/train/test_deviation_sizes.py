"""Values beyond any gear: refused with path, given, allowed; doubtful ones are warnings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError

FREE: dict[str, Any] = {"deviations": None}


def load(**settings: Any) -> Any:
    return epicyclic.load("ren2021", FREE | {path.replace("__", "."): value for path, value in settings.items()})


# the module of ren2021 is 32 mm
@pytest.mark.parametrize(
    "path",
    [
        "deviations.sun.run_out",
        "deviations.ring.left.run_out",
        "deviations.planet.run_out",
        "deviations.planet.bearing_run_out",
        "deviations.planet.position.y",
        "deviations.carrier.run_out",
        "deviations.meshes.sun-planet.profile",
        "deviations.meshes.planet-ring.left.gap",
    ],
)
def test_deviations_beside_the_module(path: str) -> None:
    def doubts(value: str) -> list[str]:
        return [
            text for text in epicyclic.load("ren2021", FREE | {path: value}).warnings if "tenth of a module" in text
        ]

    assert doubts("3.1 mm") == []
    (warning,) = doubts("3.3 mm")
    assert "3.3 mm" in warning
    assert warning.startswith("deviations.main.")
    with pytest.raises(ModelError, match="more than a module") as error:
        doubts("-33 mm")
    assert error.value.path.startswith("deviations.main.")
    assert error.value.given == "-33 mm"
    assert error.value.allowed == "at most a module, 32 mm"


def test_one_planet_of_a_list_is_seen() -> None:
    with pytest.raises(ModelError, match=r"position.y = \[0, 0, 40\] mm: is more than a module"):
        load(deviations__planet__position__y="[0, 0, 40] mm")


def test_pitch_deviations_count_from_lowest_to_highest() -> None:
    def pitch(*values: float) -> str:
        return f"[{', '.join(map(str, [*values, *[values[0]] * (23 - len(values))]))}] mm"

    assert not [text for text in load(deviations__sun__pitch=pitch(50, 51)).warnings if "pitch" in text]
    with pytest.raises(ModelError, match="more than a module"):
        load(deviations__sun__pitch=pitch(50, 90))


@pytest.mark.parametrize("slide", ["5 mm", "50 mm"])  # more than a tenth of a module, more than a module
def test_a_slide_along_the_axis_is_no_deviation_of_the_teeth(slide: str) -> None:
    assert load(deviations__sun__position__z=slide).warnings == load().warnings
    assert any("position.y" in text for text in load(deviations__sun__position__y="5 mm").warnings)


def test_a_tilt_is_what_the_ends_of_the_teeth_move() -> None:
    def doubted(tilt: str) -> bool:
        return any("tilt" in text and "tenth" in text for text in load(deviations__sun__tilt=tilt).warnings)

    # two helices of 170 mm, 20 mm apart: 180 mm from the middle to the end, which 3.2 mm move by 17.8 mrad
    assert not doubted("17.7 mrad")
    assert doubted("17.9 mrad")
    with pytest.raises(ModelError, match=r"amplitude = 20 deg: moves the ends of the teeth by more than a module"):
        load(deviations__sun__tilt="20 deg")


def test_backlash() -> None:
    load(**{"stages.main.meshes.sun-planet.backlash": "1 mm"})
    with pytest.raises(ModelError, match="no backlash of teeth") as error:
        load(**{"stages.main.meshes.sun-planet.backlash": "33 mm"})
    assert error.value.path == "stages.main.meshes.sun-planet.backlash"
    with pytest.raises(ModelError, match=r"backlash = inf: must be finite.*leave it out"):
        load(**{"stages.main.meshes.sun-planet.backlash": "inf"})


@pytest.mark.parametrize("key", ["modal", "mesh"])
@pytest.mark.parametrize("ratio", [3.0, 1.0, "300 %", "100 %"])
def test_damping_ratios_end_below_1(key: str, ratio: object) -> None:
    with pytest.raises(ModelError, match=rf"damping\.{key} = .*>= 0 and < 1; with a ratio of 1 nothing oscillates"):
        load(**{f"damping.{key}": ratio})
    load(**{f"damping.{key}": "99 %"})


@pytest.mark.parametrize(
    ("variation", "least"),
    [
        ({"cosine": [1.5]}, "-0.5 "),
        ({"sine": [0.0, 1.2]}, "-0.2 "),
        ({"cosine": [0.7], "sine": [0.8]}, "-0.06"),  # sqrt(0.7^2 + 0.8^2) = 1.063
        ({"values": [1.0, -0.2, 1.0, 2.0]}, None),
        ({"values": [1.0, 0.0]}, None),
    ],
)
def test_a_mesh_stiffness_stays_above_0(variation: dict[str, list[float]], least: str | None) -> None:
    mesh = "stages.main.meshes.sun-planet"
    with pytest.raises(ModelError, match="the mesh stiffness does not stay above 0") as error:
        load(**{mesh: {"stiffness": "2e9 N/m", "variation": variation}})
    assert error.value.path == f"{mesh}.variation"
    assert least is None or str(error.value.given).startswith(least)


@pytest.mark.parametrize(
    ("variation", "series"),
    [
        ({"cosine": [0.9]}, [0.9]),
        ({"cosine": [0.6], "sine": [0.7]}, [0.6 - 0.7j]),
        ({"values": [0.5, 1.5]}, [-0.5]),
    ],
)
def test_a_variation_that_leaves_stiffness_is_taken(variation: dict[str, list[float]], series: list[complex]) -> None:
    train = load(**{"stages.main.meshes.sun-planet": {"stiffness": "2e9 N/m", "variation": variation}})
    meshes = [mesh for mesh in train.meshes if mesh.pair == "stages.main.meshes.sun-planet"]
    assert len(meshes) == 6
    for mesh in meshes:
        assert mesh.stiffness == 2e9
        np.testing.assert_allclose(mesh.variation, series, rtol=1e-12)


@pytest.mark.parametrize(("given", "fine"), [("1e-30 m", False), ("0.3 mm", False), ("0 mm", True), ("1 mm", True)])
def test_a_bore_beside_the_gear(given: str, fine: bool) -> None:
    """The sun of xu2020 has a pitch circle above 300 mm."""
    settings = {"stages.main.sun.bore": given}
    if fine:
        epicyclic.load("xu2020", settings)
        return
    with pytest.raises(ModelError, match="no bore of a gear") as caught:
        epicyclic.load("xu2020", settings)
    assert caught.value.path == "stages.main.sun.bore"


def test_loaded_contact_needs_the_face_of_either_gear() -> None:
    with pytest.raises(ModelError, match="needs the face of either gear") as caught:
        epicyclic.load("yue2014-ii", {"stages.main.meshes.sun-p.stiffness": "contact"})
    assert caught.value.path == "stages.main.face_width"


def test_teeth_beyond_any_gear() -> None:
    with pytest.raises(ModelError) as caught:
        epicyclic.load("ren2021", {"stages.main.ring.teeth": "57000"})
    assert caught.value.path == "stages.main.ring.teeth"


def test_a_helix_that_is_none() -> None:
    with pytest.raises(ModelError, match="is no helix") as caught:
        epicyclic.load("ren2021", {"stages.main.helix_angle": "1e-30 deg"})
    assert caught.value.path == "stages.main.helix_angle"
    epicyclic.load("ren2021", {"stages.main.helix_angle": "0.01 deg"})


def test_points_of_a_force_table_that_hardly_rise() -> None:
    table = {"deflection": "[0, 1e-30, 9] um", "force": "[0, 1, 2] kN"}
    with pytest.raises(ModelError, match="hardly rises"):
        epicyclic.load("ren2021", {"stages.main.meshes.sun-planet.stiffness": table})
