"""What travels between the computing process, the page and its drawings: requests, and frames of results; their words:
one answer and its numbers, what bodies, meshes and speeds are called.

A frame is

uint32 little-endian   bytes of the JSON
JSON, UTF-8            {"rev", "kind", "head", "arrays": [[name, [shape], offset in float32], ...]}, padded with
                       spaces so that the numbers begin at a multiple of four bytes
float32 little-endian  the arrays one behind the other

The mode of one train that has the shape of a mode of another, and the chosen mode of a page followed by its shape: a
sun that begins to float changes the number and the order of the modes.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...limits import SAME_SHAPE

if TYPE_CHECKING:
    from ...document.tables import PlainTable
    from ...train.train import Body, Train

Numbers = NDArray[np.float32]
Kind = Literal["live", "full", "levers"]
_LENGTH = struct.Struct("<I")


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What is asked of the computing process; picklable.

    rev : number of the state, counted by the session.  kind : ``live``: one frame; ``full``: all frames of a state;
    ``levers``: one frame with the levers of its model.
    source, overrides : what `load` takes.  relative_speed : speed per operating speed that is shown [1].
    """

    rev: int
    kind: Kind
    source: PlainTable | Path
    overrides: Mapping[str, object] = field(default_factory=dict)
    relative_speed: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PageFrame:
    """One message of results.

    rev : of the state it belongs to.  kind : curve, live, sweep, sharing, errors, changes, levers, job or failed.
    head : texts, labels and numbers, as JSON has them.  arrays : by name.
    """

    rev: int
    kind: str
    head: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, Numbers] = field(default_factory=dict)


def failed_frame(rev: int, error: Exception) -> PageFrame:
    """The frame of what cannot be computed: ``message``, ``path``, ``given`` and ``allowed`` of the head, all texts."""
    head = {"message": str(error), "path": "", "given": "", "allowed": ""}
    if isinstance(error, ModelError):
        head |= {"message": error.problem, "path": error.path, "allowed": error.allowed}
        # an error whose path has no value gives a bare object there
        head["given"] = "" if type(error.given) is object else str(error.given)[:200]
    return PageFrame(rev=rev, kind="failed", head=head)


def pack(frame: PageFrame) -> bytes:
    """A frame as bytes; numbers of the head that are not finite become null.

    Raises
    ------
    TypeError : something in the head is no JSON.
    """
    table, parts, offset = [], [], 0
    for name, array in frame.arrays.items():
        numbers = np.ascontiguousarray(array, dtype="<f4")
        table.append([name, list(np.shape(array)), offset])
        parts.append(numbers.tobytes())
        offset += numbers.size
    content = {"rev": frame.rev, "kind": frame.kind, "head": _plain(frame.head), "arrays": table}
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([_LENGTH.pack(len(text)), text, *parts])


def drawing_key(frame: PageFrame) -> str:
    """Key of the drawing of the train in a frame; "" without one."""
    return str(frame.head.get("train", {}).get("drawing", {}).get("key", ""))


def without_drawing(frame: PageFrame, key: str) -> bytes | None:
    """A packed frame of which the drawing, known by its key where it is going, is this key alone; None for another."""
    if not key or drawing_key(frame) != key:
        return None
    train = {**frame.head["train"], "drawing": {"key": key}}
    return pack(replace(frame, head={**frame.head, "train": train}))


