"""The answers: five lines, what fails above them, what may be applied, the limit of K_gamma; and the evidence for them:
load sharing, errors, the modes as a list, a tab for each job with its options, a list of all jobs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

from nicegui import ui
from nicegui.element import Element

from ...errors import ModelError
from ...limits import TABLES, stated_limit
from ..computing.job_kinds import JOBS
from ..processes.jobs import Job, newest_of
from ..processes.session import Session
from ..state.frames import QUESTIONS, Answer, number
from .controls import Board, Words, applied, box, button, hide, plain_button, prop, refused, window
from .job_bar import JobBar, JobsList, progress_text, result_of

_MODES = "number, frequency [Hz]; a row swings in the drawing"


class ModesList:
    """Rows of natural frequencies.  choose : called with the number of a mode, None where it is left."""

    def __init__(self, choose: Callable[[int | None], None]) -> None:
        self._choose = choose
        self._rows: list[_ModeRow] = []
        with box("ck-box ck-modes", "section", aria_label="Modes"):
            with box("ck-title"):
                Words("h2", "Modes")
                self._said = Words(classes="ck-pale", text=_MODES, role="status")
            self._list = box("ck-mode-list", data_keys="go")
        self._chosen_index: int | None = None

    def follow(self, head: Mapping[str, Any]) -> None:
        """Show the modes of a frame that brings them."""
        modes = head.get("modes")
        if modes is None:
            return
        with self._list:
            while len(self._rows) < len(modes):
                self._rows.append(_ModeRow(self._on_row))
        for row, mode in zip(self._rows, modes, strict=False):
            row.follow(mode, self._chosen_index)
        for row in self._rows[len(modes) :]:
            hide(row.root, True)

    def chosen(self, index: int | None, lost: str = "") -> None:
        """Mark the chosen mode.  lost : why there is none any more, "" where nothing was lost."""
        self._chosen_index = index
        self._said.say(lost or _MODES)
        for row in self._rows:
            row.press(index)

    def _on_row(self, index: int) -> None:
        self._choose(None if index == self._chosen_index else index)


class _ModeRow:
    def __init__(self, click: Callable[[int], None]) -> None:
        self._index = -1
        self.root = box("ck-mode", "button", type="button").on("click", lambda _: click(self._index))
        with self.root:
            self._number = Words("small")
            self._frequency, self._label, self._met = Words("b"), Words(), Words("i")

    def follow(self, mode: Mapping[str, Any], chosen: int | None) -> None:
        self._index = int(mode["index"])
        prop(self.root, "data-mode", str(self._index))
        self._number.say(str(self._index))
        self._frequency.say(number(float(mode["frequency"]), 4))
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
# Times that the live set takes which differ by this factor make other estimates.
_OTHER_SIZE = 1.5


def _standing(job: Job | None, rev: int) -> tuple[str, str]:
    """Mark of a tab and words beside the pointer: how its job stands beside the present state."""
    if job is None:
        return "", "not computed yet"
    if not job.ended:
        return ("…", "waits") if job.status == "waits" else ("▸", "runs")
    if job.status != "done":
        return "✗", job.status
    return ("✓", "done, of this state") if job.rev == rev else ("↻", "done, of another state: run again")


class EvidenceTabs:
    """Tabs over one pane.  newest : the job of each name that says most of the present state."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.newest: dict[str, Job] = {}
        self._tabs: dict[str, Element] = {}
        self._bars: dict[str, JobBar] = {}
        self._sent: dict[str, tuple[int, int]] = {}
        self._size: tuple[float, int] = (0.0, 0)  # of the train of which the times are told
        with box("ck-box ck-evidence", "section", aria_label="Evidence"):
            with box("ck-tabs", role="tablist", aria_label="Evidence", data_keys="choose"):
                jobs = {name: (kind.label, kind.purpose) for name, kind in JOBS.items()}
                first = (
                    *(next(name for name, kind in JOBS.items() if kind.quick is quick) for quick in (True, False)),
                    _LIST,
                )
                for name, (words, purpose) in (_TABS | jobs | {_LIST: ("Jobs", "All jobs of this page")}).items():
                    # a line before computed views, before jobs of some time, and before their list
                    classes = f"ck-tab{' ck-first' * (name in first)}{' ck-has-mark' * (name in JOBS)}"
                    show = partial(self.show, name)
                    self._tabs[name] = button(words, show, classes=classes, role="tab", title=purpose)
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
            bar.hide(key != name)
        hide(self._drawn, name == _LIST)
        self._list.hide(name != _LIST)
        if name != _LIST:
            self.pane.tell("evidence", name)
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

    def sized(self, head: Mapping[str, Any]) -> None:
        """Say how long jobs take of the train of a frame that says how large it is, where that is news at rest."""
        state = head.get("state", {})
        if "cases" in state:
            for name, kind in JOBS.items():
                hide(self._tabs[name], "case" in kind.overrides and not state["cases"])
                if self._tabs[name].props.get("hidden") and self._tabs[name].props["aria-selected"] == "true":
                    self.show("sharing")
        if "live_ms" not in state or self._session.rev != self._session.released_rev:
            return
        size = float(state["live_ms"]), state["mesh_frequencies"]
        if self._size[1] == size[1] and max(size[0], self._size[0]) < _OTHER_SIZE * min(size[0], self._size[0]):
            return
        self._size = size
        for bar in self._bars.values():
            bar.sized(state)

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
            mark, words = _standing(job, session.rev)
            prop(self._tabs[name], "data-mark", mark or None)
            prop(self._tabs[name], "title", f"{JOBS[name].purpose}: {words}")
        self._list.follow(self.newest)


