"""Controls of the page and of its windows, and the panes that move under a slider.

Controls are native elements, which browsers make reachable by keyboard: texts sent on change, windows with a title,
buttons with a name, downloads, keys, callbacks of a session.  Panes are one element for the drawing of the train, the
sweep and the evidence.
"""

from __future__ import annotations

import asyncio
import base64
import json
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from inspect import isawaitable
from typing import Any, Literal

from nicegui import background_tasks, events, ui
from nicegui.element import Element
from nicegui.elements.mixins.text_element import TextElement
from nicegui.events import GenericEventArguments

from ...errors import ModelError
from ..processes.session import Session
from ..state.frames import drawing_key, unpack, without_drawing
from ..state.state import PageState


class Words(TextElement):
    """An element with a text; an equal one is not sent again.  attributes : as of `box`."""

    def __init__(self, tag: str = "span", text: str = "", *, classes: str = "", **attributes: object) -> None:
        super().__init__(tag=tag, text=text)
        self.classes(classes).props.update(_dashed(attributes))

    def say(self, text: str) -> None:
        if self.text != text:
            self.set_text(text)


def _dashed(attributes: Mapping[str, object]) -> dict[str, object]:
    return {name.replace("_", "-"): value for name, value in attributes.items()}


def box(classes: str, tag: str = "div", **attributes: object) -> Element:
    """A container.  attributes : of HTML, with underscores for dashes."""
    element = Element(tag).classes(classes)
    element.props.update(_dashed(attributes))
    return element


def button(
    text: str, on_click: Callable[..., Any], *, classes: str = "ck-small", label: str = "", **attributes: object
) -> Words:
    """A native button; label : its name where the text is none.  attributes : as of `box`."""
    control = Words("button", text, classes=classes, type="button", **attributes)
    if label:
        control.props["aria-label"] = label
        control.props["title"] = label
    control.on("click", lambda _: on_click())
    return control


def prop(element: Element, name: str, value: object) -> None:
    """Set a property and send it, where it is another one."""
    if element.props.get(name) != value:
        element.props[name] = value
        element.update()


def hide(element: Element, hidden: bool) -> None:
    """Take an element away from the page and its readers, or show it."""
    if bool(element.props.get("hidden")) != hidden:
        if hidden:
            element.props["hidden"] = True
        else:
            del element.props["hidden"]
        element.update()


# Characters of a file name: file systems take 255 bytes, and a suffix and a number of the browser's come behind.
_MOST_NAME = 100
# [ms] a message of an error stays: time to read two lines.
_SHOWN = 12_000

# Sliders and boxes to tick are no text: undo of the page works there.
_TEXT_FIELDS = (
    "input:not([type=range], [type=checkbox], [type=radio], [type=button]), textarea, select, [contenteditable=true]"
)

_LARGE = """
.cockpit-large { position: fixed; inset: 3vh 6vw; z-index: 3000; padding: 1rem; overflow: auto; border-radius: 6px;
  width: auto !important; background: var(--ck-raised, #fff); box-shadow: 0 0 0 100vmax rgb(0 0 0 / 45%); }
.body--dark .cockpit-large { background: var(--ck-raised, #1d1d1d); }
"""


@contextmanager
def window(title: str, *, width: int = 640, stays: bool = False) -> Iterator[ui.dialog]:
    """A dialog with a title and a button that closes it; what is built inside stands below, then it opens.

    width : [px] on a page of usual width, where that has room.
    stays : whether it is neither opened here nor deleted where it is closed.
    """
    dialog = ui.dialog().props(f'aria-label="{title}"')
    size = f"width: {width / 16:g}rem; max-width: 96vw; max-height: 92vh"
    with dialog, ui.card().classes("cockpit-window").style(size):
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(title).classes("text-h6 col").props('role="heading" aria-level="2"')
            icon_button("close", "Close", dialog.close)
        yield dialog
    if not stays:
        dialog.on("hide", dialog.delete)
        dialog.open()


def fold(title: str, build: Callable[[], Any]) -> ui.expansion:
    """Something folded, which is built when it is first opened: widgets cost time."""
    built = False

    async def opened(event: events.ValueChangeEventArguments[bool]) -> None:
        nonlocal built
        if event.value and not built:
            built = True
            with expansion:
                if isawaitable(building := build()):
                    await building

    expansion = ui.expansion(title, on_value_change=opened).props("dense dense-toggle")
    return expansion


def icon_button(icon: str, label: str, on_click: Callable[..., Any]) -> ui.button:
    """A small button with a picture; its name is read out and shown beside the pointer."""
    button = ui.button(icon=icon, on_click=on_click).props("flat dense round size=sm")
    button.props["aria-label"] = label
    with button:
        ui.tooltip(label)
    return button


def rename(button: ui.button, label: str, tip: str = "") -> None:
    """Give an `icon_button` another name, and another text beside the pointer; nothing is sent where it has them."""
    if button.props.get("aria-label") != label:
        button.props["aria-label"] = label
        button.update()
    for tooltip in button:
        if isinstance(tooltip, ui.tooltip) and tooltip.text != (tip or label):
            tooltip.set_text(tip or label)