def unpack(data: bytes) -> PageFrame:
    """The frame of `pack`.

    Raises
    ------
    ValueError : the bytes are no frame.
    """
    try:
        (length,) = _LENGTH.unpack_from(data)
        content = json.loads(data[4 : 4 + length].decode())
        numbers = np.frombuffer(data, dtype="<f4", offset=4 + length)
        arrays = {
            str(name): numbers[start : start + math.prod(shape)].reshape(shape).astype(np.float32)
            for name, shape, start in content["arrays"]
        }
        return PageFrame(rev=int(content["rev"]), kind=str(content["kind"]), head=content["head"], arrays=arrays)
    except (struct.error, KeyError, TypeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a frame: {error}") from error


def _plain(value: object) -> Any:
    """A value as JSON has it: numpy's numbers and arrays as numbers and lists, nan and infinity as null."""
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    raise TypeError(f"{type(value).__name__} in the head of a frame")


# words ----------------------------------------------------------------------------------------------------------------

Level = Literal["good", "warn", "bad", "none"]
LEVELS: Mapping[str, Level] = {"good": "good", "caution": "warn", "bad": "bad", "": "none"}
"""Level of an answer by the tone of the finding that it quotes."""

QUESTIONS: Mapping[str, str] = {
    "resonance": "Does a mesh order meet a mode near operation?",
    "planet": "Which planet carries most?",
    "float": "What does a floating sun buy?",
    "error": "Which error hurts most?",
    "relief": "What tip relief to grind?",
}
"""Key of an answer -> its question, in the order of the page."""


@dataclass(frozen=True, slots=True)
class OfferedChange:
    """A change of the model that an answer offers: a button.

    label : ``module -12 %``.  result : what it gives, ``696 rpm, +20 %``.  why : the rest, beside the pointer.
    apply : overrides by path.  speed : that it moves the answer to, on the axis of the sweep [rpm], None without one.
    """

    label: str
    result: str
    why: str
    apply: Mapping[str, object]
    speed: float | None


@dataclass(slots=True)
class Answer:
    """One line of the page.

    key : of `QUESTIONS`, whose text is the question.  text : one sentence or two.  level : how it stands.
    figure : the number to remember, as it is now.  then : what it would be with the change that is proposed, or in
    all trains.  Each with its unit, "" without one.
    apply : overrides by path that act on it, None without.  apply_label : what they do.
    evidence : what shows why: sweep, sharing, errors, relief or modes.
    job : that says more, None without.
    limit : that they are held against: its ``value``, ``words`` and ``source``, ``path`` at which the model states it.
    assumed : reasons by path of the assumed values that it rests on.
    mode : number of the mode that it is about, None without one.  speed : that it is about, on the axis of the sweep
    [rpm], None without one.  mark : words of the mark in the sweep at that speed.
    changes : that act on it, of several the first is the best.
    """

    key: str
    question: str = field(init=False)
    text: str
    _: KW_ONLY
    figure: str = ""
    then: str = ""
    level: Level = "none"
    apply: Mapping[str, object] | None = None
    apply_label: str = ""
    evidence: str = ""
    job: str | None = None
    limit: Mapping[str, object] | None = None
    assumed: Mapping[str, str] = field(default_factory=dict)
    mode: int | None = None
    speed: float | None = None
    mark: str = ""
    changes: Sequence[OfferedChange] = ()

    def __post_init__(self) -> None:
        self.question = QUESTIONS[self.key]
        if not self.apply:
            self.apply, self.apply_label = None, ""


MINUS = "\u2212"


def number(value: float, digits: int = 3) -> str:
    """A number of so many digits, without an exponent where people write none."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.10g}" if "e" in text and 1e-4 <= abs(value) < 1e9 else text


def force_unit(largest: float) -> tuple[str, float]:
    """Unit in which forces up to a largest one [N] are told, and its number per newton."""
    return ("kN", 1e-3) if largest >= 1e3 else ("N", 1.0)


def per_cent(share: float) -> str:
    """A share [1] in per cent, to a tenth at most."""
    value = 100 * share
    return f"{value:.0f} %" if abs(value) >= 10 else f"{value:.1f} %"


def signed_per_cent(share: float) -> str:
    """A share [1] that goes up or down, in per cent."""
    return f"{MINUS if share < 0 else '+'}{per_cent(abs(share))}"


def largest_known(values: NDArray[np.float64]) -> float:
    """Largest of values that are finite; nan where none is."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


SpeedAxis = tuple[str, float]
"""Label of an axis of speeds with its unit, and how much of that is the operating speed."""


def body_labels(train: Train) -> dict[str, str]:
    """Label of every body by its name: ``planet 1 left``; with the stage before it where there are several."""
    several = len(train.planets) > 1
    return {
        body.name: (f"{body.frame}: " if several and body.frame in train.planets else "")
        + _seat(body, body.side)
        + body.name.removeprefix(body.shaft_of or body.name).replace("/", " ")
        for body in train.bodies
    }


def mesh_labels(train: Train) -> dict[str, str]:
    """Label of every whole mesh by its name: ``sun, planet 1 left``; ``sun, planet 1`` where no side is needed."""
    bodies = {body.name: body for body in train.bodies}
    several = len(train.planets) > 1
    return {
        mesh.name: f"{mesh.stage}: " * several + f"{_seat(bodies[mesh.a])}, {_seat(bodies[mesh.b], mesh.side)}"
        for mesh in train.meshes
    }


def _seat(body: Body, side: str | None = None) -> str:
    """Member, branch and side of a body, those that it has."""
    return " ".join(filter(None, [body.member.rpartition(".")[2], str(body.branch or ""), side]))


def member_name(train: Train, member: str) -> str:
    """A member by its name: ``sun``, ``high sun`` of several stages."""
    stage, _, word = member.rpartition(".")
    return f"{stage} {word}" if len(train.planets) > 1 and stage else word


def member_words(train: Train, member: str, branches: Sequence[int]) -> str:
    """A member in words: ``sun``, ``planets``, ``planets 1, 3`` where only those are meant, ``planet star1 2``.

    branches : those that are meant, rising; none of a member about the axis.
    """
    word, name = member.rpartition(".")[2], member_name(train, member)
    all_branches = {body.branch for body in train.bodies if body.member == member and body.branch is not None}
    if not all_branches:
        return name
    many = "planets" if len(branches) > 1 else "planet"
    return (
        name.removesuffix(word)
        + (many if word == "planet" else f"{many} {word}")
        + ("" if len(branches) == len(all_branches) else f" {listed(branches)}")
    )


def speed_axis(train: Train) -> SpeedAxis | None:
    """The axis on which speeds of a train are shown; None without a member that turns.

    It is that of the member whose rpm the verbs take: the first of `operation.speed` that turns; else the first that
    turns at all.
    """
    speed = train.kinematics.speed or {}
    from ...document.tables import leaves, value_at

    stated = value_at(train.document, ("operation", "speed"))
    members = [path for path, _ in leaves(stated)] if isinstance(stated, dict) else []
    for member in (*members, *speed):
        if speed.get(member):
            stage, _, name = member.rpartition(".")
            words = f"{name} of stage {stage}" if len(train.planets) > 1 and stage else name
            return f"speed of the {words} [rpm]", abs(float(speed[member]))
    return None


def as_overridden(path: str, overrides: Mapping[str, object]) -> str:
    """A path without the name of its stage, where an override at it, above or beneath it is written so.

    A model of one stage takes ``deviations.sun.run_out`` for ``deviations.main.sun.run_out``, but not both.
    """
    shorts = (
        short for short in _without_stage(path) for key in overrides if _within(short, key) or _within(key, short)
    )
    return next(shorts, path)


def override_at(path: str, overrides: Mapping[str, object]) -> str:
    """The override that a path of a message is at or beneath; else the path.

    With or without the name of its stage, and of x the shorthand ``radial`` that sets it.
    """
    from ...document.tables import PAIRS

    table, _, key = path.rpartition(".")
    spellings = [path, *(f"{table}.{pair}" for pair, keys in PAIRS.items() if key in keys)]
    spellings = [one for spelling in spellings for one in (spelling, *_without_stage(spelling))]
    return next((key for spelling in spellings for key in overrides if _within(spelling, key)), path)


def _without_stage(path: str) -> list[str]:
    """A path without one of its inner words: any of them may be the stage."""
    words = path.split(".")
    return [".".join(words[:i] + words[i + 1 :]) for i in range(1, len(words) - 1)]


def _within(path: str, other: str) -> bool:
    """Whether a path is another or stands beneath it."""
    return f"{path}.".startswith(f"{other}.")


def ordinal(number: int) -> str:
    """``1st``, ``2nd``, ``11th``."""
    last = {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th") if number % 100 not in (11, 12, 13) else "th"
    return f"{number}{last}"


def listed(numbers: Sequence[int]) -> str:
    """Rising whole numbers in short: ``1-3, 5``."""
    from ...show.series import spans

    return spans(numbers).replace("\u2013", "-")


# Modes whose frequencies differ by less than this part turn within their span where the train hardly changes: they are
# compared as one group.
_EQUAL = 1e-3


class ModeShapes(NamedTuple):
    """Modes of a train as a page has them.

    of : names of the train and its bodies.  number : (m,) of the modes.  frequency : (m,) [Hz], rising.
    shape : (m, nb, 6) with rotations as lengths.  mass : (nb, 6) of these motions [kg].
    bends : name of every coordinate by which a body bends -> shape (m,) and mass [kg].
    """

    of: Sequence[str]
    number: Sequence[int]
    frequency: Sequence[float]
    shape: NDArray[Any]
    mass: NDArray[Any]
    bends: Mapping[str, tuple[NDArray[Any], float]] = MappingProxyType({})

    def over(self, bends: Sequence[str]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Shapes (c, m) and masses (c,) over the coordinates of all bodies and these of what bends, 0 of none."""
        count = len(self.shape)
        bent = [self.bends.get(name, (np.zeros(count), 0.0)) for name in bends]
        rigid = self.shape.reshape(count, -1).T.astype(float)
        shapes = np.vstack([rigid, *(shape[None] for shape, _ in bent)])
        return shapes, np.concatenate([self.mass.ravel(), [mass for _, mass in bent]])

    @property
    def groups(self) -> list[slice]:
        """Runs of modes of equal frequency."""
        ends = np.flatnonzero(np.diff(self.frequency) > _EQUAL * np.array(self.frequency[1:])) + 1
        return [slice(a, b) for a, b in zip([0, *ends], [*ends, len(self.frequency)], strict=True)]


def like_modes(before: ModeShapes, after: ModeShapes) -> dict[int, tuple[int | None, float]]:
    """Number of each mode -> that of the mode of its shape in a train of the same bodies, and their assurance [1].

    The assurance is that of their groups; no mode has the shape where no group reaches `SAME_SHAPE`.  Of a group it is
    the mode that is most alike.
    """
    from ...questions.modes.campbell import modal_assurance  # 50 ms, which only a page waits for that swings a mode

    bends = list({**before.bends, **after.bends})
    (a, mass), (b, later) = before.over(bends), after.over(bends)
    alone, of_groups = modal_assurance(a, b, np.diag((mass + later) / 2.0), (before.groups, after.groups))
    best = np.argmax(np.where(of_groups >= SAME_SHAPE, alone, -1.0), axis=1)
    most = of_groups.max(axis=1).tolist()
    like = [after.number[i] if most[place] >= SAME_SHAPE else None for place, i in enumerate(best)]
    return dict(zip(before.number, zip(like, most, strict=True), strict=True))


class FollowedMode:
    """The mode that is chosen on a page, in the newest state that it shows.

    number : of the mode, None where none is chosen.  lost : why it is no more, "" where nothing was lost.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self.lost = ""
        self._rev = -1
        self._modes: ModeShapes | None = None

    def choose(self, chosen: int | None) -> None:
        """Choose a mode of the newest state by its number; None: none."""
        self.number, self.lost = chosen, ""

    def take(self, frame: PageFrame) -> bool:
        """Follow the mode into a frame of a live set; whether it has another number there, or none."""
        if frame.kind != "live" or frame.rev < self._rev:
            return False
        before, after, chosen = self._modes, shapes_of(frame), self.number
        self._rev, self._modes = frame.rev, after
        if chosen is None:
            return False
        if before is None or after is None or before.of != after.of or chosen not in before.number:
            self.choose(None)  # another train, or no modes
            return True
        self.number, assurance = like_modes(before, after)[chosen]
        if self.number is None:
            where = f"mode {chosen}, {number(before.frequency[before.number.index(chosen)], 4)} Hz"
            self.lost = f"{where}, is gone: best MAC {assurance:.2f}, limit {SAME_SHAPE:g}"
        return self.number != chosen


def shapes_of(frame: PageFrame) -> ModeShapes | None:
    """Modes of a live frame; None where it has none."""
    rows = frame.head.get("modes")
    if not rows or not {"modes/shape", "modes/mass"} <= frame.arrays.keys():
        return None
    train, arrays = frame.head["train"], {name.removeprefix("modes/"): array for name, array in frame.arrays.items()}
    names = [f"{body['name']}/{name}" for body in train["bodies"] for name in body.get("bends", ())]
    of = [train["title"], *(body["name"] for body in train["bodies"])]
    return mode_shapes(of, rows, {**arrays, "bends": names})


def mode_shapes(names: Sequence[str], rows: Sequence[Mapping[str, Any]], view: Mapping[str, Any]) -> ModeShapes:
    """Modes of the rows of a list, with the values of a `ModeView`; names as of `ModeShapes`."""
    bends = {}
    if view.get("bends"):
        bends = dict(zip(view["bends"], zip(view["bent"].T, view["bent_mass"], strict=True), strict=True))
    number, frequency = ([row[key] for row in rows] for key in ("index", "frequency"))
    return ModeShapes(names, number, frequency, view["shape"], view["mass"], bends)
