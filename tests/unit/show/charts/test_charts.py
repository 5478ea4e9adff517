"""What each figure shows, read back from its data."""

from __future__ import annotations

import json
import re
from types import ModuleType

import numpy as np
import plotly.graph_objects as go
import pytest
import xarray as xr

import epicyclic
from epicyclic.show.charts.effects import study
from epicyclic.show.charts.mode_shapes import mode_shapes
from epicyclic.show.charts.modes import campbell, crossings, energy_shares, frequencies
from epicyclic.show.charts.over_speed import bearing_forces, mode_marks, speed_sweep
from epicyclic.show.charts.over_time import mesh_forces
from epicyclic.show.charts.renderers import DASHES, PALETTE, branch_colour
from epicyclic.show.charts.sharing import (
    grade_prices,
    k_gamma_by_design,
    k_gamma_by_tolerance,
    k_gamma_histogram,
    load_history,
    load_sharing,
    tolerance_shares,
    worst_branches,
)
from epicyclic.show.charts.speed_maps import Ray, crests, label_places, rays, waterfall
from epicyclic.show.charts.train import members, mesh_stiffness, orders, phases
from epicyclic.show.drawing.bodies import faces, parts
from epicyclic.show.drawing.painter import train_front, train_section
from epicyclic.show.series import mode_groups, summed_shares

Datasets = dict[str, xr.Dataset]


def every_figure(datasets: Datasets) -> dict[str, go.Figure]:
    check, modes = datasets["check"], datasets["modes"]
    found = {
        "front": train_front(check),
        "section": train_section(check),
        "members": members(check),
        "phases": phases(check),
        "orders": orders(check),
        "stiffness": mesh_stiffness(datasets["stiffness"]),
        "frequencies": frequencies(modes, check),
        "shapes": mode_shapes(check, modes),
        "energy": energy_shares(modes),
    }
    if "sharing" in datasets:
        found["campbell"] = campbell(datasets["campbell"])
        found["sharing"] = load_sharing(datasets["sharing"])
        found["history"] = load_history(datasets["sharing"])
        found["forces"] = mesh_forces(datasets["sharing"])
        found["sweep"] = speed_sweep(datasets["sweep"], modes)
        found["waterfall"] = waterfall(datasets["sweep"], modes)
        found["bearings"] = bearing_forces(datasets["sweep"], modes)
    if "tolerance" in datasets:
        tolerances = datasets["tolerance"]
        found["k_gamma"] = k_gamma_histogram(tolerances)
        found["k_gamma_by_tolerance"] = k_gamma_by_tolerance(tolerances)
        found["k_gamma_by_design"] = k_gamma_by_design(tolerances)
        found["tolerance_shares"] = tolerance_shares(tolerances)
        found["worst_branches"] = worst_branches(tolerances)
        found["grade_prices"] = grade_prices(datasets["allocate"])
    return found


@pytest.fixture(scope="module")
def drawn_of_ren(ren: Datasets) -> dict[str, go.Figure]:
    return every_figure(ren)


def numbers(values: object) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array(values, dtype=np.float64)


def test_every_axis_with_numbers_says_its_unit(drawn_of_ren: dict[str, go.Figure]) -> None:
    for name, drawn in drawn_of_ren.items():
        titles = [axis.title.text for axis in drawn.select_yaxes() if axis.title.text]
        titles += [axis.title.text for axis in drawn.select_xaxes() if axis.title.text]
        if name not in ("members", "phases", "orders", "frequencies", "shapes", "energy", "sharing"):
            assert titles, name
        for title in titles:
            assert title == "mode" or re.search(r"\[.+\]$", title), (name, title)


def test_figures_are_json_without_nan(drawn_of_ren: dict[str, go.Figure], lin: Datasets) -> None:
    for figures in (drawn_of_ren, every_figure(lin)):
        for name, drawn in figures.items():
            text = drawn.to_json()
            assert "NaN" not in text, name
            assert json.loads(text)["layout"]["title"]["text"], name


def test_branch_colours_differ() -> None:
    assert len({branch_colour(branch) for branch in range(1, 9)}) == len(PALETTE) == 8


