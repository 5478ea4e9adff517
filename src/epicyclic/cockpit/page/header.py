"""The header: which drive, undo, comparison with A, the link of its state, what it warns of, the theme.

And what is taken away: the model, results as Datasets, figures, the report as a job of its own, a command line and a
script.
"""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Awaitable, Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

from nicegui import background_tasks, ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...errors import ConvergenceError, ModelError
from ...show.plot import figure_names
from ..computing.job_kinds import JOBS
from ..processes.jobs import Job, compared_states, figure_of, job_file, jobs_done
from ..processes.session import Session
from ..state.model_file import text_of
from ..state.state import PageState, command_line, file_name_of, fragment_of, request_of, script
from .controls import (
    Words,
    box,
    button,
    copy,
    give,
    heard,
    hide,
    icon_button,
    on_key,
    plain_button,
    prop,
    refused,
    rename,
    safe_name,
    show_model,
    window,
)
from .job_bar import TAKEN, progress_text, replayed
from .open_model import open_button, save_buttons
from .wizard import new_button

_BEFORE = "all that the model allows, in one file; some ten seconds"


def line(heading: str) -> ui.row:
    """A line of a window with its heading."""
    row = ui.row().classes("w-full items-center no-wrap")
    with row:
        ui.label(heading).classes("text-subtitle2").style("width: 7.5rem; flex: none")
    return row


class ReportJob:
    """The newest report of a page, and its controls in the window that shows it.

    anchor : element of the page that stays while windows come and go.
    """

    def __init__(self, session: Session, anchor: Element) -> None:
        self.session, self.anchor = session, anchor
        self.job: Job | None = None
        self.name = "report.html"
        self.words = _BEFORE
        self.row: ui.row | None = None
        heard(session, anchor, jobs=self._changed)

    def line(self) -> None:
        """The controls, in the present slot."""
        with line("Report") as self.row:
            self.start = plain_button("HTML report", self.begin, icon="article")
            self.bar = ui.linear_progress(0, show_value=False, size="8px").classes("col")
            self.bar.props('aria-label="Progress of the report"')
            self.label = ui.label(self.words).classes("text-caption").props('role="status"')
            self.stop = plain_button("Cancel", self.cancel)
        self._show(0.0)

    @property
    def busy(self) -> bool:
        return self.job is not None and not self.job.ended

    def begin(self) -> None:
        state = self.session.state
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
        self.words = progress_text(job, job.rev)
        if job.ended:
            self.job = None
            if job.status == "done" and job.dataset_path is not None:
                background_tasks.create(self._give(job.dataset_path))
            elif job.status == "failed":
                ui.notify(f"The report {self.words}", type="negative", close_button="Close")
        if self.row is not None and not self.row.is_deleted:
            self._show(job.progress)

    def _show(self, progress: float) -> None:
        busy = self.busy
        self.start.set_visibility(not busy)
        self.bar.set_visibility(busy)
        self.stop.set_visibility(busy)
        if busy:
            self.bar.set_value(progress)
        if self.label.text != self.words:
            self.label.set_text(self.words)

    async def _give(self, path: Path) -> None:
        content = await asyncio.to_thread(path.read_bytes)
        if not self.anchor.is_deleted:
            with self.anchor:
                give(content, self.name, "text/html")


VERBS: tuple[str, ...] = ("check", "modes", "sharing", "static", "steady", "sweep", "stiffness", "efficiency")
"""Verbs of a train alone that take seconds; longer ones are jobs, and stand in the report."""


def figures() -> dict[str, tuple[str, ...]]:
    """Verb -> names of its figures, of `VERBS`."""
    return {verb: names for verb in VERBS if (names := figure_names(verb))}


_TYPES = {
    "nc": "application/x-netcdf",
    "csv": "text/csv",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}
# [px] of a picture, as the figures of `--figure` have; raster with two dots a point
_WIDTH, _HEIGHT, _DOTS = 900, 420, 2
_CODE = "font-family: monospace; white-space: pre-wrap; overflow-wrap: anywhere; overflow: auto; max-height: 6rem"
# [s] a browser may take to draw a large figure
_DRAWN = 30.0