# answers --------------------------------------------------------------------------------------------------------------

_MARKS = {"good": ("✓", "passes"), "warn": ("!", "look at"), "bad": ("✗", "fails"), "none": ("·", "note")}
# Numbers of an answer that stand in columns before its limit.
_COLUMNS = ("figure", "then")
# Answers whose changes lower K_gamma.
_OF_K_GAMMA = ("planet", "float", "error")
# Failing checks above the answers; the header has all of them.
_MOST_CHECKS = 2


class AnswersPane:
    """Five lines, each with its figure.

    show : called with the name of the evidence of an answer, and the mode that it is about.  run, cancel : called with
        the name of a job.  preview : with a change that the pointer or the focus is on, None where it leaves.
    """

    def __init__(
        self,
        session: Session,
        *,
        show: Callable[[str, int | None], None],
        run: Callable[[str], None],
        cancel: Callable[[str], None],
        preview: Callable[[Mapping[str, Any] | None], None],
    ) -> None:
        self.session = session
        self._told: list[str] | None = None
        self.show, self.run, self.cancel, self.preview = show, run, cancel, preview
        with box("ck-box ck-answers", "section", aria_label="Answers"):
            with box("ck-title ck-columns"):
                Words("h2", "Answers")
                for name in (*_COLUMNS, "limit"):
                    Words(text="now" if name == "figure" else name, classes="ck-figure ck-pale")
                Words(text="No strength rating: nothing here says that the teeth are strong enough.", classes="ck-pale")
            with box("ck-answer-list", aria_live="polite") as self._list:
                self._checks = box("ck-checks")
                self._lines = {key: _Line(key, question, self) for key, question in QUESTIONS.items()}
        for kind in JOBS.values():
            if kind.question:  # waits for its job where no frame answers it
                waiting = Answer(kind.question, kind.about, job=kind.name, evidence=kind.name)
                self._lines[kind.question].follow(asdict(waiting), session.rev)

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
                    with box("ck-answer ck-check", data_check="", title=text):
                        Words(text="✗", classes="ck-mark bad", aria_label="fails", role="img")
                        Words(text=text, classes="ck-answer-text")
        for answer in head.get("answers") or ():
            if (line := self._lines.get(str(answer["key"]))) is not None:
                line.follow(answer, self.session.rev)

    def jobs(self, newest: Mapping[str, Job]) -> None:
        """Show how far the jobs are that an answer waits for."""
        for line in self._lines.values():
            line.follow_jobs(newest, self.session.rev)

    def apply(self, values: Mapping[str, Any], label: str) -> None:
        applied(self.session, values, label, "It cannot be applied: ")


