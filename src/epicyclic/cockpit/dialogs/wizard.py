"""A new train without a model file: one page of fields, what comes out of them, and a model that runs."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nicegui import background_tasks, ui

from ...document.tables import PlainTable
from ...document.writer import commented_text
from ...errors import ModelError
from ...train.new_train import new_train
from ...train.resolution import load
from ...train.wishes import HELD, KINDS, MEMBERS
from ..state.state import from_text
from .controls import plain_button, refused, safe_name, show_model, window

if TYPE_CHECKING:
    from ..processes.session import Session

UNITS: Mapping[str, str] = {
    "module": "mm",
    "face_width": "mm",
    "helix_angle": "deg",
    "pressure_angle": "deg",
    "speed": "rpm",
    "torque": "N m",
    "power": "kW",
    "stages.main.carrier.mass": "kg",
    "stages.main.carrier.inertia": "kg m^2",
    "stages.main.planet.bearing.radial": "N/m",
    "stages.main.sun.support.radial": "N/m",
    "stages.main.ring.support.radial": "N/m",
    "stages.main.carrier.support.radial": "N/m",
}
"""Field -> unit of a bare number typed there; a text with its unit is taken as it is."""

BESIDE: Mapping[str, str] = {
    "damping.modal": "Damping ratio of every mode",
    "stages.main.planet.bearing.radial": "Planet bearing, radial",
    "stages.main.sun.support.radial": "Sun support, radial (0 floats, inf is rigid)",
    "stages.main.ring.support.radial": "Ring support, radial",
    "stages.main.carrier.support.radial": "Carrier bearing, radial",
    "stages.main.carrier.mass": "Carrier mass, without planets",
    "stages.main.carrier.inertia": "Carrier inertia",
}
"""Path -> label of what a running model needs beside teeth and load; empty, it follows a rule."""

# one decimal comma; of three digits behind it nobody knows whether they are thousands
_COMMA = re.compile(r"^([+-]?\d+),(\d{1,2}|\d{4,})(?!\d)")
_BARE = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_SET = re.compile(r"\b\d{2,4}/\d{2,4}/\d{2,4}\b")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preview:
    """What comes out of the fields as they stand.

    text : the model file.  title : of the model.  facts : what follows from the fields, in words.
    by_rule : path of `BESIDE` and size of the gears -> value that a rule has chosen.
    """

    text: str
    title: str
    facts: tuple[str, ...]
    by_rule: Mapping[str, str]


def drivers_of(kind: str, held: str) -> tuple[str, ...]:
    """Members that may drive; none of a differential, whose speeds are stated by member."""
    if kind == "differential":
        return ()
    fixed = (
        held if held in HELD.get("planetary", ()) and kind == "planetary" else "carrier" if kind == "star" else "ring"
    )
    return tuple(member for member in MEMBERS if member != fixed)


def needed(fields: Mapping[str, Any]) -> tuple[str, ...]:
    """Fields that nothing stands in for, and that are empty."""
    names = [str(fields.get("by", "teeth")), str(fields.get("load", "power"))]
    if fields.get("kind") == "differential":
        speeds = sum(bool(_typed(fields, f"speed.{member}")) for member in MEMBERS)
        names[0] = "teeth"
        return (*(name for name in names if not _typed(fields, name)), *(("speed",) if speeds < 2 else ()))
    return tuple(name for name in (*names, "speed") if not _typed(fields, name))


def preview_of(fields: Mapping[str, Any]) -> Preview:
    """The model of the fields, and what a person should know of it.

    Parameters
    ----------
    fields : keyword of `new_train`, path of `BESIDE`, ``speed.MEMBER`` and ``load_member`` of a differential -> text.
        ``by``: teeth or ratio; ``load``: power or torque.

    Raises
    ------
    ModelError : path is the field; what was given and what is allowed.
    """
    train = new_train(**_keywords(fields))
    beside = {path: _with_unit(path, text) for path in BESIDE if (text := _typed(fields, path))}
    document = _with_values(train.document, beside)
    try:
        model = load(document)
    except ModelError as error:
        raise error.at(next((path for path in beside if error.path.startswith(path)), error.path)) from None
    stage = document["stages"]["main"]
    facts = [train.comments["stages.main"], *_gears(train.comments), *train.remarks]
    operation = [text for path, text in train.comments.items() if path.startswith("operation.")]
    facts[1:1] = [f"module {stage['module']}, face width {stage['face_width']}"]
    head = ("Made by the wizard of a new train. Values under [assumed] are chosen, not given.", *train.remarks)
    return Preview(
        text=commented_text(document, head=head, comments=train.comments),
        title=model.title,
        facts=tuple(_sentence(fact) for fact in (*facts, *operation)),
        by_rule=_by_rule(train.document),
    )


def sets_in(text: str) -> tuple[str, ...]:
    """Tooth counts that a message or a remark proposes."""
    return tuple(dict.fromkeys(_SET.findall(text)))


def _typed(fields: Mapping[str, Any], name: str) -> str:
    return str(fields.get(name) or "").strip()


def _pointed(text: str) -> str:
    """A quantity with its decimal comma as a point."""
    return _COMMA.sub(r"\1.\2", text)


def _with_unit(name: str, text: str) -> str | float:
    """A text as the model file has it: a bare number with the unit of its field, a ratio as a number."""
    unit, text = UNITS.get(name), _pointed(text)
    if not _BARE.fullmatch(text):
        return text
    if unit is None:
        return float(text)
    return text if unit == "N/m" and float(text) == 0 else f"{text} {unit}"


def _number(name: str, text: str) -> float:
    try:
        return float(_pointed(text))
    except ValueError:
        raise ModelError("not a number", path=name, given=text, allowed="a number, 5.7") from None


def _keywords(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `new_train`. Raises ModelError."""
    kind = str(fields.get("kind", "planetary"))
    said: dict[str, Any] = {"kind": kind}
    if kind != "differential" and fields.get("by") == "ratio":
        if text := _typed(fields, "ratio"):
            said["ratio"] = _number("ratio", text)
    elif text := _typed(fields, "teeth"):
        said["teeth"] = text
    if text := _typed(fields, "planets"):
        said["planets"] = int(text) if text.isdecimal() else text
    for name in ("module", "face_width", "helix_angle", "pressure_angle"):
        if text := _typed(fields, name):
            said[name] = _with_unit(name, text)
    if text := _typed(fields, "title"):
        said["title"] = text
    load_ = "torque" if fields.get("load") == "torque" else "power"
    text = _typed(fields, load_)
    if kind == "differential":
        speeds = {m: _with_unit("speed", one) for m in MEMBERS if (one := _typed(fields, f"speed.{m}"))}
        if speeds:
            said["speed"] = speeds
        if text:
            said[load_] = {str(fields.get("load_member") or "sun"): _with_unit(load_, text)}
        return said
    if text:
        said[load_] = _with_unit(load_, text)
    if text := _typed(fields, "speed"):
        said["speed"] = _with_unit("speed", text)
    held = _typed(fields, "held")
    if kind == "planetary" and held:
        said["held"] = held
    driver = _typed(fields, "driver")
    if driver in drivers_of(kind, held):
        said["driver"] = driver
    return said