def test_the_front_view_has_the_teeth_of_every_gear(ren: Datasets) -> None:
    drawn = train_front(ren["check"])
    text = [note.text for note in drawn.layout.annotations]
    assert sum("z = 17" in word for word in text) == 3
    assert "ring, z = 57, held" in text
    assert any(word.startswith("carrier, 28.75 rpm") for word in text)
    # x and y have one scale
    assert drawn.layout.yaxis.scaleanchor == "x"
    sun = next(trace for trace in drawn.data if trace.text and "sun" in str(trace.text) and trace.fill == "toself")
    radius = np.hypot(numbers(sun.x), numbers(sun.y))
    # tip circle of the sun, to the hundredth of a millimetre that is written
    assert radius.max() == pytest.approx(1e3 * float(ren["check"].tip_radius.sel(gear="main/sun")), abs=0.05)
    tips = np.sum(np.diff((radius > radius.max() - 1).astype(int)) == 1)
    assert tips == 23


def test_herringbone_faces_lie_on_either_side_of_the_gap(ren: Datasets) -> None:
    sun = next(part for part in parts(ren["check"]) if part.name == "main/sun")
    (a, b, left), (c, d, right) = faces(sun)
    assert (a, b, c, d) == pytest.approx((-0.18, -0.01, 0.01, 0.18))
    assert (left, right) == (-1, 1)


def test_sense_of_rotation_arrows_follow_the_signs(ren: Datasets) -> None:
    drawn = train_front(ren["check"])
    arcs = next(trace for trace in drawn.data if trace.name == "sense of rotation")
    x, y = numbers(arcs.x), numbers(arcs.y)
    ends = np.flatnonzero(np.isnan(x))
    first = slice(0, ends[0])
    # bodies come in the order sun, planets: the sun turns counter-clockwise about the origin, planets clockwise
    turned = np.unwrap(np.arctan2(y[first], x[first]))
    assert turned[-1] > turned[0]
    second = slice(ends[0] + 1, ends[1])
    turned = np.unwrap(np.arctan2(y[second], x[second] - 706.16))
    assert turned[-1] < turned[0]


def test_member_bars_balance(ren: Datasets) -> None:
    drawn = members(ren["check"])
    torque, power = numbers(drawn.data[1].x), numbers(drawn.data[2].x)
    # torques of all members in equilibrium and power in = power out, to rounding
    assert torque.sum() == pytest.approx(0, abs=1e-9)
    assert power.sum() == pytest.approx(0, abs=1e-9)
    assert [label for label in drawn.data[0].y] == ["planet", "carrier", "ring", "sun"]


def test_dials_show_the_leads(ren: Datasets) -> None:
    drawn = phases(ren["check"])
    shown = {(trace.subplot, trace.name): trace.theta[1] for trace in drawn.data}
    # leads of 23 teeth and three planets: 0, 1/3, 2/3; of 57 teeth: all 0; input is rounded to 1e-9
    assert [shown["polar", f"branch {branch} L, R"] for branch in (1, 2, 3)] == pytest.approx([0, 120, 240], abs=1e-6)
    assert [shown["polar2", f"branch {branch} L, R"] for branch in (1, 2, 3)] == pytest.approx([0, 0, 0], abs=1e-6)


def test_stiffness_curves_that_coincide_are_one(ren: Datasets) -> None:
    drawn = mesh_stiffness(ren["stiffness"])
    ring = [trace for trace in drawn.data if trace.yaxis == "y2"]
    assert [trace.name for trace in ring] == ["branches 1–3 L, R alike"]
    sun = [trace for trace in drawn.data if trace.yaxis == "y"]
    assert {trace.line.dash for trace in sun} == {DASHES[0]}
    assert all(trace.x[-1] == 1 and trace.y[-1] == trace.y[0] for trace in drawn.data)


def test_frequency_groups_add_up(ren: Datasets, lin: Datasets) -> None:
    for datasets in (ren, lin):
        found = mode_groups(datasets["modes"])
        assert sum(one.multiplicity for one in found) == datasets["modes"].sizes["mode"]
        assert [one.frequency for one in found] == sorted(one.frequency for one in found)


