"""Frames of a state: the numbers of the verbs, what is missing and why, order, failures, trains of every kind."""

from __future__ import annotations

import copy
import json
import time
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic import assemble, load
from epicyclic.cockpit.computing import compute as computing
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.computing.speed_view import Effort, force_curves, speed_model
from epicyclic.cockpit.computing.train_view import live_sharing, twin_of
from epicyclic.cockpit.state.frames import PageFrame, Request, pack, unpack
from epicyclic.document.document import drive_text, ready_drives
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.steady import sweep
from epicyclic.statics.sample_loads import mean_loads
from epicyclic.train import resolution

RUN_OUTS = {
    "deviations.sun.run_out": "20 um",
    "deviations.planet.run_out": "20 um",
    "deviations.planet.position.y": "[20, 0, 0, 0] um",
}


def frames_of(
    source: str | Mapping[str, Any],
    overrides: Mapping[str, object] | None = None,
    *,
    kind: Any = "live",
    **options: Any,
) -> list[PageFrame]:
    if isinstance(source, str) and not options:
        return list(_frames_of_drive(source, json.dumps(overrides or {}), kind))
    tables = tomllib.loads(drive_text(source)) if isinstance(source, str) else dict(source)
    return list(compute(Request(rev=5, kind=kind, source=tables, overrides=overrides or {}, **options)))


@cache
def _frames_of_drive(drive: str, overrides: str, kind: Any) -> tuple[PageFrame, ...]:
    """Frames of a ready drive with overrides as JSON."""
    source = tomllib.loads(drive_text(drive))
    return tuple(compute(Request(rev=5, kind=kind, source=source, overrides=json.loads(overrides))))


@pytest.mark.parametrize("drive", ready_drives())
def test_every_ready_drive_has_a_live_frame_that_travels(drive: str) -> None:
    (frame,) = frames_of(drive)
    assert (frame.kind, frame.rev) == ("live", 5)
    again = unpack(pack(frame))
    assert set(again.arrays) == set(frame.arrays)
    head, train = frame.head, load(drive)
    assert [body["name"] for body in head["train"]["bodies"]] == [body.name for body in train.bodies]
    assert frame.arrays["modes/shape"].shape == (len(head["modes"]), len(train.bodies), 6)
    loaded, turning = bool(train.kinematics.torque), bool(train.kinematics.speed)
    assert ("sharing" in head) == loaded
    damped = assemble(train).damped
    assert ("sweep" in head) == (turning and damped)
    missing = {check["path"] for check in head["checks"] if check["code"] == "not-computed"}
    assert missing == ({"operation.torque"} if not loaded else set()) | (
        set() if "sweep" in head else {"operation.speed" if damped else "damping"}
    )
    if loaded:
        assert frame.arrays["meshes/load"].shape == frame.arrays["sharing/coefficient"].shape == (len(train.meshes),)
        assert head["sharing"]["twin"]["k_gamma"] >= 1 - 1e-6
    if "sweep" in head:
        curves = head["sweep"]["curves"]
        assert frame.arrays["sweep/y"].shape == (len(curves), len(frame.arrays["sweep/x"]))
        assert 1 <= sum(curve["strong"] for curve in curves) <= 4
        assert np.isfinite(frame.arrays["sweep/y"]).all()


