"""The evidence: load sharing, errors, and one tab for each job with its start, progress and result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui.element import Element

from ...errors import ModelError
from ..canvas.element import EvidencePane, send
from ..dialogs.parts import refused
from ..processes.jobs import Job
from ..processes.session import Session
from .controls import Words, box, button, hide, prop

__all__ = ["EvidenceTabs"]

# The tabs before those of jobs, and the jobs in the order in which they are asked for; `answers.jobs` has their labels.
_TABS = {"sharing": "Sharing", "errors": "Errors"}
_JOBS = {
    "contact": "Contact and LTE",
    "relief": "Relief",
    "stiffness": "Stiffness",
    "tolerance": "Tolerance",
    "contact_loss": "Contact loss",
    "transient": "Transient",
    "sensitivity": "Sensitivity",
}


class EvidenceTabs:
    """Tabs over one pane."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._shown = "sharing"
        self._newest: dict[str, Job] = {}
        self._tabs: dict[str, Element] = {}
        self._bars: dict[str, _JobBar] = {}
        with box("ck-box ck-evidence"):
            with box("ck-tabs") as tabs:
                tabs.props["role"] = "tablist"
                for name, words in (_TABS | _JOBS).items():
                    tab = button(words, lambda name=name: self.show(name), classes="ck-tab")
                    tab.props["role"] = "tab"
                    self._tabs[name] = tab
            for name, words in _JOBS.items():
                self._bars[name] = _JobBar(self, session, name, words)
            with box("ck-grow"):
                self.pane = EvidencePane()
        self.show("sharing")

    def show(self, name: str) -> None:
        """Show the evidence of a name: a tab of the two first, or a job."""
        if name not in self._tabs:
            return
        self._shown = name
        for own, tab in self._tabs.items():
            prop(tab, "aria-selected", "true" if own == name else "false")
        for own, bar in self._bars.items():
            bar.hide(own != name)
        self.pane.evidence(name)

    def run(self, name: str) -> None:
        """Start a job of the present state, and show it."""
        self.show(name)
        try:
            self._newest[name] = self._session.jobs.start(name, {})
        except ModelError as error:
            refused(error)

    def cancel(self, name: str) -> None:
        if name in self._newest:
            self._session.jobs.cancel(self._newest[name])

    def follow(self) -> None:
        """Show the jobs as they stand, and send results that have come."""
        for name, job in self._newest.items():
            self._bars[name].follow(job, self._session.rev)
            if job.packed is not None and not getattr(self._bars[name], "sent", None) == job.id:
                self._bars[name].sent = job.id
                send(self.pane, job.packed)


class _JobBar:
    """Start, progress, end and message of one job."""

    def __init__(self, tabs: EvidenceTabs, session: Session, name: str, words: str) -> None:
        self._session, self._words = session, words
        self._job: Job | None = None
        self.sent: int | None = None
        with box("ck-job") as self._bar:
            self._bar.props["data-job"] = name
            self._run = button("Run", lambda: tabs.run(name), classes="ck-small ck-main")
            self._cancel = button("Cancel", lambda: tabs.cancel(name))
            self._progress = box("", "progress")
            self._progress.props["max"] = 1
            self._progress.props["aria-label"] = f"{words}: share done"
            self._text = Words(classes="ck-answer-text")
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
        hide(self._cancel, True)
        hide(self._progress, True)
        hide(self._apply, True)
        self.hide(True)

    def hide(self, hidden: bool) -> None:
        hide(self._bar, hidden)

    def follow(self, job: Job, rev: int) -> None:
        self._job = job
        busy = job.status in ("waits", "runs")
        hide(self._run, busy)
        hide(self._cancel, not busy)
        hide(self._progress, not busy)
        prop(self._progress, "value", round(job.progress, 3))
        self._text.say(_said(job, rev))
        prop(self._text, "role", "alert" if job.status == "failed" else None)
        result = _result(job)
        self._apply.say(str(result.get("apply_label") or "Apply"))
        hide(self._apply, not result.get("apply") or job.rev != rev)

    def _on_apply(self) -> None:
        if self._job is None:
            return
        result = _result(self._job)
        try:
            self._session.apply(result["apply"], str(result.get("apply_label") or f"apply {self._words}"))
        except ModelError as error:
            refused(error)


def _result(job: Job) -> Mapping[str, Any]:
    found = job.frame.head.get("job") if job.frame is not None else None
    return found if isinstance(found, Mapping) else {}


def _said(job: Job, rev: int) -> str:
    """One sentence of a job as it stands."""
    if job.status == "waits":
        return "waits for another job"
    if job.status == "runs":
        left = "" if job.remaining is None else f", {_time(job.remaining)} left"
        return f"{100 * job.progress:.0f} %{left}"
    if job.status != "done":
        return f"failed: {job.message}" if job.status == "failed" else "cancelled"
    old = "" if job.rev == rev else f"of state {job.rev}, now {rev}: run again. "
    return f"{old}{_result(job).get('text') or 'done'}"


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