def test_energy_shares_of_a_group_are_summed(ren: Datasets) -> None:
    shares = ren["modes"].strain_energy_share
    names, total = summed_shares([str(name) for name in shares.connection.values], shares.values)
    assert "sun-planet" in names
    expected = shares.sel(connection=[n for n in shares.connection.values if "sun-planet" in n]).sum("connection")
    np.testing.assert_allclose(total[names.index("sun-planet")], expected, atol=1e-12)  # a sum in another order
    np.testing.assert_allclose(total.sum(axis=0)[1:], 1, atol=1e-9)


def test_crossings_lie_on_ray_and_curve(synthetic: ModuleType) -> None:
    speed = np.linspace(0, 2, 21)
    whirl = np.stack([100 - 10 * speed, 100 + 10 * speed], axis=1)
    data = synthetic.dataset(
        {
            "whirl_frequency": (("relative_speed", "mode"), whirl),
            "mesh_frequency": (("stage", "relative_speed"), 60.0 * speed[None]),
        },
        coords={"relative_speed": speed, "stage": ["main"]},
        verb="modes",
    )
    found = crossings(data, orders=2)
    # 60 l s = 100 -+ 10 s; straight lines, so interpolation is exact
    expected = sorted(100 / (60 * order + sign * 10) for order in (1, 2) for sign in (1, -1))
    assert sorted(one.relative_speed for one in found) == pytest.approx([s for s in expected if s <= 2], rel=1e-12)
    for one in found:
        assert one.frequency == pytest.approx(60 * one.order * one.relative_speed, rel=1e-12)


def frame_of(drawn: go.Figure, name: str) -> list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    frame = next(frame for frame in drawn.frames if frame.name == name)
    return [numbers(trace.x) + 1j * numbers(trace.y) for trace in frame.data]


def test_a_mode_swings_about_its_place_at_rest(lin: Datasets) -> None:
    drawn = mode_shapes(lin["check"], lin["modes"])
    rest = [numbers(trace.x) + 1j * numbers(trace.y) for trace in drawn.data[: len(drawn.frames[0].data)]]
    for mode in (1, 5):
        high, middle, low = (frame_of(drawn, f"{mode}.{step}") for step in (0, 4, 8))
        moved = max(float(np.nanmax(np.abs(a - b))) for a, b in zip(high, rest, strict=True))
        smallest = 1e3 * float(lin["check"].reference_radius.min())
        assert 0.05 * smallest < moved < 0.6 * smallest
        for up, at, down, still in zip(high, middle, low, rest, strict=True):
            np.testing.assert_allclose(at, still, atol=0.011, equal_nan=True)  # written to 0.01 mm
            # forth and back are alike but for the curvature of a turn, moved^2 / radius
            assert np.nanmax(np.abs(up + down - 2 * still)) < moved**2 / smallest + 0.05


@pytest.mark.parametrize(("direction", "expected"), [("x", 1j), ("y", -1)])
def test_planets_move_in_their_own_axes(lin: Datasets, direction: str, expected: complex) -> None:
    modes = lin["modes"].copy(deep=True)
    modes["full_shape"][:] = 0.0
    modes["full_shape"].loc[{"body": "main/planet/2", "direction": direction, "mode": 1}] = 1.0
    drawn = mode_shapes(lin["check"], modes.isel(mode=slice(0, 1)))
    count = len(drawn.frames[0].data)
    rest = [numbers(trace.x) + 1j * numbers(trace.y) for trace in drawn.data[:count]]
    moved = [a - b for a, b in zip(frame_of(drawn, "0.0"), rest, strict=True)]
    shift = moved[[trace.name for trace in drawn.data[:count]].index("planet")]
    largest = shift[np.nanargmax(np.abs(shift))]
    # of planet 2, radially outward is +y and tangential -x; numbers are written to 0.01 mm
    assert abs(largest) > 1
    assert abs(largest / expected - abs(largest)) < 0.03


