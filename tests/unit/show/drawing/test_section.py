"""The axial section: what stands where, read back from its data, for trains of every kind."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr

import epicyclic
from epicyclic.document.document import ready_drives
from epicyclic.show.drawing.bodies import drawn_train
from epicyclic.show.drawing.painter import train_front, train_section
from epicyclic.show.drawing.section_layout import layout_of, text_width
from epicyclic.show.elements import Drawing
from epicyclic.show.views import sections_of

Boxes = list[tuple[float, float, float, float]]


@cache
def checked(name: str) -> xr.Dataset:
    return epicyclic.check(name)


@cache
def section(name: str) -> go.Figure:
    return train_section(checked(name))


def drawn_boxes(drawn: go.Figure, word: str) -> Boxes:
    """Ends along z and r [mm] of the filled boxes of what a pointer calls by this name."""
    own = [trace for trace in drawn.data if trace.fill == "toself" and f"<b>{word}</b>" in str(trace.text)]
    return [(min(trace.x), max(trace.x), min(trace.y), max(trace.y)) for trace in own]


def named(drawn: go.Figure, name: str) -> list[tuple[float, float]]:
    """Points of a trace of the legend, gaps left out."""
    found = [trace for trace in drawn.data if trace.name == name]
    return [(z, r) for trace in found for z, r in zip(trace.x, trace.y, strict=True) if z is not None]


def words(drawn: go.Figure) -> list[str]:
    return [note.text for note in drawn.layout.annotations]


def test_gears_end_at_their_pitch_circles_and_faces_are_to_scale() -> None:
    # Table 1 of the source: 21/37/95 teeth, 15 mm, 8 deg, faces 185/175/185 mm, middles 225 mm apart
    unit = 15 / (2 * math.cos(math.radians(8)))
    planet = [box for box in drawn_boxes(section("xu2020"), "planet 1") if box[1] - box[0] > 170]
    assert len(planet) == 2
    for found, middle in zip(planet, (-112.5, 112.5), strict=True):
        expected = (middle - 87.5, middle + 87.5, 21 * unit, 95 * unit)
        assert found == pytest.approx(expected, abs=0.02)
    ring = [box for box in drawn_boxes(section("xu2020"), "ring") if box[1] - box[0] > 180]
    assert [box[2] for box in ring] == pytest.approx([95 * unit] * 2, abs=0.02)


def test_meshes_are_lines_on_the_faces_at_the_pitch_circles() -> None:
    # 23 and 57 teeth of 32 mm and 25 deg, two helices of 170 mm with 20 mm between them
    unit = 32 / (2 * math.cos(math.radians(25)))
    levels = {(round(z, 2), round(r, 1)) for z, r in named(section("ren2021"), "meshes")}
    # without shift 57 - 17 teeth are 40 and 23 + 17 too: one centre distance
    expected = {(z, round(teeth * unit, 1)) for z in (-180.0, -10.0, 10.0, 180.0) for teeth in (23, 57)}
    assert levels == expected


def two_bearings(one_stage: dict[str, Any], *, at: float) -> xr.Dataset:
    stage = {**one_stage["stages"]["main"]}
    seat = {"radial": "1e8 N/m"}
    ends = {"front": {"at": f"{-at} mm", **seat}, "rear": {"at": f"{at} mm", **seat}}
    stage["planet"] = {**stage["planet"], "bearing": ends}
    stage["sun"] = {**stage["sun"], "support": {"front": {"at": "-90 mm", "radial": 0, "z": "1e8 N/m"}}}
    return epicyclic.check({**one_stage, "stages": {"main": stage}})


def test_bearings_stand_where_the_file_has_them(one_stage: dict[str, Any]) -> None:
    check = two_bearings(one_stage, at=20)
    drawn = train_section(check)
    pins = [
        (z, r)
        for z, r in named(drawn, "elastic support or bearing") + named(drawn, "rigid support or bearing")
        if abs(z) < 40 and r > 50
    ]
    pin = float(np.hypot(check.centre_x, check.centre_y).sel(body="main/planet/1")) * 1e3
    assert sorted(at for at, _ in pins)[:1] == pytest.approx([-20], abs=1e-6)
    assert sorted(at for at, r in pins if abs(r - pin) < 1e-2) == pytest.approx([-20, 20], abs=1e-6)
    # what holds the sun axially stands at -90 mm; nothing holds it radially
    axial = [z for z, r in named(drawn, "holds axially") if r < 20 and z < 0]
    assert np.mean(axial) == pytest.approx(-90, abs=1e-6)
    assert any(word.startswith("sun") and "floats" in word for word in words(drawn))


def test_what_holds_against_tilt_alone_holds_nothing_axially(one_stage: dict[str, Any]) -> None:
    stage = {**one_stage["stages"]["main"]}
    front = {"at": "-90 mm", "radial": 0, "z": "1e8 N/m", "tilt": 0}
    rear = {"at": "90 mm", "radial": "1e8 N/m", "z": 0, "tilt": "1e6 N m/rad"}
    stage["sun"] = {**stage["sun"], "support": {"front": front, "rear": rear}}
    drawn = train_section(epicyclic.check({**one_stage, "stages": {"main": stage}}))
    held = np.array([z for z, r in named(drawn, "holds axially") if abs(r) < 20])
    assert np.mean(held[held < 0]) == pytest.approx(-90, abs=1e-6)
    assert np.abs(held - 90).min() > 20


def test_bodies_without_teeth_stand_between_what_they_couple() -> None:
    differential = checked("encased-differential")
    layout = layout_of(differential, drawn_train(differential))
    assert [column.place for column in layout.columns] == [
        "differential", "g1", "f1", "encased", "g2", "f2", "output",
    ]  # fmt: skip
    # the carrier's shaft passes five columns under everything else
    assert [column.passing for column in layout.columns] == [0, 1, 1, 1, 1, 1, 0]
    assert [one.lane for one in layout.couplings if one.name == "carrier-output"] == [0]
    ends = [(column.low + column.shift, column.high + column.shift) for column in layout.columns]
    assert all(left[1] < right[0] for left, right in pairwise(ends))
    links = [link for link in checked("encased-differential").link_kind.values if link == "coupling"]
    assert len(layout.couplings) == len(links) == 7
    assert {"20 MW in →", "output<br>20 MW out"} <= set(words(section("encased-differential")))


def test_two_axes_of_a_branch_have_a_half_each() -> None:
    p, d = (drawn_boxes(section("yue2014-i"), f"{word} 1") for word in "pd")
    assert p
    assert d
    assert all(low >= 0 for _, _, low, _ in p)
    assert all(high <= 0 for _, _, _, high in d)
    # radii are true on both sides: p on 102 mm; the sun is in both halves
    assert (p[0][2] + p[0][3]) / 2 == pytest.approx(102, abs=3)
    sun = drawn_boxes(section("yue2014-i"), "sun")
    assert min(box[2] for box in sun) == -max(box[3] for box in sun)


@pytest.mark.parametrize(
    ("drive", "held"), [("ren2021", "ring"), ("yue2014-i", "carrier"), ("yue2014-ii", "ring"), ("yue2014-iii", "sun")]
)
def test_what_is_held_is_said_and_stands_in_the_housing(drive: str, held: str) -> None:
    said = [word for word in words(section(drive)) if "held" in word]
    assert [word.split(" (")[0] for word in said] == [held]
    assert named(section(drive), "housing")
    front = train_front(checked(drive))
    assert [word.split(",")[0].split("<br>")[0] for word in words(front) if "held" in word] == [held]


def label_boxes(drawn: go.Figure) -> list[tuple[str, float, float, float, float]]:
    """Notes of a section as boxes in pixels from the middle of its ranges, their texts measured by `text_width`."""
    (z0, z1), (r0, r1) = drawn.layout.xaxis.range, drawn.layout.yaxis.range
    scale = min(800 / (z1 - z0), (drawn.layout.height - 130) / (r1 - r0))
    found = []
    for note in drawn.layout.annotations:
        wide, tall = text_width(note.text.replace("<b>", "").replace("</b>", "")), 15 * (note.text.count("<br>") + 1)
        if note.textangle:
            wide, tall = tall, wide
        x = (note.x - z0) * scale + (note.xshift or 0)
        y = (note.y - r0) * scale + (note.yshift or 0)
        left = x - {"left": 0, "right": wide}.get(note.xanchor or "center", wide / 2)
        low = y - {"bottom": 0, "top": tall}.get(note.yanchor or "middle", tall / 2)
        found.append((note.text, left, left + wide, low, low + tall))
    return found


@pytest.mark.parametrize("drive", [name for name in ready_drives() if name not in ("lin1999-n3", "lin1999-n5")])
def test_names_have_room(drive: str) -> None:
    drawn = section(drive)
    boxes = label_boxes(drawn)
    assert len(boxes) >= 4
    (z0, z1), (r0, r1) = drawn.layout.xaxis.range, drawn.layout.yaxis.range
    scale = min(800 / (z1 - z0), (drawn.layout.height - 130) / (r1 - r0))
    for place, (name, left, right, low, high) in enumerate(boxes):
        assert left > -30, name
        assert right < (z1 - z0) * scale + 30, name
        assert low > -5, name
        assert high < (r1 - r0) * scale + 20, name
        for other, start, stop, bottom, top in boxes[:place]:
            apart = left >= stop or start >= right or low >= top or bottom >= high
            assert apart, (name, other)


def test_gears_on_one_axis_have_one_name_each_in_the_front_view() -> None:
    front = train_front(checked("dong2019"))
    places = [(round(note.x, 3), round(note.y, 3)) for note in front.layout.annotations]
    assert len(places) == len(set(places)) == 7
    # with the teeth where there is room
    assert any({line.split(",")[0] for line in text.split("<br>")} == {"star1 1", "star2 1"} for text in words(front))


def test_results_that_say_nothing_of_kind_and_place_of_links_are_drawn() -> None:
    older = checked("ren2021").drop_vars(["link_kind", "link_station"])
    assert {note.text for note in train_section(older).layout.annotations} == set(words(section("ren2021")))


def test_stages_side_by_side_are_said_to_be() -> None:
    """Drawings of one stage say nothing of it; of several, both drawings and the report do, and each has its name."""
    for name, several in (("ren2021", False), ("encased-differential", True)):
        front, side = train_front(checked(name)), section(name)
        assert ("stages side by side, not as they stand" in front.layout.title.text) is several
        assert ("stages in series, what lies between is a scheme" in side.layout.title.text) is several
        parts = [part for one in sections_of({"check": checked(name)}) for part in one.parts]
        (caption,) = [part.caption for part in parts if isinstance(part, Drawing) and part.anchor == "front"]
        assert ("how they lie to each other is not in the model" in caption) is several
        assert sum("<b>" in text for text in words(front)) == (2 if several else 0)
