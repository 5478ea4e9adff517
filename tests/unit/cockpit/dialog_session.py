"""A session for tests of the dialogs: real states and history, nothing computed, no process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from epicyclic.cockpit.state.model_file import text_of
from epicyclic.cockpit.state.state import (
    PageState,
    StateHistory,
    Step,
    command_line,
    script,
    with_text,
    with_value,
    with_values,
)
from epicyclic.errors import ModelError


@dataclass
class FakeJob:
    """A job of which a test says how far it is."""

    status: str = "runs"
    progress: float = 0.25
    remaining: float | None = 9.0
    message: str = ""
    dataset_path: Path | None = None
    asked_to_end: bool = False
    rev: int = 1
    died: bool = False
    head: dict[str, Any] = field(default_factory=dict)

    @property
    def ended(self) -> bool:
        return self.status in ("done", "cancelled", "failed")

    def cancel(self) -> None:
        self.asked_to_end = True


class FakeSession:
    """What dialogs use of a session."""

    def __init__(self, state: PageState | None) -> None:
        self.history = StateHistory(now=Step(state=state))
        self.pinned: PageState | None = None
        self.heard: dict[str, list[Callable[..., Any]]] = {}
        self.calls: list[tuple[Any, ...]] = []
        self.others = False  # another program has written the file
        self.unsaved = False
        self.job = FakeJob()
        self.failed: dict[str, str] | None = None
        self.view: dict[str, Any] = {}
        self.is_of_another_model = False
        self.rev = 1
        self.jobs = SimpleNamespace(start=self._start, cancel=lambda job: job.cancel(), visible=lambda: [])

    def _start(self, name: str, options: Mapping[str, Any]) -> FakeJob:
        self.calls.append(("job", name, dict(options)))
        return self.job

    def listen(self, **callbacks: Callable[..., Any]) -> None:
        for kind, callback in callbacks.items():
            self.heard.setdefault(kind, []).append(callback)

    def computed_words(self) -> str:
        return ""

    def looked(self, **view: Any) -> None:
        self.view |= view

    def tell(self, kind: str, *arguments: Any) -> None:
        for callback in self.heard.get(kind, []):
            callback(*(arguments or (self,)))

    @property
    def state(self) -> PageState | None:
        return self.history.present

    @property
    def now(self) -> PageState:
        assert self.history.present is not None
        return self.history.present

    def _push(self, state: PageState, label: str) -> None:
        self.history = self.history.push(state, label)
        self.tell("state")

    async def open(self, state: PageState, *, unsaved: bool = False) -> None:
        self.unsaved = unsaved
        self._push(state, f"open {state.name}")

    def set(self, path: str, value: object, *, released: bool, key: str | None = None) -> None:
        self.calls.append(("set", path, value))
        self._push(with_value(self.now, path, value), path)

    def apply(self, values: Mapping[str, object], label: str) -> None:
        self._push(with_values(self.now, values), label)

    def set_text(self, text: str) -> None:
        self._push(with_text(self.now, text), "edit the text")

    def undo(self) -> None:
        self.history = self.history.undo()
        self.tell("state")

    def redo(self) -> None:
        self.history = self.history.redo()
        self.tell("state")

    def pin(self) -> None:
        self.pinned = self.now
        self.tell("state")

    def unpin(self) -> None:
        self.pinned = None
        self.tell("state")

    async def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return function(*arguments)

    async def take(self, kind: str, verb: str = "") -> bytes | str:
        self.calls.append(("take", kind, verb))
        if kind in ("command", "script"):
            return command_line(self.now, verb) if kind == "command" else script(self.now)
        return f"{kind} of {verb}".encode()

    def changed_on_disk(self) -> bool:
        return self.others

    async def save(self, path: Path, *, force: bool = False) -> Path:
        if path.suffix != ".toml":
            raise ModelError("is no model file", path="save", given=str(path), allowed="a path that ends in .toml")
        if path.exists() and not force:
            raise ModelError("is there already", path="save", given=str(path), allowed="overwrite it, or another name")
        text = text_of(self.now)
        path.write_text(text, encoding="utf-8")
        saved = replace(self.now, base=text, overrides={}, path=path, drive=None, trusted=True)
        self.history = replace(self.history, now=replace(self.history.now, state=saved))
        self.tell("state")
        return path