def test_the_slider_has_a_step_for_each_mode_and_frames_exist(drawn_of_ren: dict[str, go.Figure]) -> None:
    drawn = drawn_of_ren["shapes"]
    names = {frame.name for frame in drawn.frames}
    steps = drawn.layout.sliders[0].steps
    assert len(steps) == 28
    for step in steps:
        assert set(step.args[0]) <= names
    assert "side view, z to the right" in [note.text for note in drawn.layout.annotations]


def test_whirling_shapes_go_all_the_way_round(lin: Datasets) -> None:
    modes = lin["modes"].isel(mode=slice(0, 2)).copy()
    shape = np.zeros(modes["full_shape"].shape, dtype=complex)
    shape[0, 0], shape[0, 1] = 1.0, -1j
    modes["full_shape"] = modes["full_shape"].astype(complex).copy(data=shape)
    drawn = mode_shapes(lin["check"], modes)
    count = len(drawn.frames[0].data)
    sun = [trace.name for trace in drawn.data[:count]].index("sun")
    rest = numbers(drawn.data[sun].x) + 1j * numbers(drawn.data[sun].y)
    angles = [np.angle(np.nanmean(frame_of(drawn, f"0.{step}")[sun] - rest)) for step in range(16)]
    # x = cos, y = sin: one turn counter-clockwise in equal steps, to the rounding of what is written
    np.testing.assert_allclose(np.diff(np.unwrap(angles)), 2 * np.pi / 16, atol=5e-3)


def test_a_page_can_be_passed_on_by_mail(synthetic: ModuleType) -> None:
    gears = synthetic.lin_gears(8)
    text = mode_shapes(synthetic.check(gears), synthetic.modes(gears)).to_json()
    assert len(text) < 2.3e6


def test_sharing_bars_start_at_one(ren: Datasets) -> None:
    drawn = load_sharing(ren["sharing"])
    first = drawn.data[0]
    expected = ren["sharing"].load_sharing.sel(mesh="main/sun-planet/1/left").values
    np.testing.assert_allclose(1 + numbers(first.y), expected, atol=5.1e-6)  # written to six digits of the largest
    assert first.base == 1
    assert {trace.name for trace in drawn.data} == {f"branch {branch} L, R" for branch in (1, 2, 3)}


def test_histories_keep_their_peaks(synthetic: ModuleType) -> None:
    data = synthetic.sharing(synthetic.REN, cycles=200)
    drawn = load_history(data)
    peak = data.load_sharing_history.sel(mesh="main/planet-ring/3/left").values.max()
    shown = [trace for trace in drawn.data if trace.yaxis == "y2" and trace.name.startswith("branch 3")]
    # written to five digits
    assert numbers(shown[0].y).max() == pytest.approx(peak, abs=1e-4)
    assert len(shown[0].y) < 0.3 * data.sizes["time"]


def test_even_sharing_is_no_empty_panel(ren: Datasets) -> None:
    data = ren["sharing"].copy(deep=True)
    data["load_sharing_history"].values[6:] = 1.0
    drawn = load_history(data)
    assert [note.text for note in drawn.layout.annotations].count("every branch carries its share") == 1
    low, high = drawn.layout.yaxis2.range
    assert 0.98 < low < 1 < high < 1.02
    assert {shape.layer for shape in drawn.layout.shapes} == {"below"}


def test_numbers_of_natural_frequencies_do_not_collide(ren: Datasets) -> None:
    modes = ren["modes"].copy(deep=True)
    hertz = modes["frequency"].values
    hertz[:] = np.sort(np.r_[np.linspace(500, 501, 6), np.linspace(600, 1300, hertz.size - 6)])
    modes["multiplicity"].values[:] = 1
    heads = [trace for trace in frequencies(modes).data if trace.text is not None]
    written = sum(bool(text) for trace in heads for text in trace.text)
    assert sum(len(trace.text) for trace in heads) == hertz.size
    close = [text for trace in heads for x, text in zip(trace.x, trace.text, strict=True) if x <= 6 and text]
    assert len(close) <= 4  # six numbers of 30 px at one height in 170 px
    assert written > 0.4 * hertz.size  # 23 px of digits on 21 px a mode of a page of 900 px: every second one


