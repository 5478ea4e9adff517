"""The answers: five lines, what fails above them, and what may be applied."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...errors import ModelError
from ..answers.words import QUESTIONS
from ..dialogs.controls import Words, box, button, hide, prop, refused
from ..processes.jobs import Job
from ..processes.session import Session
from .evidence import progress_text

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
        if "checks" in head:
            self._follow_checks(head["checks"])
        for answer in head.get("answers") or ():
            if (line := self._lines.get(str(answer["key"]))) is not None:
                line.follow(answer, self._session.rev)

    def jobs(self, newest: Mapping[str, Job]) -> None:
        """Show how far the jobs are that an answer waits for."""
        for line in self._lines.values():
            line.follow_jobs(newest, self._session.rev)

    def _follow_checks(self, checks: Sequence[Mapping[str, Any]]) -> None:
        bad = [str(check["text"]) for check in checks if check.get("level") == "bad"]
        if bad == self._told:
            return
        self._told = bad
        self._checks.clear()
        with self._checks:
            for text in bad[:_MOST_CHECKS]:
                _check(text)
            if len(bad) > _MOST_CHECKS:
                _check(f"{len(bad) - _MOST_CHECKS} more checks fail: see the warnings above")

    def apply(self, values: Mapping[str, Any], label: str) -> None:
        try:
            self._session.apply(values, label)
        except ModelError as error:
            refused(error, "It cannot be applied: ")


def _check(text: str) -> None:
    with box("ck-answer ck-check") as line:
        line.props.update({"data-check": "", "title": text})
        Words(text="✗", classes="ck-mark bad").props.update({"aria-label": "fails", "role": "img"})
        Words(text=text, classes="ck-answer-text")


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
            self._show_answer()
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

    def _show_answer(self) -> None:
        answer = self._answer
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

    def _on_apply(self) -> None:
        values = self._answer.get("apply")
        if isinstance(values, Mapping):
            self._pane.apply(values, str(self._answer.get("apply_label") or "apply an answer"))
