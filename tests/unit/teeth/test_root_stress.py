"""Stress in the tooth roots of loaded contacts: from the forces of the contact, along the face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import epicyclic
from epicyclic.questions.flanks.views import contact_tables
from epicyclic.show.charts.flanks import root_stress as root_stress_figure
from epicyclic.system.tooth_pairs import pair_of
from epicyclic.teeth.compliance import ToothCompliance
from epicyclic.teeth.gear_pair import ContactPair
from epicyclic.teeth.loaded_contact import loaded_contact
from epicyclic.teeth.root_stress import fillet_stress, pair_influences, root_influence, root_stress

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def spur() -> ContactPair:
    train = epicyclic.load("yue2014-i")
    return pair_of(train, next(mesh for mesh in train.meshes if mesh.name == "main/p-d/1"), slices=4)


def test_one_pair_of_teeth_bears_alone(spur: ContactPair) -> None:
    # force over width times the influence function at the radius of the contact: spur teeth, an even load
    result = loaded_contact(spur, [1250.0], [0.1])
    assert np.count_nonzero(result.share[0, 0]) == 1
    gears = root_stress(spur, result.segments.lines.sigma, result.force, pair_influences(spur))
    plane = spur.plane
    for gear, tooth, radius in zip(
        gears, (spur.tooth_a, spur.tooth_b), (plane.radius_a(0.1), plane.radius_b(0.1)), strict=True
    ):
        assert isinstance(tooth, ToothCompliance)
        right, left = fillet_stress(root_influence(tooth.gear), radius)
        p = 1250.0 / plane.width
        np.testing.assert_allclose(gear.tension[0, 0].max(axis=0), p * right.max(), rtol=1e-9)
        np.testing.assert_allclose(gear.compression[0, 0].min(axis=0), p * left.min(), rtol=1e-9)


def test_two_pairs_of_teeth(spur: ContactPair) -> None:
    # the pair at sigma + 1 stands one tooth ahead of the loaded flanks of a, one behind those of b
    sigma = spur.plane.limits[0] + 0.1
    result = loaded_contact(spur, [1250.0], [sigma])
    lines = result.segments.lines
    gears = root_stress(spur, lines.sigma, result.force, pair_influences(spur))
    p = result.force[0, 0].sum(axis=1) / spur.plane.width
    assert np.count_nonzero(p) == 2
    assert (np.diff(lines.pair[0]) < 0).all()
    at = np.clip(lines.sigma[0, :, 0], *spur.plane.limits)
    for gear, tooth, radius, sense in (
        (gears[0], spur.tooth_a, spur.plane.radius_a(at), 1),
        (gears[1], spur.tooth_b, spur.plane.radius_b(at), -1),
    ):
        assert isinstance(tooth, ToothCompliance)
        influence = root_influence(tooth.gear)
        for j in range(len(p)):
            parts = [p[k] * fillet_stress(influence, radius[k], ahead=sense * (k - j))[0] for k in range(len(p))]
            assert gear.tension[0, 0, j, 0] == pytest.approx(float(np.max(sum(parts))), rel=1e-9)


def test_a_load_at_an_end_of_the_face(spur: ContactPair) -> None:
    # the sum of the loads per length that reach the root is the force, whatever its place; the end is stressed most
    pair = replace(spur, slices=20)
    force = np.zeros((1, 1, 1, 20))
    force[..., -1] = 1000.0
    sigma = np.full((1, 1, 20), 0.1)
    (gear, _) = root_stress(pair, sigma, force, pair_influences(pair))
    even, _ = root_stress(pair, sigma, np.full((1, 1, 1, 20), 50.0), pair_influences(pair))
    tension = gear.tension[0, 0, 0]
    assert tension.argmax() == 19
    assert tension.mean() == pytest.approx(even.tension.max(), rel=1e-6)
    assert tension.max() > 1.3 * even.tension.max()


def test_stress_in_the_result() -> None:
    result = epicyclic.contact("ren2021", mesh="sun-planet", samples=16, slices=6, loads=[0.5, 1.0])
    now = int(np.argmin(np.abs(result.torque_factor.values - 1.0)))
    # the map has the largest, and both helices are mirror images
    largest = result.largest_root_stress.values[now]
    np.testing.assert_allclose(result.root_stress.max(("width", "tooth_place")).values, largest, rtol=1e-12)
    lowest = result.lowest_root_stress.values[now]
    assert (lowest < -largest).all()
    np.testing.assert_allclose(largest[0], largest[1], rtol=1e-9)
    left, right = result.root_stress.values[:, 0]
    np.testing.assert_allclose(left[::-1], right, rtol=1e-6, atol=1e-3 * largest.max())
    # between the load and its half there is nothing but contact that stiffens
    assert result.largest_root_stress.values[0] == pytest.approx(0.5 * largest, rel=0.1)


def test_stress_in_the_train() -> None:
    alone = epicyclic.contact("ren2021", mesh="sun-planet", samples=16, slices=6, loads=[1.0])
    train = epicyclic.contact("ren2021", samples=16, slices=6, loads=[1.0])
    own = alone.largest_root_stress.values[-1, 0]
    found = train.largest_root_stress.sel(torque_factor=1.0, mesh="main/sun-planet/1/left").values
    # the train bends and tilts; branches share evenly within some percent
    np.testing.assert_allclose(found, own, rtol=0.15)
    assert (train.lowest_root_stress.values < 0).all()


def test_figure_and_table() -> None:
    result = epicyclic.contact("ren2021", mesh="sun-planet", samples=8, slices=4, loads=[1.0])
    drawn = root_stress_figure(result)
    kinds = [trace.type for trace in drawn.data]
    assert (kinds.count("scatter"), kinds.count("heatmap")) == (8, 4)
    axes = [axis for axis in drawn.to_plotly_json()["layout"] if axis.startswith(("xaxis", "yaxis"))]
    titles = {str(drawn.layout[axis].title.text) for axis in axes} - {"None"}
    assert all("[" in title for title in titles)
    (table,) = [one for one in contact_tables(result) if one.title == "Stress in the tooth roots"]
    assert table.columns["gear"] == ["sun", "planet"] * 2
    now = int(np.argmin(np.abs(result.torque_factor.values - 1.0)))
    np.testing.assert_allclose(
        table.columns["tension [MPa]"], result.largest_root_stress.values[now].ravel() / 1e6, rtol=1e-12
    )
