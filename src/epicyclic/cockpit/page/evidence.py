"""The answers: five lines, what fails above them, what may be applied; and the evidence for them: load sharing, errors,
the modes as a list, a tab for each job with its options, a list of all jobs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from inspect import Parameter
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...errors import ModelError
from ...options import YES, Shape, shape_of
from ..computing.job_kinds import JOBS, JobKind
from ..processes.jobs import Job, newest_of
from ..processes.session import Session
from ..state.frames import QUESTIONS
from .controls import Board, Words, box, button, hide, prop, refused


class OptionFields:
    """Fields of the options of a job, made from the options of its verb and folded away until they are asked for."""

    def __init__(self, kind: JobKind) -> None:
        self._shapes: dict[str, Shape] = {}
        self._typed: dict[str, str] = {}
        with box("ck-options", "details") as self.root:
            Words("summary", "Options", classes="ck-small")
            with box("ck-fields"):
                for name, (parameter, accepted, option) in kind.keywords().items():
                    default = kind.defaults.get(name, option.default or parameter.default)
                    self._shapes[name] = shape_of(accepted)
                    self._field(name, self._shapes[name], _default_words(default), option.help)
                if kind.views:
                    self._shapes["show"] = Shape(str, kind.views, False)
                    self._field("show", self._shapes["show"], kind.views[0], "What is drawn of the result.")

    def _field(self, name: str, shape: Shape, default: str, help: str) -> None:
        words = name.replace("_", " ").capitalize()
        choices = tuple(YES) if shape.kind is bool else () if shape.several else shape.choices
        with box("ck-choice", "label") as field:
            field.props["title"] = help
            Words(text=words, classes="ck-pale")
            with box("ck-select", "select" if choices else "input") as control:
                control.props["aria-label"] = words
                for word in ("", *choices) if choices else ():
                    Words("option", word or f"as usual: {default}").props["value"] = word
            if not choices:
                control.props.update(
                    {"placeholder": f"{default or 'one'}; ..." if shape.several else default, "size": 14}
                )
            control.on("change", partial(self._change, name), js_handler="(e) => emit(e.target.value)")

    def _change(self, name: str, event: GenericEventArguments) -> None:
        self._typed[name] = str(event.args).strip()

    def values(self) -> dict[str, Any]:
        """Option -> value of all that was typed or chosen; errors as of `Shape.read`."""
        return {name: self._shapes[name].read(text, name) for name, text in self._typed.items() if text}


def _default_words(default: object) -> str:
    if isinstance(default, bool):
        return "yes" if default else "no"
    if isinstance(default, Sequence) and not isinstance(default, str):
        return ", ".join(map(str, default))
    return "" if default is None or default is Parameter.empty else str(default)


# Steps of the progress that are worth a message: a bar has no more pixels.
_STEPS = 200
_MAIN = "ck-small ck-main"


class JobBar:
    """One job of a name.  run, cancel : called with the name; run also with a job whose process died."""

    def __init__(
        self, session: Session, kind: JobKind, *, run: Callable[..., None], cancel: Callable[[str], None]
    ) -> None:
        self._session, name, words = session, kind.name, kind.label
        self._words = words
        self._job: Job | None = None
        self._before = f"{kind.about} From {_time(kind.seconds)}, by the size of the train."
        with box("ck-job") as self.root:
            self.root.props["data-job"] = name
            self._again = button("Run again", lambda: run(name, self._job), classes=_MAIN)
            self._again.props["title"] = "With the same options, of the state that is shown"
            self._run = button("Run", lambda: run(name), classes=_MAIN)
            self._cancel = button("Cancel", lambda: cancel(name))
            self._fields = OptionFields(kind)
            self._progress = box("", "progress")
            self._progress.props.update({"max": 1, "aria-label": f"{words}: share done"})
            self._text = Words(classes="ck-answer-text", text=self._before)
            self._text.props["title"] = self._before
            self._apply = button("Apply", self._on_apply, classes=_MAIN)
        for control in (self._again, self._cancel, self._progress, self._apply):
            hide(control, True)
        hide(self.root, True)

    def options(self) -> dict[str, Any]:
        """What is chosen of the job; errors as of `OptionFields.values`."""
        return self._fields.values()

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
        self._text.say(self._before if job is None else progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        prop(self._text, "role", "alert" if job is not None and job.status == "failed" else None)
        prop(self.root, "data-stale", "true" if job is not None and job.ended and job.rev != rev else None)
        self._run.say("Run again" if job is not None and job.rev != rev and job.status == "done" else "Run")
        result = {} if job is None or job.rev != rev else result_of(job)
        hide(self._apply, not result.get("apply"))
        if job is not None:
            # without a number the bar only moves: a first part may take long
            prop(self._progress, "value", round(job.progress * _STEPS) / _STEPS or None)
            self._apply.say(str(result_of(job).get("apply_label") or "Apply"))

    def _on_apply(self) -> None:
        if self._job is None:
            return
        result = result_of(self._job)
        try:
            self._session.apply(result["apply"], str(result.get("apply_label") or f"apply {self._words}"))
        except ModelError as error:
            refused(error)


def result_of(job: Job) -> Mapping[str, Any]:
    """What a job says of its result; nothing before it is done."""
    result = job.frame.head.get("job") if job.frame is not None else None
    return result if isinstance(result, Mapping) else {}


def progress_text(job: Job, rev: int) -> str:
    """One sentence of a job as it stands, where the present state has the number `rev`."""
    if job.status == "waits":
        return "waits for another job"
    if job.status == "runs":
        left = "" if job.remaining is None else f", {_time(job.remaining)} left"
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
        self._state.say(f"{job.origin[2]}, state {job.rev}" if other and job.origin else f"state {job.rev}")
        self._text.say(progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        hide(self._cancel, job.ended)
        hide(self._open, job.frame is None or not shown)
        hide(self._again, not job.died or other or not shown or job.name not in JOBS)
        hide(self.root, False)


class ModesList:
    """Rows of natural frequencies.  choose : called with the index of a mode, None where it is left."""

    def __init__(self, choose: Callable[[int | None], None]) -> None:
        self._choose = choose
        self._rows: list[_ModeRow] = []
        with box("ck-box ck-modes", "section") as root:
            root.props["aria-label"] = "Modes"
            with box("ck-title"):
                Words("h2", "Modes")
                self._count = Words(classes="ck-pale")
            self._list = box("ck-mode-list")
            self._list.props["data-keys"] = "go"
        self._chosen_index: int | None = None

    def follow(self, head: Mapping[str, Any]) -> None:
        """Show the modes of a frame that brings them."""
        modes = head.get("modes")
        if modes is None:
            return
        self._count.say("number, frequency [Hz]; a row swings in the drawing")
        with self._list:
            while len(self._rows) < len(modes):
                self._rows.append(_ModeRow(self._on_row))
        for row, mode in zip(self._rows, modes, strict=False):
            row.follow(mode, self._chosen_index)
        for row in self._rows[len(modes) :]:
            hide(row.root, True)

    def chosen(self, index: int | None) -> None:
        """Mark the mode that another pane has chosen."""
        self._chosen_index = index
        for row in self._rows:
            row.press(index)

    def _on_row(self, index: int) -> None:
        index_or_none = None if index == self._chosen_index else index
        self.chosen(index_or_none)
        self._choose(index_or_none)


class _ModeRow:
    def __init__(self, click: Callable[[int], None]) -> None:
        self._index = -1
        self.root = box("ck-mode", "button").on("click", lambda _: click(self._index))
        self.root.props["type"] = "button"
        with self.root:
            self._number = Words("small")
            self._frequency, self._label, self._met = Words("b"), Words(), Words("i")

    def follow(self, mode: Mapping[str, Any], chosen: int | None) -> None:
        self._index = int(mode["index"])
        prop(self.root, "data-mode", str(self._index))
        self._number.say(str(self._index))
        self._frequency.say(f"{float(mode['frequency']):.4g}")
        self._label.say(str(mode["label"]))
        prop(self.root, "title", f"{mode['label']}{': met by ' + str(mode['met_by']) if mode.get('met_by') else ''}")
        self._met.say(str(mode.get("met_by") or "").replace(" mesh order", " order"))
        self.press(chosen)
        hide(self.root, False)

    def press(self, chosen: int | None) -> None:
        prop(self.root, "aria-pressed", "true" if chosen == self._index else "false")


# tabs -----------------------------------------------------------------------------------------------------------------

# Words of the tabs before those of jobs, and what each is for, beside the pointer.
_TABS = {
    "sharing": ("Sharing", "Load of each mesh per fair share, at rest and over the hunting period"),
    "errors": ("Errors", "What each deviation costs in load sharing"),
}
_LIST = "jobs"


class EvidenceTabs:
    """Tabs over one pane.  newest : the job of each name that says most of the present state."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.newest: dict[str, Job] = {}
        self._tabs: dict[str, Element] = {}
        self._bars: dict[str, JobBar] = {}
        self._sent: dict[str, tuple[int, int]] = {}
        with box("ck-box ck-evidence", "section") as root:
            root.props["aria-label"] = "Evidence"
            with box("ck-tabs") as tabs:
                tabs.props.update({"role": "tablist", "aria-label": "Evidence", "data-keys": "choose"})
                jobs = {name: (kind.label, kind.purpose) for name, kind in JOBS.items()}
                for name, (words, purpose) in (_TABS | jobs | {_LIST: ("Jobs", "All jobs of this page")}).items():
                    tab = button(words, partial(self.show, name), classes="ck-tab")
                    tab.props.update({"role": "tab", "title": purpose})
                    self._tabs[name] = tab
            for name, kind in JOBS.items():
                self._bars[name] = JobBar(session, kind, run=self.run, cancel=self.cancel)
            with box("ck-grow") as self._drawn:
                self.pane = Board("evidence")
            self._list = JobsList(session, show=self.show, run=self.run)
        self.show("sharing")

    def show(self, name: str) -> None:
        """Show the evidence of a name: a tab of the first two, a job, or the list of jobs."""
        if name not in self._tabs:
            return
        for key, tab in self._tabs.items():
            prop(tab, "aria-selected", "true" if key == name else "false")
            prop(tab, "tabindex", "0" if key == name else "-1")
        for key, bar in self._bars.items():
            hide(bar.root, key != name)
        hide(self._drawn, name == _LIST)
        self._list.hide(name != _LIST)
        if name != _LIST:
            self.pane.evidence(name)
        self._session.looked(tab=name)

    def forget(self) -> None:
        """What was sent is taken away from the panes; results that belong to a later state are sent again."""
        self._sent.clear()
        self.pane.show_instead()

    def run(self, name: str, died: Job | None = None) -> None:
        """Start a job of the present state, and show it.  died : with the options of a job whose process died."""
        self.show(name)
        before = self.newest.get(name)
        if before is not None and not before.ended:
            return
        try:
            self._session.jobs.start(name, self._bars[name].options() if died is None else died.options)
        except ModelError as error:
            refused(error)
        self.follow()

    def cancel(self, name: str) -> None:
        if name in self.newest:
            self._session.jobs.cancel(self.newest[name])

    def follow(self) -> None:
        """Show the jobs as they stand, mark those of another state, and send results that have come."""
        session = self._session
        origin = None if session.state is None else session.state.origin
        self.newest = newest_of(session.jobs.visible(), session.rev, origin)
        for name, bar in self._bars.items():
            job = self.newest.get(name)
            bar.follow(job)
            if job is not None and job.packed is not None and self._sent.get(name) != (job.id, job.rev):
                self._sent[name] = job.id, job.rev
                self.pane.frame(job.packed)
            prop(self._tabs[name], "data-busy", "true" if job is not None and not job.ended else None)
        self._list.follow(self.newest)