def test_names_of_rays_and_mesh_frequencies_have_room(ren: Datasets) -> None:
    """Names of modes widen the margin; every ray is named once, inside the diagram and on the ray."""
    data = ren["campbell"]
    tone = data["mesh_frequency"]
    wide = data.drop_vars(["mesh_frequency", "stage"]).assign(
        mesh_frequency=(("stage", "relative_speed"), np.stack([tone.values.ravel(), 20 * tone.values.ravel()]))
    )
    wide = wide.assign_coords(stage=["differential", "encased"])
    drawn = campbell(wide)
    names = {note.text: note for note in drawn.layout.annotations}
    beside = [name for name in names if name.startswith("mode")]
    assert beside
    assert drawn.layout.margin.r >= 7 * max(map(len, beside))
    heights = sorted(names[name].y for name in beside)
    assert min(np.diff(heights), default=1.0) >= 0.04 * drawn.layout.yaxis.range[1]
    speed = 100 * data["relative_speed"].values
    for name, note in ((name, note) for name, note in names.items() if "encased" in name):
        order = int(name.split("×")[0])
        assert note.y == pytest.approx(order * np.interp(note.x, speed, 20 * tone.values.ravel()), rel=1e-9)
        assert 0 < note.x < drawn.layout.xaxis.range[1]
        assert 0 < note.y < drawn.layout.yaxis.range[1]


def test_a_study_names_its_definition_and_spells_micrometres() -> None:
    result = xr.Dataset(
        {"system_load_sharing": (("member", "run_out"), np.ones((1, 3)), {"units": "1", "long_name": "coefficient"})},
        {"member": ["main.sun"], "run_out": ["0 um", "10 um", "20 um"]},
        {"options": json.dumps({"definition": "worst-case"})},
    )
    drawn = study(result)
    assert drawn.layout.yaxis.title.text == "coefficient,<br>worst case [-]"
    assert drawn.layout.xaxis.title.text == "run out [µm]"


def test_lost_contact_is_said(ren: Datasets) -> None:
    data = ren["sharing"].copy()
    data["contact_lost"] = data.contact_lost.copy(data=np.arange(12) < 2)
    notes = [note.text for note in mesh_forces(data).layout.annotations]
    assert "contact lost in 2 of 12 meshes" in notes


def test_the_waterfall_has_a_ray_for_every_line(ren: Datasets) -> None:
    sweep = ren["sweep"]
    every = rays(sweep)
    assert [ray.order for ray in every] == pytest.approx([0.0435, 1, 1.0435, *range(2, 13)])
    first = every[1]
    assert first.label == "1× mesh"
    expected = sweep.mesh_force_order.sel(order=1).max("mesh").values
    np.testing.assert_array_equal(first.amplitude, expected)
    at = int(np.nanargmax(expected))
    assert first.mesh[at] == str(sweep.mesh.values[sweep.mesh_force_order.sel(order=1).values[:, at].argmax()])
    found = crests(every, sweep.mesh_frequency.values, ren["modes"])
    natural = np.array([one.frequency for one in mode_groups(ren["modes"])])
    assert 1 <= len(found) <= 5
    assert found[0].amplitude == max(one.amplitude for one in found)
    for one in found:
        assert np.abs(natural / one.y - 1).min() < 0.06
        assert one.y / one.x == pytest.approx(float(one.label.partition("×")[0])) or "run_out" in one.label
    drawn = waterfall(sweep, ren["modes"])
    shades = [trace for trace in drawn.data if trace.marker.coloraxis == "coloraxis"]
    strongest = max(shades, key=lambda trace: max(trace.marker.color))
    # in kN, as a logarithm, to four digits
    assert 10 ** max(strongest.marker.color) == pytest.approx(float(np.nanmax(expected)) / 1e3, rel=1e-2)
    alone = waterfall(sweep, mesh=str(sweep.mesh.values[0]))
    assert "main/" in alone.layout.title.text