# Changes that a line has room for.
_MOST_CHANGES = 3


class _Changes:
    """Changes that act on an answer, a button each, which shows what it gives before it is pressed."""

    def __init__(self, pane: AnswersPane) -> None:
        self._pane = pane
        self._changes: Sequence[Mapping[str, Any]] = ()
        with box("ck-changes", role="group", aria_label="Changes that move it away") as self._row:
            self._buttons = [self._button(place) for place in range(_MOST_CHANGES)]
        hide(self._row, True)

    def _button(self, place: int) -> Words:
        control = button("", partial(self._apply, place), classes="ck-small ck-change")
        for event in ("mouseenter", "focus"):
            control.on(event, lambda _: self._pane.preview(self._changes[place]))
        for event in ("mouseleave", "blur"):
            control.on(event, lambda _: self._pane.preview(None))
        return control

    def follow(self, changes: Sequence[Mapping[str, Any]]) -> None:
        """Offer other changes."""
        self._changes = changes
        hide(self._row, not changes)
        for place, control in enumerate(self._buttons):
            hide(control, place >= len(changes))
            if place < len(changes):
                control.say(f"{changes[place]['label']}: {changes[place]['result']}")
                prop(control, "title", str(changes[place]["why"]))

    def _apply(self, place: int) -> None:
        self._pane.preview(None)
        self._pane.apply(self._changes[place]["apply"], str(self._changes[place]["label"]))


