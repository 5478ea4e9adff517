"""The mode of one train that has the shape of a mode of another, and the chosen mode of a page followed by its shape: a
sun that begins to float changes the number and the order of the modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...limits import SAME_SHAPE
from ..state.frames import PageFrame, number

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
