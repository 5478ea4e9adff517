"""The evidence: load sharing, errors, the modes as a list, and one tab for each job."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui.element import Element

from ...errors import ModelError
from ..canvas.element import EvidencePane, send
from ..dialogs.parts import refused
from ..processes.jobs import Job, newest_of
from ..processes.session import Session
from .controls import Words, box, button, hide, prop
from .job_bar import JobBar, JobsList


class ModesList:
    """Rows of natural frequencies.  choose : called with the index of a mode, None where it is left."""

    def __init__(self, choose: Callable[[int | None], None]) -> None:
        self._choose = choose
        self._rows: list[_Row] = []
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
                self._rows.append(_Row(self._on_row))
        for row, mode in zip(self._rows, modes, strict=False):
            row.follow(mode, self._chosen_index)
        for row in self._rows[len(modes) :]:
            row.end()

    def chosen(self, index: int | None) -> None:
        """Mark the mode that another pane has chosen."""
        self._chosen_index = index
        for row in self._rows:
            row.press(index)

    def _on_row(self, index: int) -> None:
        index_or_none = None if index == self._chosen_index else index
        self.chosen(index_or_none)
        self._choose(index_or_none)


class _Row:
    def __init__(self, click: Callable[[int], None]) -> None:
        self._index = -1
        self._row = box("ck-mode", "button").on("click", lambda _: click(self._index))
        self._row.props["type"] = "button"
        with self._row:
            self._number = Words("small")
            self._frequency, self._label, self._met = Words("b"), Words(), Words("i")

    def follow(self, mode: Mapping[str, Any], chosen: int | None) -> None:
        self._index = int(mode["index"])
        prop(self._row, "data-mode", str(self._index))
        self._number.say(str(self._index))
        self._frequency.say(f"{float(mode['frequency']):.4g}")
        self._label.say(str(mode["label"]))
        prop(self._row, "title", f"{mode['label']}{': met by ' + str(mode['met_by']) if mode.get('met_by') else ''}")
        self._met.say(str(mode.get("met_by") or "").replace(" mesh order", " order"))
        self.press(chosen)
        hide(self._row, False)

    def press(self, chosen: int | None) -> None:
        prop(self._row, "aria-pressed", "true" if chosen == self._index else "false")

    def end(self) -> None:
        hide(self._row, True)


# The tabs before those of jobs, and the jobs in the order in which they are asked for.
_TABS = {"sharing": "Sharing", "errors": "Errors"}
_JOBS = {
    "contact": "Contact, LTE",
    "relief": "Relief",
    "stiffness": "Stiffness",
    "tolerance": "Tolerance",
    "contact_loss": "Contact loss",
    "transient": "Transient",
    "sensitivity": "Sensitivity",
}
# What a tab is for, beside the pointer.
_WHY = {
    "sharing": "Load of each mesh per fair share, at rest and over the hunting period",
    "errors": "What each deviation costs in load sharing",
    "contact": "Load over the flanks and loaded transmission error",
    "relief": "Tip relief for the least transmission error",
    "stiffness": "Mesh stiffness over a mesh cycle, and the phases of the meshes",
    "tolerance": "Load sharing within the tolerances, and the share of each",
    "contact_loss": "Sweep in which teeth may part",
    "transient": "Run in time, as the model's scenario or at its speed",
    "sensitivity": "What the natural frequencies depend on",
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
                for name, words in (_TABS | _JOBS | {_LIST: "Jobs"}).items():
                    self._tabs[name] = self._tab(name, words)
            for name, words in _JOBS.items():
                self._bars[name] = JobBar(session, name, words, run=self.run, cancel=self.cancel)
            with box("ck-grow") as self._place:
                self.pane = EvidencePane()
            self._list = JobsList(session, show=self.show)
        self.show("sharing")

    def _tab(self, name: str, words: str) -> Words:
        tab = button(words, lambda: self.show(name), classes="ck-tab")
        tab.props.update({"role": "tab", "title": _WHY.get(name, "All jobs of this page")})
        return tab

    def show(self, name: str) -> None:
        """Show the evidence of a name: a tab of the first two, a job, or the list of jobs."""
        if name not in self._tabs:
            return
        for own, tab in self._tabs.items():
            prop(tab, "aria-selected", "true" if own == name else "false")
            prop(tab, "tabindex", "0" if own == name else "-1")
        for own, bar in self._bars.items():
            bar.hide(own != name)
        hide(self._place, name == _LIST)
        self._list.hide(name != _LIST)
        if name != _LIST:
            self.pane.evidence(name)

    def run(self, name: str) -> None:
        """Start a job of the present state, and show it."""
        self.show(name)
        before = self.newest.get(name)
        if before is not None and not before.ended:
            return
        try:
            self._session.jobs.start(name, self._bars[name].options)
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
                send(self.pane, job.packed)
            prop(self._tabs[name], "data-busy", "true" if job is not None and not job.ended else None)
        self._list.follow(self.newest)
