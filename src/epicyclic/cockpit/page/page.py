"""The whole page of a session: its levers, the page without a model, and what each part hears.

A lever is a slider and a number box over a value of the model, or over one entry of a list.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from ...document.document import drive_titles
from ...document.units import KINDS, Written, factor, is_unit_of, split_list, written
from ...errors import ModelError
from ..processes.session import Session
from ..state.frames import QUESTIONS, FollowedMode, PageFrame
from ..state.model_file import assumed_reason, file_value, overriding, written_value
from ..state.state import PageState, opened
from .controls import Board, Words, box, button, fold, heard, hide, prop, refused, sentence, show_model
from .evidence import AnswersPane, EvidenceTabs, ModesList
from .file_panels import FieldsPanel, TextPanel
from .header import Header

# levers ---------------------------------------------------------------------------------------------------------------


def number_in(value: object, unit: str) -> float | None:
    """One number as written, in a unit; None of what is none, or has another dimension.  A bare one is SI."""
    number = written(value)
    if number is None or number.many:
        return None
    (size,) = number.values
    if number.unit != unit and (size or number.unit):
        si = next((kind.unit for name, kind in KINDS.items() if is_unit_of(unit, name)), "")
        scale = factor(number.unit or si, unit) if unit else None
        size = math.nan if scale is None else float(f"{size * scale:.12g}")
    return size if math.isfinite(size) else None


def entries_of(value: object, unit: str, count: int) -> tuple[float, ...] | None:
    """The `count` entries of a list as written, in a unit; None of what is no such list.

    One number stands for every entry, a value that is missing for zeros.
    """
    items, shared = split_list(value)
    behind = "" if shared in ("", "SI") else f" {shared}"  # the unit that the entries of a text share
    one = [0.0 if value is None else value] * count
    numbers = [number_in(f"{item}{behind}" if behind else item, unit) for item in (one if items is None else items)]
    known = tuple(number for number in numbers if number is not None)
    return known if len(known) == len(numbers) == count else None


def with_entry(entries: tuple[float, ...], unit: str, entry: int, number: float) -> object:
    """Override of a list in a unit, with one of its entries, from 0, another number."""
    values = (*entries[:entry], number, *entries[entry + 1 :])
    return Written(values=values, unit=unit, many=True).text(values)


# Positions of a slider whose lever states no step.
_POSITIONS = 200
# Digits with which a value is written into the model: as many as the box shows, and as many as were typed.
_DIGITS, _TYPED = 6, 15


class LeverControl(Element, component="lever.js"):
    """A lever of a session.

    lever : as the session gives it: path, label, value, unit, least, most, step, log, why, entry, count.
    """

    def __init__(self, session: Session, lever: Mapping[str, Any]) -> None:
        super().__init__()
        self._session, self.path = session, str(lever["path"])
        self._unit = str(lever.get("unit") or "")
        self._value, self._drags, self._shows = float(lever["value"]), 0, 0
        self._asked: PageState | None = None  # the state that this lever has made last
        self._entry, self._count = lever.get("entry"), int(lever.get("count") or 0)
        self._seen: object = None
        least, most = float(lever["least"]), float(lever["most"])
        # what holds where the model states nothing: it came with the lever, unless an override was there already
        state = session.state
        overridden = state is not None and overriding(state, self.path) is not None
        self._unstated = least if overridden else self._value
        self._props.update(
            path=self.path,
            label=str(lever["label"]),
            unit=self._unit,
            why=f"{lever.get('why') or lever['label']} ({self.path})",
            least=least,
            most=most,
            step=float(lever.get("step") or 0.0) or (most - least) / _POSITIONS,
            log=bool(lever.get("log")) and least > 0,
            changed=False,
            assumed="",
            message="",
            shown=[0, self._value],
        )
        self.on("move", lambda event: self._moved(event, released=False))
        self.on("release", lambda event: self._moved(event, released=True))
        self.on("typed", lambda event: self._typed(str(event.args)))
        self.on("reset", lambda _: self._to_file())
        self.on("restore", lambda _: self._take_back())

    def follow(self) -> None:
        """Show the value of the present state, unless it is the one that this lever has asked for."""
        state = self._session.state
        if state is None or state is self._seen:
            return
        self._seen = state
        stated = written_value(state, self.path)
        prop(self, "changed", not self._is_of_file(state, stated))
        number = self._unstated if stated is None else self._read(stated)
        if number is None or math.isclose(number, self._value, rel_tol=1e-9, abs_tol=1e-300):
            return
        self._value, self._shows = number, self._shows + 1
        prop(self, "shown", [self._shows, number])

    def assume(self, assumed: Mapping[str, str]) -> None:
        """Mark a value that the model assumes.  assumed : its reasons, by full path."""
        state = self._session.state
        prop(self, "assumed", "" if state is None else assumed_reason(state, self.path, assumed))

    def refuse(self, failed: Mapping[str, Any] | None, whose: str) -> bool:
        """Show the message of a failed state that is about this lever; whether it is.  whose : of the figures."""
        if failed is None or str(failed.get("path")) != self.path:
            self._tell("")
            return False
        words = sentence(str(failed.get("message") or ""), str(failed.get("allowed") or ""))
        self._tell(". ".join(filter(None, [words, whose])))
        return True

    def _moved(self, event: GenericEventArguments, *, released: bool) -> None:
        value = event.args
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return
        self._value = float(value)
        self._ask(lambda: self._written(self._value), released=released)
        self._drags += released

    def _typed(self, text: str) -> None:
        """Take a number in the unit of the lever, or a value with a unit of its own; nothing is the file's value."""
        self._tell("")  # what was refused before
        if not text:
            self._to_file()
            return
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if self._entry is not None and not math.isfinite(number):
            own = number_in(text, self._unit)
            if own is None:
                problem = "a list, and the lever has one entry of it" if "[" in text else "no number with a known unit"
                self._tell(sentence(problem, f"one number, as 40 {self._unit}; the list under All fields"))
                return
            number = own
        self._value = math.nan  # whatever the model then has is shown, at the slider too
        self._ask(lambda: self._written(number, typed=True) if math.isfinite(number) else text, released=True)
        self._drags += 1

    def _read(self, stated: object) -> float | None:
        """The number of this lever in a value of the model, of a list its own entry."""
        if self._entry is None:
            return number_in(stated, self._unit)
        entries = entries_of(stated, self._unit, self._count)
        return None if entries is None else entries[self._entry]

    def _is_of_file(self, state: PageState, stated: object) -> bool:
        """Whether the value is that of the file, of a list its own entry."""
        if self._entry is None:
            return overriding(state, self.path) is None
        return self._read(stated) == self._read(file_value(state, self.path))

    def _written(self, value: float, *, typed: bool = False) -> object:
        """A value as the model file writes it. Raises ModelError where the other entries of its list are not known."""
        text = f"{value:.{_DIGITS}g}"
        if typed and float(text) != value:
            text = f"{value:.{_TYPED}g}"
        if self._entry is None:
            return f"{text} {self._unit}" if self._unit else float(text)
        state = self._session.state
        entries = entries_of(None if state is None else written_value(state, self.path), self._unit, self._count)
        if entries is None:
            raise ModelError(
                "its list cannot be read", path=self.path, allowed=f"{self._count} numbers, under All fields"
            )
        return with_entry(entries, self._unit, self._entry, float(text))

    def _ask(self, value: Callable[[], object], *, released: bool) -> None:
        try:
            self._session.set(self.path, value(), released=released, key=f"{self.path} {self._drags}")
        except ModelError as error:
            self._tell(sentence(error.problem, error.allowed))
        else:
            self._asked = self._session.state
            if self._session.failed is None:
                self._tell("")

    def _take_back(self) -> None:
        """Undo a value that was refused, where nothing has changed since; what was no value is forgotten."""
        state = self._session.state
        if self._session.failed is not None and state is not None and state is self._asked:
            self._session.undo()
        self._tell("")

    def _to_file(self) -> None:
        """Take the value of the file, of a list that of its own entry."""
        state = self._session.state
        if state is None:
            return
        self._value = math.nan
        value = file_value(state, self.path)

        def asked() -> object:
            of_file = self._read(value)
            if self._entry is None or of_file is None:
                return value
            again = self._written(of_file, typed=True)
            same = entries_of(again, self._unit, self._count) == entries_of(value, self._unit, self._count)
            return value if same else again

        self._ask(asked, released=True)

    def _tell(self, text: str) -> None:
        prop(self, "message", text)


