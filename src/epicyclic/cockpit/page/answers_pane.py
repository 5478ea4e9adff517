"""The answers: five lines, what fails above them, and what may be applied."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nicegui.element import Element

from ...errors import ModelError
from ..dialogs.parts import refused
from ..processes.session import Session
from .controls import Words, box, button, hide, prop

__all__ = ["AnswersPane"]

_MARKS = {"good": ("✓", "passes"), "warn": ("!", "look at"), "bad": ("✗", "fails"), "none": ("·", "note")}
# Failing checks above the answers; the header has all of them.
_MOST_CHECKS = 2


class AnswersPane:
    """Five lines, each with its figure.

    show : called with the name of the evidence of an answer.  run : called with the name of a job.
    """

    def __init__(self, session: Session, *, show: Callable[[str], None], run: Callable[[str], None]) -> None:
        self._session, self._show, self._run = session, show, run
        self._lines: dict[str, _Line] = {}
        with box("ck-box ck-answers") as root:
            root.props["aria-live"] = "polite"
            with box("ck-title"):
                Words(text="Answers")
                Words(text="No strength rating: nothing here says that the teeth are strong enough.", classes="ck-pale")
            self._list = box("ck-answer-list")
            with self._list:
                self._checks = box("ck-checks")
        self._told: object = None

    def follow(self, head: Mapping[str, Any]) -> None:
        """Show the answers and checks of a frame that brings some."""
        if "checks" in head:
            self._follow_checks(head["checks"])
        for answer in head.get("answers") or ():
            key = str(answer["key"])
            if key not in self._lines:
                with self._list:
                    self._lines[key] = _Line(self, key)
            self._lines[key].follow(answer)

    def _follow_checks(self, checks: Sequence[Mapping[str, Any]]) -> None:
        bad = [str(one["text"]) for one in checks if one.get("level") == "bad"][:_MOST_CHECKS]
        if bad == self._told:
            return
        self._told = bad
        self._checks.clear()
        with self._checks:
            for text in bad:
                with box("ck-answer") as line:
                    line.props["data-check"] = ""
                    line.props["title"] = text
                    Words(text="✗", classes="ck-mark bad").props["aria-label"] = "fails"
                    Words(text=text, classes="ck-answer-text")

    def apply(self, values: Mapping[str, Any], label: str) -> None:
        try:
            self._session.apply(values, label)
        except ModelError as error:
            refused(error, "It cannot be applied: ")

    def show(self, evidence: str) -> None:
        self._show(evidence)

    def run(self, job: str) -> None:
        self._run(job)


class _Line:
    """One answer."""

    def __init__(self, pane: AnswersPane, key: str) -> None:
        self._pane, self._answer = pane, {"key": key}
        with box("ck-answer") as self._row:
            self._row.props["data-answer"] = key
            self._mark = Words(classes="ck-mark")
            self._figure = Words(classes="ck-figure")
            self._text = Words(classes="ck-answer-text")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
            self._job = button("Compute", self._on_job)
            self._evidence = button("Show", self._on_evidence)

    def follow(self, answer: Mapping[str, Any]) -> None:
        self._answer = dict(answer)
        mark, words = _MARKS.get(str(answer.get("level")), _MARKS["none"])
        self._mark.say(mark)
        prop(self._mark, "aria-label", words)
        _level(self._mark, str(answer.get("level")))
        self._figure.say(str(answer.get("figure") or ""))
        text = str(answer.get("text") or "")
        self._text.say(text)
        prop(self._text, "title", f"{answer.get('question')} {text}")
        label = str(answer.get("apply_label") or "Apply")
        self._apply.say(label)
        hide(self._apply, not answer.get("apply"))
        hide(self._job, not answer.get("job"))
        prop(self._job, "aria-label", f"Compute {answer.get('job') or ''}")
        hide(self._evidence, not answer.get("evidence") or bool(answer.get("job")))
        prop(self._evidence, "aria-label", f"Show {answer.get('evidence') or ''}")
        prop(self._row, "data-stale", "true" if answer.get("stale") else None)

    def _on_apply(self) -> None:
        values = self._answer.get("apply")
        if isinstance(values, Mapping):
            self._pane.apply(values, str(self._answer.get("apply_label") or "apply an answer"))

    def _on_job(self) -> None:
        self._pane.run(str(self._answer["job"]))

    def _on_evidence(self) -> None:
        self._pane.show(str(self._answer["evidence"]))


def _level(mark: Element, level: str) -> None:
    others = [one for one in _MARKS if one != level and one in mark.classes]
    if others or level not in mark.classes:
        mark.classes(add=level, remove=" ".join(others))
