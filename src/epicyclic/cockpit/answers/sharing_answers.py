"""The answers on load sharing: the planet that carries most, what a floating sun buys, the error that hurts most."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...train.train import Train
from ..computing.names import listed
from .answer import Answer, Level, answer, number
from .assumed import class_six
from .paths import scaled

__all__ = ["error_answer", "float_answer", "planet_answer"]

# Mesh-load factors that are usual for so many planets without proof, of wind and industrial gears: what a train is
# measured by.  More planets: as for seven.
_USUAL = {1: 1.0, 2: 1.0, 3: 1.1, 4: 1.25, 5: 1.35, 6: 1.44, 7: 1.47}
# Above the usual factor by more than a tenth: the gears are no longer those that were rated.
_FAR = 0.1
# A K_gamma this close to 1 is 1; a change of it below this is none (half a unit of the last digit shown).
_ONE, _NO_CHANGE = 5e-7, 5e-4
# Coefficients this close to the largest are the same: planets that symmetry loads alike differ by rounding alone.
_TIED = 1e-6
# Share of the excess of K_gamma that makes an error worth a word, and worth a warning [%].
_WORTH, _MOST = 1.0, 50.0
# Branch in the label of a mesh: "sun, planet 2 left", "sun, star1 5".
_BRANCH = re.compile(r"\b(\w+) (\d+)\b")
_MANY = {"planet": "planets", "branch": "branches"}
_HALVE = "Halve this deviation"
_ASSUME = "Assume ISO class 6 deviations"


def planet_answer(train: Train, sharing: Mapping[str, Any] | None, errors: Mapping[str, Any] | None) -> Answer:
    """The branch with the largest coefficient, by the definition mean-load; while turning where all are equal."""
    if sharing is None:
        return answer("planet", _no_load(train))
    value = np.asarray(sharing["coefficient"], dtype=float)
    if not np.isfinite(value).any():
        return answer("planet", "Not known: no mesh carries load.")
    largest, turning = float(np.nanmax(value)), float(sharing.get("k_gamma_turning") or np.nan)
    planets = _planets(train)
    if largest <= 1 + _ONE and not has_deviations(train):
        text = f"No deviations are given: all {planets} planets carry the same; class 6 of ISO 1328-1 may be assumed."
        values = class_six(train)
        return answer(
            "planet", text, figure="1.000", apply=values, apply_label=_ASSUME, evidence="sharing", level="none"
        )
    if largest <= 1 + _ONE:
        while_turning = np.asarray(sharing.get("turning", value), dtype=float)
        peak = ""
        if turning > 1 + _ONE and np.isfinite(while_turning).any():
            whom = carrying(sharing["rows"], while_turning, f"up to {turning:.3f}")
            peak = f"; while turning {whom[:1].lower()}{whom[1:]}"
        text = f"All planets carry the same mean load: nothing that stands still parts it{peak}."
        return answer("planet", text, figure=f"{largest:.3f}", level=_level(turning, planets), evidence="sharing")
    text = carrying(sharing["rows"], value, f"{largest:.3f}") + ", mean-load K_gamma"
    if turning > largest + _NO_CHANGE:
        text += f" ({turning:.3f} while turning)"
    mean, peak = _level(largest, planets), _level(turning - _FAR, planets)
    worse = _worse(mean, peak)
    return answer(
        "planet",
        f"{text}{_because(errors)}.",
        # the figure that the level is of stands in the line
        figure=f"{largest:.3f}" if worse == mean else f"{largest:.3f}, {turning:.3f} turning",
        level=worse,
        evidence="sharing",
    )


def _worse(one: Level, other: Level) -> Level:
    """The worse of two levels of load; what turns lasts a part of each revolution, so it counts from 0.1 above."""
    order: tuple[Level, ...] = ("good", "warn", "bad")
    return max(one, other, key=order.index)


def carrying(rows: Sequence[Mapping[str, Any]], value: NDArray[np.float64], much: str) -> str:
    """``Planets 2, 3 carry 1.034 of their fair share at sun-planet``: the branches that carry most, and at which pair
    of gears where they have another one."""
    tied = [row for row, one in zip(rows, value, strict=True) if one >= np.nanmax(value) - _TIED]
    sides: dict[tuple[str, int, str], set[str]] = {}  # by word, branch and stage
    for row in tied:
        word, branch, side, of = _seat(str(row["label"]))
        sides.setdefault((word, branch, of), set()).add(side)
    branches: dict[tuple[str, str, str], list[int]] = {}  # a branch that carries as much on both sides needs no side
    for (word, branch, of), own in sides.items():
        branches.setdefault((word, "".join(own) if len(own) == 1 else "", of), []).append(branch)
    whom = " and ".join(
        f"{word if len(own) == 1 else _MANY.get(word, word)} {listed(own) if any(own) else ''}".rstrip() + side + of
        for (word, side, of), own in branches.items()
    )
    carry, their = ("carries", "its") if len(sides) == 1 else ("carry", "their")
    pairs = dict.fromkeys(str(row["pair"]) for row in tied)
    theirs = {str(row["pair"]) for row in rows if _seat(str(row["label"]))[::3] in {key[::2] for key in sides}}
    at = "" if set(pairs) == theirs else f" at {' and '.join(pairs)}"
    return f"{whom[:1].upper()}{whom[1:]} {carry} {much} of {their} fair share{at}"


def _seat(label: str) -> tuple[str, int, str, str]:
    """Of the label of a mesh: what its branch is called and its number, 0 where it has none; its side; its stage."""
    stage, colon, rest = label.partition(": ") if ": " in label else ("", "", label)
    branch = _BRANCH.search(rest)
    if branch is None:
        return f"mesh {label}", 0, "", ""
    side = next((f" {word}" for word in ("left", "right") if label.endswith(word)), "")
    word = "planet" if branch[1] == "planet" else "branch"
    return word, int(branch[2]), side, f" of {stage}" if colon else ""


def _level(factor: float, planets: int) -> Level:
    usual = _USUAL.get(planets, _USUAL[7])
    return "good" if not factor > usual else "warn" if factor <= usual + _FAR else "bad"


def _because(errors: Mapping[str, Any] | None) -> str:
    """The error with the largest share, where it is known."""
    if errors is None or not errors["rows"] or not float(errors["rows"][0]["share"]) > _WORTH:
        return ""
    first = errors["rows"][0]
    share = float(first["share"])
    much = "most" if share >= _MOST else f"{share:.0f} %"
    return f"; {much} of what is above 1 from {first['label']}"


def has_deviations(train: Train) -> bool:
    """Whether anything deviates from the drawing: a member, a mesh or a pin that is not where or as it should be."""
    return any(np.any(item.vector) for item in train.displacements) or any(item.amplitude for item in train.mesh_errors)


def float_answer(train: Train, sharing: Mapping[str, Any] | None, twin: Mapping[str, Any] | None) -> Answer:
    """K_gamma of the train beside that of the same train with a floating sun, or with a supported one."""
    if not any(body.kind == "sun" and body.gear is not None for body in train.bodies):
        return answer("float", "The train has no sun that could float.")
    if sharing is None:
        return answer("float", _no_load(train))
    if twin is None or sharing["k_gamma"] is None:
        return answer("float", "The sun has no radial support of its own to take away, or nothing else holds it.")
    now, then = float(sharing["k_gamma"]), float(twin["k_gamma"])
    figure = f"{now:.3f} → {then:.3f}"
    if not has_deviations(train) and now <= 1 + _ONE:
        text = "Nothing yet: without deviations the planets share equally, floating sun or not."
        return answer("float", text, figure="0 %", evidence="sharing")
    of_stage = f" of {twin['stage']}" if len(train.planets) > 1 else ""
    if twin["value"] != 0:
        text = f"The sun{of_stage} floats already: K_gamma {now:.3f}; with a rigid support it would be {then:.3f}."
        return answer("float", text, figure=f"{now:.3f}", level="good", evidence="sharing")
    if abs(now - then) < _NO_CHANGE:
        text = f"Nothing: K_gamma is {now:.3f} with the support of the sun{of_stage} and without it."
        return answer("float", text, figure="0 %", level="good", evidence="sharing")
    if then > now:
        text = f"It costs: without its support the sun{of_stage} raises K_gamma from {now:.3f} to {then:.3f}."
        return answer("float", text, figure=figure, level="good", evidence="sharing")
    text = f"K_gamma falls from {now:.3f} to {then:.3f} where the sun{of_stage} floats."
    level: Level = "warn" if now - then > 0.01 else "good"
    return answer(
        "float",
        text,
        figure=figure,
        level=level,
        apply={str(twin["path"]): twin["value"]},
        apply_label="Let the sun float",
        evidence="sharing",
    )


def error_answer(train: Train, sharing: Mapping[str, Any] | None, errors: Mapping[str, Any] | None) -> Answer:
    """The deviation without which K_gamma falls most; where the drawing has tolerances a job says their shares."""
    job = "tolerance" if train.document.get("tolerance") and sharing is not None else None
    if sharing is None:
        return answer("error", _no_load(train))
    if not has_deviations(train):
        text = "No deviations are given: no error costs anything; class 6 of ISO 1328-1 may be assumed."
        return answer(
            "error", text, figure="0 %", apply=class_six(train), apply_label=_ASSUME, evidence="errors", job=job
        )
    if errors is None or not errors["rows"]:
        text = "No deviation parts the load: all of them follow the mesh frequency, which is no part of K_gamma."
        return answer("error", text, evidence="errors", job=job)
    first = errors["rows"][0]
    share = float(first["share"])
    of = "while turning" if "turning" in str(errors.get("of", "")) else "mean-load"
    if not share > _WORTH or float(errors["k_gamma"]) - 1 < _NO_CHANGE:
        return _turning_error(train, errors, of, job)
    without = float(first.get("without", np.nan))
    then = f"; {without:.3f} without it" if np.isfinite(without) else ""
    return answer(
        "error",
        f"of K_gamma\u00a0-\u00a01 ({of}): {first['label']}{then}.",
        figure=f"{share:.0f} %",
        level="warn" if share >= _MOST and _level(float(errors["k_gamma"]), _planets(train)) != "good" else "good",
        apply=scaled(train, str(first["path"]), 0.5),
        apply_label=_HALVE,
        evidence="errors",
        job=job,
    )


def _turning_error(train: Train, errors: Mapping[str, Any], of: str, job: str | None) -> Answer:
    """The answer where no deviation parts the mean load: the one that costs most while the train turns."""
    first = max(errors["rows"], key=lambda row: float(row.get("turning", 0.0)))
    turning = float(first.get("turning", 0.0))
    text = f"No single deviation changes K_gamma ({of}) by {number(_WORTH)} % of what it is above 1"
    if not turning > _WORTH:
        return answer("error", f"{text}.", figure="0 %", level="good", evidence="errors", job=job)
    return answer(
        "error",
        f"{text}; while turning the largest part has the {first['label']}, {turning:.0f} %.",
        figure=f"{turning:.0f} %",
        level="good",
        apply=scaled(train, str(first["path"]), 0.5),
        apply_label=_HALVE,
        evidence="errors",
        job=job,
    )


def _planets(train: Train) -> int:
    return max(train.planets.values(), default=1)


def _no_load(train: Train) -> str:
    """Why there is no load to share."""
    if not train.kinematics.torque or not any(train.kinematics.torque.values()):
        return "Not known: no torque loads the teeth (operation.torque)."
    return "Not known: the load has no equilibrium in this model."