class LeversColumn:
    """The levers of a session; built anew when another model brings other levers."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._shown: object = None  # levers and words that stand on the page
        self._levers: list[LeverControl] = []
        self._assumed: Mapping[str, str] = {}
        with box("ck-box ck-levers", "section", aria_label="Levers"):
            with box("ck-title"):
                Words("h2", "Levers")
            self._list = box("ck-lever-list")
            fold("All fields", lambda: FieldsPanel(session)).classes("ck-fold")
            fold("Model text (TOML)", lambda: TextPanel(session)).classes("ck-fold")

    def follow(self) -> None:
        """Show the values of the present state, and the levers of the present model."""
        session = self._session
        instead = ""  # what stands in the place of levers that are not there
        if session.state is not None and not session.levers:
            fails = session.failed is not None
            instead = "Levers come as soon as the model computes." if fails else "Choosing levers ..."
        if (session.levers, instead) != self._shown:
            self._shown = session.levers, instead
            self._list.clear()
            with self._list:
                self._levers = [LeverControl(session, lever) for lever in session.levers]
                if instead:
                    Words("div", instead, classes="ck-lever ck-pale")
        for lever in self._levers:
            lever.follow()
            lever.assume(self._assumed)

    def frame(self, head: Mapping[str, Any]) -> None:
        """Mark what the model of a frame assumes."""
        self._assumed = head.get("assumed", self._assumed)
        for lever in self._levers:
            lever.assume(self._assumed)

    def refuse(self, failed: Mapping[str, Any] | None, whose: str) -> bool:
        """Show a message beside the lever it is about; whether there is one.  whose : of the figures."""
        return any([lever.refuse(failed, whose) for lever in self._levers])


# page -----------------------------------------------------------------------------------------------------------------


def empty_page(session: Session, header: Header) -> Element:
    """Open a file, begin a train, or take a ready drive."""
    with box("ck-box ck-empty-page", "section", aria_label="No model is open") as root:
        Words("h2", "Which gear train?", classes="ck-large")
        with box("ck-ways"):
            for name, words, way in (
                ("New train", "from teeth or a ratio, power and speed; one page", header.new_train),
                ("Open a model", "a .toml or REXS file; dropping it on the page does as well", header.open_model),
            ):
                with button("", way, classes="ck-drive ck-way"):
                    Words("b", name)
                    Words(text=words)
        Words("div", "A ready drive, to look at and to change", classes="ck-pale")
        with box("ck-drives", data_keys="go"):
            for name, title in drive_titles().items():

                async def show(name: str = name) -> None:
                    show_model(session, await asyncio.to_thread(opened, name), root)

                with button("", show, classes="ck-drive"):
                    Words("b", name)
                    Words(text=title)
    return root


# [s] after which curves of the state before are drawn as such; a newer one is there sooner with nearly every train.
_LATE = 0.4
# [s] by which words follow the curves: the browser builds the whole page anew for a word, which keeps it from drawing.
_WORDS_AFTER = 0.03


def cockpit_page(session: Session) -> None:
    """Build the page of a session in the present slot; it follows the session until it is deleted."""
    ui.add_css(_file("page.css"))
    ui.add_head_html(f"<script>{_file('page.js')}</script>")
    with box("ck-page", "main") as root:
        page = _Page(session, root)
    heard(
        session,
        root,
        early=page.early,
        frame=page.frame,
        state=page.follow,
        failed=page.refuse,
        jobs=page.jobs,
        preview=page.preview,
        view=page.view,
        waits=lambda _: ui.notify("Waits for another job of this page or of another tab"),
    )
    page.follow(session)


@cache
def _file(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


class _Page:
    """The parts of the page, and what each hears."""

    def __init__(self, session: Session, root: Element) -> None:
        self._session, self._root = session, root
        self._pinned: dict[str, bytes] = {}
        self._shown_rev = 0
        self._previewed: Mapping[str, Any] | None = None
        self._previewed_rev = 0
        self._timer: asyncio.TimerHandle | None = None
        self._late = False
        self._head: dict[str, Any] = {}
        self._header = Header(session)
        with box("ck-banner", role="alert") as self._banner:
            Words(text="✗", classes="ck-mark bad")
            self._message = Words(classes="ck-answer-text")
            self._undo = button("Undo", session.undo)
        self._levers = LeversColumn(session)
        self._answers = AnswersPane(
            session,
            show=self._show,
            run=lambda name: self._evidence.run(name),
            cancel=lambda name: self._evidence.cancel(name),
            preview=self._preview,
        )
        with box("ck-box ck-train", "section", aria_label="Train"), box("ck-grow"):
            self._train = Board("train")
        with box("ck-box ck-sweep", "section", aria_label="Sweep"), box("ck-grow"):
            self._sweep = Board("sweep")
        self._mode, self._modes = FollowedMode(), ModesList(self._chose)
        self._evidence = EvidenceTabs(session)
        self._empty: Element | None = None
        self._sweep.on_speed(session.operate_at)
        for pane in (self._train, self._sweep):
            pane.on_mode(self._chose)
        hide(self._banner, True)

    def _show(self, name: str, mode: int | None) -> None:
        """Show what an answer rests on: a mode where it is about one, with its peaks of the curve, else a tab."""
        if mode is not None:
            self._chose(mode)
        self._evidence.show(name)

    def _preview(self, change: Mapping[str, Any] | None) -> None:
        """Show beside the curves what a change would give, its speed at once and its curves when they are computed."""
        self._previewed = change
        self._previewed_rev = self._session.rev
        self._sweep.preview(self._previewed)
        try:
            self._session.preview(None if change is None else change["apply"])
        except ModelError as error:
            refused(error)

    def preview(self, packed: bytes) -> None:
        """Show the curves of the change that the pointer is on."""
        self._sweep.preview(self._previewed, packed)

    def _chose(self, index: int | None) -> None:
        """A mode was chosen: the drawing moves, the list marks it."""
        self._mode.choose(index)
        self._modes.chosen(index)
        self._train.tell("mode", index)
        self._session.looked(mode=index)

    def view(self, session: Session) -> None:
        """Show what another page of the session did: its evidence, its mode."""
        view = dict(session.view)
        self._evidence.show(str(view.get("tab")))
        mode = view.get("mode")
        self._chose(mode if isinstance(mode, int) and not isinstance(mode, bool) else None)

    def early(self, packed: bytes) -> None:
        """Show what comes ahead of a frame."""
        self._train.early(packed)

    def frame(self, packed: bytes, frame: PageFrame) -> None:
        """Show a frame; the panes first, since they are what moves under a lever."""
        if self._mode.take(frame):
            self._train.frame(packed, self._mode.number)  # in one message: no picture shows another mode
            self._train.tell("mode", self._mode.number)
        else:
            self._train.frame(packed)
        self._shown_rev = max(self._shown_rev, frame.rev)
        self._draw_late(False)
        if not self._head:
            asyncio.get_running_loop().call_later(_WORDS_AFTER, self._show_words)
        self._head |= frame.head

    def _show_words(self) -> None:
        """Show what the frames say that came meanwhile."""
        head, self._head = self._head, {}
        if self._root.is_deleted:
            return
        session = self._session
        with self._root:
            self._answers.follow(head, moving=session.rev != session.released_rev)
            self._header.frame(head)
            self._modes.follow(head)
            self._modes.chosen(self._mode.number, self._mode.lost)
            self._evidence.sized(head)
            self._levers.frame(head)
            self._show_busy()

    def follow(self, session: Session) -> None:
        """Show a state that has changed."""
        if self._previewed is not None and session.rev != self._previewed_rev:
            self._preview(None)
        self._header.follow()
        self._levers.follow()
        self._show_busy()
        if self._shown_rev and self._timer is None:
            self._watch()
        # the ways to a model, where there is none; they are built when they are first seen
        is_empty = session.rev > 0 and session.state is None
        if is_empty and self._empty is None:
            with self._root:
                self._empty = empty_page(session, self._header)
        if self._empty is not None:
            hide(self._empty, not is_empty)
        prop(self._root, "data-empty", "true" if is_empty else None)
        prop(self._root, "data-starting", None if session.rev > 0 else "true")
        if session.pinned_packed != self._pinned:  # A is drawn dashed; its frames may come one after another
            self._pinned = dict(session.pinned_packed)
            self._train.ghost(None)
            for packed in self._pinned.values():
                self._train.ghost(packed)
        self.jobs(session)

    def _watch(self) -> None:
        """Look after a while whether the present state, or a newer one, is shown."""
        rev, session = self._session.rev, self._session
        if self._shown_rev == rev or session.failed is not None:
            return

        def look() -> None:
            self._timer = None
            if self._root.is_deleted:
                return
            if self._shown_rev < rev and session.failed is None:
                with self._root:
                    self._draw_late(True)
                    if session.state is not None and session.is_of_another_model:
                        self._clear(f"{session.state.name} is being computed ...", "...")
            self._watch()

        self._timer = asyncio.get_running_loop().call_later(_LATE, look)

    def _draw_late(self, late: bool) -> None:
        if late == self._late:
            return
        self._late = late
        for pane in (self._train, self._sweep, self._evidence.pane):
            pane.tell("stale", late)
        prop(self._root, "data-loading", "true" if late else None)

    def refuse(self, failed: Mapping[str, Any] | None) -> None:
        """Show why a state does not compute, beside its lever or above the page.  The last good curves of the same
        model stay, pale; nothing stands under the name of another one."""
        session = self._session
        stays = failed is not None and not session.is_of_another_model
        whose = session.computed_words() if stays else ""
        beside = self._levers.refuse(failed, whose)
        self._draw_late(False)
        for pane in (self._train, self._sweep, self._evidence.pane):
            pane.tell("stale", stays)
        prop(self._root, "data-failed", "true" if stays else None)
        hide(self._banner, failed is None or beside)
        hide(self._undo, not session.history.undo_label)
        if failed is not None:
            words = [str(failed.get("path") or ""), str(failed.get("message") or "")]
            why = sentence(": ".join(filter(None, words)), str(failed.get("allowed") or ""))
            self._message.say(". ".join(filter(None, [why, whose])))
            if not stays and session.state is not None:
                self._clear(f"{session.state.name} does not compute. {why}", "Not computed: see the error above.")
        self._levers.follow()

    def _clear(self, instead: str, answer: str) -> None:
        """Take away what another model has shown.  instead : in the place of drawings.  answer : of each question."""
        self._head = {}
        self._train.show_instead(instead)
        self._sweep.show_instead()
        self._evidence.forget()
        lines = [{"key": key, "text": f"{question} {answer}"} for key, question in QUESTIONS.items()]
        head = {"answers": lines, "checks": (), "modes": (), "state": {}, "assumed": {}}
        self._answers.follow(head, moving=False)
        self._header.frame(head)
        self._modes.follow(head)
        self._levers.frame(head)

    def jobs(self, _: Session) -> None:
        """Show the jobs as they stand."""
        self._evidence.follow()
        self._answers.jobs(self._evidence.newest)

    def _show_busy(self) -> None:
        """A line runs over the page while everything of a released state is computed; a drag needs none."""
        session = self._session
        busy = session.busy and session.rev == session.released_rev
        prop(self._root, "data-busy", "true" if busy else None)