def take_away_button(session: Session) -> None:
    """A button with all that leaves the page; nothing is written on the machine of the server."""

    def show() -> None:
        state = session.state
        if state is None:
            return
        with window("Take away", width=720):
            _model(state)
            _results(session, state)
            _figures(session, state)
            report.line()
            _command(session, state)
            _script(state)
            if state.relative_speed != 1:
                ui.label(f"At the speed of the model: the page shows {100 * state.relative_speed:.4g} % of it.")

    report = ReportJob(session, plain_button("Take away", show, icon="download"))


def _model(state: PageState) -> None:
    async def save() -> None:
        text = await _computed(asyncio.to_thread(text_of, state))
        if text is not None:
            give(text, file_name_of(state), "application/toml")

    with line("Model"):
        plain_button("Model file (.toml)", save, icon="description")
        ui.label("with comments, and with what was set on the page").classes("text-caption")


def _results(session: Session, state: PageState) -> None:
    """Dataset of a verb, or of a job that was run of this state, in three formats."""
    done = {f"job {name}": job for name, job in jobs_done(session.jobs.visible(), session.rev).items()}
    options = {verb: verb for verb in VERBS} | {name: f"{job.label} (job)" for name, job in done.items()}
    with line("Results"):
        choice = ui.select(options, value="sharing", label="of").props("dense options-dense").style("width: 9rem")
        for kind in _TYPES:

            async def save(kind: str = kind) -> None:
                name = str(choice.value)
                job = done.get(name)
                work = session.take(kind, name) if job is None else session.call(job_file, job.dataset_path, kind)
                content = await _computed(work)
                if content is not None:
                    stem = f"{file_name_of(state, '')}-{name.removeprefix('job ')}"
                    give(content, safe_name(stem, f".{kind}"), _TYPES[kind])

            _busy(f".{kind}", save)
        ui.label("with units and the whole model; of a job once it has run").classes("text-caption")


def _figures(session: Session, state: PageState) -> None:
    """A figure of the report, drawn by the browser."""
    options = {f"{verb}/{name}": f"{verb}: {name}" for verb, names in figures().items() for name in names}
    media = {"svg": "image/svg+xml", "png": "image/png"}
    with line("Figure"):
        choice = ui.select(options, value="sweep/sweep").style("width: 14rem")
        choice.props('dense options-dense aria-label="Figure"')
        for kind in media:

            async def save(kind: str = kind) -> None:
                verb, _, name = str(choice.value).partition("/")
                figure = await _computed(session.call(figure_of, request_of(state), verb, name))
                content = None if figure is None else await _drawn(figure, kind)
                if content is not None:
                    give(content, safe_name(f"{file_name_of(state, '')}-{name}", f".{kind}"), media[kind])

            _busy(kind.upper(), save)


async def _drawn(figure: dict[str, Any], kind: str) -> bytes | None:
    """Bytes of a figure as the browser draws it, on white and of the size of the report's."""
    layout = {key: value for key, value in figure.get("layout", {}).items() if key != "updatemenus"}
    layout |= {"paper_bgcolor": "white"}
    height = int(layout.get("height") or _HEIGHT)
    with ui.element("div").style("position: fixed; left: -9999px; width: 900px") as hidden:
        plotted = ui.plotly({"data": figure.get("data", []), "layout": layout, "config": {"responsive": False}})
        options = {"format": kind, "width": _WIDTH, "height": height, "scale": _DOTS if kind == "png" else 1}
    try:
        uri = await ui.run_javascript(
            f"""const {{ Plotly }} = await import("nicegui-plotly");
            return await Plotly.toImage(getElement({plotted.id}).$el, {options!r});""",
            timeout=_DRAWN,
        )
    except TimeoutError:
        ui.notify("The browser has not drawn the figure in half a minute", type="negative")
        return None
    finally:
        hidden.delete()
    return bytes_of_picture(str(uri))