class LimitButton:
    """The number of a limit; a click opens the window that sets another one, where the model states it."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._limit: Mapping[str, Any] = {}
        self.root = button("", self._open, classes="ck-figure ck-limit")
        self.follow(None)

    def follow(self, limit: Mapping[str, Any] | None) -> None:
        """Show the limit of an answer; None leaves its column empty."""
        self._limit = limit or {}
        number = f"{limit['value']:g}" if limit else ""
        words = f"Limit of K_gamma {number}: {limit['source']}. A click sets another one." if limit else ""
        settable = bool(limit and limit["path"])
        self.root.say(number)
        prop(self.root, "disabled", None if settable else True)
        prop(self.root, "title", words if settable else None)
        prop(self.root, "aria-label", words if settable else f"limit {number}")

    def _open(self) -> None:
        path = str(self._limit["path"])
        with window("Limit of K_gamma", width=440) as dialog:
            ui.label(f"Now {self._limit['value']:g}: {self._limit['source']}.")
            field = ui.input("Limit of K_gamma", value=f"{self._limit['value']:g}").classes("w-full").props("autofocus")
            tables = " or ".join(TABLES)
            ui.label(f"A number from 1 on, or a table by the number of planets: {tables}. Written to {path}.")

            def put(value: object) -> None:
                if applied(self._session, {path: value}, "limit of K_gamma"):
                    dialog.close()

            def take() -> None:
                try:
                    limit = stated_limit(str(field.value or "").strip(), path)
                except ModelError as error:
                    field.error = f"allowed: {error.allowed}"
                else:
                    put(limit)

            field.on("keydown.enter", take)
            with ui.row().classes("w-full justify-end"):
                plain_button("As the table has it", lambda: put(None))
                plain_button("Set the limit", take, main=True)


class _Line:
    """One answer: what a frame says, or what its job has found of the same state."""

    def __init__(self, key: str, question: str, pane: AnswersPane) -> None:
        self._answer: Mapping[str, Any] = {"key": key}  # shown
        self._of_frame: Mapping[str, Any] = self._answer
        self._jobs: Mapping[str, Job] = {}
        self._pane = pane
        with box("ck-answer", data_answer=key) as self._row:
            self._mark = Words(text="·", classes="ck-mark none", role="img")
            self._numbers = {name: Words(classes="ck-figure") for name in _COLUMNS}
            self._limit = LimitButton(pane.session)
            self._more = button("", self._unfold, classes="ck-more", label="Whole answer", aria_expanded="false")
            with box("ck-answer-text") as self._words:
                self._text = Words(text=question, classes="ck-pale")
            self._words.on("click", self._unfold)
            self._assumed = Words(classes="ck-assumed")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
            self._job = button("Compute", lambda: pane.run(str(self._answer["job"])))
            self._cancel = button("Cancel", lambda: pane.cancel(str(self._answer["job"])))
            self._evidence = button("Show", lambda: pane.show(str(self._answer["evidence"]), self._answer.get("mode")))
            self._changes = _Changes(pane)
        for control in (self._assumed, self._apply, self._job, self._cancel, self._evidence):
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
        met = False  # whether nearly all trains meet the limit: what would lower K_gamma further buys nothing
        for known in self._jobs.values():
            if known.frame is None or known.status != "done" or known.rev != rev:
                continue
            met |= bool(result_of(known).get("met"))
            for of_job in known.head.get("answers") or ():
                if of_job["key"] == self._of_frame["key"]:
                    # changes that a job has found stand below the answer of the frame, which knows more
                    changes = {"changes": of_job["changes"]} if of_job.get("changes") else None
                    answer, by_job = {**self._of_frame, **changes} if changes else of_job, True
        if answer != self._answer:
            self._answer = answer
            level = str(answer.get("level"))
            mark, meaning = _MARKS.get(level, _MARKS["none"])
            self._mark.say(mark)
            prop(self._mark, "aria-label", meaning)
            self._mark.classes(replace=f"ck-mark {level}")
            prop(self._row, "data-level", level)
            for name, words in self._numbers.items():  # a job that finds the second number leaves the first one
                words.say(str(answer.get(name) or self._of_frame.get(name) or ""))
            self._limit.follow(answer.get("limit"))
            self._changes.follow(answer.get("changes") or ())
            self._mark_assumed(answer.get("assumed") or {})
            self._text.classes(remove="ck-pale")
            self._apply.say(str(answer.get("apply_label") or "Apply"))
            for name in ("aria-label", "title"):
                prop(self._job, name, f"Compute {answer.get('job') or ''}")
            prop(self._evidence, "aria-label", f"Show {answer.get('evidence') or ''}")
        hide(self._apply, not answer.get("apply") or (met and answer["key"] in _OF_K_GAMMA))
        hide(self._job, not answer.get("job") or runs or by_job)
        hide(self._cancel, not runs)
        waits = bool(answer.get("job")) and not done and answer.get("mode") is None  # of a mode there is a curve
        hide(self._evidence, not answer.get("evidence") or waits)
        text = str(answer.get("text") or "")
        if job is not None and not by_job:
            if not done:
                text = f"{text} ({progress_text(job, rev)})"
            elif job.rev == rev:  # else the text is of this state, the job is not
                text = progress_text(job, rev)
        self._text.say(text)
        prop(self._words, "title", f"{self._answer.get('question') or ''} {text}".strip())

    def _unfold(self, _: object = None) -> None:
        """Show the whole text, or two lines of it again."""
        prop(self._more, "aria-expanded", "false" if self._more.props["aria-expanded"] == "true" else "true")

    def _mark_assumed(self, assumed: Mapping[str, str]) -> None:
        """A mark of assumed values that the answer rests on, with their paths and reasons beside the pointer."""
        hide(self._assumed, not assumed)
        self._assumed.say(f"{len(assumed)} assumed")
        reasons = "\n".join(f"{path}: {reason}" for path, reason in assumed.items())
        prop(self._assumed, "title", f"Rests on assumed values:\n{reasons}")

    def _on_apply(self) -> None:
        values = self._answer.get("apply")
        if isinstance(values, Mapping):
            self._pane.apply(values, str(self._answer.get("apply_label") or "apply an answer"))
