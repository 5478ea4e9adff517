"""The train as it is drawn: circles that touch at the mesh, teeth that roll, faces that meet, of every ready drive."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from epicyclic import load
from epicyclic.cockpit.computing.train_view import train_head
from epicyclic.cockpit.state.frames import body_labels, mesh_labels
from epicyclic.document.document import ready_drives

DRIVES = ready_drives()
# radii as printed in these do not add up to the centre distance that is printed: drawn by their teeth
UNEVEN = {"dong2019", "lin1999-n3", "lin1999-n4", "lin1999-n5"}


def head_of(drive: str, overrides: dict[str, Any] | None = None, *, relative_speed: float = 1.0) -> dict[str, Any]:
    train = load(drive, overrides)
    return train_head(train, body_labels(train), mesh_labels(train), relative_speed=relative_speed)


def shapes_of(head: dict[str, Any], view: str, kind: str, role: str) -> list[dict[str, Any]]:
    """Shapes of a kind and role, with their contours in the place of the numbers of these."""
    drawn = json.loads(head["drawing"][view])
    own = [shape for shape in drawn["shapes"] if (shape["type"], shape["role"]) == (kind, role)]
    return [shape | {"contours": [drawn["contours"][i] for i in shape.get("contours", ())]} for shape in own]


def place_of(head: dict[str, Any], body: int) -> dict[str, Any]:
    """The area of a body in the front view."""
    (area,) = [shape for shape in shapes_of(head, "front", "area", "body") if shape["body"] == body]
    return area


def reach_of(area: dict[str, Any]) -> float:
    """Radius about its centre that an area takes [mm]."""
    contours: list[list[float]] = area["contours"]
    points = [math.hypot(x, y) for one in contours for x, y in zip(one[2::2], one[3::2], strict=True)]
    return max(*points, *(one[1] for one in contours))


def faces_of(head: dict[str, Any], body: int) -> list[tuple[float, float]]:
    """Axial ends of what is cut of a body in the section [mm]."""
    own = [shape for shape in shapes_of(head, "section", "area", "cut") if shape["body"] == body]
    ends = [[shape["at"][0] + z for z in shape["contours"][0][2::2]] for shape in own]
    return sorted((min(one), max(one)) for one in ends)


@pytest.mark.parametrize("drive", DRIVES)
def test_pitch_circles_touch_at_the_pitch_point(drive: str) -> None:
    head, train = head_of(drive), load(drive)
    assert len(head["meshes"]) == len(train.meshes)
    point = {mesh: mark["at"] for mark in shapes_of(head, "front", "symbol", "mesh") for mesh in mark["meshes"]}
    circles = {
        one["body"]: [path[1] for path in one["contours"]] for one in shapes_of(head, "front", "stroke", "pitch circle")
    }
    lines = {mesh: line for line in shapes_of(head, "section", "stroke", "mesh") for mesh in line["meshes"]}
    lines |= {mesh: line for line in shapes_of(head, "section", "stroke", "mesh beside") for mesh in line["meshes"]}
    for number, (mesh, source) in enumerate(zip(head["meshes"], train.meshes, strict=True)):
        for index, radius in zip(mesh["bodies"], (source.radius_a, source.radius_b), strict=True):
            x, y, _ = place_of(head, index)["at"]
            away = math.hypot(point[number][0] - x, point[number][1] - y)
            if drive not in UNEVEN:
                assert away == pytest.approx(1e3 * radius, abs=2e-3), (mesh["name"], index)
            assert min(abs(away - own) for own in circles[index]) < 5e-3, (mesh["name"], index)
            # with two working angles each mesh has a pitch circle of its own, beside the one that is told
            assert away == pytest.approx(head["bodies"][index]["pitch"], rel=0.03)
        (z0, _, z1, _) = lines[number]["contours"][0][2:]
        branch = [i for i in mesh["bodies"] if faces_of(head, i)]  # the section shows the first branch
        for index in branch:
            ends = faces_of(head, index)
            assert min(low for low, _ in ends) - 1e-3 <= z0 < z1 <= max(high for _, high in ends) + 1e-3
        assert len(place_of(head, mesh["bodies"][0])["contours"]) == 1  # no ring: that has a rim besides
        assert mesh["label"]


@pytest.mark.parametrize("drive", ["ren2021", "xu2020", "encased-differential", "dong2019", "wind-five"])
def test_teeth_roll_on_each_other(drive: str) -> None:
    head = head_of(drive, relative_speed=0.5)
    for mesh in head["meshes"]:
        a, b = (head["bodies"][index] for index in mesh["bodies"])
        orbit = a["orbit"] or b["orbit"]
        sense = 1 if len(place_of(head, mesh["bodies"][1])["contours"]) > 1 else -1  # a ring has a rim
        # in the frame that holds the centres still both have the speed of the pitch point
        rolls = (a["speed"] - orbit) * a["teeth"], sense * (b["speed"] - orbit) * b["teeth"]
        assert rolls[0] == pytest.approx(rolls[1], rel=1e-9), mesh["name"]
        assert rolls[0] != 0


def test_speeds_follow_the_relative_speed() -> None:
    full, half = head_of("ren2021"), head_of("ren2021", relative_speed=0.5)
    assert full["bodies"][0]["speed"] == pytest.approx(100 * 2 * math.pi / 60)
    assert half["bodies"][0]["speed"] == full["bodies"][0]["speed"] / 2


def test_planets_orbit_with_their_carrier_alone() -> None:
    bodies = {body["name"]: body for body in head_of("encased-differential")["bodies"]}
    assert bodies["differential/planet/2"]["orbit"] == bodies["differential/carrier"]["speed"] != 0
    assert bodies["encased/planet/2"]["orbit"] == 0
    # the plate of a carrier reaches as far as its pins there, and no further than its size
    head = head_of("encased-differential")
    names = [body["name"] for body in head["bodies"]]
    ((times, radius, *plate),) = place_of(head, names.index("differential/carrier"))["contours"]
    assert (times, radius) == (1, 0)
    reach = [math.hypot(x, y) for x, y in zip(plate[::2], plate[1::2], strict=True)]
    assert max(reach) > math.hypot(*place_of(head, names.index("differential/planet/1"))["at"][:2])
    lobes = [i for i, one in enumerate(reach[:-1]) if one == pytest.approx(max(reach), abs=2e-3)]
    assert [round(3 * i) for i in lobes] == [0, 120, 240]  # degrees


def test_held_and_floating_members_are_marked() -> None:
    bodies = {body["name"]: body for body in head_of("wind-five", {"stages.main.sun.support.radial": 0})["bodies"]}
    assert [name for name, body in bodies.items() if body["floating"]] == ["main/sun"]
    assert [name for name, body in bodies.items() if body["held"]] == ["main/ring"]
    assert not any(body["floating"] for body in head_of("wind-five")["bodies"])


def test_stages_stand_side_by_side_and_helices_mirror() -> None:
    head = head_of("encased-differential")
    names = [body["name"] for body in head["bodies"]]
    stages = ["differential", "encased"]
    one, other = (
        [place_of(head, i) for i, name in enumerate(names) if name.startswith(f"{stage}/")] for stage in stages
    )
    assert max(area["at"][0] + reach_of(area) for area in one) < min(area["at"][0] - reach_of(area) for area in other)
    ends = [
        [end for i, name in enumerate(names) if name.startswith(f"{stage}/") for end in faces_of(head, i)]
        for stage in stages
    ]
    assert max(high for _, high in ends[0]) < min(low for low, _ in ends[1])

    def rises(head: dict[str, Any], name: str) -> list[bool]:
        """Whether the teeth on each face of a body rise to the right: of a left hand."""
        index = [body["name"] for body in head["bodies"]].index(name)
        traces = [one for one in shapes_of(head, "section", "stroke", "helix") if one["body"] == index]
        return [
            one["contours"][0][5] > one["contours"][0][3]
            for one in sorted(traces, key=lambda one: one["contours"][0][2])
        ]

    assert rises(head, names[0]) == [False, True]
    split = head_of("xu2020")
    assert (rises(split, "main/sun/left"), rises(split, "main/sun/right")) == ([True], [False])
    left, right = (
        faces_of(split, [body["name"] for body in split["bodies"]].index(f"main/sun/{side}"))
        for side in ("left", "right")
    )
    assert left[0][1] < 0 < right[0][0]


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
