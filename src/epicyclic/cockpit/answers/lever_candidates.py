"""Numbers of a model that may become levers: errors, supports, load, speed, design; with their paths as written."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...document.tables import PlainTable, leaves, split_path
from ...document.units import factor
from ...document.written_numbers import Written, written
from ...train.train import Train
from ..state.spellings import at_path
from .paths import in_short

__all__ = ["Candidate", "candidates_of"]

# A soft support that is still felt, per mesh stiffness: where a floating sun is first held.
_SOFT = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A number of the model file.

    kind : pin, run_out, sun, support, load, speed or design.  path, label, unit, entry, count : as of a lever.
    value : in `unit`; 0 where the model has none, inf where it is rigid.  log : whether a slider is logarithmic.
    usual : a usual value in `unit`, of a support.  others : all entries of a list, in `unit`.
    """

    kind: str
    path: str
    label: str
    value: float
    unit: str
    log: bool = False
    usual: float = 0.0
    entry: int | None = None
    count: int | None = None
    others: tuple[float, ...] = ()

    def scaled(self, si: float) -> float:
        """A value in SI in the unit of the candidate."""
        return si / _scale(self.unit)

    def written(self) -> object:
        """Value of the override."""
        if self.entry is None:
            return Written(values=(self.value,), unit=self.unit, many=False).text((self.value,))
        values = (*self.others[: self.entry], self.value, *self.others[self.entry + 1 :])
        return Written(values=values, unit=self.unit, many=True).text(values)


def candidates_of(train: Train, tables: PlainTable, overrides: Mapping[str, object]) -> list[Candidate]:
    """Candidates of a train in the order of the page.

    tables, overrides : the model file and what is laid over it, which say how a number is written.
    """
    model = _Model(train, tables, overrides)
    return [
        *(model.pins() if model.loaded else ()),
        *(model.run_outs() if model.loaded else ()),
        *model.supports(),
        *model.operation(),
        *model.design(),
    ]