def _peaks(x: np.ndarray, *places: tuple[float, float]) -> np.ndarray:
    """Amplitude over x with peaks of given place and height."""
    return np.asarray(sum(height * np.exp(-(((x - at) / 1.5) ** 2)) for at, height in places))


def test_resonances_that_nothing_excites_are_not_marked() -> None:
    modes, speed = epicyclic.modes("ren2021", band=0.2), np.linspace(0.8, 1.2, 9)
    marks = mode_marks(modes, xr.Dataset(coords={"speed": speed}), 100 * speed)
    excited = modes.resonance_excited.values != "no"
    driven, idle = (100 * modes.resonance_speed.values[one] for one in (excited, ~excited))
    assert marks
    assert idle.size
    assert {mark.x for mark in marks} <= set(driven) - set(idle)


def test_the_strongest_resonances_are_ringed(ren: Datasets) -> None:
    """Two of nearly one speed or one frequency too: a name without room is no reason to ring a weaker one."""
    x = np.linspace(1.0, 41.0, 81)
    heights = {7: (34.0, 1700.0), 8: (30.0, 1200.0), 9: (26.0, 730.0), 11: (21.5, 70.0), 12: (20.0, 390.0)}
    shown = [
        Ray(
            order=float(order),
            label=f"{order}× mesh",
            amplitude=_peaks(x, peak),
            mesh=["main/sun-planet/1"] * 81,
            labels=[f"{order}× mesh"] * 81,
        )
        for order, peak in heights.items()
    ]
    found = crests(shown, x, highest=400.0)
    assert [one.label for one in found] == ["7× mesh", "8× mesh", "9× mesh", "12× mesh", "11× mesh"]
    lower = crests(shown, x, highest=239.0)  # 7 x 34 is the only one within
    assert [one.label for one in lower] == ["7× mesh", "9× mesh", "11× mesh"]


def test_names_of_rings_have_places_of_their_own() -> None:
    rings = [(0.9, 0.7), (0.8, 0.7), (0.83, 0.72), (0.02, 0.01), (0.06, 0.01)]
    letters = [21, 21, 20, 20, 22]
    places = label_places(rings, letters)
    boxes = [(x + dx, y + dy, n * 0.0105, 0.045) for (x, y), (dx, dy), n in zip(rings, places, letters, strict=True)]
    for i, (x, y, wide, tall) in enumerate(boxes):
        assert min(x - wide / 2, y - tall / 2) >= 0
        assert max(x + wide / 2, y + tall / 2) <= 1
        for other_x, other_y, other, _ in boxes[:i]:
            assert abs(x - other_x) >= (wide + other) / 2 - 1e-12 or abs(y - other_y) >= tall - 1e-12
        for ring_x, ring_y in rings:
            assert abs(x - ring_x) > wide / 2 or abs(y - ring_y) > tall / 2


def test_a_ray_of_two_tones_is_named_by_the_stronger(ren: Datasets) -> None:
    """8 x a tone 1.5 times the first is 12 x the first."""
    sweep = ren["sweep"].copy(deep=True)
    sweep["mesh"] = [name.replace("main", "high" if i >= 6 else "low") for i, name in enumerate(sweep.mesh.values)]
    sweep = sweep.assign_coords(mesh_tone=("mesh", np.where(np.arange(sweep.sizes["mesh"]) < 6, 1.0, 1.5)))
    force = sweep["mesh_force_order"]
    force.loc[{"order": 12, "mesh": sweep.mesh[:6]}] = 1.0
    force.loc[{"order": 8, "mesh": sweep.mesh[6:]}] = 1e6
    (both,) = [ray for ray in rays(sweep) if ray.order == 12.0]
    assert both.label == "8× high mesh"
    assert set(both.labels) == {"8× high mesh"}
    assert set(both.mesh) <= {str(name) for name in sweep.mesh.values[6:]}