def bytes_of_picture(uri: str) -> bytes | None:
    """Content of a data URI of a picture; None where it is none."""
    head, comma, body = uri.partition(",")
    if not comma or not head.startswith("data:image/"):
        ui.notify("The browser gave no picture", type="negative")
        return None
    return base64.b64decode(body) if head.endswith(";base64") else unquote_to_bytes(body)


def _command(session: Session, state: PageState) -> None:
    """The command line of a verb, or of a job as it was run of this state, else by default; a button copies it."""
    ran = {job.name: job.options for job in jobs_done(session.jobs.visible(), session.rev).values()}
    options = {verb: verb for verb in ("report", *VERBS)}
    options |= {f"job {name}": f"{kind.label} (job)" for name, kind in JOBS.items()}

    async def change() -> None:
        job, name = str(verb.value).startswith("job "), str(verb.value).removeprefix("job ")
        if not job:
            shown.set_text(command_line(state, verb=name))
            return
        texts = await _computed(replayed(session, name, ran.get(name, {})))
        if texts is not None and not shown.is_deleted:
            shown.set_text(texts[TAKEN[0]])

    with line("Command line"):
        verb = ui.select(options, value="report", on_change=change).props('dense options-dense aria-label="verb"')
        verb.style("width: 9rem")
        # a label, since what shows code with colours goes through Markdown, and a model may hold anything
        shown = ui.label(command_line(state)).classes("col cockpit-command").style(_CODE)
        icon_button("content_copy", "Copy the command line", lambda: copy(shown.text, "Command line"))
    if state.drive is None and state.path is None:
        words = "The command and the script read the model file: download it into their folder."
        ui.label(words).classes("text-caption")


def _script(state: PageState) -> None:
    """The Python script that gives the same numbers."""
    text, name = script(state), safe_name(file_name_of(state, ""), ".py")
    with line("Python"):
        with ui.expansion("Script").classes("col").props("dense"):
            ui.label(text).classes("w-full").style(f"{_CODE}; max-height: 16rem")
        icon_button("content_copy", "Copy the script", lambda: copy(text, "Script"))
        icon_button("download", "Download the script", lambda: give(text, name, "text/x-python"))


async def _computed(work: Awaitable[Any]) -> Any:
    """The result of what a process computes; None where it cannot, which is said."""
    try:
        return await work
    except (ModelError, ConvergenceError) as error:
        refused(error)
        return None


def _busy(text: str, work: Callable[[], Awaitable[None]]) -> None:
    """A button that turns while its work is under way."""

    async def run() -> None:
        turning.props("loading")
        try:
            await work()
        finally:
            if not turning.is_deleted:
                turning.props(remove="loading")

    turning = plain_button(text, run)


# header ---------------------------------------------------------------------------------------------------------------


def compare_controls(session: Session) -> None:
    """Buttons that pin the present state as A, unpin it, and open the comparison, where both can change places."""
    with ui.row().classes("items-center no-wrap q-gutter-xs") as root:
        pin = plain_button("Pin A", session.pin, icon="push_pin")
        with pin:
            ui.tooltip("Keep this state as A: its curves stay as dashed lines")
        compare = plain_button("Compare", lambda: _show(session), icon="compare_arrows")
        unpin = plain_button("Unpin A", session.unpin)

    def show(_: object = None) -> None:
        pinned = session.pinned is not None
        pin.set_visibility(not pinned)
        pin.set_enabled(session.state is not None)
        compare.set_visibility(pinned)
        unpin.set_visibility(pinned)

    heard(session, root, state=show)
    show()


