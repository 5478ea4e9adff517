"""Jobs on the page: the bar of each with its options, its time, what replays it outside; the list of all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from ...errors import ModelError
from ...options import YES, Shape, default_words, shape_of
from ..computing.job_kinds import JOBS, JobKind, job_keywords
from ..processes.jobs import Job
from ..processes.session import Session
from ..state.state import PageState, command_line, download_needed, file_name_of, request_of, verb_script
from .controls import Words, applied, box, button, copy, give, hide, plain_button, prop, refused, safe_name, window


class OptionFields:
    """Fields of the options of a job, made from the options of its verb and folded away until they are asked for."""

    def __init__(self, kind: JobKind, *, changed: Callable[[], None]) -> None:
        self._changed = changed
        self._shapes: dict[str, Shape] = {}
        self._typed: dict[str, str] = {}
        with box("ck-options", "details") as self.root:
            Words("summary", "Options", classes="ck-small")
            with box("ck-fields"):
                for name, (default, accepted, option) in kind.keywords().items():
                    self._shapes[name] = shape_of(accepted)
                    usual = default_words(kind.defaults.get(name, option.default or default))
                    self._field(name, self._shapes[name], usual, option.help)
                if kind.views:
                    self._shapes["show"] = Shape(str, kind.views, False)
                    self._field("show", self._shapes["show"], kind.views[0], "What is drawn of the result.")

    def _field(self, name: str, shape: Shape, default: str, help: str) -> None:
        words = name.replace("_", " ").capitalize()
        choices = tuple(YES) if shape.kind is bool else () if shape.several else shape.choices
        with box("ck-choice", "label", title=help):
            Words(text=words, classes="ck-pale")
            with box("ck-select", "select" if choices else "input", aria_label=words) as control:
                for word in ("", *choices) if choices else ():
                    Words("option", word or f"as usual: {default}", value=word)
            if not choices:
                control.props.update(
                    {"placeholder": f"{default or 'one'}; ..." if shape.several else default, "size": 14}
                )
            control.on("change", partial(self._change, name), js_handler="(e) => emit(e.target.value)")

    def _change(self, name: str, event: GenericEventArguments) -> None:
        self._typed[name] = str(event.args).strip()
        self._changed()

    def values(self) -> dict[str, Any]:
        """Option -> value of all that was typed or chosen; errors as of `Shape.read`."""
        return {name: self._shapes[name].read(text, name) for name, text in self._typed.items() if text}


# Steps of the progress that are worth a message: a bar has no more pixels.
_STEPS = 200


class JobBar:
    """One job of a name.  run, cancel : called with the name; run also with a job whose process died."""

    def __init__(
        self, session: Session, kind: JobKind, *, run: Callable[..., None], cancel: Callable[[str], None]
    ) -> None:
        self._session, self._kind, name, words = session, kind, kind.name, kind.label
        self._words = words
        self._job: Job | None = None
        self._head: Mapping[str, Any] = {}
        with box("ck-job", data_job=name) as self.root:
            again = "With the same options, of the state that is shown"
            self._again = button("Run again", lambda: run(name, self._job), classes="ck-small ck-main", title=again)
            self._run = button("Run", lambda: run(name), classes="ck-small ck-main")
            self._cancel = button("Cancel", lambda: cancel(name))
            self._fields = OptionFields(kind, changed=self._offer)
            for what in TAKEN:
                button(what, partial(self._take, what))
            self._progress = box("", "progress", max=1, aria_label=f"{words}: share done")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
            self._text = Words(classes="ck-answer-text", text=kind.about)
        self._tables = ui.html("", sanitize=False).classes("ck-tables")  # of the report, which escapes what they hold
        for control in (self._again, self._cancel, self._progress, self._apply):
            hide(control, True)
        self.hide(True)
        self._offer()

    def hide(self, hidden: bool) -> None:
        hide(self.root, hidden)
        hide(self._tables, hidden or not self._tables.content)

    def options(self) -> dict[str, Any]:
        """What is chosen of the job; errors as of `OptionFields.values`."""
        return self._fields.values()

    def sized(self, head: Mapping[str, Any]) -> None:
        """Say how long the job takes of the train of this head ``state`` of a frame."""
        self._head = head
        self._offer()

    def _offer(self) -> None:
        """Say what the job does and how long that takes, where none stands there."""
        if self._job is not None:
            return
        try:
            options = self.options()
        except ModelError:  # which is told where it is run
            options = {}
        self._say(f"{self._time_of(options)} {self._kind.about}".strip())

    def _time_of(self, options: Mapping[str, Any]) -> str:
        """About how long it takes with its options."""
        jobs = [job for job in self._session.jobs.visible() if job.name == self._kind.name and job.status == "done"]
        return time_words(self._kind, self._head, options, jobs, self._session.state)

    def _say(self, text: str) -> None:
        self._text.say(text)
        prop(self._text, "title", text)

    async def _take(self, what: str) -> None:
        """A window with the command line, or the script, of the job with what is chosen of it."""
        state = self._session.state
        try:
            options = self.options()
            texts = await replayed(self._session, self._kind.name, options) if state is not None else {}
        except ModelError as error:
            return refused(error)
        if state is None:
            return
        with window(f"{self._words}: {what.lower()}", width=720):
            Words("pre", texts[what], classes="ck-code", tabindex="0")
            if download_needed(state):
                Words("p", f"Reads the model as {file_name_of(state)}: Take away has that file.", classes="ck-pale")
            with box("ck-row"):
                plain_button("Copy", lambda: copy(texts[what], what), icon="content_copy", main=True)
                if what == TAKEN[1]:
                    name = safe_name(f"{file_name_of(state, '')}-{self._kind.name}", ".py")
                    plain_button("Download", lambda: give(texts[what], name, "text/x-python"), icon="download")

    def follow(self, job: Job | None) -> None:
        """Show a job as it stands beside the present state; None: none that says anything of it."""
        if job is None and self._job is None:
            return
        self._job = job
        rev = self._session.rev
        runs = job is not None and not job.ended
        for control, hidden in ((self._run, runs), (self._cancel, not runs), (self._progress, not runs)):
            hide(control, hidden)
        hide(self._fields.root, runs)
        hide(self._again, job is None or not job.died)
        if job is None:
            self._offer()
        else:
            begun = job.status == "runs" and job.remaining is None
            self._say(f"{progress_text(job, rev)}. {self._time_of(job.options)}" if begun else progress_text(job, rev))
        prop(self._text, "role", "alert" if job is not None and job.status == "failed" else None)
        prop(self.root, "data-stale", "true" if job is not None and job.ended and job.rev != rev else None)
        self._run.say("Run again" if job is not None and job.rev != rev and job.status == "done" else "Run")
        result = {} if job is None or job.rev != rev else result_of(job)
        hide(self._apply, not result.get("apply"))
        if (tables := str({} if job is None else result_of(job).get("tables") or "")) != self._tables.content:
            self._tables.set_content(tables)
            self.hide(self.root.props.get("hidden") is not None)
        if job is not None:
            # without a number the bar only moves: a first part may take long
            prop(self._progress, "value", round(job.progress * _STEPS) / _STEPS or None)
            self._apply.say(str(result_of(job).get("apply_label") or "Apply"))

    def _on_apply(self) -> None:
        if self._job is None:
            return
        result = result_of(self._job)
        applied(self._session, result["apply"], str(result.get("apply_label") or f"apply {self._words}"))


TAKEN = ("Command line", "Script")
"""What replays a job outside of the page."""


async def replayed(session: Session, name: str, options: Mapping[str, Any]) -> dict[str, str]:
    """Each of `TAKEN` of a job of the present state.

    Raises
    ------
    ModelError : an option, or what the model lacks; no model is open.
    """
    state = session.state
    if state is None:
        raise ModelError("no model is open", path="model")
    verb, keywords = JOBS[name].verb, await session.call(job_keywords, name, *request_of(state), options)
    state = replace(state, overrides={**state.overrides, **JOBS[name].overrides})
    return dict(zip(TAKEN, (command_line(state, verb, keywords), verb_script(state, verb, keywords)), strict=True))


def time_words(
    kind: JobKind, head: Mapping[str, Any], options: Mapping[str, Any], done: Sequence[Job], state: PageState | None
) -> str:
    """About how long a job takes with its options: by its last run of the same model file, else by the time that the
    live set of the train has taken, ``head`` of its frame."""
    last = next((job for job in reversed(done) if state is not None and job.origin == state.origin), None)
    work = kind.work(options)
    if last is not None:
        seconds = last.seconds * work / kind.work(last.options)
        return f"{_span(seconds, _LIKE_LAST)}: the last run took {_time(last.seconds)}."
    seconds = kind.seconds(float(head.get("live_ms") or 0.0) / 1e3, int(head.get("mesh_frequencies") or 1)) * work
    return f"{_span(seconds, _BY_SIZE)} on this train." if seconds > 0 else ""


def _span(seconds: float, part: float) -> str:
    """``About 2 to 8 s``: a time and what it may be off by, times and per so much."""
    low, high = _time(seconds / part), _time(seconds * part)
    if low == high:
        return f"About {low}"
    number, _, unit = low.partition(" ")
    return f"About {number if high.endswith(unit) else low} to {high}"


# What a time may be off by, estimated from that of the live set, and from the last run.
_BY_SIZE, _LIKE_LAST = 2.0, 1.3


def result_of(job: Job) -> Mapping[str, Any]:
    """What a job says of its result; nothing before it is done."""
    return dict(job.head.get("job") or {})


def progress_text(job: Job, rev: int) -> str:
    """One sentence of a job as it stands, where the present state has the number `rev`."""
    if job.status == "waits":
        return "waits for another job"
    if job.status == "runs":
        left = "" if job.remaining is None else f", about {_time(job.remaining)} left"
        return f"{100 * job.progress:.0f} %{left}{'' if job.rev == rev else ', of another state'}"
    if job.status != "done":
        how = "cancelled" if job.status == "cancelled" else "stopped" if job.died else "failed"
        return f"{how}: {job.message}" if job.message else how
    return f"{'' if job.rev == rev else 'of another state: run again. '}{result_of(job).get('text') or 'done'}"


def _time(seconds: float) -> str:
    return f"{max(seconds, 1):.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


class JobsList:
    """Rows of jobs.  show : called with the name of a job whose result is to be shown.  run : as of `JobBar`."""

    def __init__(self, session: Session, *, show: Callable[[str], None], run: Callable[..., None]) -> None:
        self._session, self._show, self._run = session, show, run
        self._rows: list[_JobRow] = []
        self._hidden = True
        self._newest: Mapping[str, Job] = {}
        with box("ck-grow ck-jobs") as self._root:
            self._none = Words("div", "No job has been started. A job runs beside the page.", classes="ck-nothing")
        hide(self._root, True)

    def hide(self, hidden: bool) -> None:
        hide(self._root, hidden)
        self._hidden = hidden
        self.follow(self._newest)

    def follow(self, newest: Mapping[str, Job]) -> None:
        """Show the jobs as they stand, where the list is seen.  newest : those whose results are shown."""
        self._newest = newest
        if self._hidden:
            return
        jobs = list(reversed(self._session.jobs.visible()))
        hide(self._none, bool(jobs))
        with self._root:
            while len(self._rows) < len(jobs):
                self._rows.append(_JobRow(self._session, self._show, self._run))
        for row, job in zip(self._rows, jobs, strict=False):
            row.follow(job, self._session.rev, shown=newest.get(job.name) is job)
        for row in self._rows[len(jobs) :]:
            hide(row.root, True)


class _JobRow:
    """One job."""

    def __init__(self, session: Session, show: Callable[[str], None], run: Callable[..., None]) -> None:
        self._session = session
        self._job: Job | None = None
        with box("ck-job-row") as self.root:
            self._name = Words("b")
            self._state = Words(classes="ck-pale")
            self._text = Words(classes="ck-answer-text")
            self._cancel = button("Cancel", lambda: session.jobs.cancel(self._job) if self._job else None)
            self._open = button("Show", lambda: show(self._job.name) if self._job else None)
            self._again = button("Run again", lambda: run(self._job.name, self._job) if self._job else None)

    def follow(self, job: Job, rev: int, *, shown: bool) -> None:
        self._job = job
        state = self._session.state
        other = job.origin is not None and (state is None or state.origin != job.origin)
        self._name.say(job.label or job.name)
        took = f", {_time(job.seconds)}" if job.status == "done" else ""
        self._state.say(f"{f'{job.origin[2]}, ' if other and job.origin else ''}state {job.rev}{took}")
        self._text.say(progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        hide(self._cancel, job.ended)
        hide(self._open, job.frame is None or not shown)
        hide(self._again, not job.died or other or not shown or job.name not in JOBS)
        hide(self.root, False)
