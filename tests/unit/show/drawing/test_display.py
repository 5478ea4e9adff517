"""The display list: what stands where against the train, and that each painter knows every kind of shape and role."""

from __future__ import annotations

import math
import subprocess
import sys
from functools import cache

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr

import epicyclic
from epicyclic.document.document import ready_drives
from epicyclic.show.drawing import bodies
from epicyclic.show.drawing.bodies import (
    Area,
    DrawnShape,
    Stroke,
    Symbol,
    Text,
    bounds,
    circle,
    drawn_train,
    lines_of,
    plain,
    polygon,
)
from epicyclic.show.drawing.front import front_centres, front_notes, front_parts, front_shapes
from epicyclic.show.drawing.painter import PAINTERS, paint
from epicyclic.show.drawing.section import section_names, section_shapes
from epicyclic.show.drawing.section_layout import layout_of

# radii as printed in these do not add up to the centre distance: drawn by their teeth
UNEVEN = {"dong2019", "lin1999-n3", "lin1999-n4", "lin1999-n5"}


@cache
def checked(drive: str) -> xr.Dataset:
    return epicyclic.check(drive)


def front_of(drive: str) -> list[DrawnShape]:
    train = drawn_train(checked(drive))
    return front_shapes(train, front_parts(train, behind=True))


def section_of(drive: str) -> list[DrawnShape]:
    train = drawn_train(checked(drive))
    return section_shapes(train, layout_of(checked(drive), train))


@pytest.mark.parametrize("drive", ready_drives())
def test_every_body_stands_in_the_front_view_with_its_teeth_and_radii(drive: str) -> None:
    check, shapes = checked(drive), front_of(drive)
    areas = {shape.body: shape for shape in shapes if isinstance(shape, Area)}
    stages = list(dict.fromkeys(check.mesh_stage.values.tolist()))
    first = check.body_stage.values == stages[0]
    for body, x, y in zip(
        check.body.values[first], check.centre_x.values[first], check.centre_y.values[first], strict=True
    ):
        assert areas[body].at == pytest.approx(1e3 * complex(x, y), abs=1e-6)
    for gear in check.gear.values:
        row, area = check.sel(gear=gear), areas[gear]
        teeth = area.contours[-1]
        assert teeth.times == int(row.teeth)
        reach = np.abs(teeth.points)
        if drive not in UNEVEN:
            ends = sorted((1e3 * float(row.tip_radius), 1e3 * float(row.root_radius)))
            assert [reach.min(), reach.max()] == pytest.approx(ends, rel=1e-12)  # to rounding
        # a ring lies between its rim and its teeth, another gear within its teeth
        assert [one.radius > reach.max() for one in area.contours[:-1]] == ([True] if bool(row.internal) else [])


def test_a_body_is_turned_and_moved_as_one() -> None:
    """The stroke that shows the turning stands in the middle of a tooth."""
    shapes = front_of("ren2021")
    for mark in (shape for shape in shapes if isinstance(shape, Stroke) and shape.role == "turning"):
        area = next(shape for shape in shapes if isinstance(shape, Area) and shape.body == mark.body)
        assert (mark.at, mark.turn) == (area.at, area.turn)
        (line,) = lines_of(mark)
        angle = np.angle(lines_of(area)[-1][:-1] - area.at) - np.angle(line[0] - mark.at)
        pitch = 2 * math.pi / area.contours[-1].times
        away = np.abs((angle + pitch / 2) % pitch - pitch / 2)
        tip = area.contours[-1].points.size // 2
        assert away[tip - 1] == pytest.approx(away[tip], abs=1e-9)  # both corners of a tip are as far from the stroke
        assert away[tip] < pitch / 4


def test_held_bodies_have_the_housing_about_them() -> None:
    def held(drive: str) -> list[tuple[str, str]]:
        return [(shape.role, shape.body) for shape in front_of(drive) if shape.role.startswith("held")]

    assert held("ren2021") == [("held", "main/ring/left"), ("held", "main/ring/right")]
    assert held("yue2014-i") == [("held hub", "main/carrier")]
    assert held("encased-differential") == []