async def _show(session: Session) -> None:
    """A window with what differs, computed while it is open."""
    first, second = session.pinned, session.state
    if first is None or second is None:
        return
    with window("What differs: A is pinned, B is the present state", width=980) as dialog:
        with ui.column().classes("w-full") as outcome:
            ui.linear_progress(show_value=False).props("indeterminate").classes("w-full")
            ui.label("Both trains are computed: modes, sharing, forces.").props('role="status"')

        def swap() -> None:
            dialog.close()
            pinned = session.pinned
            if pinned is not None:  # undo takes back the change of the present state
                session.pin()
                show_model(session, pinned, ui.context.client.layout)

        def renew() -> None:
            dialog.close()
            session.pin()

        with ui.row().classes("w-full justify-end"):
            plain_button("Swap A and B", swap).tooltip("A becomes the present state; undo takes it back")
            plain_button("Pin the present state instead", renew)
            plain_button("Close", dialog.close, main=True)
    try:
        names = first.name, second.name
        difference = await session.call(compared_states, request_of(first), request_of(second), names)
    except (ModelError, ConvergenceError) as error:
        difference = error
    if outcome.is_deleted:
        return
    outcome.clear()
    with outcome:
        if isinstance(difference, Exception):
            ui.label(str(difference)).classes("text-negative").props('role="alert"')
        else:
            _table(**difference)
            if first.relative_speed != 1 or second.relative_speed != 1:
                ui.label("Both at the speed of their model, whatever speed the page shows.").classes("text-caption")


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]], lead: str, notes: Sequence[str]) -> None:
    """A table of differences, of `compared_states`."""
    ui.label(lead).classes("text-caption")
    columns = [
        {"name": f"c{i}", "label": heading, "field": f"c{i}", "align": "left" if i < 2 else "right", "sortable": i < 2}
        for i, heading in enumerate(headings)
    ]
    cells = [{"id": number, **{f"c{i}": cell for i, cell in enumerate(row)}} for number, row in enumerate(rows)]
    table = ui.table(columns=columns, rows=cells, row_key="id").classes("w-full").style("max-height: 62vh")
    table.props('dense flat wrap-cells hide-pagination virtual-scroll aria-label="Differences of model and results"')
    for note in notes:
        ui.label(note).classes("text-caption")


def undo_buttons(session: Session) -> None:
    """Two buttons, and Ctrl+Z, Ctrl+Shift+Z and Ctrl+Y where no text field has the keys."""
    undo = icon_button("undo", "Undo", session.undo)
    redo = icon_button("redo", "Redo", session.redo)

    def show(_: object = None) -> None:
        labels = (session.history.undo_label, session.history.redo_label)
        for word, control, label in zip(("Undo", "Redo"), (undo, redo), labels, strict=True):
            control.set_enabled(bool(label))
            rename(control, f"{word}: {label}" if label else word, "" if label else f"Nothing to {word.lower()}")

    on_key("z", session.undo)
    on_key("z", session.redo, shift=True)
    on_key("y", session.redo)
    heard(session, undo, state=show)
    show()


# Characters that mail programs and chats leave whole; browsers take more.
_SURE = 8000
# [s] a browser may take to say its address and to copy
_ANSWER = 5.0


def link_button(session: Session) -> None:
    """A button that copies a link to the present state."""

    async def make() -> None:
        state = session.state
        if state is None:
            return
        try:
            fragment = fragment_of(state)
        except ModelError as error:
            return refused(error, "No link: download the model instead. ")
        script = f"""
            const link = location.origin + "/#" + {fragment!r};
            try {{ await navigator.clipboard.writeText(link); return [link.length, true]; }}
            catch {{ window.prompt("Copy this link", link); return [link.length, false]; }}
        """
        answer = await ui.run_javascript(script, timeout=_ANSWER)
        length, copied = answer if isinstance(answer, list) and len(answer) == 2 else (len(fragment), False)
        words = f"Link {'copied' if copied else 'made'}, {length} characters"
        if length > _SURE:
            ui.notify(f"{words}: some mail programs and chats cut it. The model as a file is safer.", type="warning")
        else:
            ui.notify(f"{words}. It holds the whole model.", type="positive")

    icon_button("link", "Copy a link to this state", make)


class ThemeButton(Element, component="theme_button.js"):
    """A button that goes through the themes; the browser keeps the choice."""


