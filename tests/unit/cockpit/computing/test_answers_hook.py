"""What the answers are made of, and where they stand in the frames of a state."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from epicyclic.cockpit.answers import answers, checks
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.computing.frames import Request
from epicyclic.studies.drives import drive_text


@dataclass(frozen=True)
class FakeAnswer:
    key: str
    figure: str


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, dict[str, Any]]]:
    """Calls of a room of answers that only writes down what it is given."""
    calls: list[tuple[str, dict[str, Any]]] = []

    def record(name: str) -> Any:
        def told(train: Any, system: Any, **given: Any) -> tuple[FakeAnswer, ...]:
            calls.append((name, {"train": train, "system": system, **given}))
            return (FakeAnswer(key="float", figure=name),)

        return told

    monkeypatch.setattr(answers, "live_answers", record("live"))
    monkeypatch.setattr(answers, "full_answers", record("full"))
    told = [{"level": "bad", "code": "x", "text": "y", "path": "z"}]
    monkeypatch.setattr(checks, "checks_of", lambda train, system: told)
    return calls


def frames_of(drive: str, kind: Any) -> list[Any]:
    return list(compute(Request(rev=1, kind=kind, source=tomllib.loads(drive_text(drive)), compiled=False)))


def test_every_frame_brings_the_answers_as_they_are(asked: list[tuple[str, dict[str, Any]]]) -> None:
    frames = frames_of("wind-stage", "full")
    assert [name for name, _ in asked] == ["live", "live", "live", "live", "full"]
    assert [frame.head["answers"][0]["figure"] for frame in frames] == [name for name, _ in asked]
    assert frames[-1].head["checks"] == [{"level": "bad", "code": "x", "text": "y", "path": "z"}]
    _, given = asked[-1]
    assert set(given) == {"train", "system", "modes", "sharing", "twin", "sweep", "errors"}
    assert given["train"].title == given["system"].provenance["title"]


def test_the_answers_are_made_of_what_the_page_shows(asked: list[tuple[str, dict[str, Any]]]) -> None:
    (frame,) = frames_of("wind-stage", "live")
    _, given = asked[0]
    for name in ("coefficient", "over_period"):
        np.testing.assert_allclose(given["sharing"][name], frame.arrays[f"sharing/{name}"], rtol=1e-6)
    assert given["sharing"]["k_gamma"] == frame.head["sharing"]["k_gamma"]
    assert given["twin"]["path"] == "stages.main.sun.support.radial"
    np.testing.assert_allclose(given["twin"]["coefficient"], frame.arrays["sharing/twin"], rtol=1e-6)
    assert given["modes"]["rows"] == frame.head["modes"]
    np.testing.assert_allclose(given["modes"]["frequency"], frame.arrays["modes/frequency"], rtol=1e-6)
    np.testing.assert_allclose(given["sweep"]["y"], frame.arrays["sweep/y"], rtol=1e-6)
    assert given["sweep"]["operating"] == 15.0


def test_what_is_not_known_is_none(asked: list[tuple[str, dict[str, Any]]]) -> None:
    (frame,) = frames_of("lin1999-n3", "live")
    _, given = asked[0]
    assert (given["sharing"], given["twin"], given["sweep"]) == (None, None, None)
    assert [check["code"] for check in frame.head["checks"]] == ["x", "not-computed", "not-computed"]
