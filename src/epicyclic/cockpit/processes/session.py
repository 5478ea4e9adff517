"""One page: its history of states, what is computed of them, its jobs, and its file.  Runs in one event loop."""

from __future__ import annotations

import asyncio
import hashlib
import itertools
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...errors import ModelError
from ...results.files import write_text
from ..state.frames import Kind, PageFrame, Request, failed_frame, unpack
from ..state.model_file import text_of
from ..state.state import (
    Origin,
    PageState,
    StateHistory,
    Step,
    at_speed,
    file_of,
    from_fragment,
    request_of,
    seal_of,
    snapshot_text,
    with_text,
    with_value,
    with_values,
)
from .jobs import Job, Jobs, verb_file
from .worker import Client, Worker, start_worker

Levers = tuple[Mapping[str, Any], ...]


class Session:
    """What one page shows and does.

    history : states, undo and redo.  rev : number of the present state; released_rev : of the last one asked for whole.
    frames, packed : the newest of each kind.  failed : head of the newest failed frame, None where the state computes.
    levers : of the model opened.  pinned, pinned_packed : state A and its frames.  busy : whether something computes.
    view : what is shown of it: ``tab`` of the evidence, ``mode`` that is chosen.
    computed : newest state of the model that has frames; None where those of another model were dropped.
    """

    def __init__(self, worker: Worker | None = None) -> None:
        self.history = StateHistory()
        self.rev = self.released_rev = 0
        self.frames: dict[str, PageFrame] = {}
        self.packed: dict[str, bytes] = {}
        self.failed: Mapping[str, Any] | None = None
        self.computed: PageState | None = None
        self._opened = 0, 0  # opening of the model that is shown, and number of its first state since
        self.levers: Levers = ()
        # by the text of the model and its case, so that undo brings them back at once
        self._levers_of: dict[tuple[str, object], Levers] = {}
        self._asked_levers: dict[int, tuple[str, object]] = {}  # of what they are, by the number of the state
        self.pinned: PageState | None = None
        self._numbers_of_a = 0
        self.pinned_packed: dict[str, bytes] = {}
        self.view: dict[str, Any] = {}
        self.busy = False
        self.closed = False
        self.jobs = _PageJobs(self)
        self._worker = worker
        self._client = Client(deliver=self._deliver, idle=self._idle, early=self._deliver_early)
        self._client_of_a = Client(deliver=self._deliver_a, idle=self._tell_state)
        self._previews = 0
        self._client_of_preview = Client(deliver=self._deliver_preview, idle=lambda: None)
        self._client_of_levers = Client(deliver=self._deliver_levers, idle=lambda: None)
        self._clients = self._client, self._client_of_a, self._client_of_preview, self._client_of_levers
        self._listeners: dict[str, list[Callable[..., None]]] = {
            name: [] for name in ("frame", "state", "failed", "jobs", "view", "looked", "waits", "preview", "early")
        }
        self._kept: dict[Origin, PageState | None] = {}
        self._digests: dict[Path, str] = {}

    # listeners --------------------------------------------------------------------------------------------------------

    def listen(self, **callbacks: Callable[..., None]) -> None:
        """Be called in the event loop: ``frame`` with each frame, packed and not; ``state`` with the session after each
        change of the state; ``failed`` with the head of a failed frame, None once the state computes again; ``jobs``
        with the session after each change of a job, ``looked`` after each of the view; ``view`` with the session once
        it shows what another page did; ``waits`` with it where a call waits for its turn; ``preview`` with the packed
        frame of `preview`; ``early`` with one that comes ahead of the frame of the present state."""
        for name, function in callbacks.items():
            self._listeners[name].append(function)

    def _tell(self, name: str, *arguments: Any) -> None:
        for function in self._listeners[name]:
            function(*arguments)

    def _tell_state(self) -> None:
        self._tell("state", self)

    def looked(self, **view: Any) -> None:
        """Something else is shown: of ``tab`` and ``mode``."""
        if self.view != self.view | view:
            self.view |= view
            self._tell("looked", self)

    # the state --------------------------------------------------------------------------------------------------------

    @property
    def state(self) -> PageState | None:
        return self.history.present

    @property
    def relative_speed(self) -> float:
        """Speed that is shown, per operating speed [1]."""
        return 1.0 if self.state is None else self.state.relative_speed

    @property
    def unsaved(self) -> bool:
        """Whether the present state differs from what was opened or saved last."""
        now = self.state
        if now is None:
            return False
        kept = self._kept.get(now.origin)
        return kept is None or (now.base, now.overrides) != (kept.base, kept.overrides)

    async def start(self, state: PageState | None) -> None:
        """Begin with a state, which is no step to take back; None: the empty page."""
        self._join()
        state = None if state is None else _opening(state)
        self.history = StateHistory(now=Step(state=state))
        self._begun(state, state)

    async def open(self, state: PageState, *, unsaved: bool = False) -> None:
        """Show another model, as one step that can be taken back.  unsaved : it lies nowhere yet."""
        self.history = self.history.push(_opening(state), f"open {state.name}").closed()
        self._begun(state, None if unsaved else state)

    def _join(self) -> None:
        """Have a share in the live process of the server."""
        if self._worker is None:
            self._worker = start_worker()
        self.jobs.spare, self.jobs.queue = self._worker.spare, self._worker.queue
        for client in self._clients:
            if client not in self._worker.clients:
                self._worker.join(client)

    def _begun(self, state: PageState | None, kept: PageState | None) -> None:
        if state is not None:
            self._kept[state.origin] = kept
            if state.path is not None:
                self._digests[state.path] = _digest(state.path)
        self.levers = ()
        self._show_levers()
        self._changed(released=True)

    def _show_levers(self) -> None:
        """Have the levers of the present model: those chosen before, or chosen now while the last ones stand."""
        if self.state is not None and _of_levers(self.state) in self._levers_of:
            self.levers = self._levers_of[_of_levers(self.state)]
        else:
            asyncio.get_running_loop().call_soon(self._ask_levers)  # once the state has its number

    def _ask_levers(self) -> None:
        """Have the levers chosen from the present model."""
        if self.state is not None and self._worker is not None and not self.closed:
            self._asked_levers[self.rev] = _of_levers(self.state)
            with suppress(ModelError):  # the failed frame says what is wrong
                self._worker.ask(self._client_of_levers, _request(self.state, self.rev, "levers"))

    def _deliver_levers(self, packed: bytes) -> None:
        frame = unpack(packed)
        of = self._asked_levers.pop(frame.rev, None)
        if of is not None and frame.kind != "failed" and not self.closed:
            self._levers_of[of] = tuple(frame.head["levers"])
            if self.state is not None and _of_levers(self.state) == of:
                self.levers = self._levers_of[of]
                self._tell_state()

    def set(self, path: str, value: object, *, released: bool, key: str | None = None) -> None:
        """Set one value.  released : ask for everything, not only for what follows a drag; key : of one drag.

        Raises
        ------
        ModelError : no model is open; a value that no model file holds.
        """
        name = ".".join(path.split(".")[-2:])
        label = f"{name} removed" if value is None else f"{name} = {value}"
        self.history = self.history.push(with_value(self._present(), path, value), label, key or f"drag {path}")
        if released:
            self.history = self.history.closed()
        self._changed(released=released)

    def apply(self, values: Mapping[str, object], label: str) -> None:
        """Set several values as one step. Raises ModelError as `set`."""
        self._moved(self.history.push(with_values(self._present(), values), label))

    def set_text(self, text: str) -> None:
        """Take another model text. Raises ModelError where it is no TOML or names a file that it may not."""
        self._moved(self.history.push(with_text(self._present(), text), "edit the text"))

    def undo(self) -> None:
        self._moved(self.history.undo())

    def redo(self) -> None:
        self._moved(self.history.redo())

    def operate_at(self, relative_speed: float) -> None:
        """Show the train at another speed, per operating speed; the model stays as it is."""
        state = at_speed(self._present(), relative_speed)
        self._moved(self.history.push(state, f"operate at {state.relative_speed:.4g} times the speed"))

    def _moved(self, history: StateHistory) -> None:
        if history.now is self.history.now:
            return
        before, self.history = self.state, history
        if before is not None and self.state is not None and _of_levers(before) != _of_levers(self.state):
            self._show_levers()
        self._changed(released=True)

    def _present(self) -> PageState:
        if self.state is None:
            raise _no_model()
        return self.state

    def _changed(self, *, released: bool) -> None:
        """Number the state anew and have it computed; what cannot be asked for fails."""
        self.rev += 1
        if self.state is not None and self.state.opening != self._opened[0]:
            self._opened = self.state.opening, self.rev
        failed: Mapping[str, Any] | None = None
        if self.state is not None and self._worker is not None and not self.closed:
            if released:
                self.released_rev = self.rev
            try:
                request = _request(self.state, self.rev, "full" if released else "live")
            except ModelError as error:
                failed = failed_frame(self.rev, error).head
            else:
                self.jobs.follow((request.source, request.overrides), self.rev)
                self.busy = True
                self._worker.ask(self._client, request)
        self._tell_state()  # while the process computes
        if failed is not None:
            self._fail(failed)

    # what is computed -------------------------------------------------------------------------------------------------

    def _deliver(self, packed: bytes) -> None:
        frame = unpack(packed)
        if self.closed or frame.rev < self._opened[1]:
            return
        if frame.kind != "failed" and (frame.rev == self.rev or self.is_of_another_model):
            self.computed = self.state
        if frame.kind == "failed":
            if frame.rev == self.rev:
                self._fail(frame.head)
            return
        if self.failed is not None and frame.rev == self.rev:
            self._fail(None)
        self.frames[frame.kind], self.packed[frame.kind] = frame, packed
        self._tell("frame", packed, frame)

    def _deliver_early(self, packed: bytes) -> None:
        if not self.closed and not self.is_of_another_model and unpack(packed).rev == self.rev:
            self._tell("early", packed)

    @property
    def is_of_another_model(self) -> bool:
        """Whether the frames are of another model than the present state."""
        return self.computed is None or self.state is None or self.computed.opening != self.state.opening

    def computed_words(self) -> str:
        """Of which state the figures are where the present one does not compute, as a sentence."""
        if self.computed is None:
            return ""
        steps = itertools.pairwise([*self.history.behind, self.history.now])
        label = next((after.label for before, after in steps if before.state is self.computed), "")
        return (
            f"The pale figures are those before “{label}”" if label else "The pale figures are the last that computed"
        )

    def _fail(self, head: Mapping[str, Any] | None) -> None:
        if head is not None and self.is_of_another_model:
            self.frames, self.packed, self.computed = {}, {}, None
        self.failed = head
        self._tell("failed", head)

    def _idle(self) -> None:
        self.busy = False
        self._tell_state()

    # A ----------------------------------------------------------------------------------------------------------------

    def pin(self) -> None:
        """Keep the present state as A, with its frames, to compare with. Raises ModelError where no model is open."""
        self._pin(self._present())
        of_state = [kind for kind, frame in self.frames.items() if frame.rev == self.rev]
        self.pinned_packed = {kind: self.packed[kind] for kind in of_state}
        self._tell_state()
        if self.busy or self.released_rev != self.rev:
            self._ask_a()  # some of its frames are not there yet

    def unpin(self) -> None:
        self._pin(None)
        self._tell_state()

    def _pin(self, state: PageState | None) -> None:
        self.pinned, self.pinned_packed = state, {}
        self._numbers_of_a += 1

    def _ask_a(self) -> None:
        """Have all frames of A computed; their revision is negative, so none is taken for one of the present state."""
        if self.pinned is not None and self._worker is not None:
            self._worker.ask(self._client_of_a, _request(self.pinned, -self._numbers_of_a, "full"))

    def _deliver_a(self, packed: bytes) -> None:
        frame = unpack(packed)
        if frame.rev == -self._numbers_of_a and frame.kind != "failed" and not self.closed:
            self.pinned_packed[frame.kind] = packed

    # what a change would give -----------------------------------------------------------------------------------------

    def preview(self, values: Mapping[str, object] | None) -> None:
        """Have the present state computed with other values, which is no step; None: its frame is not wanted any more.

        Its revision is negative, so none takes it for one of the present state. Raises ModelError as `set`.
        """
        self._previews += 1
        if values is not None and self._worker is not None and not self.closed:
            request = _request(with_values(self._present(), values), -self._previews, "live")
            self._worker.ask(self._client_of_preview, request)

    def _deliver_preview(self, packed: bytes) -> None:
        frame = unpack(packed)
        if frame.rev == -self._previews and frame.kind != "failed" and not self.closed:
            self._tell("preview", packed)

    # taking away ------------------------------------------------------------------------------------------------------

    async def take(self, kind: str, verb: str) -> bytes:
        """Result of a verb of the present state as the content of a file: "nc", "csv" or "xlsx".

        Raises
        ------
        ModelError : what the verb raises.
        """
        content: bytes = await self.call(verb_file, request_of(self._present()), verb, kind, self.jobs.folder)
        return content

    async def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """function(*arguments) in a process of this page, which is killed with it.

        function : of a module; arguments and value are pickled.
        Raises ModelError : what the function raises, or that its process ended.
        """
        jobs = self.jobs  # another page may take them over meanwhile
        job = jobs.start("call", {"function": function, "arguments": arguments}, hidden=True)
        if job.status == "waits":
            self._tell("waits", self)
        try:
            await job.wait()
            if job.error is not None:
                raise job.error
            if job.status != "done":
                raise ModelError(job.message or "was cancelled", path=job.name)
            return job.value
        finally:
            jobs.forget(job)

    # file -------------------------------------------------------------------------------------------------------------

    def changed_on_disk(self) -> bool:
        """Whether the file of the state is not as it was opened or saved."""
        state = self.state
        if state is None or state.path is None:
            return False
        return self._digests.get(state.path, "") != _digest(state.path)

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
        problem, allowed = "", "overwrite it, or save as another one"
        if not force and target == state.path and self.changed_on_disk():
            problem = "changed on disk since it was opened" if target.exists() else "changed on disk: it is gone"
        elif not force and target != state.path and target.exists():
            problem, allowed = "is there already", "overwrite it, or another name"
        if problem:
            raise ModelError(problem, path="save", given=str(target), allowed=allowed)
        text = await asyncio.to_thread(text_of, state, target.parent)
        await asyncio.to_thread(write_text, target, text)
        self._digests[target] = await asyncio.to_thread(_digest, target)
        saved = replace(state, base=text, overrides={}, path=target, name=target.name, drive=None, trusted=True)
        self._kept[saved.origin] = saved
        self.history = self.history.with_file(state, saved)
        self._tell_state()
        return target

    # recovery and end -------------------------------------------------------------------------------------------------

    def snapshot(self) -> dict[str, object]:
        """What a browser keeps of the page, as JSON: texts of the states, no numbers; its file is sealed."""
        state, pinned = self.state, self.pinned
        if state is None:
            return {"state": None}
        kept = self._kept.get(state.origin)
        snapshot: dict[str, object] = {
            "state": snapshot_text(state),
            "pinned": None if pinned is None else snapshot_text(pinned),
            "unsaved": self.unsaved,
            "base_kept": kept is not None and kept.base == state.base and not kept.overrides,
            "view": self.view,
            # what only this process has
            "steps": len(self.history.behind) + len(self.history.ahead),
            "results": sum(job.status == "done" for job in self.jobs.visible()),
        }
        if state.path is not None:
            file = {"file": str(state.path), "trusted": state.trusted, "digest": self._digests.get(state.path, "")}
            snapshot |= file | {"seal": seal_of(str(snapshot["state"]), file)}
        return snapshot

    async def restore(self, snapshot: Mapping[str, object]) -> None:
        """Begin with what a browser kept; without a valid seal it has no file.

        Raises
        ------
        ModelError : it is no snapshot, or its model cannot be one.
        """
        text = snapshot.get("state")
        if not isinstance(text, str):
            raise ModelError("is no snapshot", path="kept state", allowed="what this page has kept")
        sealed = file_of(text, snapshot)
        state = _opening(from_fragment(text, most=None, file=sealed))
        kept = None if snapshot.get("unsaved", True) is not False else state
        if kept is None and snapshot.get("base_kept") is True:
            kept = replace(state, overrides={})
        if self.history.present is None and not self.rev:
            self._join()
            self.history = StateHistory(now=Step(state=state))
        else:
            self.history = self.history.push(state, f"restore {state.name}").closed()
        self._begun(state, kept)
        if sealed is not None:
            self._digests[sealed.path] = sealed.digest  # a change on disk since then is told
        if isinstance(pinned := snapshot.get("pinned"), str):
            with suppress(ModelError):
                self._pin(from_fragment(pinned, most=None))
                self._ask_a()
        if isinstance(view := snapshot.get("view"), Mapping):
            self.view = dict(view)
        self._tell_state()
        self._tell("view", self)

    def leave(self) -> None:
        """Have nothing computed any more but jobs: nobody looks."""
        for client in self._clients:
            if self._worker is not None:
                self._worker.leave(client)

    def take_over(self, other: Session) -> None:
        """Go on where the session of a page that is gone has ended, with all it has; that one has nothing then."""
        other.leave()
        for name in _TAKEN:
            setattr(self, name, getattr(other, name))
        self.jobs.move_to(self)
        other.jobs, other.closed = _PageJobs(other), True
        self._join()
        for frame in sorted(self.frames.values(), key=lambda frame: frame.rev):
            self._tell("frame", self.packed[frame.kind], frame)
        if not self.levers:
            self._show_levers()
        self._changed(released=True)
        self._tell("view", self)
        if len(self.pinned_packed) < len(self.packed):
            self._ask_a()

    async def close(self) -> None:
        """Stop everything that is this page's."""
        self.closed = True
        self.leave()
        await self.jobs.close()


