"""The chosen mode of a page stays the same mode: it is followed by its shape, pairs by the span of their shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from tests.unit.cockpit.computing.test_compute import frames_of

from epicyclic import assemble, load
from epicyclic.cockpit.computing.speed_view import mode_view
from epicyclic.cockpit.state.frames import (
    FollowedMode,
    ModeShapes,
    PageFrame,
    body_labels,
    like_modes,
    mode_shapes,
    shapes_of,
)
from epicyclic.limits import SAME_SHAPE
from epicyclic.questions.modes.campbell import modal_assurance
from epicyclic.questions.modes.eigen import mean_modes
from epicyclic.statics.tangent import linear

RADIAL = "stages.main.sun.support.radial"


def frame_of(drive: str, changes: Mapping[str, object], rev: int) -> PageFrame:
    (frame,) = frames_of(drive, changes)
    return replace(frame, rev=rev)


def rows_of(frame: PageFrame) -> dict[int, tuple[str, str]]:
    """Number of a mode -> its frequency in four digits and what moves."""
    return {row["index"]: (f"{row['frequency']:.4g}", row["label"]) for row in frame.head["modes"]}


@pytest.fixture
def chosen() -> FollowedMode:
    """Mode 5 of ren2021, the carrier and the planets that turn."""
    mode = FollowedMode()
    assert not mode.take(frame_of("ren2021", {}, 1))
    mode.choose(5)
    return mode


def test_a_sun_that_begins_to_float_changes_the_number_and_not_the_mode(chosen: FollowedMode) -> None:
    rigid, floating = frame_of("ren2021", {}, 3), frame_of("ren2021", {RADIAL: 0}, 2)
    assert rows_of(rigid)[5] == rows_of(floating)[7] == ("159.5", "carrier rotates with the planets")
    assert rows_of(floating)[5][0] != "159.5"
    assert chosen.take(floating)
    assert (chosen.number, chosen.lost) == (7, "")
    assert chosen.take(rigid)  # undo
    assert chosen.number == 5
    assert not chosen.take(replace(rigid, rev=4))


def test_a_mode_without_a_like_is_dropped_and_said() -> None:
    mode = FollowedMode()
    mode.take(frame_of("ren2021", {RADIAL: 0}, 1))
    mode.choose(2)  # the carrier sideways with the sun, which a rigid support holds
    assert mode.take(frame_of("ren2021", {RADIAL: "inf"}, 2))
    assert mode.number is None
    assert mode.lost == f"mode 2, 47.44 Hz, is gone: best MAC 0.48, limit {SAME_SHAPE:g}"
    mode.choose(3)
    assert not mode.lost


def test_another_train_drops_the_mode_and_a_late_frame_changes_nothing(chosen: FollowedMode) -> None:
    assert not chosen.take(frame_of("ren2021", {RADIAL: 0}, 0))
    assert not chosen.take(replace(frame_of("ren2021", {RADIAL: 0}, 2), kind="sharing"))
    assert chosen.number == 5
    for other in (frame_of("xu2020", {}, 2), frame_of("ren2021", {"title": "another"}, 2)):
        mode = FollowedMode()
        mode.take(frame_of("ren2021", {}, 1))
        mode.choose(5)
        assert mode.take(other)
        assert (mode.number, mode.lost) == (None, "")
        assert not mode.take(frame_of("ren2021", {}, 3))


def test_a_state_without_modes_drops_the_mode(chosen: FollowedMode) -> None:
    frame = frame_of("ren2021", {}, 2)
    without = {key: value for key, value in frame.head.items() if key != "modes"}
    assert chosen.take(replace(frame, head=without))
    assert chosen.number is None


def shapes(drive: str, changes: Mapping[str, object]) -> ModeShapes:
    train = load(drive, dict(changes))
    view = mode_view(train, assemble(train), body_labels(train))
    rows = [{"index": int(n), "frequency": float(f)} for n, f in zip(view.number, view.frequency, strict=True)]
    return mode_shapes([], rows, {"shape": view.shape, "mass": view.mass})


def test_the_pairs_of_equal_planets_rotate_and_are_followed_by_their_span() -> None:
    """Two supports of the sun between which the basis of a pair turns by half a right angle."""
    before, after = (shapes("lin1999-n5", {RADIAL: f"{radial} N/m"}) for radial in (1.468e8, 1.778e8))
    a, b = (modes.shape.reshape(len(modes.shape), -1).T for modes in (before, after))
    alone, _ = modal_assurance(a, b, np.diag((before.mass + after.mass).ravel() / 2), (before.groups, after.groups))
    pair = before.number.index(9)
    assert alone[pair : pair + 2].max() < 0.55  # neither of the two has the shape of either
    like = like_modes(before, after)
    assert {like[9][0], like[10][0]} <= {10, 11}
    assert min(like[9][1], like[10][1]) > 0.95
    assert np.ptp(after.frequency[after.number.index(10) : after.number.index(12)]) < 1e-6  # the pair


@pytest.mark.parametrize("split", [0.0, 2e-4])
def test_any_basis_of_many_equal_frequencies_is_the_same_group(split: float) -> None:
    """Planet modes of many planets: by themselves no two of them are alike, and they stay together where they split."""
    rng = np.random.default_rng(7)
    basis = np.linalg.qr(rng.normal(size=(24, 24)))[0]
    turn = np.ones((4, 4)) / 2 - np.eye(4)  # a rotation of four with the same share of each, but for sign
    apart = np.array([100.0, *(200 * (1 + split * np.arange(4))), 300.0])
    turned = np.column_stack([basis[:, 0], basis[:, 1:5] @ turn, basis[:, 5]])
    before, after = (
        ModeShapes([], list(range(2, 8)), apart.tolist(), columns.T.reshape(6, 4, 6), np.ones((4, 6)))
        for columns in (basis[:, :6], turned)
    )
    like = like_modes(before, after)
    assert {number: other for number, (other, _) in like.items() if number in (2, 7)} == {2: 2, 7: 7}
    assert all(like[number][0] in range(3, 7) for number in range(3, 7))
    np.testing.assert_allclose([assurance for _, assurance in like.values()], 1.0, rtol=1e-9)


def test_shapes_of_a_frame_are_orthogonal_by_the_masses_that_come_with_them() -> None:
    for drive in ("ren2021", "xu2020", "encased-differential"):
        modes = shapes_of(frame_of(drive, {}, 1))
        assert modes is not None
        flat = modes.shape.reshape(len(modes.shape), -1).astype(float)
        energy = flat @ (modes.mass.ravel()[:, None] * flat.T)
        size = np.sqrt(np.diag(energy))
        np.testing.assert_allclose(energy / np.outer(size, size), np.eye(len(size)), atol=2e-5)


def test_the_modes_of_a_page_pair_as_the_whole_shapes_do() -> None:
    """Two routes: 60 shapes of the page as lengths, and all shapes of two Systems of the same coordinates."""
    states: list[Mapping[str, object]] = [{"stages.main.sun.mass": mass} for mass in ("1 kg", "500 kg")]
    before, after = (shapes("ren2021", changes) for changes in states)
    like = like_modes(before, after)
    systems = [linear(assemble(load("ren2021", dict(changes)))) for changes in states]
    a, b = (mean_modes(system)[1] for system in systems)
    mass = (systems[0].M + systems[1].M) / 2
    whole = [ModeShapes([], [], [0.0, *modes.frequency], np.empty(0), np.empty(0)) for modes in (before, after)]
    _, groups = modal_assurance(a, b, mass, (whole[0].groups, whole[1].groups))
    assert {number for number, (other, _) in like.items() if other is None} == {10, 11, 27, 28}
    for number, (_, assurance) in like.items():
        assert assurance == pytest.approx(groups[number - 1, 1:].max(), abs=1e-6)