def test_lines_of_one_frequency_are_one_ray(ren: Datasets) -> None:
    sweep = ren["sweep"].assign_coords(line_order=("line", [1.0, 1.0435]))
    (first,) = [ray for ray in rays(sweep) if ray.order == 1.0]
    both = np.maximum(sweep.mesh_force_order.sel(order=1).max("mesh"), sweep.mesh_force_line[:, 0].max("mesh"))
    np.testing.assert_array_equal(first.amplitude, both.values)


def test_a_mesh_of_another_tone_has_its_own_rays(ren: Datasets) -> None:
    tones = np.where(np.arange(ren["sweep"].sizes["mesh"]) < 6, 1.0, 0.3)
    found = {ray.order: ray.label for ray in rays(ren["sweep"].assign_coords(mesh_tone=("mesh", tones)))}
    assert found[0.3] == found[1.0] == "1× main mesh"
    assert found[0.6] == "2× main mesh"
    assert len(found) == 12 + 12 + 2 - 1  # 10 x 0.3 is 3 x 1


def test_bearings_are_told_apart_in_each_panel(ren: Datasets) -> None:
    """Curves that coincide beside the static forces of the other panel are two where their own panel shows it."""
    sweep = ren["sweep"].copy(deep=True)
    sweep["bearing_force_peak"].values[:] = 1e6
    rms = sweep["bearing_force_rms"]
    rms.values[:] = 500.0
    rms.values[-1] = 900.0
    names = [trace.name for trace in bearing_forces(sweep).data if trace.showlegend is not False][:2]
    assert str(sweep["bearing"].values[-1]).split("/", 1)[-1].replace("/", " ") in names


def test_bearings_that_carry_the_same_are_one_curve(ren: Datasets) -> None:
    drawn = bearing_forces(ren["sweep"], ren["modes"])
    names = [trace.name for trace in drawn.data if trace.showlegend is not False and trace.y[0] is not None]
    assert [name for name in names if "bearing" in name] == ["planet 1, 2, 3 bearing"]
    assert "ring left, right support" in names
    curve = next(trace for trace in drawn.data if trace.name == "planet 1, 2, 3 bearing")
    expected = ren["sweep"].bearing_force_peak[0].values / 1e3
    np.testing.assert_allclose(numbers(curve.y), expected, rtol=1e-3)


def test_sweep_marks_natural_frequencies_operating_point_and_failures(ren: Datasets) -> None:
    drawn = speed_sweep(ren["sweep"], ren["modes"])
    at = {round(float(shape.x0), 6) for shape in drawn.layout.shapes}
    inside = [one.frequency for one in mode_groups(ren["modes"]) if 20 <= one.frequency <= 600]
    assert {round(value, 6) for value in inside} < at
    assert 27.3125 in at
    failed = next(trace for trace in drawn.data if trace.name == "no convergence")
    assert failed.x[0] == pytest.approx(float(ren["sweep"].mesh_frequency[120]))


def test_studies(synthetic: ModuleType) -> None:
    data = synthetic.dataset(
        {"load_sharing": (("mesh", "point"), np.ones((2, 3)))},
        coords={"mesh": ["m/a-b/1", "m/a-b/2"], "point": [0, 1, 2], "k": ("point", ["1e8 N/m", "1e9 N/m", "1e10 N/m"])},
        verb="vary",
    )
    again = study(data)
    assert list(again.data[0].x) == [1e8, 1e9, 1e10]
    assert again.layout.xaxis.type == "log"
    assert [shape.y0 for shape in again.layout.shapes] == [1]
    assert again.layout.xaxis.title.text == "k [N/m]"
    assert [trace.name for trace in again.data] == ["a-b 1", "a-b 2"]


def test_trains_without_speeds_or_widths_are_drawn(lin: Datasets) -> None:
    check = lin["check"].copy()
    for name in ("face_width", "tip_radius", "root_radius", "module", "pressure_angle"):
        check[name] = check[name] * np.nan
    check["outer_radius"] = check["outer_radius"] * np.nan
    front, section = train_front(check), train_section(check)
    assert "not given" in section.layout.title.text
    assert sum("z = 35" in word for word in (note.text for note in front.layout.annotations)) == 4