# answers --------------------------------------------------------------------------------------------------------------

_MARKS = {"good": ("✓", "passes"), "warn": ("!", "look at"), "bad": ("✗", "fails"), "none": ("·", "note")}
# Failing checks above the answers; the header has all of them.
_MOST_CHECKS = 2


class AnswersPane:
    """Five lines, each with its figure.

    show : called with the name of the evidence of an answer, and the mode that it is about.  run, cancel : called with
        the name of a job.
    """

    def __init__(
        self,
        session: Session,
        *,
        show: Callable[[str, int | None], None],
        run: Callable[[str], None],
        cancel: Callable[[str], None],
    ) -> None:
        self._session = session
        self._told: list[str] | None = None
        self.show, self.run, self.cancel = show, run, cancel
        with box("ck-box ck-answers", "section") as root:
            root.props["aria-label"] = "Answers"
            with box("ck-title"):
                Words("h2", "Answers")
                Words(text="No strength rating: nothing here says that the teeth are strong enough.", classes="ck-pale")
            with box("ck-answer-list") as self._list:
                self._list.props["aria-live"] = "polite"
                self._checks = box("ck-checks")
                self._lines = {key: _Line(key, question, self) for key, question in QUESTIONS.items()}

    def follow(self, head: Mapping[str, Any], *, moving: bool) -> None:
        """Show the answers and checks of a frame that brings some.  moving : a lever is held, nothing is read out."""
        prop(self._list, "aria-busy", "true" if moving else "false")
        bad = [str(check["text"]) for check in head.get("checks", ()) if check.get("level") == "bad"]
        if "checks" in head and bad != self._told:
            self._told = bad
            texts, others = bad[:_MOST_CHECKS], len(bad) - _MOST_CHECKS
            if others > 0:
                texts.append(f"{others} more checks fail: see the warnings above")
            self._checks.clear()
            with self._checks:
                for text in texts:
                    with box("ck-answer ck-check") as failing:
                        failing.props.update({"data-check": "", "title": text})
                        Words(text="✗", classes="ck-mark bad").props.update({"aria-label": "fails", "role": "img"})
                        Words(text=text, classes="ck-answer-text")
        for answer in head.get("answers") or ():
            if (line := self._lines.get(str(answer["key"]))) is not None:
                line.follow(answer, self._session.rev)

    def jobs(self, newest: Mapping[str, Job]) -> None:
        """Show how far the jobs are that an answer waits for."""
        for line in self._lines.values():
            line.follow_jobs(newest, self._session.rev)

    def apply(self, values: Mapping[str, Any], label: str) -> None:
        try:
            self._session.apply(values, label)
        except ModelError as error:
            refused(error, "It cannot be applied: ")


