"""One page: its history of states, what is computed of them, its jobs, and its file.  Runs in one event loop."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ...errors import ModelError
from ...results.whole_file import write_text
from ..computing.frames import Frame, Request, unpack
from ..state.history import StateHistory, Step
from ..state.links import from_fragment, snapshot_text
from ..state.replay import command_line, script
from ..state.state import PageState, request_of, with_text, with_value, with_values
from ..state.written_text import text_of
from .jobs import Job, Jobs
from .levers import levers_at
from .worker import Client, Worker, start_worker

__all__ = ["Session"]

Levers = tuple[Mapping[str, Any], ...]
# Relative speeds that a click in the sweep may ask for: beyond, no analysis of the package goes.
_SPEEDS = (1e-3, 100.0)


@dataclass(slots=True, eq=False)
class _Listeners:
    frame: list[Callable[[bytes, Frame], None]] = field(default_factory=list)
    state: list[Callable[[Session], None]] = field(default_factory=list)
    failed: list[Callable[[Mapping[str, Any] | None], None]] = field(default_factory=list)
    jobs: list[Callable[[Session], None]] = field(default_factory=list)


class Session:
    """What one page shows and does.

    history : states, undo and redo.  rev : number of the present state; released_rev : of the last one asked for whole.
    frames, packed : the newest of each kind.  failed : head of the newest failed frame, None where the state computes.
    levers : of the model opened.  pinned, pinned_frames : state A and its frames.  busy : whether something computes.
    """

    def __init__(self, worker: Worker | None = None) -> None:
        self.history = StateHistory()
        self.rev = self.released_rev = 0
        self.frames: dict[str, Frame] = {}
        self.packed: dict[str, bytes] = {}
        self.failed: Mapping[str, Any] | None = None
        self.levers: Levers = ()
        self.pinned: PageState | None = None
        self.pinned_frames: dict[str, Frame] = {}
        self.pinned_packed: dict[str, bytes] = {}
        self.relative_speed = 1.0
        self.busy = False
        self.closed = False
        self.jobs = _PageJobs(self)
        self._worker = worker
        self._client = Client(deliver=self._deliver, idle=self._idle)
        self._listeners = _Listeners()
        self._saved: PageState | None = None
        self._digest = ""
        self._tasks: set[asyncio.Task[None]] = set()

    # listeners --------------------------------------------------------------------------------------------------------

    def listen(
        self,
        *,
        frame: Callable[[bytes, Frame], None] | None = None,
        state: Callable[[Session], None] | None = None,
        failed: Callable[[Mapping[str, Any] | None], None] | None = None,
        jobs: Callable[[Session], None] | None = None,
    ) -> None:
        """Be called in the event loop: with each frame, packed and not; after each change of the state; with the head
        of a failed frame, None once the state computes again; after each change of a job."""
        for name, function in {"frame": frame, "state": state, "failed": failed, "jobs": jobs}.items():
            if function is not None:
                getattr(self._listeners, name).append(function)

    def tell_jobs(self) -> None:
        for function in self._listeners.jobs:
            function(self)

    # the state --------------------------------------------------------------------------------------------------------

    @property
    def state(self) -> PageState | None:
        return self.history.present

    @property
    def unsaved(self) -> bool:
        """Whether the present state differs from what was opened or saved last."""
        now, saved = self.state, self._saved
        return now is not None and (saved is None or (now.base, now.overrides) != (saved.base, saved.overrides))

    async def start(self, state: PageState | None) -> None:
        """Begin with a state, which is no step to take back; None: the empty page."""
        if self._worker is None:
            self._worker = start_worker()
        self._worker.join(self._client)
        self.history = StateHistory(now=Step(state=state))
        await self._begun(state)

    async def open(self, state: PageState) -> None:
        """Show another model, as one step that can be taken back."""
        self.history = self.history.push(state, f"open {state.name}")
        await self._begun(state)

    async def _begun(self, state: PageState | None) -> None:
        self._saved, self.relative_speed = state, 1.0
        self._digest = "" if state is None or state.path is None else _digest(state.path)
        self.levers = ()
        self._changed(released=True)
        if state is not None:
            await self.renew_levers()

    async def renew_levers(self) -> None:
        """Choose the levers anew from the present model."""
        state = self.state
        if state is None:
            return
        try:
            source, overrides = request_of(state)
            levers = await self.call(levers_at, source, overrides)
        except ModelError:
            return  # the failed frame says what is wrong
        if self.state is not None and self.state.base == state.base:
            self.levers = tuple(levers)
            self._tell_state()

    def set(self, path: str, value: object, *, released: bool, key: str | None = None) -> None:
        """Set one value.  released : ask for everything, not only for what follows a drag; key : of one drag.

        Raises
        ------
        ModelError : no model is open; a value that no model file holds.
        """
        self._push(with_value(self._present(), path, value), _label(path, value), key or f"drag {path}")
        if released:
            self.history = self.history.closed()
        self._changed(released=released)

    def apply(self, values: Mapping[str, object], label: str) -> None:
        """Set several values as one step. Raises ModelError as `set`."""
        self._push(with_values(self._present(), values), label)
        self._changed(released=True)

    def set_text(self, text: str) -> None:
        """Take another model text. Raises ModelError where it is no TOML or names a file that it may not."""
        before = self._present()
        self._push(with_text(before, text), "edit the text")
        self._changed(released=True)
        self._spawn(self.renew_levers())

    def undo(self) -> None:
        self._moved(self.history.undo())

    def redo(self) -> None:
        self._moved(self.history.redo())

    def operate_at(self, relative_speed: float) -> None:
        """Show the train at another speed, per operating speed; the model stays as it is."""
        self.relative_speed = min(max(float(relative_speed), _SPEEDS[0]), _SPEEDS[1])
        self._changed(released=True)

    def _moved(self, history: StateHistory) -> None:
        if history.now is self.history.now:
            return
        before, self.history = self.state, history
        if before is not None and self.state is not None and before.base != self.state.base:
            self._spawn(self.renew_levers())
        self._changed(released=True)

    def _present(self) -> PageState:
        if self.state is None:
            raise ModelError("no model is open", path="model", allowed="open one, or make a new one")
        return self.state

    def _push(self, state: PageState, label: str, key: str | None = None) -> None:
        self.history = self.history.push(state, label, key)

    def _changed(self, *, released: bool) -> None:
        """Number the state anew and have it computed."""
        self.rev += 1
        self._tell_state()
        state = self.state
        if state is None or self._worker is None:
            return
        if released:
            self.released_rev = self.rev
        try:
            source, overrides = request_of(state)
        except ModelError as error:
            self._fail({"message": error.problem, "path": error.path, "given": "", "allowed": error.allowed})
            return
        self.busy = True
        self._worker.ask(
            self._client,
            Request(
                rev=self.rev,
                kind="full" if released else "live",
                source=source,
                overrides=overrides,
                relative_speed=self.relative_speed,
            ),
        )

    def _tell_state(self) -> None:
        for function in self._listeners.state:
            function(self)

    # what is computed -------------------------------------------------------------------------------------------------

    def _deliver(self, packed: bytes) -> None:
        frame = unpack(packed)
        if self.closed:
            return
        if frame.kind == "failed":
            if frame.rev == self.rev:
                self._fail(frame.head)
            return
        if self.failed is not None and frame.rev == self.rev:
            self._fail(None)
        self.frames[frame.kind], self.packed[frame.kind] = frame, packed
        for function in self._listeners.frame:
            function(packed, frame)

    def _fail(self, head: Mapping[str, Any] | None) -> None:
        self.failed = head
        for function in self._listeners.failed:
            function(head)

    def _idle(self) -> None:
        self.busy = False
        self._tell_state()

    # A ----------------------------------------------------------------------------------------------------------------

    def pin(self) -> None:
        """Keep the present state as A, with its frames, to compare with. Raises ModelError where no model is open."""
        self.pinned = self._present()
        self.pinned_frames, self.pinned_packed = dict(self.frames), dict(self.packed)
        self._tell_state()

    def unpin(self) -> None:
        self.pinned, self.pinned_frames, self.pinned_packed = None, {}, {}
        self._tell_state()

    # taking away ------------------------------------------------------------------------------------------------------

    async def take(self, kind: str, verb: str = "") -> bytes | str:
        """The present state: "toml", "command" and "script" as text; "nc", "json", "csv", "xlsx" of a verb and "html",
        the report, as bytes.

        Raises
        ------
        ModelError : what the verb raises; no such kind.
        """
        state = self._present()
        if kind == "toml":
            return await asyncio.to_thread(text_of, state)
        if kind == "command":
            return command_line(state, verb or "report")
        if kind == "script":
            return script(state)
        job = self.jobs.start(kind, {"verb": verb}, hidden=True)
        path = (await self._result(job)).dataset_path
        if path is None:
            raise ModelError("no file of that kind", path="kind", given=kind, allowed="nc, json, csv, xlsx, html")
        return await asyncio.to_thread(path.read_bytes)

    async def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """function(*arguments) in a process of this page, which is killed with it.

        function : of a module; arguments and value are pickled.
        Raises ModelError : what the function raises, or that its process ended.
        """
        job = self.jobs.start("call", {"function": function, "arguments": arguments}, hidden=True)
        return (await self._result(job)).value

    async def _result(self, job: Job) -> Job:
        await job.wait()
        if job.error is not None:
            raise job.error
        if job.status != "done":
            raise ModelError(job.message or "was cancelled", path=job.name)
        return job

    # file -------------------------------------------------------------------------------------------------------------

    def changed_on_disk(self) -> bool:
        """Whether the file of the state is not as it was opened or saved."""
        state = self.state
        return state is not None and state.path is not None and self._digest != _digest(state.path)

    async def save(self, path: Path | None = None, *, force: bool = False) -> Path:
        """Write the model text to its file, or to another one, which is its file then.  No step to take back.

        Raises
        ------
        ModelError : "changed on disk" and "is there already" without `force`; no file; it cannot be written.
        """
        state = self._present()
        target = path if path is not None else state.path
        if target is None:
            raise ModelError("has no file yet", path="save", allowed="save as, with a path")
        target = target.expanduser().absolute()
        if target.suffix.lower() != ".toml":
            raise ModelError("is no model file", path="save", given=str(target), allowed="a path that ends in .toml")
        if not force and state.path is not None and target == state.path:
            if self.changed_on_disk():
                problem = "changed on disk since it was opened" if target.exists() else "changed on disk: it is gone"
                raise ModelError(
                    problem, path="save", given=str(target), allowed="overwrite it, or save as another one"
                )
        elif not force and target.exists():
            raise ModelError(
                "is there already", path="save", given=str(target), allowed="overwrite it, or another name"
            )
        text = await asyncio.to_thread(text_of, state)
        await asyncio.to_thread(write_text, target, text)
        saved = replace(state, base=text, overrides={}, path=target, name=target.name, drive=None, trusted=True)
        self._saved, self._digest = saved, _digest(target)
        if self.state is state:
            self.history = replace(self.history, now=replace(self.history.now, state=saved))
        self._tell_state()
        return target

    # recovery and end -------------------------------------------------------------------------------------------------

    def snapshot(self) -> dict[str, object]:
        """What a browser keeps of the page: no path and no numbers, since it comes back from outside."""
        state, pinned = self.state, self.pinned
        return {
            "state": None if state is None else snapshot_text(state),
            "pinned": None if pinned is None else snapshot_text(pinned),
            "speed": self.relative_speed,
        }

    async def restore(self, snapshot: Mapping[str, object]) -> None:
        """Begin with what a browser kept. Raises ModelError where it is none of ours."""
        text = snapshot.get("state")
        if not isinstance(text, str):
            raise ModelError("is no snapshot", path="kept state")
        state = from_fragment(text, most=None)
        if self.history.present is None and not self.rev:
            await self.start(state)
        else:
            await self.open(state)
        self._saved = None
        self._tell_state()

    async def close(self) -> None:
        """Stop everything that is this page's."""
        self.closed = True
        if self._worker is not None:
            self._worker.leave(self._client)
        for task in self._tasks:
            task.cancel()
        await self.jobs.close()

    def _spawn(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


class _PageJobs(Jobs):
    """Jobs of the present state of a page."""

    def __init__(self, session: Session) -> None:
        super().__init__(lambda _: session.tell_jobs())
        self._session = session

    def start(self, name: str, options: Mapping[str, Any] | None = None, *, hidden: bool = False) -> Job:
        """Start a job of the present state: one of the answers, or a kind of file.

        Raises
        ------
        ModelError : no such job; no model is open; the model names a file that it may not.
        """
        state = self._session.state
        source, overrides = request_of(state) if state is not None else ({}, {})
        if state is None and name != "call":
            raise ModelError("no model is open", path="model", allowed="open one, or make a new one")
        return self.begin(name, options or {}, source=source, overrides=overrides, rev=self._session.rev, hidden=hidden)


def _label(path: str, value: object) -> str:
    words = path.split(".")
    return f"{'.'.join(words[-2:])} = {value}" if value is not None else f"{'.'.join(words[-2:])} removed"


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""
