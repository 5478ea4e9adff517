"""All jobs of a page, the newest first, with the state each belongs to."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..processes.jobs import Job
from ..processes.session import Session
from .controls import Words, box, button, hide, prop
from .job_bar import progress_text

__all__ = ["JobsList"]


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