class _Line:
    """One answer: what a frame says, or what its job has found of the same state."""

    def __init__(self, key: str, question: str, pane: AnswersPane) -> None:
        self._answer: Mapping[str, Any] = {"key": key}  # shown
        self._of_frame: Mapping[str, Any] = self._answer
        self._jobs: Mapping[str, Job] = {}
        self._pane = pane
        with box("ck-answer") as self._row:
            self._row.props["data-answer"] = key
            self._mark = Words(text="·", classes="ck-mark none")
            self._mark.props["role"] = "img"
            with box("ck-answer-text") as self._words:
                self._figure = Words("b", classes="ck-figure")
                self._text = Words(text=question, classes="ck-pale")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
            self._job = button("Compute", lambda: pane.run(str(self._answer["job"])))
            self._cancel = button("Cancel", lambda: pane.cancel(str(self._answer["job"])))
            self._evidence = button("Show", lambda: pane.show(str(self._answer["evidence"]), self._answer.get("mode")))
        for control in (self._apply, self._job, self._cancel, self._evidence):
            hide(control, True)

    def follow(self, answer: Mapping[str, Any], rev: int) -> None:
        """Show the answer of a frame, where the present state has the number `rev`."""
        if answer != self._of_frame:
            self._of_frame = dict(answer)
            self._show(rev)

    def follow_jobs(self, newest: Mapping[str, Job], rev: int) -> None:
        """Show what the job of this answer has found, or how far it is and how to end it."""
        self._jobs = newest
        self._show(rev)

    def _show(self, rev: int) -> None:
        if "text" not in self._of_frame:
            return  # the question stands there
        job = self._jobs.get(str(self._of_frame.get("job") or ""))
        runs = job is not None and not job.ended
        done = job is not None and job.status == "done"
        answer, by_job = self._of_frame, False
        if job is not None and job.frame is not None and done and job.rev == rev:
            for of_job in job.frame.head.get("answers") or ():
                if of_job["key"] == self._of_frame["key"]:
                    answer, by_job = of_job, True
                    break
        if answer != self._answer:
            self._answer = answer
            level = str(answer.get("level"))
            mark, words = _MARKS.get(level, _MARKS["none"])
            self._mark.say(mark)
            prop(self._mark, "aria-label", words)
            others = [mark for mark in _MARKS if mark != level and mark in self._mark.classes]
            if others or level not in self._mark.classes:
                self._mark.classes(add=level, remove=" ".join(others))
            self._figure.say(str(answer.get("figure") or ""))
            self._text.classes(remove="ck-pale")
            self._apply.say(str(answer.get("apply_label") or "Apply"))
            hide(self._apply, not answer.get("apply"))
            for name in ("aria-label", "title"):
                prop(self._job, name, f"Compute {answer.get('job') or ''}")
            prop(self._evidence, "aria-label", f"Show {answer.get('evidence') or ''}")
            prop(self._row, "data-stale", "true" if answer.get("stale") else None)
        hide(self._job, not answer.get("job") or runs or by_job)
        hide(self._cancel, not runs)
        hide(self._evidence, not answer.get("evidence") or (bool(answer.get("job")) and not done))
        text = str(answer.get("text") or "")
        if job is not None and not by_job:
            if not done:
                text = f"{text} ({progress_text(job, rev)})"
            elif job.rev == rev:  # else the text is of this state, the job is not
                text = progress_text(job, rev)
        self._text.say(text)
        prop(self._words, "title", f"{self._answer.get('question') or ''} {text}".strip())

    def _on_apply(self) -> None:
        values = self._answer.get("apply")
        if isinstance(values, Mapping):
            self._pane.apply(values, str(self._answer.get("apply_label") or "apply an answer"))
