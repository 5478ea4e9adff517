"""The answers: five lines, what fails above them, and what may be applied."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from nicegui.element import Element

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
        self._session, self._told = session, None
        with box("ck-box ck-answers", "section") as self._root:
            self._root.props["aria-label"] = "Answers"
            with box("ck-title"):
                Words("h2", "Answers")
                Words(text="No strength rating: nothing here says that the teeth are strong enough.", classes="ck-pale")
            with box("ck-answer-list") as list_of_lines:
                list_of_lines.props["aria-live"] = "polite"
                self._list = list_of_lines
                self._checks = box("ck-checks")
                self._lines = {
                    key: _Line(key, words, apply=self._apply, show=show, run=run, cancel=cancel)
                    for key, words in QUESTIONS.items()
                }

    _told: list[str] | None

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
        bad = [str(one["text"]) for one in checks if one.get("level") == "bad"]
        if bad == self._told:
            return
        self._told = bad
        self._checks.clear()
        with self._checks:
            for text in bad[:_MOST_CHECKS]:
                _check(text)
            if len(bad) > _MOST_CHECKS:
                _check(f"{len(bad) - _MOST_CHECKS} more checks fail: see the warnings above")

    def _apply(self, values: Mapping[str, Any], label: str) -> None:
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

    def __init__(
        self,
        key: str,
        question: str,
        *,
        apply: Callable[[Mapping[str, Any], str], None],
        show: Callable[[str, int | None], None],
        run: Callable[[str], None],
        cancel: Callable[[str], None],
    ) -> None:
        self._answer: Mapping[str, Any] = {"key": key}  # shown
        self._of_frame: Mapping[str, Any] = self._answer
        self._jobs: Mapping[str, Job] = {}
        self._send = apply
        with box("ck-answer") as self._row:
            self._row.props["data-answer"] = key
            self._mark = Words(text="·", classes="ck-mark none")
            self._mark.props["role"] = "img"
            with box("ck-answer-text") as self._words:
                self._figure = Words("b", classes="ck-figure")
                self._text = Words(text=question, classes="ck-pale")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
            self._job = button("Compute", lambda: run(str(self._answer["job"])))
            self._cancel = button("Cancel", lambda: cancel(str(self._answer["job"])))
            self._evidence = button("Show", lambda: show(str(self._answer["evidence"]), self._answer.get("mode")))
        for part in (self._apply, self._job, self._cancel, self._evidence):
            hide(part, True)

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
        answer = _answer_of(job, rev, self._of_frame)
        if answer != self._answer:
            self._answer = answer
            self._show_answer()
        runs = job is not None and not job.ended
        done = job is not None and job.status == "done"
        found = answer is not self._of_frame  # by the job, of this state
        hide(self._job, not answer.get("job") or runs or found)
        hide(self._cancel, not runs)
        hide(self._evidence, not answer.get("evidence") or (bool(answer.get("job")) and not done))
        text = str(answer.get("text") or "")
        if job is None or found:
            self._say(text)
        elif done:
            self._say(text if job.rev != rev else progress_text(job, rev))  # the text is of this state, the job is not
        else:
            self._say(f"{text} ({progress_text(job, rev)})")

    def _show_answer(self) -> None:
        answer = self._answer
        level = str(answer.get("level"))
        mark, words = _MARKS.get(level, _MARKS["none"])
        self._mark.say(mark)
        prop(self._mark, "aria-label", words)
        _level(self._mark, level)
        self._figure.say(str(answer.get("figure") or ""))
        self._text.classes(remove="ck-pale")
        self._apply.say(str(answer.get("apply_label") or "Apply"))
        hide(self._apply, not answer.get("apply"))
        prop(self._job, "aria-label", f"Compute {answer.get('job') or ''}")
        prop(self._job, "title", f"Compute {answer.get('job') or ''}")
        prop(self._evidence, "aria-label", f"Show {answer.get('evidence') or ''}")
        prop(self._row, "data-stale", "true" if answer.get("stale") else None)

    def _say(self, text: str) -> None:
        self._text.say(text)
        prop(self._words, "title", f"{self._answer.get('question') or ''} {text}".strip())

    def _on_apply(self) -> None:
        values = self._answer.get("apply")
        if isinstance(values, Mapping):
            self._send(values, str(self._answer.get("apply_label") or "apply an answer"))


def _answer_of(job: Job | None, rev: int, of_frame: Mapping[str, Any]) -> Mapping[str, Any]:
    """The answer that a job found of the present state; without one what a frame said."""
    if job is None or job.frame is None or job.status != "done" or job.rev != rev:
        return of_frame
    found: Iterable[Mapping[str, Any]] = job.frame.head.get("answers") or ()
    return next((one for one in found if one["key"] == of_frame["key"]), of_frame)


def _level(mark: Element, level: str) -> None:
    others = [one for one in _MARKS if one != level and one in mark.classes]
    if others or level not in mark.classes:
        mark.classes(add=level, remove=" ".join(others))
