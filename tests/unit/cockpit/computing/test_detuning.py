"""Changes that the first answer offers: those of the verb, where they pay, and given up for something newer."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import Any

import pytest

import epicyclic
from epicyclic.cockpit.computing.answers import is_quick
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.computing.job_kinds import JOBS
from epicyclic.cockpit.state.frames import PageFrame, Request
from epicyclic.document.document import drive_text

FAST = {"operation.speed.sun": "580 rpm"}
REQUEST = Request(rev=1, kind="full", source=tomllib.loads(drive_text("ren2021")), overrides=FAST)


def resonance(head: Any) -> Any:
    return next(answer for answer in head["answers"] if answer["key"] == "resonance")


def test_a_resonance_that_matters_offers_the_changes_of_the_verb() -> None:
    frames = list(compute(REQUEST))
    assert [frame.kind for frame in frames][-2:] == ["sharing", "changes"]
    assert all(not resonance(frame.head)["changes"] for frame in frames[:-1] if "answers" in frame.head)
    answer = resonance(frames[-1].head)
    assert (answer["level"], answer["job"]) == ("bad", None)
    (offered,) = answer["changes"]
    found = epicyclic.detune("ren2021", overrides=FAST).isel(change=0)
    assert offered["label"] == str(found["change"].values)
    assert offered["result"] == "696.5 rpm, +20 %, 5.9 % left"
    assert offered["speed"] == pytest.approx(580 * float(found["moved_speed"]))
    assert offered["apply"] == {"stages.main.planet.bearing.radial": "1500000000.0 N/m"}
    # what it says is what the page says once it is applied: nothing that matters much
    then = replace(REQUEST, kind="live", overrides={**FAST, **offered["apply"]})
    (frame,) = compute(then)
    assert "5.9 % of the mean force" in offered["why"]
    assert "5.9 % of the mean force" in resonance(frame.head)["text"]


def test_the_speed_that_is_shown_is_the_one_to_leave() -> None:
    # of the drive as it is no resonance matters; at 5.8 times its speed it is that of the file above
    frames = list(compute(replace(REQUEST, overrides={}, relative_speed=5.8)))
    (offered,) = resonance(frames[-1].head)["changes"]
    assert (frames[-1].kind, offered["label"]) == ("changes", "radial planet bearing x 1.5")
    assert offered["result"] == "696.5 rpm, +20 %, 5.9 % left"
    assert "changes" not in [frame.kind for frame in compute(replace(REQUEST, overrides={}))]


def test_the_search_is_given_up_for_something_newer() -> None:
    asked: list[str] = []
    frames: list[PageFrame] = []

    def stop() -> bool:
        asked.append(frames[-1].kind if frames else "")
        return asked.count("sharing") > 3

    for frame in compute(REQUEST, stop=stop):
        frames.append(frame)
    assert frames[-1].kind == "sharing"
    assert asked.count("sharing") == 4


def test_a_large_train_asks_for_the_job() -> None:
    source = tomllib.loads(drive_text("encased-differential"))
    train = epicyclic.load("encased-differential")
    assert not is_quick(train, epicyclic.assemble(train))
    (frame,) = compute(Request(rev=1, kind="live", source=source))
    answer = resonance(frame.head)
    assert (answer["level"], answer["job"]) == ("bad", "detune")
    of_job, _ = JOBS["detune"].run(source, {}, {"changes": 1}, lambda *_: None)
    found = resonance(of_job.head)
    assert (found["mode"], found["figure"], found["level"]) == (answer["mode"], answer["figure"], answer["level"])
    assert found["speed"] == pytest.approx(answer["speed"])
    (offered,) = found["changes"]
    assert offered["label"] == "differential module −15 %"
    assert "centre distance 351.06 -> 298.4 mm" in offered["why"]
