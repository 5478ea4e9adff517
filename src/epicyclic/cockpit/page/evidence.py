"""The evidence: load sharing, errors, the modes as a list, a tab for each job with its options, a list of all jobs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...errors import ModelError
from ..answers.jobs import JOBS
from ..canvas.element import EvidencePane, send
from ..dialogs.controls import Words, box, button, hide, prop, refused
from ..processes.jobs import Job, newest_of
from ..processes.session import Session

OPTIONS: Mapping[str, tuple[str, Mapping[str, Mapping[str, int | float | str]]]] = {
    "contact": ("Show", {"transmission error": {}, "load along the face": {"show": "load"}}),
    # three times the candidates and generations: two optima of nearly the same error are told apart
    "relief": ("Search", {"quick": {}, "thorough": {"population": 36, "generations": 24}}),
    "tolerance": ("Trains", {"16 384": {}, "131 072": {"samples": 131_072}}),
    "contact_loss": ("Speeds", {"60": {}, "200": {"points": 200}, "60 with shaft orders": {"shaft_orders": True}}),
    "transient": ("Mesh cycles", {"50": {}, "300": {"cycles": 300.0}}),
    "sensitivity": ("Of", {"lowest frequency": {}, "mesh force": {"of": "force"}}),
}
"""Job -> name of its list of choices, and the options that each means; a job that is missing has nothing to choose."""


# Steps of the progress that are worth a message: a bar has no more pixels.
_STEPS = 200


class JobBar:
    """One job of a name.  run, cancel : called with the name."""

    def __init__(
        self, session: Session, name: str, words: str, *, run: Callable[[str], None], cancel: Callable[[str], None]
    ) -> None:
        self._session, self._name, self._words = session, name, words
        self._job: Job | None = None
        kind = JOBS[name]
        self._before = f"{kind.about} From {_time(kind.seconds)}, by the size of the train."
        list_label, choices = OPTIONS.get(name, ("", {}))
        self._options = list(choices.values())
        self._chosen = 0
        with box("ck-job") as self._bar:
            self._bar.props["data-job"] = name
            self._run = button("Run", lambda: run(name), classes="ck-small ck-main")
            self._cancel = button("Cancel", lambda: cancel(name))
            with box("ck-choice", "label") as self._choices:
                Words(text=list_label, classes="ck-pale")
                with box("ck-select", "select") as select:
                    select.props["aria-label"] = list_label
                    for number, label in enumerate(choices):
                        Words("option", label).props["value"] = str(number)
                select.on("change", self._choose, js_handler="(e) => emit(Number(e.target.value))")
            self._progress = box("", "progress")
            self._progress.props.update({"max": 1, "aria-label": f"{words}: share done"})
            self._text = Words(classes="ck-answer-text", text=self._before)
            self._text.props["title"] = self._before
            self._apply = button("Apply", self._on_apply, classes="ck-small ck-main")
        hide(self._choices, not choices)
        for control in (self._cancel, self._progress, self._apply):
            hide(control, True)
        self.hide(True)

    def hide(self, hidden: bool) -> None:
        hide(self._bar, hidden)

    @property
    def options(self) -> Mapping[str, Any]:
        """What is chosen of the job."""
        return self._options[self._chosen] if self._options else {}

    def _choose(self, event: GenericEventArguments) -> None:
        if isinstance(event.args, int) and 0 <= event.args < len(self._options):
            self._chosen = event.args

    def follow(self, job: Job | None) -> None:
        """Show a job as it stands beside the present state; None: none that says anything of it."""
        if job is None and self._job is None:
            return
        self._job = job
        rev = self._session.rev
        runs = job is not None and not job.ended
        for control, hidden in ((self._run, runs), (self._cancel, not runs), (self._progress, not runs)):
            hide(control, hidden)
        hide(self._choices, runs or not self._options)
        self._text.say(self._before if job is None else progress_text(job, rev))
        prop(self._text, "title", self._text.text)
        prop(self._text, "role", "alert" if job is not None and job.status == "failed" else None)
        prop(self._bar, "data-stale", "true" if job is not None and job.ended and job.rev != rev else None)
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
        return f"failed: {job.message}" if job.status == "failed" else "cancelled"
    return f"{'' if job.rev == rev else 'of another state: run again. '}{result_of(job).get('text') or 'done'}"


def _time(seconds: float) -> str:
    return f"{max(seconds, 1):.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


class JobsList:
    """Rows of jobs.  show : called with the name of a job whose result is to be shown."""

    def __init__(self, session: Session, *, show: Callable[[str], None]) -> None:
        self._session, self._show = session, show
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
                self._rows.append(_JobRow(self._session, self._show))
        for row, job in zip(self._rows, jobs, strict=False):
            row.follow(job, self._session.rev, shown=newest.get(job.name) is job)
        for row in self._rows[len(jobs) :]:
            row.end()


class _JobRow:
    """One job."""

    def __init__(self, session: Session, show: Callable[[str], None]) -> None:
        self._session = session
        self._job: Job | None = None
        with box("ck-job-row") as self._row:
            self._name = Words("b")
            self._state = Words(classes="ck-pale")
            self._text = Words(classes="ck-answer-text")
            self._cancel = button("Cancel", lambda: session.jobs.cancel(self._job) if self._job else None)
            self._open = button("Show", lambda: show(self._job.name) if self._job else None)

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


class _ModeRow:
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


# Words of the tabs before those of jobs, and of jobs in the order in which they are asked for; what each is for, beside
# the pointer.
_TABS = {
    "sharing": ("Sharing", "Load of each mesh per fair share, at rest and over the hunting period"),
    "errors": ("Errors", "What each deviation costs in load sharing"),
}
_JOBS = {
    "contact": ("Contact, LTE", "Load over the flanks and loaded transmission error"),
    "relief": ("Relief", "Tip relief for the least transmission error"),
    "stiffness": ("Stiffness", "Mesh stiffness over a mesh cycle, and the phases of the meshes"),
    "tolerance": ("Tolerance", "Load sharing within the tolerances, and the share of each"),
    "contact_loss": ("Contact loss", "Sweep in which teeth may part"),
    "transient": ("Transient", "Run in time, as the model's scenario or at its speed"),
    "sensitivity": ("Sensitivity", "What the natural frequencies depend on"),
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
                for name, (words, purpose) in (_TABS | _JOBS | {_LIST: ("Jobs", "All jobs of this page")}).items():
                    tab = button(words, partial(self.show, name), classes="ck-tab")
                    tab.props.update({"role": "tab", "title": purpose})
                    self._tabs[name] = tab
            for name, (words, _) in _JOBS.items():
                self._bars[name] = JobBar(session, name, words, run=self.run, cancel=self.cancel)
            with box("ck-grow") as self._drawn:
                self.pane = EvidencePane()
            self._list = JobsList(session, show=self.show)
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
