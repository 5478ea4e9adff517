"""What the answers are made of, and where they stand in the frames of a state."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from epicyclic.cockpit.computing import answers
from epicyclic.cockpit.computing.compute import compute
from epicyclic.cockpit.state.frames import Request
from epicyclic.document.document import drive_text


@dataclass(frozen=True)
class FakeAnswer:
    key: str
    figure: str


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Calls of a room of answers that only writes down what it is given."""
    calls: list[dict[str, Any]] = []

    def record(train: Any, system: Any, told: dict[str, Any], changes: Any) -> tuple[FakeAnswer, ...]:
        calls.append({"train": train, "system": system, **told, "changes": changes})
        return (FakeAnswer(key="float", figure=str(len(calls))),)

    monkeypatch.setattr(answers, "answers_of", record)
    told = {"level": "bad", "code": "x", "text": "y", "path": "z"}
    monkeypatch.setattr(answers, "checks_of", lambda train, system: [told])
    return calls


def frames_of(drive: str, kind: Any) -> list[Any]:
    return list(compute(Request(rev=1, kind=kind, source=tomllib.loads(drive_text(drive)))))


def test_every_frame_brings_the_answers_as_they_are(asked: list[dict[str, Any]]) -> None:
    frames = frames_of("wind-stage", "full")
    assert [frame.kind for frame in frames] == ["live", "sweep", "sweep", "errors", "sharing"]
    assert [frame.head["answers"][0]["figure"] for frame in frames] == ["1", "2", "3", "4", "5"]
    assert frames[-1].head["checks"] == [{"level": "bad", "code": "x", "text": "y", "path": "z"}]
    given = asked[-1]
    assert set(given) == {"train", "system", "modes", "sharing", "twin", "sweep", "errors", "changes"}
    assert given["train"].title == given["system"].provenance["title"]


def test_the_answers_are_made_of_what_the_page_shows(asked: list[dict[str, Any]]) -> None:
    (frame,) = frames_of("wind-stage", "live")
    given = asked[0]
    for name in ("coefficient", "over_period"):
        np.testing.assert_allclose(given["sharing"][name], frame.arrays[f"sharing/{name}"], rtol=1e-6)
    assert given["sharing"]["k_gamma"] == frame.head["sharing"]["k_gamma"]
    assert given["twin"]["path"] == "stages.main.sun.support.radial"
    np.testing.assert_allclose(given["twin"]["coefficient"], frame.arrays["sharing/twin"], rtol=1e-6)
    assert given["modes"]["rows"] == frame.head["modes"]
    np.testing.assert_allclose(given["modes"]["frequency"], frame.arrays["modes/frequency"], rtol=1e-6)
    np.testing.assert_allclose(given["sweep"]["y"], frame.arrays["sweep/y"], rtol=1e-6)
    assert given["sweep"]["operating"] == 15.0


def test_what_is_not_known_is_none(asked: list[dict[str, Any]]) -> None:
    (frame,) = frames_of("lin1999-n3", "live")
    given = asked[0]
    assert (given.get("sharing"), given.get("twin"), given.get("sweep")) == (None, None, None)
    assert [check["code"] for check in frame.head["checks"]] == ["x", "not-computed", "not-computed"]
