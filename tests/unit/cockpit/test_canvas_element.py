"""The Python side of the panes: what is told to a browser that is there, late or again, and what is believed of it."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra app is not installed")

from nicegui import Client
from nicegui.events import GenericEventArguments
from nicegui.page import page as nicegui_page

from epicyclic.cockpit.page.controls import Board
from epicyclic.cockpit.state.frames import unpack

from .canvas_frames import job, live


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, ...]]:
    """Calls of the browser, in their order."""
    calls: list[tuple[Any, ...]] = []
    monkeypatch.setattr(
        Board, "run_method", lambda self, name, *given, **_: calls.append((self._props["kind"], name, *given))
    )
    return calls


@pytest.fixture
def client() -> Client:
    return Client(nicegui_page("/"))


def hear(pane: Board, event: str, given: Any = None) -> None:
    """An event of the browser arrives."""
    for listener in list(pane._event_listeners.values()):
        if listener.type == event and listener.handler is not None:
            handler: Any = listener.handler
            handler(
                GenericEventArguments(sender=pane, client=pane.client, args=given)
            ) if event != "ready" else handler()


def text(packed: bytes) -> str:
    return base64.b64encode(packed).decode()


def test_a_browser_that_comes_late_is_told_the_newest_of_every_kind(told: list[Any], client: Client) -> None:
    with client:
        pane, evidence = Board("train"), Board("evidence")
    for frame in (live(1), live(2), job(2, "relief"), job(2, "contact")):
        pane.frame(frame)
    pane.tell("mode", 4)
    evidence.tell("evidence", "contact")
    assert told == []
    hear(pane, "ready")
    hear(evidence, "ready")
    frames = [("train", "frame", text(frame)) for frame in (live(2), job(2, "relief"), job(2, "contact"))]
    assert told == [*frames, ("train", "mode", 4), ("evidence", "evidence", "contact")]


def test_a_frame_goes_to_the_page_once(told: list[Any], client: Client) -> None:
    with client:
        panes = [Board("train"), Board("sweep"), Board("evidence")]
    for pane in panes:
        hear(pane, "ready")
    panes[0].frame(live(1))
    panes[1].frame(live(2))
    assert told == [("train", "frame", text(live(1))), ("sweep", "frame", text(live(2)))]


def test_a_drawing_goes_to_the_page_once(told: list[Any], client: Client) -> None:
    with client:
        pane = Board("train")
    for rev in (1, 2):
        pane.frame(live(rev))
    hear(pane, "ready")
    pane.frame(live(3))
    other = live(4, planets=4)
    for frame in (other, other, live(5)):
        pane.frame(frame)
    sent = [unpack(base64.b64decode(packed)) for _, _, packed in told]
    assert ["front" in frame.head["train"]["drawing"] for frame in sent] == [True, False, True, False, True]
    short, whole = sent[1], unpack(live(3))
    assert short.head["train"]["drawing"] == {"key": whole.head["train"]["drawing"]["key"]}
    assert {**short.head["train"], "drawing": whole.head["train"]["drawing"]} == whole.head["train"]
    np.testing.assert_array_equal(short.arrays["meshes/load"], whole.arrays["meshes/load"])
    # a browser that mounts the pane again is told all of it
    hear(pane, "ready")
    assert told[-1] == ("train", "frame", text(live(5)))


def test_the_ghost_gathers_frames_and_goes(told: list[Any], client: Client) -> None:
    with client:
        pane = Board("sweep")
    pane.ghost(live(1))
    pane.ghost(None)
    pane.ghost(live(3))
    hear(pane, "ready")
    pane.ghost(None)
    assert told == [("sweep", "ghost", text(live(3))), ("sweep", "ghost", None)]


@pytest.mark.parametrize("given", [0, -1, 1e9, float("nan"), float("inf"), "1.0", None, [1], True])
def test_speeds_that_no_pane_sends_are_not_believed(client: Client, given: object) -> None:
    with client:
        pane = Board("sweep")
    speeds: list[float] = []
    pane.on_speed(speeds.append)
    hear(pane, "speed", 0.75)
    hear(pane, "speed", given)
    assert speeds == [0.75]


@pytest.mark.parametrize("given", [-1, 2.5, True, "3", [3]])
def test_modes_that_no_pane_sends_are_not_believed(client: Client, given: object) -> None:
    with client:
        pane = Board("train")
    modes: list[int | None] = []
    pane.on_mode(modes.append)
    for index in (3, given, None):
        hear(pane, "mode", index)
    assert modes == [3, None]
