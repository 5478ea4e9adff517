"""Jobs on the page: options before the start, progress, end and message of each, and the list of all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...errors import ModelError
from ..dialogs.parts import refused
from ..processes.jobs import Job
from ..processes.session import Session
from .controls import Words, box, button, hide, prop


@dataclass(frozen=True, slots=True, kw_only=True)
class JobChoice:
    """One entry: its words, and the options that it means."""

    label: str
    options: Mapping[str, int | float | str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class JobOption:
    """A list of choices with its name."""

    label: str
    choices: tuple[JobChoice, ...]


OPTIONS: Mapping[str, JobOption] = {
    "contact": JobOption(
        label="Show",
        choices=(
            JobChoice(label="transmission error"),
            JobChoice(label="load along the face", options={"show": "load"}),
        ),
    ),
    "relief": JobOption(
        label="Search",
        # three times the candidates and generations: two optima of nearly the same error are told apart
        choices=(JobChoice(label="quick"), JobChoice(label="thorough", options={"population": 36, "generations": 24})),
    ),
    "tolerance": JobOption(
        label="Trains",
        choices=(JobChoice(label="16 384"), JobChoice(label="131 072", options={"samples": 131_072})),
    ),
    "contact_loss": JobOption(
        label="Speeds",
        choices=(
            JobChoice(label="60"),
            JobChoice(label="200", options={"points": 200}),
            JobChoice(label="60 with shaft orders", options={"shaft_orders": True}),
        ),
    ),
    "transient": JobOption(
        label="Mesh cycles",
        choices=(JobChoice(label="50"), JobChoice(label="300", options={"cycles": 300.0})),
    ),
    "sensitivity": JobOption(
        label="Of",
        choices=(JobChoice(label="lowest frequency"), JobChoice(label="mesh force", options={"of": "force"})),
    ),
}
"""Job -> what may be chosen of it; a job that is missing has nothing to choose."""


# Steps of the progress that are worth a message: a bar has no more pixels.
_STEPS = 200


class JobBar:
    """One job of a name.  run, cancel : called with the name."""

    def __init__(
        self, session: Session, name: str, words: str, *, run: Callable[[str], None], cancel: Callable[[str], None]
    ) -> None:
        self._session, self._name, self._words = session, name, words
        self._job: Job | None = None
        self._before = _before(name)
        with box("ck-job") as self._bar:
            self._bar.props["data-job"] = name
            self._run = button("Run", lambda: run(name), classes="ck-small ck-main")
            self._cancel = button("Cancel", lambda: cancel(name))
            self._chosen = 0
            self._choices = _choices(OPTIONS[name], self._choose) if name in OPTIONS else None
            self._progress = box("", "progress")
            self._progress.props.update({"max": 1, "aria-label": f"{words}: share done"})
            self._text = Words(classes="ck-answer-text", text=self._before)
            self._text.props["title"] = self._before
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
        for part in (self._cancel, self._progress, self._apply):
            hide(part, True)
        self.hide(True)

    def hide(self, hidden: bool) -> None:
        hide(self._bar, hidden)

    @property
    def options(self) -> Mapping[str, Any]:
        """What is chosen of the job."""
        return OPTIONS[self._name].choices[self._chosen].options if self._name in OPTIONS else {}

    def _choose(self, event: GenericEventArguments) -> None:
        if isinstance(event.args, int) and 0 <= event.args < len(OPTIONS[self._name].choices):
            self._chosen = event.args

    def follow(self, job: Job | None) -> None:
        """Show a job as it stands beside the present state; None: none that says anything of it."""
        if job is None and self._job is None:
            return
        self._job = job
        if job is None:
            self._forget()
            return
        rev = self._session.rev
        hide(self._run, not job.ended)
        hide(self._cancel, job.ended)
        hide(self._progress, job.ended)
        if self._choices is not None:
            hide(self._choices, not job.ended)
        # without a number the bar only moves: a first part may take long
        prop(self._progress, "value", round(job.progress * _STEPS) / _STEPS or None)
        self._text.say(progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        prop(self._text, "role", "alert" if job.status == "failed" else None)
        prop(self._bar, "data-stale", "true" if job.ended and job.rev != rev else None)
        self._run.say("Run" if job.rev == rev or job.status != "done" else "Run again")
        result = result_of(job)
        self._apply.say(str(result.get("apply_label") or "Apply"))
        hide(self._apply, not result.get("apply") or job.rev != rev)

    def _forget(self) -> None:
        """Show the job as one that has not run."""
        for part, hidden in ((self._run, False), (self._cancel, True), (self._progress, True), (self._apply, True)):
            hide(part, hidden)
        if self._choices is not None:
            hide(self._choices, False)
        self._run.say("Run")
        self._text.say(self._before)
        for name, value in {"title": self._before, "role": None}.items():
            prop(self._text, name, value)
        prop(self._bar, "data-stale", None)

    def _on_apply(self) -> None:
        if self._job is None:
            return
        result = result_of(self._job)
        try:
            self._session.apply(result["apply"], str(result.get("apply_label") or f"apply {self._words}"))
        except ModelError as error:
            refused(error)


def _choices(option: JobOption, choose: Callable[[GenericEventArguments], None]) -> Element:
    """A native list."""
    with box("ck-choice", "label") as root:
        Words(text=option.label, classes="ck-pale")
        with box("ck-select", "select") as list_of_choices:
            list_of_choices.props["aria-label"] = option.label
            for number, choice in enumerate(option.choices):
                Words("option", choice.label).props["value"] = str(number)
        list_of_choices.on("change", choose, js_handler="(e) => emit(Number(e.target.value))")
    return root


def _before(name: str) -> str:
    """What is said of a job that has not run."""
    from ..answers.jobs import JOBS

    if name not in JOBS:
        return "runs beside the page"
    return f"{JOBS[name].about} From {_time(JOBS[name].seconds)}, by the size of the train."


def result_of(job: Job) -> Mapping[str, Any]:
    """What a job says of its result; nothing before it is done."""
    found = job.frame.head.get("job") if job.frame is not None else None
    return found if isinstance(found, Mapping) else {}


def progress_text(job: Job, rev: int) -> str:
    """One sentence of a job as it stands, where the present state has the number `rev`."""
    if job.status == "waits":
        return "waits for another job"
    other = "" if job.rev == rev else "of another state"
    if job.status == "runs":
        left = "" if job.remaining is None else f", {_time(job.remaining)} left"
        return f"{100 * job.progress:.0f} %{left}{other and f', {other}'}"
    if job.status != "done":
        return f"failed: {job.message}" if job.status == "failed" else "cancelled"
    old = f"{other}: run again. " if other else ""
    return f"{old}{result_of(job).get('text') or 'done'}"


def _time(seconds: float) -> str:
    return f"{max(seconds, 1):.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


class JobsList:
    """Rows of jobs.  show : called with the name of a job whose result is to be shown."""

    def __init__(self, session: Session, *, show: Callable[[str], None]) -> None:
        self._session, self._show = session, show
        self._rows: list[_Row] = []
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
                self._rows.append(_Row(self._session, self._show))
        for row, job in zip(self._rows, jobs, strict=False):
            row.follow(job, self._session.rev, shown=newest.get(job.name) is job)
        for row in self._rows[len(jobs) :]:
            row.end()


class _Row:
    """One job."""

    def __init__(self, session: Session, show: Callable[[str], None]) -> None:
        self._session, self._job = session, None
        with box("ck-job-row") as self._row:
            self._name = Words("b")
            self._state = Words(classes="ck-pale")
            self._text = Words(classes="ck-answer-text")
            self._cancel = button("Cancel", self._on_cancel)
            self._open = button("Show", lambda: show(self._job.name) if self._job else None)

    _job: Job | None

    def follow(self, job: Job, rev: int, *, shown: bool) -> None:
        self._job = job
        state = self._session.state
        other = job.origin is not None and (state is None or state.origin != job.origin)
        self._name.say(job.label or job.name)
        self._state.say(f"{job.origin[2]}, state {job.rev}" if other and job.origin else f"state {job.rev}")
        self._text.say(progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        hide(self._cancel, job.ended)
        hide(self._open, job.frame is None or not shown)
        hide(self._row, False)

    def end(self) -> None:
        hide(self._row, True)

    def _on_cancel(self) -> None:
        if self._job is not None:
            self._session.jobs.cancel(self._job)