def test_centres_say_numbers_names_and_what_floats() -> None:
    train = drawn_train(checked("ren2021"))
    found = front_parts(train, behind=True)
    said = front_centres(found, {"main/sun", "main/ring/left"})
    texts = {shape.body: shape.text for shape in said if isinstance(shape, Text)}
    assert texts == {"main/sun": "sun", **{f"main/planet/{n}": str(n) for n in (1, 2, 3)}}
    roles = [shape.role for shape in said if isinstance(shape, Symbol)]
    assert roles == ["floats on the rim", "floats on the rim", "floats"]
    assert "centre" in [shape.role for shape in front_centres(found, ())]


def test_meshes_of_all_branches_share_the_line_of_the_section() -> None:
    lines = [shape for shape in section_of("ren2021") if shape.role == "mesh"]
    assert {shape.meshes for shape in lines} == {
        tuple(f"main/{pair}/{n}/{side}" for n in (1, 2, 3))
        for pair in ("sun-planet", "planet-ring")
        for side in ("left", "right")
    }
    left = [shape for shape in lines if isinstance(shape, Stroke) and shape.meshes[0].endswith("left")]
    assert all(end.real < 0 for shape in left for line in lines_of(shape) for end in line)
    # those of two planets of a branch stand beside the plane, at the distance of their pitch point
    assert {shape.meshes for shape in section_of("yue2014-i") if shape.role == "mesh beside"} == {
        tuple(f"main/p-d/{n}" for n in (1, 2, 3))
    }


def test_contours_are_repeated_joined_in_an_area_and_apart_in_a_stroke() -> None:
    side = polygon(1 + 0j, 1j, times=4)
    area = Area(role="body", at=5 + 1j, turn=0.5, contours=(side, circle(3)))
    square, rim = lines_of(area)
    assert len(square) == 9
    assert square[0] == square[-1]
    np.testing.assert_allclose(square[::2] - area.at, np.exp(1j * (0.5 + np.pi / 2 * np.arange(5))), atol=1e-12)
    np.testing.assert_allclose(np.abs(rim - area.at), 3, rtol=1e-12)
    assert [len(line) for line in lines_of(Stroke(role="held", contours=(side,)))] == [2, 2, 2, 2]
    assert bounds([area, Symbol(role="axial", at=-4j)]) == pytest.approx(
        [0, 8, -4, 4], abs=2e-3
    )  # a circle of 120 sides
    assert bounds([]) == [-1, 1, -1, 1]


def test_a_contour_is_sent_once() -> None:
    train = drawn_train(checked("ren2021"))
    bodies = {name: i for i, name in enumerate(checked("ren2021").body.values)}
    meshes = {name: i for i, name in enumerate(checked("ren2021").mesh.values)}
    sent = plain(front_of("ren2021"), bodies, meshes)
    planets = [row for row in sent["shapes"] if row["kind"] == "planet" and row["type"] == "area"]
    assert len(planets) == 3
    assert len({tuple(row["contours"]) for row in planets}) == 1
    assert sent["contours"][planets[0]["contours"][0]][0] == 17
    x, y, turn = planets[1]["at"]
    part = train.parts[planets[1]["body"]]
    assert complex(x, y) == pytest.approx(part.centre, abs=1e-3)
    area = next(shape for shape in front_of("ren2021") if isinstance(shape, Area) and shape.body == part.name)
    assert turn == pytest.approx(area.turn, abs=1e-6)


def test_a_list_is_made_without_plotly() -> None:
    """The process that computes for the page loads none."""
    code = "import sys, epicyclic.cockpit.computing.train_view; sys.exit('plotly' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_painter_of_the_figures_knows_every_shape() -> None:
    kinds = {kind for kind in vars(bodies).values() if isinstance(kind, type) and issubclass(kind, DrawnShape)}
    assert set(PAINTERS) == kinds - {DrawnShape}
    for unknown in (
        Area(role="unheard of", contours=(circle(1),)),
        Stroke(role="unheard of", contours=(circle(1),)),
        Symbol(role="unheard of"),
    ):
        with pytest.raises(KeyError):
            paint(go.Figure(), [unknown])


@pytest.mark.parametrize("drive", ready_drives())
def test_the_figures_paint_every_role_of_the_lists(drive: str) -> None:
    train = drawn_train(checked(drive))
    layout, drawn = layout_of(checked(drive), train), go.Figure()
    paint(
        drawn, [*front_of(drive), *front_notes(train, front_parts(train)), *section_of(drive), *section_names(layout)]
    )
    assert drawn.data