def _with_values(document: Mapping[str, Any], values: Mapping[str, object]) -> PlainTable:
    """The document with values put in, and without the reasons of those they replace."""
    changed: PlainTable = {**document, "assumed": {k: v for k, v in document["assumed"].items() if k not in values}}
    for path, value in values.items():
        *above, last = path.split(".")
        table = changed
        for key in above:
            table[key] = dict(table[key])
            table = table[key]
        table[last] = value
    return changed


def _by_rule(document: Mapping[str, Any]) -> dict[str, str]:
    found = {}
    for path in BESIDE:
        value: Any = document
        for key in path.split("."):
            value = value.get(key, {})
        if value != {}:
            found[path] = str(value)
    stage = document["stages"]["main"]
    return found | {"module": str(stage["module"]), "face_width": str(stage["face_width"])}


def _gears(comments: Mapping[str, str]) -> Sequence[str]:
    names = ("sun", "planet", "ring")
    return [f"{name}: {text}" for name in names if (text := comments.get(f"stages.main.{name}"))]


def _sentence(text: str) -> str:
    return text if text[1:2] in ("_", "") else text[0].upper() + text[1:]


# [s] after the last key until what comes out is worked out anew
_PAUSE = 0.25
_LABELS = {
    "kind": "Kind",
    "planets": "Planets",
    "by": "Gears",
    "teeth": "Teeth sun/planet/ring",
    "ratio": "Ratio, input to output",
    "module": "Normal module",
    "helix_angle": "Helix angle",
    "face_width": "Face width",
    "pressure_angle": "Normal pressure angle",
    "held": "Held member",
    "driver": "Driving member",
    "speed": "Speed",
    "load": "Load",
    "power": "Power",
    "torque": "Torque",
    "load_member": "Load of the",
    "title": "Title",
}
# examples are marked as such, beside what a field holds that stays empty
_PLACEHOLDERS = {
    "teeth": "e.g. 21/39/99",
    "ratio": "e.g. 5.7",
    "power": "e.g. 750 kW",
    "torque": "e.g. 7.2 kN m",
    "speed": "e.g. 1000 rpm",
    "module": "by load",
    "face_width": "by load",
    "helix_angle": "0 deg",
    "pressure_angle": "20 deg",
}
# path of an error -> the field that shows it, where it is another one
_SHOWN_AT = {"stages.main.planets": "planets", "stages.main.module": "module", "stages.main.face_width": "face_width"}


