"""Options of the verbs: what a keyword means; those that several verbs share have one meaning and one help.

The options of a verb are a frozen dataclass in the room of its question.  A field has the type that the analysis is
given, in SI, its default, and an `Option`: help, flag, bounds, what a person may give instead, and the reader of that.
Keywords of the public function, command line, forms of the page, jobs of studies, docs and stub follow from it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import reduce
from inspect import Parameter
from operator import or_
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, ForwardRef, Literal, NamedTuple, Union, get_args, get_origin

from .errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Progress = Callable[[float], None]
"""Called with the share done, 0..1."""


ALL_CASES = "all"
"""Stands for every load case of a model file, so no case has this name."""


@dataclass(frozen=True, slots=True, repr=False)
class Option:
    """What help, documentation and command line say of a keyword.

    help : one sentence.  flag : of the command line; empty: the keyword with dashes; None: keyword of Python alone.
    least, most : bounds of a number, above : what it must be above.
    default : in words, where the default is None.  metavar : of the value.
    reads : name of the reader that makes the value of the field of what a person gives (`verbs.options.READERS`): of a
        text, or of what `accepts` says.
    """

    help: str
    flag: str | None = ""
    least: float | None = None
    most: float | None = None
    above: float | None = None
    default: str = ""
    metavar: str = ""
    accepts: Any = None
    reads: str = ""

    def accepted(self, kind: Any) -> Any:
        """Type of what a person may give for a field of a type: a text too where one is read."""
        if self.accepts is not None or not self.reads:
            return self.accepts or kind
        kinds = get_args(kind) if NoneType in get_args(kind) else ()
        return kind | str if not kinds else reduce(or_, [*(one for one in kinds if one is not NoneType), str, None])

    def __repr__(self) -> str:
        """The help alone: `help(verb)` shows it beside the type."""
        return repr(self.help)

    @property
    def range(self) -> str:
        """Bounds of a number in words; "" without any."""
        if self.least is not None and self.most is not None:
            return f"{self.least:g} to {self.most:g}"
        ends = ((self.above, "above {:g}"), (self.least, "{:g} or more"), (self.most, "at most {:g}"))
        return ", ".join(words.format(end) for end, words in ends if end is not None)

    def flag_of(self, keyword: str) -> str | None:
        """Flag of a keyword; None where it has none."""
        return f"--{keyword.replace('_', '-')}" if self.flag == "" else self.flag


RANGE_LOADS = 7
"""Loads of a range where their number is not given: enough to draw a curve through."""


class Shape(NamedTuple):
    """What a person types for a type.

    kind : of one entry: bool, int, float or str.  choices : words of which one it must be.  several : entries.
    """

    kind: type
    choices: tuple[str, ...]
    several: bool

    def read(self, text: str, path: str) -> Any:
        """Value of what was typed; entries are separated by ``;``, a truth value is yes or no.

        Raises
        ------
        ModelError : no number where one is wanted, a word that is none of the choices.
        """
        if self.several:
            return [
                self._replace(several=False).read(entry.strip(), path) for entry in text.split(";") if entry.strip()
            ]
        words = self.choices or (tuple(YES) if self.kind is bool else ())
        if words and text not in words:
            raise ModelError("not one of them", path=path, given=text, allowed=", ".join(words))
        try:
            return YES[text] if self.kind is bool else self.kind(text)
        except ValueError:
            number = "a whole number" if self.kind is int else "a number"
            raise ModelError(f"not {number}", path=path, given=text, allowed=number) from None


def option_fields(options: type[Any]) -> dict[str, tuple[Any, Any, Option]]:
    """Field -> default, `MISSING` without one, type and option, of those of a dataclass that have an option."""
    return {
        one.name: (one.default, *get_args(one.type)) for one in fields(options) if get_origin(one.type) is Annotated
    }


YES = {"yes": True, "no": False}
"""Words of a truth value."""


def default_words(default: object) -> str:
    """A default as a person types it; "" where there is none."""
    if isinstance(default, bool):
        return "yes" if default else "no"
    if isinstance(default, Sequence) and not isinstance(default, str):
        return ", ".join(map(str, default))
    return "" if default is None or default is Parameter.empty else str(default)


def shape_of(kind: Any) -> Shape:
    """Shape of a type: a text where one can be typed, several for a sequence of them."""
    members = get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)
    for entry in (get_args(one)[0] for one in members if get_origin(one) is Sequence):
        if entry is str or get_origin(entry) is Literal:
            return Shape(str, get_args(entry), True)
    if any(one is str or isinstance(one, str | ForwardRef) for one in members):
        return Shape(str, (), False)
    (only,) = (one for one in members if one is not NoneType)
    return Shape(str, get_args(only), False) if get_origin(only) is Literal else Shape(only, (), False)


# beyond any drive; squares of much more are no numbers
MOST_SPEED = 10_000
# mesh cycles or turns, and instants of one: what they cost together is asked where the train is known
_MOST_CYCLES, _MOST_SAMPLES = 10**12, 1_000_000

# one speed
RelativeSpeed = Annotated[
    float,
    Option(
        "Speed per operating speed, 0 standstill, 1 the operating point; or a mesh frequency or speed with its unit: "
        '"20 Hz", "50 rpm", "50 %".',
        least=0,
        most=MOST_SPEED,
        reads="relative speed",
    ),
]

# ranges of speed
Start = Annotated[
    float | str | None,
    Option('Lowest mesh frequency [Hz] or speed: "20 Hz", "50 rpm", "50 %".', default="by the range"),
]
Stop = Annotated[float | str | None, Option('Highest, e.g. "0.6 kHz", "2000 rpm".', default="by the range")]
Range = Annotated[
    Literal["operation", "modes"] | None,
    Option("Speeds about operation, 5 to 130 %, or to 1.2 times the modes.", default="operation"),
]
MeshFrequencies = Annotated["ArrayLike | None", Option("(P,) mesh frequencies of the first mesh [Hz].", flag=None)]
RelativeSpeeds = Annotated["ArrayLike | None", Option("(P,) speeds per operating speed [1].", flag=None)]
FrameSpeed = Annotated[
    Literal["kinematic", "operating"], Option("Let the frame turn with the speed, or as at operation.")
]

# runs that are stopped and go on
Folder = Annotated[str | Path | None, Option("Folder that keeps what is done while the run goes on.", flag=None)]
Resume = Annotated[bool, Option("Continue a run that was stopped; needs the same -o and options.")]

# records
Cycles = Annotated[
    int | None, Option("Length of the record in mesh cycles.", least=1, most=_MOST_CYCLES, default="chosen")
]
Turns = Annotated[int | None, Option("Length in turns of a body (--of).", least=1, most=_MOST_CYCLES, default="chosen")]
Of = Annotated[str | None, Option("Count turns of this body, e.g. main/sun.", metavar="BODY")]
Samples = Annotated[
    int | None, Option("Instants per mesh cycle or turn.", least=1, most=_MOST_SAMPLES, default="chosen")
]

# shaft orders
ShaftOrders = Annotated[bool, Option("Count run-outs and other shaft orders between the mesh orders.")]
ShaftTones = Annotated[
    int | None,
    Option("With --contact-loss: shaft frequencies that are phases of the torus.", least=0, most=3, default="chosen"),
]

# verdicts
Limit = Annotated[
    float | str | None,
    Option(
        'Largest K_gamma, or a table of it: "IEC 61400-4", "IACS UR M56".',
        metavar="K",
        default="[limits] of the model, else IEC 61400-4",
    ),
]

# loaded teeth
LoadPoints = Annotated[
    int | None, Option("Number of loads in a range (--loads).", least=1, most=10_000, default=str(RANGE_LOADS))
]
ChosenSlices = Annotated[
    int | None, Option("Pieces of each face.", least=1, most=1000, default="doubled until the tolerance holds")
]
Tolerance = Annotated[
    float,
    Option(
        "Relative error of transmission error (peak to peak), largest load and pressure, where phases or slices "
        "are not given."
    ),
]
Corner = Annotated[bool, Option("Let tips bear beyond the path of contact.")]
LinearAt = Annotated[
    float | None,
    Option(
        'Load per length [N/m], or e.g. "200 N/mm", at which the flanks\' contact is made linear.',
        above=0,
        default="Hertz",
        reads="load_per_length",
    ),
]
Misalignment = Annotated[
    float, Option('Of the flanks [rad], or e.g. "0.1 mrad"; positive opens the right end.', reads="angle")
]
