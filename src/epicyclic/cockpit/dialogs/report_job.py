"""The HTML report as a job: it goes on while the window is closed, and is downloaded when it is done."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from nicegui import background_tasks, ui
from nicegui.element import Element

from ...errors import ModelError
from ..state.replay import file_name_of
from .parts import give, heard, plain_button, present, refused, safe_name

if TYPE_CHECKING:
    from ..processes.jobs import Job
    from ..processes.session import Session

__all__ = ["ReportJob", "line"]

_BEFORE = "all that the model allows, in one file; some ten seconds"


def line(heading: str) -> ui.row:
    """A line of a window with its heading."""
    row = ui.row().classes("w-full items-center no-wrap")
    with row:
        ui.label(heading).classes("text-subtitle2").style("width: 7.5rem; flex: none")
    return row


class ReportJob:
    """The newest report of a page.

    anchor : element of the page that stays while windows come and go.
    """

    def __init__(self, session: Session, anchor: Element) -> None:
        self.session, self.anchor = session, anchor
        self.job: Job | None = None
        self.name = "report.html"
        self.words = _BEFORE
        self._shown: _Line | None = None
        heard(session, anchor, jobs=self._changed)

    def line(self) -> None:
        """The controls, in the present slot."""
        self._shown = _Line(self)
        self._shown.show()

    @property
    def busy(self) -> bool:
        return self.job is not None and self.job.status in ("waits", "runs")

    def begin(self) -> None:
        state = present(self.session)
        if state is None or self.busy:
            return
        self.name = safe_name(file_name_of(state, ""), "-report.html")
        try:
            self.job = self.session.jobs.start("html", {})
        except ModelError as error:
            return refused(error)
        self._changed()

    def cancel(self) -> None:
        if self.job is not None:
            self.session.jobs.cancel(self.job)

    def _changed(self, _: object = None) -> None:
        job = self.job
        if job is None:
            return
        if self.busy:
            left = f", {job.remaining:.0f} s left" if job.remaining is not None else ""
            self.words = f"{job.progress:.0%}{left}" if job.status == "runs" else "waits for another job"
        else:
            self.job = None
            self.words = f"failed: {job.message}" if job.status == "failed" else job.status
            if job.status == "done" and job.dataset_path is not None:
                background_tasks.create(self._give(job))
            elif job.status == "failed":
                ui.notify(f"The report {self.words}", type="negative", close_button="Close")
        if self._shown is not None and not self._shown.row.is_deleted:
            self._shown.show(0.0 if job is None else job.progress)

    async def _give(self, job: Job) -> None:
        assert job.dataset_path is not None
        content = await asyncio.to_thread(job.dataset_path.read_bytes)
        if not self.anchor.is_deleted:
            with self.anchor:
                give(content, self.name, "text/html")


class _Line:
    """Controls of the report in a window."""

    def __init__(self, report: ReportJob) -> None:
        self.report = report
        with line("Report") as self.row:
            self.start = plain_button("HTML report", report.begin, icon="article")
            self.bar = ui.linear_progress(0, show_value=False, size="8px").classes("col")
            self.bar.props('aria-label="Progress of the report"')
            self.words = ui.label(report.words).classes("text-caption").props('role="status"')
            self.cancel = plain_button("Cancel", report.cancel)

    def show(self, progress: float = 0.0) -> None:
        busy = self.report.busy
        self.start.set_visibility(not busy)
        self.bar.set_visibility(busy)
        self.cancel.set_visibility(busy)
        if busy:
            self.bar.set_value(progress)
        if self.words.text != self.report.words:
            self.words.set_text(self.report.words)