def enlarge_button(panel: Element, name: str) -> None:
    """A button that lets a panel of a narrow column fill the page, and puts it back.

    The panel stays the same element, so that nothing typed there is lost.
    """
    ui.add_css(_LARGE)
    large = False

    def change() -> None:
        nonlocal large
        large = not large
        panel.classes(add="cockpit-large" if large else "", remove="" if large else "cockpit-large")
        control.props(f"icon={'close_fullscreen' if large else 'open_in_full'}")
        rename(control, f"{name}: {'back into the column' if large else 'enlarge'}")

    control = icon_button("open_in_full", f"{name}: enlarge", change)


def show_model(session: Session, state: PageState, where: Element, *, unsaved: bool = False) -> None:
    """Have the session show another model; the handler that asks does not wait until all about it is known.

    where : element that stays, in whose slot an error is told.  unsaved : it lies in no file yet.
    """

    async def work() -> None:
        try:
            await (session.open(state, unsaved=True) if unsaved else session.open(state))
        except ModelError as error:
            if not where.is_deleted:
                with where:
                    refused(error)

    background_tasks.create(work())


def on_key(key: str, handler: Callable[[], Any], *, shift: bool = False, in_text: bool = False) -> None:
    """Call a handler on Ctrl (or Cmd) with a letter; in a text field only with `in_text`, which has keys of its own."""
    name = f"cockpit-key-{key}{'-shift' * shift}"
    text = "false" if in_text else f"event.target.closest?.('{_TEXT_FIELDS}')"
    ui.on(name, handler)
    ui.add_head_html(
        f"""<script>document.addEventListener("keydown", (event) => {{
            if (!(event.ctrlKey || event.metaKey) || event.altKey || event.shiftKey !== {str(shift).lower()}) return;
            if (event.key.toLowerCase() !== "{key}" || {text}) return;
            event.preventDefault();
            emitEvent("{name}");
        }});</script>"""
    )


def plain_button(text: str, on_click: Callable[..., Any], *, icon: str | None = None, main: bool = False) -> ui.button:
    """A button with words; the main one of a dialog is filled."""
    return ui.button(text, icon=icon, on_click=on_click).props(f"no-caps dense {'unelevated' if main else 'flat'}")


def refused(error: Exception, what: str = "") -> None:
    """Tell of an error where no field shows it."""
    ui.notify(f"{what}{error}", type="negative", multi_line=True, timeout=_SHOWN, close_button="Close")


def applied(session: Session, values: Mapping[str, Any], label: str, what: str = "") -> bool:
    """Apply values to the model; whether it takes them, which is told where it does not."""
    try:
        session.apply(values, label)
    except ModelError as error:
        refused(error, what)
        return False
    return True


def sentence(problem: str, allowed: str) -> str:
    """What is wrong, and what is allowed where that is known."""
    return f"{problem}; allowed: {allowed}" if allowed else problem


def literal(value: object) -> str:
    """A value as JavaScript that runs in the page, whatever it holds."""
    return json.dumps(value).replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def safe_name(name: str, suffix: str) -> str:
    """A file name of letters, digits, point, dash and underscore that every system takes."""
    plain = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_.") else "-" for letter in name)
    return f"{plain.strip('-.')[:_MOST_NAME] or 'model'}{suffix}"


def give(content: bytes | str, name: str, media_type: str = "application/octet-stream") -> None:
    """Have the browser save a file; nothing is written on the machine of the server."""
    raw = content.encode("utf-8") if isinstance(content, str) else content
    ui.download.content(raw, name, media_type)


def copy(text: str, what: str) -> None:
    """Put a text on the clipboard and say so."""
    ui.clipboard.write(text)
    ui.notify(f"{what} copied", type="positive", timeout=2000)


def heard(session: Session, element: Element, **callbacks: Callable[..., Any]) -> None:
    """Listen to a session as long as an element is there; callbacks run in its slot.

    callbacks : as of `Session.listen`.
    """

    def within(callback: Callable[..., Any]) -> Callable[..., None]:
        def call(*arguments: Any) -> None:
            if not element.is_deleted:
                with element:
                    callback(*arguments)

        return call

    session.listen(**{name: within(callback) for name, callback in callbacks.items()})


class Later:
    """Work that is done once, a moment after it was last asked for, in the slot of an element that is still there.

    often : a moment after it was first asked for: while changes go on it is done again and again.
    """

    def __init__(self, place: Element, work: Callable[[], Awaitable[object]], *, often: bool = False) -> None:
        self._place, self._work, self._often = place, work, often
        self._asked, self._waits = 0, False

    def ask(self, seconds: float) -> None:
        """Ask for the work, so many seconds from now."""
        if self._often and self._waits:
            return
        self._asked, self._waits = self._asked + 1, True
        background_tasks.create(self._wait(seconds, self._asked))

    def drop(self) -> None:
        """Forget what was asked for."""
        self._asked, self._waits = self._asked + 1, False

    async def _wait(self, seconds: float, number: int) -> None:
        await asyncio.sleep(seconds)
        self._waits = False
        if number == self._asked and not self._place.is_deleted:
            with self._place:
                await self._work()