# What makes a session: not who listens, nor what computes for it.
_TAKEN = (
    *("history", "rev", "released_rev", "computed", "_opened", "frames", "packed", "levers", "_levers_of", "view"),
    *("pinned", "_numbers_of_a", "pinned_packed", "jobs", "_kept", "_digests"),
)


class _PageJobs(Jobs):
    """Jobs of the present state of a page."""

    def __init__(self, session: Session) -> None:
        super().__init__(lambda _: self._session._tell("jobs", self._session))
        self._session = session

    def move_to(self, session: Session) -> None:
        """Belong to another page."""
        self._session = session

    def start(self, name: str, options: Mapping[str, Any] | None = None, *, hidden: bool = False) -> Job:
        """Start a job of the present state: one of the answers, or the report.

        Raises
        ------
        ModelError : no such job; no model is open; the model names a file that it may not.
        """
        state, rev = self._session.state, self._session.rev
        if state is None and name != "call":
            raise _no_model()
        model, origin = ({}, {}) if state is None else request_of(state), None if state is None else state.origin
        job = self.begin(name, options or {}, model=model, rev=rev, origin=origin, hidden=hidden)
        job.state = state
        return job


def _no_model() -> ModelError:
    return ModelError("no model is open", path="model", allowed="open one, or make a new one")


_openings = itertools.count(1)


def _of_levers(state: PageState) -> tuple[str, object]:
    """What the choice of levers follows: the text of the model, and the case that is computed."""
    return state.base, state.overrides.get("case")


def _opening(state: PageState) -> PageState:
    """A state as that of a model that is opened now."""
    return replace(state, opening=next(_openings))


def _request(state: PageState, rev: int, kind: Kind) -> Request:
    source, overrides = request_of(state)
    return Request(rev=rev, kind=kind, source=source, overrides=overrides, relative_speed=state.relative_speed)


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""