# The wizard of a page: one, so that what was typed is there from wherever it is opened.
_WIZARDS: dict[Session, _Wizard] = {}


def new_button(session: Session) -> None:
    """A button that opens the wizard; what was typed stays there until a train is made of it."""
    plain_button("New", _wizard_of(session).open, icon="add").props('aria-label="New train"')


def new_window(session: Session) -> None:
    """Open the wizard of `new_button` from another place of the page."""
    _wizard_of(session).open()


def _wizard_of(session: Session) -> _Wizard:
    if session not in _WIZARDS:
        _WIZARDS[session] = _Wizard(session)
        ui.context.client.on_delete(lambda: _WIZARDS.pop(session, None))
    return _WIZARDS[session]


class _Wizard:
    """The window; it is built when it is first opened, and keeps what was typed."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.slot = ui.element("div").classes("hidden")
        self.window: ui.dialog | None = None
        self.fields: dict[str, Any] = {}
        self.asked = 0
        self.insists = False  # create was pressed: what is missing is an error now
        self.ready: Preview | None = None

    def open(self) -> None:
        if self.window is None:
            with self.slot:
                self._build()
        assert self.window is not None
        self.window.open()

    # fields -----------------------------------------------------------------------------------------------------------

    def _build(self) -> None:
        with window("New train", width=1000) as self.window:
            with ui.row().classes("w-full no-wrap items-start q-col-gutter-md"):
                with ui.column().classes("q-gutter-none").style("flex: 3; min-width: 0"):
                    self._train_fields()
                    self._load_fields()
                    self._beside_fields()
                with ui.column().classes("q-gutter-none").style("flex: 2; min-width: 280px"):
                    self._outcome()
            with ui.row().classes("w-full justify-end items-center"):
                self.status = ui.label("").classes("col text-caption").props('role="status" aria-live="polite"')
                plain_button("Start over", self._clear)
                self.create = plain_button("Create", self._create, main=True)
        self._arrange()
        self._ask()

    def _train_fields(self) -> None:
        with ui.row().classes("w-full items-start"):
            self._choice("kind", {kind: kind for kind in KINDS}, "planetary")
            self._text("planets", "3")
            self._choice("held", {}, None)
            self._choice("driver", {}, None)
        with ui.row().classes("w-full items-start"):
            self._choice("by", {"teeth": "by their teeth", "ratio": "from a ratio"}, "teeth")
            self._text("teeth")
            self._text("ratio")
        self.proposals = ui.row().classes("w-full items-center q-gutter-xs")
        with ui.row().classes("w-full items-start"):
            for name in ("module", "face_width", "helix_angle", "pressure_angle"):
                self._text(name)

    def _load_fields(self) -> None:
        with ui.row().classes("w-full items-start"):
            self._text("speed")
            for member in MEMBERS:
                self._text(f"speed.{member}", label=f"Speed of the {member}")
            self._choice("load", {"power": "power", "torque": "torque"}, "power")
            self._choice("load_member", {member: member for member in MEMBERS}, "sun")
            self._text("power")
            self._text("torque")
        self._text("title").classes("w-full").style("flex: none")

    def _beside_fields(self) -> None:
        words = "Damping, bearings, carrier: by rules unless said here"
        with ui.expansion(words).classes("w-full").props("dense"), ui.grid(columns=2).classes("w-full"):
            for path, label in BESIDE.items():
                self._text(path, label=label)

    def _outcome(self) -> None:
        ui.label("What comes out").classes("text-subtitle2")
        self.facts = ui.column().classes("w-full q-gutter-xs").props('aria-live="polite"')
        self.message = ui.label("").classes("text-negative").props('role="alert"')
        ui.label("A preselection to begin with: no strength rating.").classes("text-caption")

    def _text(self, name: str, value: str = "", *, label: str = "") -> ui.input:
        unit = UNITS.get("speed" if name.startswith("speed.") else name, "")
        field = ui.input(
            f"{label or _LABELS[name]}{f' [{unit}]' if unit else ''}",
            value=value,
            placeholder=_PLACEHOLDERS.get(name, ""),
            on_change=self._ask,
        )
        field.props("dense stack-label hide-bottom-space autocomplete=off spellcheck=false").mark(f"new-{name}")
        field.style("flex: 1 1 7rem; min-width: 7rem")
        field.on("keydown.enter", self._create)
        self.fields[name] = field
        return field

    def _choice(self, name: str, options: dict[str, str], value: str | None) -> None:
        field = ui.select(options, value=value, label=_LABELS[name], on_change=self._rearrange)
        field.props("dense options-dense stack-label hide-bottom-space").style("min-width: 8rem").mark(f"new-{name}")
        self.fields[name] = field

    def values(self) -> dict[str, Any]:
        """What stands in the fields."""
        return {name: field.value for name, field in self.fields.items()}

    def _rearrange(self) -> None:
        if self.window is not None and "title" in self.fields:
            self._arrange()
            self._ask()

    def _arrange(self) -> None:
        """Show the fields that the kind and the choices ask for; those hidden keep what was typed."""
        values = self.values()
        kind = str(values["kind"])
        sides = HELD["planetary"] if kind == "planetary" else ()
        self._offer("held", sides)
        self._offer("driver", drivers_of(kind, str(values["held"] or "")))
        several = kind == "differential"
        by, load = values["by"], values["load"]
        shown = {
            "held": bool(sides),
            "driver": not several,
            "by": not several,
            "teeth": several or by == "teeth",
            "ratio": not several and by == "ratio",
            "speed": not several,
            "load_member": several,
            "power": load == "power",
            "torque": load == "torque",
            **{f"speed.{member}": several for member in MEMBERS},
        }
        for name, visible in shown.items():
            self.fields[name].set_visibility(visible)
        member = values["load_member"] if several else self.fields["driver"].value
        for name in ("speed", "power", "torque"):
            self.fields[name].props["label"] = f"{_LABELS[name]} of the {member} [{UNITS[name]}]"

    def _offer(self, name: str, members: tuple[str, ...]) -> None:
        """Options of a choice of members; what was chosen stays where it may."""
        field = self.fields[name]
        if list(field.options) != list(members):
            chosen = field.value if field.value in members else next(iter(members), None)
            field.set_options(dict(zip(members, members, strict=True)), value=chosen)

    # what comes out ---------------------------------------------------------------------------------------------------

    def _ask(self) -> None:
        """Work out what comes out, a moment after the last key."""
        self.asked += 1
        self.ready = None
        if self.window is not None and "title" in self.fields and hasattr(self, "facts"):
            background_tasks.create(self._work_out(self.asked))

    async def _work_out(self, number: int) -> None:
        await asyncio.sleep(_PAUSE)
        if number == self.asked and not self.slot.is_deleted:
            with self.slot:
                await self._show(number)

    async def _show(self, number: int) -> bool:
        """Show what comes out of the fields; whether a train does."""
        fields = self.values()
        missing = needed(fields)
        if missing and not self.insists:
            self._mark(None)
            self.status.set_text(f"Still needed: {', '.join(self._label(name) for name in missing)}")
            return False
        found: Preview | ModelError
        try:
            found = await asyncio.to_thread(preview_of, fields)
        except ModelError as error:
            found = error
        if number != self.asked or self.slot.is_deleted:
            return False
        if isinstance(found, ModelError):
            self._mark(found)
            self.status.set_text("")
            return False
        self.ready = found
        self._mark(None)
        self.status.set_text("Ready: a model that runs")
        self._tell(found)
        return True

    def _label(self, name: str) -> str:
        return {"speed": "speed", "teeth": "teeth", "ratio": "ratio"}.get(name, _LABELS.get(name, name).lower())

    def _tell(self, found: Preview) -> None:
        self.facts.clear()
        with self.facts:
            for fact in found.facts:
                ui.label(fact)
        self._propose(sets_in(" ".join(found.facts)))
        for name, value in found.by_rule.items():
            self.fields[name].props["placeholder"] = value
            self.fields[name].update()

    def _mark(self, error: ModelError | None) -> None:
        """Put the message beside the field that it is of, and take it from all others."""
        place = None if error is None else self._place(error.path)
        for name, field in self.fields.items():
            if isinstance(field, ui.input):
                field.error = _message(error) if error is not None and name == place else None
        self.facts.style("opacity: 0.4" if error is not None else "opacity: 1")  # of the fields as they were
        self.message.set_text("" if error is None or isinstance(self.fields.get(place or ""), ui.input) else str(error))
        if error is not None:
            self._propose(sets_in(error.allowed))

    def _place(self, path: str) -> str | None:
        """The field of a path: its own, or that of the table that the path is in."""
        known = _SHOWN_AT.get(path, path)
        if known == "speed" and self.fields["kind"].value == "differential":
            return "speed.sun"
        if known in self.fields:
            return known
        table = known.rpartition(".")[0]
        return next((name for name in BESIDE if table and name.rpartition(".")[0] == table), None)

    def _propose(self, sets: tuple[str, ...]) -> None:
        """Buttons that take other tooth counts."""
        own = str(self.fields["teeth"].value or "").strip()
        self.proposals.clear()
        with self.proposals:
            for teeth in sets:
                if teeth == own:
                    continue

                def take(teeth: str = teeth) -> None:
                    self.fields["by"].set_value("teeth")
                    self.fields["teeth"].set_value(teeth)

                plain_button(teeth, take).tooltip("Take these teeth")

    # end --------------------------------------------------------------------------------------------------------------

    async def _create(self) -> None:
        """Open the model of the fields; the window stays, with all that was typed, where there is none."""
        self.insists = True
        self.asked += 1
        self.create.props("loading")
        try:
            if not await self._show(self.asked) or self.ready is None:
                return
            try:
                state = from_text(safe_name(self.ready.title, ".toml"), self.ready.text)
            except ModelError as error:
                return refused(error)
        finally:
            self.create.props(remove="loading")
        assert self.window is not None
        self.window.close()
        show_model(self.session, state, self.slot, unsaved=True)
        ui.notify(
            "A new train. What its drawing does not say yet is assumed; save keeps it.",
            timeout=5000,
            position="bottom-left",
        )

    def _clear(self) -> None:
        """Empty fields again."""
        first: Mapping[str, str] = {
            "kind": "planetary",
            "planets": "3",
            "by": "teeth",
            "load": "power",
            "load_member": "sun",
        }
        self.insists = False
        for name, field in self.fields.items():
            if name not in ("held", "driver"):
                field.set_value(first.get(name, ""))
        self.facts.clear()
        self.proposals.clear()


def _message(error: ModelError) -> str:
    return f"{error.problem}; allowed: {error.allowed}" if error.allowed else error.problem