@pytest.mark.parametrize(("drive", "overrides"), [("ren2021", {}), ("xu2020", RUN_OUTS)])
def test_the_numbers_are_those_of_the_verbs(drive: str, overrides: dict[str, object]) -> None:
    frames = frames_of(drive, overrides, kind="full")
    assert [frame.kind for frame in frames] == ["live", "sweep", "sweep", "errors", "sharing"]
    live, orders, shafts, errors, shared = frames
    train = load(drive, overrides)
    verb = epicyclic.sharing(train, method="static")
    mean_load = verb["load_sharing"].sel(definition="mean-load").values
    for frame in (live, shared):
        np.testing.assert_allclose(frame.arrays["sharing/coefficient"], mean_load, rtol=1e-6)
        assert frame.head["sharing"]["k_gamma"] == mean_load.max()
    assert [frame.head["sharing"]["stage"] for frame in (live, shared)] == ["at rest", "whole"]
    assert errors.head["errors"]["k_gamma"] == pytest.approx(mean_load.max(), rel=1e-9)
    system = assemble(train)
    # a picture of the live set, and what it is at rest
    most = {"ren2021": 120, "xu2020": 4000 // 56}.get(drive, 48)  # by coordinates and mesh frequencies
    for frame, points, shaft, close in (
        (live, most, False, 5e-3),
        (orders, 200, False, 5e-4),
        (shafts, 60, True, 5e-4),
    ):
        swept = sweep(system, SweepOptions(points=points, shaft_orders=shaft, forces_alone=True))
        exact = swept["mesh_force_peak"].transpose("mesh", "speed").values
        np.testing.assert_allclose(1e3 * frame.arrays["sweep/y"], exact, rtol=close)
        rpm = swept["mesh_frequency"].values / float(system.tones[0]) * frame.head["sweep"]["operating"]
        np.testing.assert_allclose(frame.arrays["sweep/x"], rpm, rtol=1e-6)
    assert [frame.head["sweep"]["stage"] for frame in (live, orders, shafts)] == [
        *("mesh orders", "mesh orders", "with shaft orders")
    ]


def test_a_frame_at_work_is_given_up_when_somebody_waits() -> None:
    request = Request(rev=1, kind="full", source=tomllib.loads(drive_text("wind-stage")))
    for calls in (0, 2, 5):
        asked: list[bool] = []

        def stop(asked: list[bool] = asked, calls: int = calls) -> bool:
            asked.append(len(asked) >= calls)
            return asked[-1]

        frames = list(compute(request, stop=stop))
        assert frames[0].kind == "live"
        assert frames[-1].kind != "sharing"
        assert asked.count(True) == 1  # not asked again
    # while a lever moves nothing is given up: what is at work is shown
    live = list(compute(replace(request, kind="live"), stop=lambda: True))
    assert [frame.kind for frame in live] == ["live"]


def test_a_lever_that_is_let_go_is_not_computed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    source = tomllib.loads(drive_text("ren2021"))
    moved = {"stages.main.sun.mass": "700 kg"}
    request = Request(rev=3, kind="live", source=source, overrides=moved)
    (live,) = compute(request)
    loads: list[object] = []

    def counted(*given: Any) -> Any:
        loads.append(given)
        return resolution.load(*given)

    monkeypatch.setattr(computing, "load", counted)
    released = next(iter(compute(replace(request, rev=4, kind="full"))))
    assert loads == []
    assert (released.rev, live.rev) == (4, 3)
    assert all(np.array_equal(released.arrays[name], live.arrays[name], equal_nan=True) for name in live.arrays)
    assert {**released.head, "state": None} == {**live.head, "state": None}
    for other in (
        replace(request, overrides={"stages.main.sun.mass": "701 kg"}),
        replace(request, relative_speed=1.1),
        replace(request, source=tomllib.loads(drive_text("wind-stage")), overrides={}),
        request,
    ):
        loads.clear()
        next(iter(compute(other)))
        assert len(loads) == 1


@pytest.mark.parametrize("lever", ["stages.main.sun.support.radial", "stages.sun.support.radial"])
def test_a_refused_value_is_told_at_the_path_that_was_set(lever: str) -> None:
    source = tomllib.loads(drive_text("ren2021"))
    (frame,) = compute(Request(rev=1, kind="live", source=source, overrides={lever: "-5 N/m"}))
    assert (frame.kind, frame.head["path"]) == ("failed", lever)


def test_work_pauses_often(slowness: float) -> None:
    request = Request(rev=1, kind="full", source=tomllib.loads(drive_text("xu2020")), overrides=RUN_OUTS)
    clock: list[float] = []

    def asked() -> bool:
        clock.append(time.process_time())
        return False

    list(compute(request, stop=asked))
    # of some 0.6 s; a busy machine may take several times as long
    assert np.median(np.diff(clock)) < 0.1 * slowness
    assert len(clock) >= 15


FAST: Mapping[str, object] = {"operation.speed.sun": "900 rpm", "damping.modal": 0.01}  # with resonances that matter


def test_peaks_are_where_orders_meet_the_modes_they_name() -> None:
    (frame,) = frames_of("ren2021", FAST)
    peaks, frequency = frame.head["sweep"]["peaks"], {row["index"]: row["frequency"] for row in frame.head["modes"]}
    named = [peak for peak in peaks if peak["mode"]]
    assert len(named) >= 4
    highest = np.nanmax(frame.arrays["sweep/y"], axis=0)
    for peak in named:
        order = int(peak["label"].split(", ")[1].split()[0][:-2])
        met = 100 * frequency[peak["mode"]] / (order * 437 / 16)
        assert met == pytest.approx(peak["x"], rel=0.03)
        at = int(np.argmin(np.abs(frame.arrays["sweep/x"] - peak["x"])))
        assert highest[at] == pytest.approx(peak["y"], rel=1e-6)
        assert highest[at] == highest[max(0, at - 1) : at + 2].max()


@pytest.mark.parametrize(
    ("drive", "overrides", "count"), [("ren2021", {}, 0), ("ren2021", FAST, 5), ("encased-differential", {}, 3)]
)
def test_peaks_that_rise_by_a_twentieth_are_named_and_no_others(
    drive: str, overrides: Mapping[str, object], count: int
) -> None:
    (frame,) = frames_of(drive, overrides)
    highest = np.nanmax(frame.arrays["sweep/y"].astype(float), axis=0)
    rises = []
    for i in range(1, len(highest) - 1):
        if not highest[i - 1] < highest[i] > highest[i + 1]:
            continue
        # the lowest place on each side, on the way to a higher one
        sides = [side[: np.argmax(side > highest[i]) or None].min() for side in (highest[i::-1], highest[i:])]
        if highest[i] >= 1.05 * max(sides):
            rises.append(frame.arrays["sweep/x"][i])
    np.testing.assert_allclose([peak["x"] for peak in frame.head["sweep"]["peaks"]], rises, rtol=1e-6)
    assert len(rises) == count


def test_the_curve_comes_ahead_with_the_numbers_of_the_live_frame() -> None:
    request = Request(
        rev=7, kind="live", source=tomllib.loads(drive_text("ren2021")), overrides={"damping.modal": 0.03}
    )
    ahead: list[PageFrame] = []
    (live,) = compute(request, early=ahead.append)
    (curve,) = ahead
    assert (curve.kind, curve.rev, set(curve.head)) == ("curve", 7, {"sweep", "state"})
    assert set(curve.arrays) == {"sweep/x", "sweep/y"}
    for name, values in curve.arrays.items():
        np.testing.assert_array_equal(values, live.arrays[name])
    named = [
        {**head["sweep"], "peaks": [(peak["x"], peak["y"]) for peak in head["sweep"]["peaks"]]}
        for head in (curve.head, live.head)
    ]
    assert named[0] == named[1]
    assert 0 < curve.head["state"]["computed_ms"] < live.head["state"]["computed_ms"]
    list(compute(replace(request, kind="full"), early=ahead.append))
    assert len(ahead) == 1  # of a lever that is let go everything is there
    (_,) = compute(replace(request, overrides={"damping": None}), early=ahead.append)
    assert len(ahead) == 1  # a train without a curve


def test_curves_that_lie_on_each_other_are_one_strong_curve() -> None:
    (frame,) = frames_of("wind-five")
    curves = frame.head["sweep"]["curves"]
    strong = [curve for curve in curves if curve["strong"]]
    assert [curve["label"] for curve in strong] == ["sun, planet 1 and 9 alike"]
    (frame,) = frames_of("wind-five", {"deviations.planet.position.y": "[50, 0, 0, 0, 0] um"})
    strong = [curve["label"] for curve in frame.head["sweep"]["curves"] if curve["strong"]]
    assert strong[0] == "sun, planet 1 and 1 alike"
    assert len(strong) == 3
    largest = np.nanmax(frame.arrays["sweep/y"], axis=1)
    drawn = [curve["mesh"] for curve in frame.head["sweep"]["curves"] if curve["strong"]]
    assert largest[drawn].max() == pytest.approx(largest.max(), rel=2e-3)


@pytest.mark.parametrize(
    ("drive", "overrides"),
    [
        ("ren2021", {}),
        ("xu2020", RUN_OUTS),
        ("encased-differential", {}),
        ("wind-five", {"deviations.planet.position.y": "[50, 0, 0, 0, 0] um", "stages.main.sun.support.radial": 0}),
        ("ren2021", {"stages.main.sun.support.clearance": "50 um"}),
    ],
)
def test_the_twin_is_the_train_with_the_override_it_names(drive: str, overrides: dict[str, object]) -> None:
    (frame,) = frames_of(drive, overrides)
    twin = frame.head["sharing"]["twin"]
    mean_load, turning = mean_loads(assemble(load(drive, {**overrides, twin["path"]: twin["value"]})))
    np.testing.assert_allclose(frame.arrays["sharing/twin"], mean_load, rtol=1e-6)
    assert twin["k_gamma_turning"] == pytest.approx(float(turning.max()), rel=1e-9)
    assert twin["k_gamma"] == pytest.approx(float(mean_load.max()), rel=1e-9)
    floats = overrides.get("stages.main.sun.support.radial") == 0
    assert twin["label"].startswith("with a supported sun" if floats else "with a floating sun")


def test_a_train_without_a_sun_has_no_twin() -> None:
    train = load("wind-stage")
    view = live_sharing(assemble(train))
    assert twin_of(train, view) is not None
    sunless = tuple(replace(body, kind="gear") if body.kind == "sun" else body for body in train.bodies)
    assert twin_of(replace(train, bodies=sunless), view) is None


def test_the_share_of_an_error_is_what_goes_with_it() -> None:
    (frame,) = frames_of("dong2019")
    table = frame.head["errors"]
    assert table["of"] == "mean-load K_gamma"
    for row in table["rows"][:3]:
        without = epicyclic.sharing(load("dong2019", {row["path"]: None}), method="static", cycles=1)
        k = float(without["load_sharing"].sel(definition="mean-load").max())
        assert row["without"] == pytest.approx(k, rel=1e-9)
        assert row["share"] == pytest.approx(100 * (table["k_gamma"] - k) / (table["k_gamma"] - 1), abs=1e-6)
    assert table["rows"][0]["label"] == "position of the sun, 6 um"
    assert [row["share"] for row in table["rows"]] == sorted((row["share"] for row in table["rows"]), reverse=True)


def test_errors_that_only_turn_are_ranked_by_the_turning_coefficient() -> None:
    (frame,) = frames_of("ren2021", {"deviations.carrier.run_out": None})
    assert frame.head["errors"]["of"] == "K_gamma while turning"
    assert frame.head["errors"]["rows"][0]["share"] > 20
    assert frame.head["sharing"]["k_gamma"] == pytest.approx(1.0, abs=1e-9)
    assert frame.head["sharing"]["k_gamma_turning"] == pytest.approx(frame.head["errors"]["k_gamma"], rel=1e-9)


def test_an_error_is_named_as_it_was_overridden() -> None:
    (frame,) = frames_of("xu2020", RUN_OUTS)
    rows = {row["label"]: row["path"] for row in frame.head["errors"]["rows"]}
    assert rows["pin position of planet 1, 20 um"] == "deviations.planet.position"
    assert rows["run-out of the sun, 20 um"] == "deviations.sun.run_out"
    (given,) = frames_of("ren2021")
    assert given.head["errors"]["rows"][0]["path"] == "deviations.main.carrier.run_out"


@pytest.mark.parametrize("drive", ["encased-differential", "ren2021"])
def test_the_colour_of_a_mesh_is_its_mean_over_the_hunting_period(drive: str) -> None:
    (frame,) = frames_of(drive)
    exact = mean_loads(assemble(load(drive)))[0]
    np.testing.assert_allclose(frame.arrays["meshes/load"], exact, rtol=1e-6)


def test_without_deviations_the_load_is_shared_equally() -> None:
    (frame,) = frames_of("xu2020")
    np.testing.assert_allclose(frame.arrays["sharing/coefficient"], 1.0, atol=1e-6)
    np.testing.assert_allclose(frame.arrays["meshes/load"], 1.0, atol=1e-6)
    assert "errors" not in frame.head


@pytest.mark.parametrize(
    ("overrides", "path", "kept"),
    [
        ({"damping": None}, "damping", {"modes", "sharing", "errors"}),
        ({"operation.torque": None}, "operation.torque", {"modes", "sweep"}),
        ({"operation.speed": None}, "operation.speed", {"modes", "sharing", "errors"}),
        ({"stages.main.planet.mass": 0}, "stages.main.planet.mass", {"sharing", "errors"}),
    ],
)
def test_what_is_missing_is_said_and_the_rest_is_there(overrides: dict[str, object], path: str, kept: set[str]) -> None:
    (frame,) = frames_of("ren2021", overrides)
    assert kept == set(frame.head) & {"modes", "sharing", "errors", "sweep"}
    said = [check for check in frame.head["checks"] if check["code"] == "not-computed"]
    assert {check["path"] for check in said} == {path}
    assert all(check["text"] and check["level"] == "warn" for check in said)
    assert set(frame.head["missing"].values()) == {check["text"] for check in said}
    assert not set(frame.head["missing"]) & kept


@pytest.mark.parametrize(
    ("overrides", "path"),
    [
        ({"stages.main.sun.teeth": -3}, "stages.main.sun.teeth"),
        ({"stages.main.planets": 7}, ""),
        ({"stages.main.sun.nothing": 1}, "stages.main.sun.nothing"),
        ({"operation.speed.sun": "fast"}, "operation.speed.sun"),
        ({"deviations.planet.run_out": "20 apples"}, "deviations.planet.run_out"),
    ],
)
def test_a_wrong_model_is_one_failed_frame(overrides: dict[str, object], path: str) -> None:
    (frame,) = frames_of("ren2021", overrides, kind="full")
    assert (frame.kind, frame.rev) == ("failed", 5)
    assert path in frame.head["path"]
    assert frame.head["message"]
    assert set(frame.head) == {"message", "path", "given", "allowed"}


def test_a_speed_of_nothing_is_refused() -> None:
    (frame,) = frames_of("ren2021", relative_speed=0.0)
    assert (frame.kind, frame.head["path"]) == ("failed", "relative_speed")


def test_laws_are_followed() -> None:
    frames = frames_of("ren2021", {"stages.main.planet.bearing.clearance": "50 um"}, kind="full")
    assert [frame.kind for frame in frames] == ["live", "sweep", "sweep", "errors", "sharing"]
    assert frames[-1].head["sharing"]["stage"] == "at rest"  # every instant is solved by itself


def three_stages() -> dict[str, Any]:
    """Three industrial stages in series, of other teeth each: three mesh frequencies."""
    tables = tomllib.loads(drive_text("industrial-stage"))
    del tables["tolerance"], tables["assumed"]
    stage = tables["stages"].pop("main")
    for name, sun, ring in (("a", 20, 82), ("b", 23, 85), ("c", 26, 88)):
        tables["stages"][name] = copy.deepcopy(stage)
        tables["stages"][name]["sun"]["teeth"], tables["stages"][name]["ring"]["teeth"] = sun, ring
    tables["couplings"] = {
        f"{one}{other}": {"between": [f"{one}.carrier", f"{other}.sun"], "rz": "1e8 N m/rad"}
        for one, other in ("ab", "bc")
    }
    tables["deviations"] = {"a": tables["deviations"]}
    tables["operation"] = {
        "held": ["a.ring", "b.ring", "c.ring"],
        "speed": {"a": {"sun": "1480 rpm"}},
        "power": {"a": {"sun": "160 kW"}},
    }
    return tables


def test_many_mesh_frequencies_are_solved_one_at_a_time() -> None:
    (frame,) = frames_of(three_stages())
    assert frame.head["sweep"]["stage"] == "mesh orders of one stage at a time"  # which stands above the curves
    assert np.isfinite(frame.arrays["sweep/y"]).all()
    system = assemble(load(three_stages()))
    few = Effort(points=4, shaft_orders=False, tolerance=1e-4)
    found = force_curves(speed_model(system), few)
    exact = sweep(system, SweepOptions(relative_speed=found.speed[-1:], shaft_orders=False, forces_alone=True))
    # what combinations of mesh frequencies add
    np.testing.assert_allclose(found.force[:, -1:], exact["mesh_force_peak"].transpose("mesh", "speed"), rtol=0.02)


def test_the_speed_shown_moves_orders_and_the_drawing_alone() -> None:
    (full,), (half,) = frames_of("ren2021"), frames_of("ren2021", relative_speed=0.5)
    assert half.head["sweep"]["operating"] == full.head["sweep"]["operating"] / 2
    np.testing.assert_array_equal(half.arrays["sweep/y"], full.arrays["sweep/y"])
    assert half.head["state"]["speeds"][0] == ["sun", 50.0, "rpm"]
    assert full.head["state"]["ratio"] == pytest.approx(1 + 105 / 45, rel=0.1)
