"""What fails in a model: the warnings of `check` with their codes, as short as the page needs them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from ...errors import ModelError
from ...statics.equilibrium import compliance_of
from ...statics.unheld import unheld_warnings
from ...system.system import System
from ...system.tooth_pairs import pair_of, tooth_warnings
from ...train.train import Train
from ...warning_codes import WARNING_CODES, CodedText, code_of, coded

# Codes of trains that cannot be built or do not run; all others are warnings.
_FAILS = frozenset(
    {
        *("not-assembled", "ring-too-small", "planets-collide", "tips-in-roots", "contact-ratio-below-one"),
        *("shafts-not-alike", "centre-distances-differ", "not-solvable", "no-tooth-contact", "load-not-held"),
    }
)
_PATH = re.compile(r"\b(?:stages|operation|deviations|bodies|couplings|loads|damping|tolerance)(?:\.[\w-]+)+")


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelCheck:
    """One line of the checks.

    level : ``bad`` where the train cannot be built or solved, else ``warn``.  code : of `warning_codes`, or "".
    text : without its code.  path : of the model file, "" where the text names none.  cure : what helps.
    """

    level: Literal["bad", "warn"]
    code: str
    text: str
    path: str
    cure: str


def checks_of(train: Train, system: System) -> tuple[ModelCheck, ...]:
    """Warnings of the train, its teeth and its equations; those that fail first."""
    said = [*train.warnings, *_teeth(train), *unheld_warnings(system, compliance_of(system).free)]
    found = [_check(text) for text in dict.fromkeys(said)]
    return tuple(sorted(found, key=lambda one: one.level != "bad"))


def _teeth(train: Train) -> list[CodedText]:
    """Warnings of the tooth contact of the first mesh of every pair that has teeth."""
    first = {mesh.pair: mesh for mesh in reversed(train.meshes) if mesh.teeth is not None}
    said: list[CodedText] = []
    for mesh in first.values():
        try:
            said += tooth_warnings(pair_of(train, mesh), mesh)
        except ModelError as error:
            if error.path != "operation.torque":
                said.append(coded("no-tooth-contact", str(error)))
    return said


def _check(text: CodedText) -> ModelCheck:
    code = code_of(text) or ""
    plain = text.removesuffix(f" [{code}]") if code else str(text)
    path = _PATH.search(plain)
    return ModelCheck(
        level="bad" if code in _FAILS else "warn",
        code=code,
        text=plain,
        path=path[0] if path else "",
        cure=WARNING_CODES[code].cure if code else "",
    )
