"""Names of stages, members and bodies, and references to them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import product

from ..errors import ModelError
from .schema import KIND_BY_NAME, STAGE_KEYS

__all__ = ["SIDES", "Names", "check_label", "check_names", "collect", "full_path", "mesh_name", "nearest", "reference"]

SIDES = ("left", "right")
_TAKEN = (*SIDES, "meshes", "members", "bearings")
_NAME = re.compile(r"[A-Za-z0-9_]{1,60}")
_LINK_NAME = re.compile(r"[A-Za-z0-9_-]{1,60}")
_KINDS = tuple(dict.fromkeys(KIND_BY_NAME.values()))
_RANK = {"sun": 0, "planet": 1, "ring": 2}  # order of the two names of a mesh, along the power path


@dataclass(frozen=True, slots=True, kw_only=True)
class Names:
    """The names of a file: kind of each member by stage and member name, and the bodies."""

    stages: Mapping[str, Mapping[str, str]]
    bodies: tuple[str, ...]

    @property
    def members(self) -> tuple[str, ...]:
        """All full member paths, and the bodies."""
        return (*(f"{s}.{m}" for s, members in self.stages.items() for m in members), *self.bodies)


def collect(*layers: Mapping[str, object]) -> Names:
    """Return the names in the layers of a file laid over each other; wrong forms are left to validation."""
    stages: dict[str, dict[str, str]] = {}
    bodies: dict[str, None] = {}
    for layer in layers:
        for stage, table in _tables(layer.get("stages")):
            members = stages.setdefault(stage, {})
            for name, member in _tables(table):
                if name not in STAGE_KEYS:
                    kind = member.get("kind") or members.get(name) or KIND_BY_NAME.get(name, "")
                    members[name] = kind if isinstance(kind, str) else "unknown"
        bodies.update((name, None) for name, _ in _tables(layer.get("bodies")))
    return Names(stages=stages, bodies=tuple(bodies))


def check_names(names: Names, *layers: Mapping[str, object]) -> None:
    """Raise ModelError for a name that is taken, used twice or no name, and for a member of no kind."""
    for stage, members in names.stages.items():
        _check_name(stage, f"stages.{stage}", _NAME, (*_TAKEN, *names.bodies))
        for member, kind in members.items():
            _check_name(member, f"stages.{stage}.{member}", _NAME, _TAKEN)
            if not kind:
                problem = f"no member of a known name, and without kind{nearest(member, (*KIND_BY_NAME, *STAGE_KEYS))}"
                raise ModelError(problem, path=f"stages.{stage}.{member}", allowed=f"kind = {', '.join(_KINDS)}")
    for body in names.bodies:
        _check_name(body, f"bodies.{body}", _NAME, _TAKEN)
    for table, layer in product(("couplings", "loads"), layers):
        for name, _ in _tables(layer.get(table)):
            check_label(name, f"{table}.{name}")


def check_label(name: str, path: str) -> None:
    """Raise ModelError for a name, of the user's own, of a coupling, load or error that is none."""
    _check_name(name, path, _LINK_NAME, ())


def _check_name(name: str, path: str, form: re.Pattern[str], taken: tuple[str, ...]) -> None:
    """Raise ModelError for one bad name."""
    if name in taken:
        raise ModelError("this name is taken", path=path, given=name, allowed="another name")
    if not form.fullmatch(name):
        letters = "letters, digits, _ and -" if form is _LINK_NAME else "letters, digits and _"
        raise ModelError("not a name", path=path, given=name, allowed=f"{letters}, at most 60")


def full_path(segments: tuple[str, ...], names: Names) -> tuple[str, ...]:
    """Return the segments of a reference with the stage put in front where it was left out and there is only one."""
    if not segments or segments[0] in names.bodies or segments[0] in names.stages or len(names.stages) != 1:
        return segments
    return (next(iter(names.stages)), *segments)


def reference(text: object, names: Names, *, path: str, sides: bool = True) -> str:
    """Return the full path of a member (`main.sun`, with `sides` also `main.sun.right`) or body.

    Raises ModelError with the nearest known name.
    """
    allowed = "a member or body" + (", or a side of a member" if sides else "")
    if not isinstance(text, str):
        raise ModelError("not a name", path=path, given=text, allowed=allowed)
    segments = full_path(tuple(text.split(".")), names)
    member = ".".join(segments[:1] if segments[0] in names.bodies else segments[:2])
    rest = segments[len(member.split(".")) :]
    if member not in names.members:
        raise ModelError(f"no such member{nearest(text, _spoken(names))}", path=path, given=text, allowed=allowed)
    if rest and (not sides or len(rest) > 1 or rest[0] not in SIDES or member in names.bodies):
        raise ModelError("no such member or side", path=path, given=text, allowed=allowed)
    return ".".join(segments)


def mesh_name(name: str, stage: str, names: Names, *, path: str) -> str:
    """Return the name of a mesh with its gears in the order sun, planet, ring; as written where both are of one kind.

    Raises ModelError where it does not join two gears of the stage.
    """
    members = names.stages.get(stage, {})
    gears = tuple(m for m, kind in members.items() if kind != "carrier")
    parts = name.split("-")
    if len(parts) != 2 or parts[0] == parts[1]:
        allowed = "two gears of the stage joined by -; a key of a mesh stands in its table, meshes.A-B.KEY"
        raise ModelError("not a mesh", path=path, given=name, allowed=allowed)
    for part in parts:
        if part not in gears:
            word = nearest(part, gears)
            raise ModelError(
                f"no gear '{part}' in this stage{word}", path=path, given=name, allowed=f"two of {', '.join(gears)}"
            )
    a, b = parts
    return f"{b}-{a}" if _RANK.get(members[a], 0) > _RANK.get(members[b], 0) else name


def nearest(word: object, known: Iterable[str]) -> str:
    """Return `; did you mean 'teeth'?`, or nothing where no known word is near."""
    found = get_close_matches(str(word)[:80], list(known), n=1, cutoff=0.6)
    return f"; did you mean '{found[0]}'?" if found else ""


def _spoken(names: Names) -> tuple[str, ...]:
    """Return the references as they are written: without the stage where there is only one."""
    short = tuple(next(iter(names.stages.values()))) if len(names.stages) == 1 else ()
    return (*short, *names.members)


def _tables(value: object) -> list[tuple[str, Mapping[str, object]]]:
    """Return the sub-tables of a table, nothing where it is none."""
    return [(str(k), v) for k, v in value.items() if isinstance(v, Mapping)] if isinstance(value, Mapping) else []
