"""The train as it is drawn: circles that touch at the mesh, teeth that roll, faces that meet, of every ready drive."""

from __future__ import annotations

import math
from typing import Any

import pytest

from epicyclic import load
from epicyclic.cockpit.computing.train_view import train_head
from epicyclic.cockpit.state.frames import body_labels, mesh_labels
from epicyclic.document.document import ready_drives

DRIVES = ready_drives()


def head_of(drive: str, overrides: dict[str, Any] | None = None, *, relative_speed: float = 1.0) -> dict[str, Any]:
    train = load(drive, overrides)
    return train_head(train, body_labels(train), mesh_labels(train), relative_speed=relative_speed)


# radii as printed in these do not add up to the centre distance that is printed
UNEVEN = {"dong2019", "lin1999-n3", "lin1999-n4", "lin1999-n5"}


@pytest.mark.parametrize("drive", DRIVES)
def test_pitch_circles_touch_at_the_pitch_point(drive: str) -> None:
    head, train = head_of(drive), load(drive)
    assert len(head["meshes"]) == len(train.meshes)
    for mesh, source in zip(head["meshes"], train.meshes, strict=True):
        a, b = (head["bodies"][index] for index in mesh["bodies"])
        for body, radius in ((a, source.radius_a), (b, source.radius_b)):
            away = math.hypot(mesh["x"] - body["x"], mesh["y"] - body["y"])
            if body is a or drive not in UNEVEN:
                assert away == pytest.approx(1e3 * radius, abs=2e-3), (mesh["name"], body["name"])
                # with two working angles each mesh has a pitch circle of its own, beside the one that is drawn
                assert away == pytest.approx(body["pitch"], rel=0.03)
        assert max(a["z"][0], b["z"][0]) - 1e-3 <= mesh["z"][0] < mesh["z"][1] <= min(a["z"][1], b["z"][1]) + 1e-3
        assert not a["internal"]
        assert mesh["label"]


@pytest.mark.parametrize("drive", ["ren2021", "xu2020", "encased-differential", "dong2019", "wind-five"])
def test_teeth_roll_on_each_other(drive: str) -> None:
    head = head_of(drive, relative_speed=0.5)
    for mesh in head["meshes"]:
        a, b = (head["bodies"][index] for index in mesh["bodies"])
        orbit = a["orbit"] or b["orbit"]
        sense = -1 if not b["internal"] else 1
        # in the frame that holds the centres still both have the speed of the pitch point
        rolls = (a["speed"] - orbit) * a["teeth"], sense * (b["speed"] - orbit) * b["teeth"]
        assert rolls[0] == pytest.approx(rolls[1], rel=1e-9), mesh["name"]
        assert rolls[0] != 0


def test_speeds_follow_the_relative_speed() -> None:
    full, half = head_of("ren2021"), head_of("ren2021", relative_speed=0.5)
    assert full["bodies"][0]["speed"] == pytest.approx(100 * 2 * math.pi / 60)
    assert half["bodies"][0]["speed"] == full["bodies"][0]["speed"] / 2
    assert half["stages"][0]["mesh_frequency"] == full["stages"][0]["mesh_frequency"] / 2


def test_planets_orbit_with_their_carrier_alone() -> None:
    bodies = {body["name"]: body for body in head_of("encased-differential")["bodies"]}
    assert bodies["differential/planet/2"]["orbit"] == bodies["differential/carrier"]["speed"] != 0
    assert bodies["encased/planet/2"]["orbit"] == 0
    assert bodies["differential/carrier"]["pins"] == [f"differential/planet/{n}" for n in (1, 2, 3)]


def test_held_and_floating_members_are_marked() -> None:
    bodies = {body["name"]: body for body in head_of("wind-five", {"stages.main.sun.support.radial": 0})["bodies"]}
    assert [name for name, body in bodies.items() if body["floating"]] == ["main/sun"]
    assert [name for name, body in bodies.items() if body["held"]] == ["main/ring"]
    assert not any(body["floating"] for body in head_of("wind-five")["bodies"])


def test_stages_stand_side_by_side_and_helices_mirror() -> None:
    head = head_of("encased-differential")
    reach = {
        stage["name"]: [
            (body["x"] - body["outer"], body["x"] + body["outer"], *body["z"])
            for body in head["bodies"]
            if body["stage"] == stage["name"]
        ]
        for stage in head["stages"]
    }
    one, other = (reach[name] for name in ("differential", "encased"))
    assert max(end[1] for end in one) < min(end[0] for end in other)
    assert max(end[3] for end in one) < min(end[2] for end in other)
    sun = head["bodies"][0]
    assert [face[2] for face in sun["faces"]] == ["right", "left"]
    split = {body["name"]: body for body in head_of("xu2020")["bodies"]}
    assert (split["main/sun/left"]["hand"], split["main/sun/right"]["hand"]) == ("left", "right")
    assert split["main/sun/left"]["z"][1] < 0 < split["main/sun/right"]["z"][0]


def test_a_drawing_that_is_kept_is_that_of_its_train() -> None:
    first = head_of("ren2021")
    assert head_of("ren2021", {"stages.main.sun.support.radial": "2e9 N/m"})["bodies"] == first["bodies"]
    wider = head_of("ren2021", {"stages.main.module": "40 mm"})
    assert wider["bodies"][0]["pitch"] > 1.1 * first["bodies"][0]["pitch"]
    assert head_of("ren2021") == first


def test_names_of_a_train_are_not_repeated() -> None:
    for drive in DRIVES:
        train = load(drive)
        assert len(set(body_labels(train).values())) == len(train.bodies)
        assert len(set(mesh_labels(train).values())) == len(train.meshes)