class _Model:
    """A train with its document and its texts."""

    def __init__(self, train: Train, tables: PlainTable, overrides: Mapping[str, object]) -> None:
        self.train, self.tables, self.overrides = train, tables, overrides
        self.document = dict(leaves(dict(train.document)))
        self.several = len(train.planets) > 1
        # errors of a train without load part nothing
        self.loaded = any((train.kinematics.torque or {}).values())
        self.members: dict[str, Any] = {}
        for body in train.bodies:
            self.members.setdefault(body.member, body)

    def of(self, member: str) -> str:
        """A member in words: ``sun``, ``high sun`` of several stages."""
        stage, _, name = member.rpartition(".")
        return f"{stage} {name}" if self.several else name

    def path_of(self, full: str) -> str:
        """The path at which the file or an override states a value, else the short one."""
        paths = list(dict.fromkeys([in_short(self.train, full, self.document), full, full.removesuffix(".amplitude")]))
        if full.endswith(".radial"):
            paths.append(f"{full.removesuffix('.radial')}.x")
        for path in paths:
            if path in self.overrides or written(at_path(self.tables, split_path(path, path=path))) is not None:
                return path
        return paths[0].removesuffix(".amplitude")

    def number(self, full: str) -> Written | None:
        """Number of the document at a full path; a radial stiffness is that along x."""
        names = (full, f"{full.removesuffix('.radial')}.x") if full.endswith(".radial") else (full,)
        return next((one for name in names if (one := written(self.document.get(name))) is not None), None)

    def pins(self) -> Iterator[Candidate]:
        """Tangential position of the pin that stands farthest off, else of that of planet 1."""
        for member, body in self.members.items():
            if body.kind != "planet" or body.carried_by is None or body.gear is None:
                continue
            count = self.train.planets.get(body.frame, 1)
            full = f"deviations.{member}.position.y"
            number = self.number(full)
            values = number.values if number is not None and number.many else (0.0,) * count
            if (number is not None and not number.many) or len(values) != count or count < 2:
                continue
            entry = max(range(count), key=lambda i: (abs(values[i]), -i))
            yield Candidate(
                kind="pin",
                path=self.path_of(full),
                label=f"pin of {self.of(member)} {entry + 1}, tangential",
                value=values[entry],
                unit=number.unit if number is not None and number.unit else "um",
                entry=entry,
                count=count,
                others=tuple(values),
            )

    def run_outs(self) -> Iterator[Candidate]:
        """Run-out of every member about the axis that turns; of planets where the file has one."""
        speeds = self.train.kinematics.speed or {}
        for member, body in self.members.items():
            full = f"deviations.{member}.run_out.amplitude"
            number = self.number(full)
            if number is not None and number.many:
                continue
            if body.frame not in self.train.planets or (number is None and not (speeds.get(member) and body.gear)):
                continue
            if number is None and body.kind == "planet":
                continue
            yield Candidate(
                kind="run_out",
                path=self.path_of(full),
                label=f"run-out of the {self.of(member)}{'s' if body.kind == 'planet' else ''}",
                value=0.0 if number is None else number.values[0],
                unit=number.unit if number is not None and number.unit else "um",
            )

    def supports(self) -> Iterator[Candidate]:
        """Radial stiffness of suns, whether they float or not, and of what has a finite one."""
        mesh: dict[str, float] = {}
        for one in self.train.meshes:
            mesh.setdefault(one.stage, one.stiffness)
        for member, body in self.members.items():
            sun = body.kind == "sun" and body.gear is not None
            for table in ("support", "bearing"):
                full = f"stages.{member}.{table}.radial"
                number = self.number(full)
                stated = number is not None and not number.many
                value = number.values[0] if number is not None and stated else math.inf
                if body.frame not in mesh or (number is not None and not stated):
                    continue
                if not (0 < value < math.inf) and not (sun and table == "support"):
                    continue
                unit = number.unit if number is not None and number.unit else "N/m"
                word = "bearing of the" if table == "bearing" else "support of the"
                yield Candidate(
                    kind="sun" if sun and table == "support" else "support",
                    path=self.path_of(full),
                    label=f"{word} {self.of(member)}{'s' if body.kind == 'planet' else ''}, radial",
                    value=value,
                    unit=unit,
                    log=True,
                    usual=_two_digits(_SOFT * mesh[body.frame] / _scale(unit)),
                )

    def operation(self) -> Iterator[Candidate]:
        """Torques, powers and speeds that the file states."""
        for table, kind in (("torque", "load"), ("power", "load"), ("speed", "speed")):
            for full, value in self.document.items():
                number = written(value)
                if not full.startswith(f"operation.{table}.") or number is None or number.many or not number.values[0]:
                    continue
                member = full.removeprefix(f"operation.{table}.")
                short = in_short(self.train, full, self.document).removeprefix(f"operation.{table}.")
                yield Candidate(
                    kind=kind,
                    path=self.path_of(full),
                    label=f"{table} of the {short.replace('.', ' ') if not self.several else member.replace('.', ' ')}",
                    value=number.values[0],
                    unit=number.unit,
                )

    def design(self) -> Iterator[Candidate]:
        """Helix angle, module, face width, masses, damping and mesh stiffnesses that the file states."""
        words = {"helix_angle": "helix angle", "module": "module", "face_width": "face width"}
        for full, value in self.document.items():
            parts, number = full.split("."), written(value)
            if number is None or number.many or not number.values[0]:
                continue
            stage = f" of {parts[1]}" if self.several and len(parts) > 1 else ""
            if full == "damping.modal":
                label, log = "damping of every mode", False
            elif parts[0] == "stages" and len(parts) == 3 and parts[2] in words:
                label, log = words[parts[2]] + stage, False
            elif parts[0] == "stages" and len(parts) == 4 and parts[3] == "mass":
                label, log = f"mass of the {self.of(f'{parts[1]}.{parts[2]}')}", False
            elif parts[0] == "stages" and parts[2] == "meshes" and parts[-1] == "stiffness" and len(parts) == 5:
                label, log = f"stiffness of {parts[3]}{stage}", True
            else:
                continue
            yield Candidate(
                kind="design",
                path=self.path_of(full),
                label=label,
                value=number.values[0],
                unit=number.unit,
                log=log,
            )


def _scale(unit: str) -> float:
    """SI value of one of a unit."""
    for target in ("m", "N/m", "rad", "N m", "W", "N/m^2"):
        found = factor(unit, target) if unit else 1.0
        if found:
            return found
    return 1.0


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")