class Header:
    """Controls over the whole page.  open_model, new_train : open these windows from another place of the page."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._told: list[tuple[str, str]] | None = None
        self._title = ""
        with box("ck-head", "header"):
            self._name = Words("h1", "Cockpit", classes="ck-name", data_testid="name")
            self._edited = Words(text="edited", classes="ck-edited", data_testid="edited")
            self.open_model = open_button(session)
            self.new_train = new_button(session)
            self._of_model = [box("ck-head-part"), box("ck-head-part ck-head-end")]
            with self._of_model[0]:
                box("ck-split")
                undo_buttons(session)
                save_buttons(session)
                box("ck-split")
                with ui.button().props("flat dense no-caps").classes("ck-warnings") as self._warnings:
                    self._list = ui.menu().classes("ck-wide")
                words = "Load case that is computed"
                self._case = box("ck-select", "select", aria_label="Load case", title=words)
                self._case.on("change", self._choose, js_handler="(e) => emit(e.target.value)")
                self._facts = Words(classes="ck-facts")
                self._speed = button("", lambda: session.operate_at(1.0), classes="ck-small ck-main")
            with self._of_model[1]:
                compare_controls(session)
                link_button(session)
                take_away_button(session)
            ThemeButton()
        self._cases: tuple[str, tuple[str, ...]] = "", ()
        for part in (self._warnings, self._speed, self._case):
            hide(part, True)

    def follow(self) -> None:
        """Show the name of the state and whether it is saved; without a model, only the ways to one."""
        state = self._session.state
        for part in self._of_model:
            hide(part, state is None)
        hide(self._edited, state is None or not self._session.unsaved)
        if state is None:
            self._say("Cockpit", "epicyclic")
            return
        self._say(state.name, f"{state.name} · epicyclic")
        saved = " (edited, not saved)" if self._session.unsaved else ""
        prop(self._name, "title", f"{state.path or state.name}{saved}")
        relative = self._session.relative_speed
        hide(self._speed, relative == 1.0)
        self._speed.say(f"at {100 * relative:.3g} % speed: back to 100 %")

    def _choose(self, event: GenericEventArguments) -> None:
        name = str(event.args)
        self._session.apply({"case": name or None}, f"case {name}" if name else "nominal operation")

    def _show_cases(self, case: str, cases: tuple[str, ...]) -> None:
        """The load cases of the model to choose from, the one that is computed chosen."""
        if (case, cases) == self._cases:
            return
        self._cases = case, cases
        hide(self._case, not cases)
        self._case.clear()
        with self._case:
            for name in ("", *cases):
                Words("option", name or "nominal operation", value=name, selected=name == case)

    def _say(self, name: str, title: str) -> None:
        self._name.say(name)
        if title != self._title:
            self._title = title
            ui.page_title(title)

    def frame(self, head: Mapping[str, Any]) -> None:
        """Show facts and warnings of a frame that brings them."""
        state = head.get("state")
        if isinstance(state, Mapping):  # ratio, speeds and torques in one line
            facts = [] if state.get("ratio") is None else [f"ratio {float(state['ratio']):.4g}"]
            for member, value, unit in [*(state.get("speeds") or ()), *(state.get("torques") or ())]:
                if value:
                    facts.append(f"{member} {float(value):.4g} {unit}")
            self._show_cases(str(state.get("case", "")), tuple(state.get("cases") or ()))
            self._facts.say(" · ".join(facts))
            prop(self._facts, "title", self._facts.text)
        checks = [(str(check.get("level")), str(check["text"])) for check in head.get("checks", ())]
        if "checks" not in head or checks == self._told:
            return
        self._told = checks
        hide(self._warnings, not checks)
        self._warnings.set_text(f"{len(checks)} warning{'s' * (len(checks) != 1)}")
        self._list.clear()
        with self._list:
            for level, text in checks:
                with box("ck-warning"):
                    mark, meaning = ("✗", "fails") if level == "bad" else ("!", "look at")
                    Words(text=mark, classes=f"ck-mark {level}", role="img", aria_label=meaning)
                    Words(text=text)
