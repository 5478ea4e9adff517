"""Modes as the page lists them: numbers of the verb, shapes in the axes of the stage, labels, orders that meet them."""

from __future__ import annotations

import numpy as np
import pytest

import epicyclic
from epicyclic import assemble, load
from epicyclic.cockpit.computing.speed_view import ModeView, mode_view
from epicyclic.cockpit.state.frames import body_labels, listed, number, ordinal, speed_axis
from epicyclic.document.document import ready_drives
from epicyclic.train.train import Train


def view_of(drive: str) -> tuple[Train, ModeView]:
    train = load(drive)
    return train, mode_view(train, assemble(train), body_labels(train))


@pytest.mark.parametrize("drive", ready_drives())
def test_frequencies_kinds_and_shapes_are_those_of_the_verb(drive: str) -> None:
    train, view = view_of(drive)
    verb = epicyclic.modes(train)
    own = view.number - 1
    np.testing.assert_allclose(view.frequency, verb["frequency"].values[own], rtol=1e-12)
    assert view.kind == tuple(verb["mode_kind"].values[own])
    assert (view.frequency > 0).all()
    assert len(view.frequency) == min(60, int((verb["frequency"] > 0).sum()))
    np.testing.assert_allclose(np.abs(view.shape).max(axis=(1, 2)), 1.0)
    # in the axes of the stage, up to a factor: motions of a body are turned by the angle of its own axes
    full = verb["full_shape"].transpose("mode", "body", "direction").values[own]
    turn = np.exp(1j * np.array([body.angle for body in train.bodies]))
    drawn, wanted = (np.stack([one[..., 0] + 1j * one[..., 1], one[..., 2]]) for one in (view.shape, full))
    wanted[0] *= turn
    size = np.sum(np.abs(wanted) ** 2, axis=(0, 2))
    scale = np.sum((drawn * wanted.conj()).real, axis=(0, 2)) / np.where(size > 0, size, 1.0)
    np.testing.assert_allclose(drawn, scale[:, None] * wanted, atol=1e-9)


def test_planets_of_a_translational_mode_move_alike_in_the_axes_of_the_stage() -> None:
    train, view = view_of("lin1999-n4")
    first = int(np.flatnonzero(np.array(view.kind) == "translational")[0])
    carrier = [body.name for body in train.bodies].index("main/carrier")
    planets = [i for i, body in enumerate(train.bodies) if body.kind == "planet"]
    # the carrier takes its pins along: planets follow in its direction, whatever the direction of their own axes
    along = view.shape[first, planets, :2] @ view.shape[first, carrier, :2]
    assert (along > 0).all()


@pytest.mark.parametrize(
    ("drive", "number", "label"),
    [
        ("ren2021", 2, "carrier moves sideways"),
        ("ren2021", 3, "carrier moves sideways"),
        ("ren2021", 4, "carrier slides along the axis"),
        ("ren2021", 5, "carrier rotates with the planets"),
        ("xu2020", 11, "planets rotate against the ring"),
        ("xu2020", 8, "planets 1, 3 slide along the axis"),
        ("yue2014-ii", 10, "sun rotates against the planets p"),
        ("encased-differential", 6, "differential carrier rotates"),
    ],
)
def test_labels_say_what_moves(drive: str, number: int, label: str) -> None:
    _, view = view_of(drive)
    assert view.label[view.of_number[number]] == label


def test_orders_that_meet_a_mode_near_the_speed_are_named() -> None:
    train, view = view_of("ren2021")
    axis = speed_axis(train)
    assert axis == ("speed of the sun [rpm]", 100.0)
    rows = {row["index"]: row for row in view.rows(axis, 1.0, 1)}
    # 437/16 Hz is the mesh frequency at 100 rpm
    order = round(rows[5]["frequency"] / (437 / 16))
    met = 100 * rows[5]["frequency"] / (order * 437 / 16)
    assert rows[5]["met_by"] == f"{order}th mesh order at {met:.3g} rpm"
    slower = {row["index"]: row for row in view.rows(axis, 0.5, 1)}
    assert slower[5]["met_by"] != rows[5]["met_by"]
    speed = float(slower[5]["met_by"].split()[-2])
    assert 40 <= speed <= 60
    resonances = epicyclic.modes(train, band=0.2)
    excited = resonances["resonance_excited"].values == "yes"
    near = set(resonances["resonance_mode"].values[excited].tolist())
    assert view.at_rest == (~excited).sum() > 0
    alone = [row["index"] for row in rows.values() if row["kind"] == "rotational"]
    assert {index for index in alone if rows[index]["met_by"]} == near & set(alone)


def test_a_train_without_a_speed_has_modes_that_nothing_meets() -> None:
    train, view = view_of("lin1999-n3")
    assert speed_axis(train) is None
    assert {row["met_by"] for row in view.rows(None, 1.0, 1)} == {""}


def test_numbers_in_words() -> None:
    assert [ordinal(n) for n in (1, 2, 3, 4, 11, 12, 13, 21, 22, 103)] == [
        *("1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "22nd", "103rd")
    ]
    assert listed([1, 2, 3, 5]) == "1-3, 5"
    assert listed([1, 2]) == "1, 2"
    assert listed([]) == ""
    assert [number(x) for x in (1234.5, 0.0123456, 12.0, 1.5e-7)] == ["1230", "0.0123", "12", "1.5e-07"]