# panes ----------------------------------------------------------------------------------------------------------------

# Names of the panes for screen readers; a pane adds what it shows.
_NAMES = {"train": "Drawing of the train", "sweep": "Mesh forces over speed", "evidence": "Evidence"}


class Board(Element, component="board.js", esm={"epicyclic-cockpit": "static"}):
    """One pane of the cockpit, drawn in the browser from packed frames that all panes of a page share.

    Parameters
    ----------
    kind : train: its front view and axial section, turning, meshes coloured by load, or a mode shape; sweep: largest
        mesh forces over speed, peaks named after their modes; evidence: load sharing, what each error costs, or the
        lines and bars of a job.
    """

    def __init__(self, kind: Literal["train", "sweep", "evidence"]) -> None:
        super().__init__()
        self._props["kind"] = kind
        self._props["label"] = _NAMES[kind]
        self._sent: dict[str, bytes] = {}
        self._told: dict[str, tuple[Any, ...]] = {}
        self._pinned: list[bytes] = []
        self._drawn = ""  # key of the drawing that the browser has
        self._ready = False
        self.on("ready", self._on_ready)

    def frame(self, packed: bytes, *mode: int | None) -> None:
        """Show a packed frame in every pane of the page; parts with an older revision than shown are dropped there.

        mode : number of the chosen mode in this frame, where it is another one than before.
        """
        frame = unpack(packed)
        job = frame.head.get("job", {}).get("name", "") if frame.kind == "job" else ""
        self._sent[f"{frame.kind}:{job}"] = packed
        self._told.pop("clear", None)
        if self._ready:
            self.run_method("frame", _text(without_drawing(frame, self._drawn) or packed), *mode)
            self._drawn = drawing_key(frame) or self._drawn

    def early(self, packed: bytes) -> None:
        """Show a packed frame ahead of the next one, which has all of it again."""
        if self._ready:
            self.run_method("frame", _text(packed))

    def show_instead(self, text: str | None = None) -> None:
        """Forget what was sent; with a text, have all panes of the page show that in its place."""
        self._sent.clear()
        if text is not None:
            self.tell("clear", text)

    def ghost(self, packed: bytes | None) -> None:
        """Add the parts of a packed frame to the dashed ghost of pin A; None takes the ghost away, in every pane."""
        self._pinned = [] if packed is None else [*self._pinned, packed]
        if self._ready:
            self.run_method("ghost", None if packed is None else _text(packed))

    def preview(self, mark: Mapping[str, Any] | None, packed: bytes | None = None) -> None:
        """Draw beside the curves what a change would give: a speed and its words, and the curves of a packed frame."""
        self.tell("preview", mark, None if packed is None else _text(packed))

    def on_speed(self, handler: Callable[[float], Any]) -> None:
        """Call `handler` with the relative speed (1 = operating speed of the model) that was clicked in the sweep."""

        def handle(event: GenericEventArguments) -> None:
            relative = event.args
            is_number = isinstance(relative, int | float) and not isinstance(relative, bool)
            if is_number and 0 < relative < _LARGEST_SPEED:
                handler(float(relative))

        self.on("speed", handle)

    def on_mode(self, handler: Callable[[int | None], Any]) -> None:
        """Call `handler` with the index of the mode that was chosen in a pane, None where it was left."""

        def handle(event: GenericEventArguments) -> None:
            index = event.args
            if index is None or (isinstance(index, int) and not isinstance(index, bool) and index >= 0):
                handler(index)

        self.on("mode", handle)

    def tell(self, method: str, *arguments: Any) -> None:
        """Call a method of the pane in the browser, once it is mounted and after each time that it is.

        mode : animate the mode of this index of the frame in the drawing of the train; None lets the train turn again.
        stale : draw at 40 %, as older than the state; a part older than the newest frame is drawn so anyhow.
        evidence : what an evidence pane shows: ``"sharing"``, ``"errors"`` or the name of a job.
        """
        self._told[method] = arguments
        if self._ready:
            self.run_method(method, *arguments)

    def _on_ready(self) -> None:
        """The browser has mounted the pane, perhaps again after a reconnection: it is told all it has to know."""
        self._ready = True
        for packed in self._sent.values():
            self.run_method("frame", _text(packed))
            self._drawn = drawing_key(unpack(packed)) or self._drawn
        for packed in self._pinned:
            self.run_method("ghost", _text(packed))
        for method, arguments in self._told.items():
            self.run_method(method, *arguments)


# Beyond a hundred times the operating speed nothing is computed: such a number did not come from the pane.
_LARGEST_SPEED = 100.0


def _text(packed: bytes) -> str:
    return base64.b64encode(packed).decode("ascii")
