"""What a state of the cockpit shows, computed: the live set of a lever that moves, and all of a state at rest."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...document.document import drive_text
from ...errors import ConvergenceError, ModelError
from ...questions.sharing.definitions import require_speed
from ...system.assembly import assemble
from ...system.system import System
from ...train.resolution import load
from ...train.train import Train
from ..state.frames import (
    OfferedChange,
    PageFrame,
    Request,
    SpeedAxis,
    body_labels,
    failed_frame,
    mesh_labels,
    override_at,
    speed_axis,
)
from . import answers
from .answers import is_quick, offered_of
from .levers import levers_at
from .speed_view import ForceCurves, ModeView, SpeedModel, efforts, force_curves, mode_view, speed_head, speed_model
from .train_view import (
    SharingView,
    Shown,
    Twin,
    error_view,
    live_sharing,
    operation_head,
    sharing_head,
    train_head,
    twin_of,
)

Found = TypeVar("Found")

# Time for load sharing where instants have to be solved one by one, while a lever moves and at rest [s].
_LIVE_PATIENCE, _FULL_PATIENCE = 0.05, 0.5
# A small drive with every kind of result, for the first run of everything.
_WARM = "ren2021"


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """A train with what follows from it for every frame."""

    request: Request
    train: Train
    system: System
    labels: Mapping[str, str]
    meshes: Mapping[str, str]
    axis: SpeedAxis | None


class _Missing(NamedTuple):
    """What is not computed: for which pane, why, and the path in the model file that it is about."""

    pane: str
    text: str
    path: str


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """What is known of a state so far; None: not known, and ``missing`` says why of what the model lacks.

    seconds : that the live set took, by which the time of a job is estimated.
    shift : what becomes of the resonance in the twin, "" as long as nobody knows.
    """

    modes: ModeView | None = None
    sharing: SharingView | None = None
    twin: Twin | None = None
    errors: Shown | None = None
    ready: SpeedModel | None = None
    curves: ForceCurves | None = None
    missing: tuple[_Missing, ...] = ()
    seconds: float = 0.0
    shift: str = ""
    changes: tuple[OfferedChange, ...] = ()


# The newest live set, and the request that it is of without its number.
_newest: tuple[Request, _Model, _Parts] | None = None


_NOT_COMPUTED = (ModelError, ConvergenceError, ArithmeticError, np.linalg.LinAlgError)


class _Stopped(Exception):
    """Somebody waits for something newer."""


def compute(
    request: Request, *, stop: Callable[[], bool] | None = None, early: Callable[[PageFrame], None] | None = None
) -> Iterator[PageFrame]:
    """Frames of a state, the first within a tenth of a second or two; the caller may stop between any two.

    ``live``: one frame with everything a lever moves: train, modes, sharing, errors, the sweep with mesh orders,
    answers, checks.  ``full``: that, then frames ``sweep`` (200 speeds, then 60 with shaft orders), ``errors`` and
    ``sharing`` (of a longer record where instants are solved one by one), each with the answers as they then are; where
    a resonance matters ``changes``, answers with what moves it away.  ``levers``: one frame with the levers of the
    model file.

    A model that is wrong gives one frame ``failed`` with the problem, its path, what was given and what is allowed.

    Parameters
    ----------
    stop : asked every few milliseconds while frames after the first are computed, which take up to a second; when it is
        true, the frame at work is given up and no other follows.
    early : called with a frame ``curve`` of what the frame ``live`` will say of forces over speed, but for the names of
        peaks, as soon as that is known: about half way to it.
    """
    start = time.perf_counter()

    def pause() -> None:
        if stop is not None and stop():
            raise _Stopped

    try:
        if request.kind == "levers":
            levers = levers_at(request.source, request.overrides)
            yield PageFrame(rev=request.rev, kind="levers", head={"levers": [asdict(lever) for lever in levers]})
            return
        model, parts = _live_set(request, early)
        yield _live_frame(model, parts, start)
        if request.kind == "full":
            yield from _further_frames(model, parts, pause)
    except _Stopped:
        return
    except _NOT_COMPUTED as error:
        frame = failed_frame(request.rev, error)
        yield replace(frame, head={**frame.head, "path": override_at(frame.head["path"], request.overrides)})


def warm_up() -> None:
    """Import what `compute` needs, by all frames of a drive that has every kind of result: no lever waits for it."""
    for _ in compute(Request(rev=0, kind="full", source=tomllib.loads(drive_text(_WARM)))):
        pass


def _live_set(request: Request, early: Callable[[PageFrame], None] | None) -> tuple[_Model, _Parts]:
    """Train and live set of a request; those of the request before where a lever is only let go.

    Raises
    ------
    ModelError : the model is wrong, or cannot be assembled, or the speed is not above zero.
    """
    global _newest
    same = replace(request, rev=0, kind="live")
    # a file may have changed meanwhile
    if _newest is not None and _newest[0] == same and not isinstance(request.source, Path):
        return replace(_newest[1], request=request), _newest[2]
    start = time.perf_counter()
    require_speed(request.relative_speed)
    train = load(request.source, dict(request.overrides))
    model = _Model(request, train, assemble(train), body_labels(train), mesh_labels(train), speed_axis(train))
    system, relative_speed, missing = model.system, request.relative_speed, list[_Missing]()
    curves = None
    ready = _attempt("sweep", "forces over speed", lambda: speed_model(system), missing)
    if ready is not None:
        effort = efforts(ready)[0]
        curves = _attempt("sweep", "forces over speed", lambda: force_curves(ready, effort), missing)
    if early is not None and curves is not None:
        state = {"computed_ms": 1e3 * (time.perf_counter() - start)}
        early(_frame(model, "curve", _shown(model, _Parts(curves=curves)), {"state": state}))
    modes = _attempt(
        "modes", "modes", lambda: mode_view(train, system, model.labels, relative_speed=relative_speed), missing
    )
    shared = _attempt("sharing", "load sharing", lambda: live_sharing(system, patience=_LIVE_PATIENCE), missing)
    twin = errors = None
    if shared is not None:
        twin = twin_of(train, shared)
        errors = _attempt(
            "errors", "share of the errors", lambda: error_view(train, system, request.overrides), missing
        )
    parts = _Parts(modes, shared, twin, errors, ready, curves, tuple(missing), time.perf_counter() - start)
    _newest = same, model, parts
    return model, parts


def _attempt(pane: str, what: str, compute_it: Callable[[], Found], missing: list[_Missing]) -> Found | None:
    """A result, or None and why it is missing: what cannot be computed leaves the rest of the page alone."""
    try:
        return compute_it()
    except ModelError as error:
        allowed = f"; allowed: {error.allowed}" if error.allowed else ""
        missing.append(_Missing(pane, f"no {what}: {error.problem}{allowed}", error.path))
    except _NOT_COMPUTED as error:
        missing.append(_Missing(pane, f"no {what}: {error}", ""))
    return None


def _live_frame(model: _Model, parts: _Parts, start: float) -> PageFrame:
    """The frame of the live set."""
    relative_speed, shown = model.request.relative_speed, _shown(model, parts)
    head = {
        "train": train_head(model.train, model.labels, model.meshes, relative_speed=relative_speed),
        **_answers(model, parts, shown),
        "assumed": dict(model.train.assumed),
        "missing": {one.pane: one.text for one in parts.missing},
        "state": {
            **operation_head(model.train, relative_speed=relative_speed),
            "computed_ms": 1e3 * (time.perf_counter() - start),
            "live_ms": 1e3 * parts.seconds,
            "mesh_frequencies": len({tone for tone in model.system.tones if tone}),
        },
    }
    return _frame(model, "live", shown, head, {} if parts.sharing is None else {"meshes/load": parts.sharing.load})


def _further_frames(model: _Model, parts: _Parts, pause: Callable[[], None]) -> Iterator[PageFrame]:
    """The frames of a state at rest, after the live one."""
    system, missing = model.system, list[_Missing]()
    if parts.ready is not None and parts.curves is not None:
        ready = parts.ready
        for effort in efforts(ready)[1:]:
            work = partial(force_curves, ready, effort, pause=pause)
            curves = _attempt("sweep", "forces over speed", work, missing)
            if curves is not None:
                parts = replace(parts, curves=curves)
                yield _part_frame(model, parts, "sweep")
    parts = replace(parts, shift=_shift(model, parts))
    if parts.errors is not None:
        yield _part_frame(model, parts, "errors")
    if parts.sharing is not None:
        whole: SharingView | None = replace(parts.sharing, whole=True)
        if not parts.sharing.spread.quick:  # mean loads are exact already; the strip is of a longer record
            longer = partial(live_sharing, system, patience=_FULL_PATIENCE)
            whole = _attempt("sharing", "load sharing", longer, missing)
        parts = replace(parts, sharing=whole or parts.sharing, missing=(*parts.missing, *missing))
        yield _part_frame(model, parts, "sharing")
    yield from _change_frame(model, parts, pause)


def _change_frame(model: _Model, parts: _Parts, pause: Callable[[], None]) -> Iterator[PageFrame]:
    """The answers with what moves a resonance that matters away, where that is quick."""
    system, told = model.system, _told(model, parts, _shown(model, parts))
    resonance = answers.resonance_answer(model.train, system, told.get("modes"), told.get("sweep"))
    if resonance.mode is not None and resonance.level != "good" and is_quick(model.train, system):
        relative = model.request.relative_speed
        work = partial(offered_of, model.train, model.axis, resonance, relative, told=lambda _: pause())
        parts = replace(parts, changes=_attempt("modes", "changes", work, []) or ())
        yield _frame(model, "changes", {}, _answers(model, parts, _shown(model, parts)))


def _shift(model: _Model, parts: _Parts) -> str:
    """What becomes of the resonance in the twin, whose modes take longer than a lever may wait; "" where unknown."""
    twin, modes, relative_speed = parts.twin, parts.modes, model.request.relative_speed
    if twin is None or modes is None or not modes.tones:
        return ""
    try:
        of_twin = mode_view(twin.train, twin.system, model.labels, relative_speed=relative_speed)
    except _NOT_COMPUTED:
        return ""
    told, told_of_twin = (_told_modes(view, _mode_rows(model, view)) for view in (modes, of_twin))
    to_rpm = None if model.axis is None else model.axis[1]
    return answers.resonance_shift([(model.system, told), (twin.system, told_of_twin)], relative_speed, to_rpm)


def _mode_rows(model: _Model, view: ModeView) -> list[dict[str, Any]]:
    return view.rows(model.axis, model.request.relative_speed, len(model.train.planets))


def _told_modes(view: ModeView, rows: Any) -> dict[str, Any]:
    """Modes as the answers take them: with the mesh orders that meet them."""
    names = ("frequency", "shape", "mass", "bends", "bent", "bent_mass", "crossings", "force_ratio", "at_rest")
    return {"rows": rows, **{name: getattr(view, name) for name in names}}


def _part_frame(model: _Model, parts: _Parts, name: str) -> PageFrame:
    """A frame of one part, with the answers as they now are."""
    shown = _shown(model, parts)
    return _frame(model, name, {name: shown[name]}, _answers(model, parts, shown))


def _frame(
    model: _Model,
    kind: str,
    shown: Mapping[str, Shown],
    head: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]] = MappingProxyType({}),
) -> PageFrame:
    """A frame of parts, and what stands beside them; its numbers are float32."""
    tables = {name: table for name, (table, _) in shown.items()}
    of_parts = {f"{name}/{key}": array for name, (_, values) in shown.items() for key, array in values.items()}
    with np.errstate(over="ignore"):
        small = {name: np.asarray(values, dtype=np.float32) for name, values in {**arrays, **of_parts}.items()}
    return PageFrame(rev=model.request.rev, kind=kind, head={**head, **tables}, arrays=small)


def _shown(model: _Model, parts: _Parts) -> dict[str, Shown]:
    """Parts of a frame by their names; those that there are."""
    shown: dict[str, Shown] = {}
    if parts.modes is not None:
        names = ("frequency", "shape", "mass", *(("bent", "bent_mass") if parts.modes.bent_mass.size else ()))
        values = {name: getattr(parts.modes, name) for name in names}
        shown["modes"] = _mode_rows(model, parts.modes), values
    if parts.sharing is not None:
        shown["sharing"] = sharing_head(parts.sharing, parts.twin, model.train, model.meshes)
    if parts.errors is not None:
        shown["errors"] = parts.errors
    if parts.curves is not None and model.axis is not None:
        head, arrays = speed_head(parts.curves, model.axis, parts.modes, list(model.meshes.values()))
        head["operating"] = model.axis[1] * model.request.relative_speed
        head["uncounted"] = answers.curve_note(model.train)
        shown["sweep"] = head, arrays
    return shown


def _told(model: _Model, parts: _Parts, shown: Mapping[str, Shown]) -> dict[str, Any]:
    """What the answers are asked with: what is shown, and of the modes the mesh orders that meet them."""
    told = {name: {**table, **values} for name, (table, values) in shown.items() if name != "modes"}
    if parts.modes is not None:
        told["modes"] = _told_modes(parts.modes, shown["modes"][0])
    if parts.twin is not None:
        told["twin"] = {**parts.twin.head, "coefficient": parts.twin.coefficient, "resonance": parts.shift}
    return told


def _answers(model: _Model, parts: _Parts, shown: Mapping[str, Shown]) -> dict[str, Any]:
    """Answers and checks of a frame."""
    found = answers.answers_of(model.train, model.system, _told(model, parts, shown), parts.changes)
    checks = answers.checks_of(model.train, model.system)
    for missing in parts.missing:
        checks.append({"level": "warn", "code": "not-computed", "text": missing.text, "path": missing.path})
    return {"answers": [asdict(answer) for answer in found], "checks": checks}
