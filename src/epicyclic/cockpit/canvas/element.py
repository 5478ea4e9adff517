"""Panes that move under a slider: one element for the drawing of the train, the sweep and the evidence."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from typing import Any, Literal

from nicegui import Client
from nicegui.element import Element
from nicegui.events import GenericEventArguments

Kind = Literal["train", "sweep", "evidence"]


class Board(Element, component="board.js", esm={"epicyclic-cockpit": "static"}):
    """One pane of the cockpit, drawn in the browser from packed frames that all panes of a page share.

    Parameters
    ----------
    kind : which pane.  label : its name for screen readers; a pane adds what it shows.
    """

    def __init__(self, kind: Kind, *, label: str) -> None:
        super().__init__()
        self._props["kind"] = kind
        self._props["label"] = label
        self._sent: dict[str, bytes] = {}
        self._told: dict[str, tuple[Any, ...]] = {}
        self._pinned: list[bytes] = []
        self._ready = False
        self.on("ready", self._on_ready)

    def frame(self, packed: bytes) -> None:
        """Show a packed frame in every pane of the page; parts with an older revision than shown are dropped there."""
        size = int.from_bytes(packed[:4], "little")
        frame = json.loads(packed[4 : 4 + size])
        job = frame["head"].get("job", {}).get("name", "") if frame["kind"] == "job" else ""
        self._sent[f"{frame['kind']}:{job}"] = packed
        if self._ready:
            self.run_method("frame", _text(packed))

    def ghost(self, packed: bytes | None) -> None:
        """Add the parts of a packed frame to the dashed ghost of pin A; None takes the ghost away, in every pane."""
        self._pinned = [] if packed is None else [*self._pinned, packed]
        if self._ready:
            self.run_method("ghost", None if packed is None else _text(packed))

    def show_mode(self, index: int | None) -> None:
        """Animate the mode of this index of the frame in the drawing of the train; None lets the train turn again."""
        self._tell("mode", index)

    def stale(self, is_stale: bool) -> None:
        """Draw at 40 %, as older than the state; a part older than the newest frame is drawn so anyhow."""
        self._tell("stale", is_stale)

    def evidence(self, name: str) -> None:
        """What an evidence pane shows: ``"sharing"``, ``"errors"`` or the name of a job."""
        self._tell("evidence", name)

    def on_speed(self, handler: Callable[[float], Any]) -> None:
        """Call `handler` with the relative speed (1 = operating speed of the model) that was clicked in the sweep."""

        def handle(event: GenericEventArguments) -> None:
            relative = event.args
            is_number = isinstance(relative, int | float) and not isinstance(relative, bool)
            if is_number and 0 < relative < _LARGEST_SPEED:
                handler(float(relative))

        self.on("speed", handle)

    def on_mode(self, handler: Callable[[int | None], Any]) -> None:
        """Call `handler` with the index of the mode that was chosen in a pane, None where it was left."""

        def handle(event: GenericEventArguments) -> None:
            index = event.args
            if index is None or (isinstance(index, int) and not isinstance(index, bool) and index >= 0):
                handler(index)

        self.on("mode", handle)

    def _tell(self, method: str, *arguments: Any) -> None:
        self._told[method] = arguments
        if self._ready:
            self.run_method(method, *arguments)

    def _on_ready(self) -> None:
        """The browser has mounted the pane, perhaps again after a reconnection: it is told all it has to know."""
        self._ready = True
        for packed in self._sent.values():
            self.run_method("frame", _text(packed))
        for packed in self._pinned:
            self.run_method("ghost", _text(packed))
        for method, arguments in self._told.items():
            self.run_method(method, *arguments)


class TrainPane(Board):
    """Front view and axial section of the train, turning, its meshes coloured by load, or a mode shape."""

    def __init__(self) -> None:
        super().__init__("train", label="Drawing of the train")


class SweepPane(Board):
    """Largest mesh forces over speed, peaks named after their modes."""

    def __init__(self) -> None:
        super().__init__("sweep", label="Mesh forces over speed")


class EvidencePane(Board):
    """Load sharing, what each error costs, or the lines and bars of a job."""

    def __init__(self) -> None:
        super().__init__("evidence", label="Evidence")


# Beyond a hundred times the operating speed nothing is computed: such a number did not come from the pane.
_LARGEST_SPEED = 100.0


def send(where: Client | Board, packed: bytes) -> None:
    """Show a packed frame in all panes of a page, in one message.

    Parameters
    ----------
    where : any pane of the page, or its client; a client without a pane is left alone.
    packed : frame as `pack` gives it.
    """
    elements = [where] if isinstance(where, Board) else where.elements.values()
    board = next((element for element in elements if isinstance(element, Board)), None)
    if board is not None:
        board.frame(packed)


def _text(packed: bytes) -> str:
    return base64.b64encode(packed).decode("ascii")
