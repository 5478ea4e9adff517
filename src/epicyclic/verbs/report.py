"""Every analysis a model allows, in one run: what the report shows."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ConvergenceError, ModelError
from ..warning_codes import CodedText, coded, placed
from .record import Verb, require_folder, verbs

if TYPE_CHECKING:
    import xarray as xr

    from ..engine.source import Overrides, Source
    from ..system.system import System
    from ..train.train import Train

STUDIES = ("support stiffness", "run-out")
Item = TypeVar("Item")
Result = TypeVar("Result")
TO_MODES = "sweep to the modes"
# Speeds of the sweeps of a report, about operation and to the modes: with several mesh frequencies, whose balance takes
# 20 ms a speed and more, a second each.
_POINTS, _POINTS_OF_MANY_TONES = (200, 200), (40, 25)
# Points of a curve over support stiffness and over run-out, a point taking up to a tenth of a second: bends still show.
_STUDY_POINTS = (7, 4)
# Error of loads and pressures that the tooth contact of a report is refined to; the page says what is left.  The verb
# itself goes to a hundredth, which takes half a minute where the teeth are finely relieved.
_CONTACT = 0.05
# Samples of tolerances in a report: quantiles to some thousandths, with what buys what in a second.
_SAMPLES = 2**13


def report_verbs() -> tuple[str, ...]:
    """Names of the verbs of a report, in the order in which they run."""
    shown = [verb for verb in verbs().values() if verb.in_report]
    return tuple(verb.name for verb in sorted(shown, key=lambda verb: verb.in_report))


def report_sections() -> tuple[str, ...]:
    """Names of what a report computes, as `run_report` takes them in ``sections``."""
    names: list[str] = []
    for name in report_verbs():
        names += [name, TO_MODES] if name == "sweep" else [name]
    return tuple(_section(name) for name in (*names, *STUDIES))


def _section(name: str) -> str:
    """A name without spaces: ``sweep-to-the-modes``."""
    return name.replace(" ", "-").replace("_", "-")


def run_report(
    source: Source,
    *,
    overrides: Overrides | None = None,
    sections: Sequence[str] | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[str], None] | None = None,
) -> dict[str, xr.Dataset]:
    """Run all analyses a model allows, each once.

    An analysis that asks for what the model does not say (torque, speed, damping, masses), or does not converge, is
    left out, and the first result's attribute ``not_run`` says why.  Tolerances are shown where the model has a table
    of them.

    Parameters
    ----------
    source, overrides : as of every verb.
    sections : names of `report_sections`; only these are computed, and `check`, which says what the train is.  Without
        them all are, but for the studies of trains with several mesh frequencies: their worst case over the slow phases
        takes a minute.
    folder : keeps every section that is done, and what the one at work keeps, so that a report that was stopped goes on
        with `resume`.
    progress : called with the name of what is done, in the order of the sections.

    Returns
    -------
    name -> Dataset, in the order of `report_verbs`, `TO_MODES` and `STUDIES`.

    Raises
    ------
    ModelError : the model itself is wrong, or no such section.
    """
    from ..engine.run_folder import run_folder
    from ..engine.source import train_of

    require_folder(resume, folder)
    chosen = None if sections is None else _chosen(sections)
    results: dict[str, xr.Dataset] = {}
    left_out: list[CodedText] = []
    train = train_of(source, overrides=overrides)
    options = {} if chosen is None else {"sections": sorted(chosen)}  # what tells one report from another in its folder
    with run_folder(folder, train, verb="report", options=options, resume=resume) as (train, kept):
        place = None if kept is None else kept.folder
        steps = _steps(train, place)
        if chosen is not None:
            steps = {name: step for name, step in steps.items() if _section(name) in chosen}
        elif _several_tones(train):
            words = "takes long with several mesh frequencies; it runs where --sections names it,"
            left_out += [coded("section-left-out", f"{name} {words} {_section(name)}") for name in STUDIES]
            steps = {name: step for name, step in steps.items() if name not in STUDIES}
        for name, found in zip(steps, _run_steps(steps, place, progress), strict=True):
            if isinstance(found, str):
                left_out.append(coded("section-left-out", f"{name}, as {found}"))
            else:
                results[name] = found
    first = next(iter(results.values()))
    first.attrs["not_run"] = json.dumps(left_out)
    return results


def _run_steps(
    steps: Mapping[str, Callable[[], xr.Dataset]], place: Path | None, progress: Callable[[str], None] | None
) -> list[xr.Dataset | str]:
    """The result of every section, or why it has none; where forked on several cores."""
    names = list(steps)
    # what takes longest begins first, after the one that says what the train is: no core waits for it at the end
    order = sorted(range(len(names)), key=lambda at: (at > 0, names[at] not in STUDIES))
    done: set[int] = set()

    def made(name: str) -> xr.Dataset | str:
        try:
            return steps[name]() if place is None else _kept(place, name, steps[name])
        except ModelError as error:
            if place is not None and Path(error.path).is_relative_to(place):
                raise  # a folder that takes nothing is no property of the model
            # a sentence, where nothing wrong was given
            plain = error.path and error.allowed and f"{error.path} = " not in str(error)
            return f"{error.problem}; it needs {error.allowed} in {error.path}" if plain else str(error)
        except ConvergenceError as error:
            return str(error)

    def arrived(turn: int, _: xr.Dataset | str) -> None:
        before = next((i for i in range(len(names)) if i not in done), len(names))
        done.add(order[turn])
        after = next((i for i in range(len(names)) if i not in done), len(names))
        for name in names[before:after]:
            if progress is not None:
                progress(name)

    found = side_by_side(made, [names[at] for at in order], arrived=arrived)
    return [one for _, one in sorted(zip(order, found, strict=True), key=lambda pair: pair[0])]


def side_by_side(
    work: Callable[[Item], Result], items: Sequence[Item], *, arrived: Callable[[int, Result], None] | None = None
) -> list[Result]:
    """work(item) of every item, in order; on several cores where workers are forked, so that nothing is pickled.

    arrived : called here with the place and the result of every item, as they arrive.
    """
    if sys.platform == "linux":
        from ..engine.workers import each

        return each(work, items, arrived=arrived)
    found = []
    for at, item in enumerate(items):
        found.append(work(item))
        if arrived is not None:
            arrived(at, found[-1])
    return found


def _chosen(sections: Sequence[str]) -> set[str]:
    """Names asked for, and `check`.

    Raises
    ------
    ModelError : none, or one that is not known.
    """
    names, known = [_section(name.strip()) for name in sections], report_sections()
    wrong = [name for name in names if name not in known]
    if wrong or not names:
        raise ModelError("no such section", path="sections", given=", ".join(wrong), allowed=", ".join(known))
    return {"check", *names}


def _several_tones(train: Train) -> bool:
    """Whether meshes have several frequencies, so that a worst case is one over their phases too."""
    return len(set((train.kinematics.mesh_frequency or {}).values()) - {0}) > 1


def _kept(folder: Path, name: str, step: Callable[[], xr.Dataset]) -> xr.Dataset:
    """The result of a section, from the folder where a report before has left it; else made and written there."""
    from ..engine.run_folder import remove_folder
    from ..results.dataset import load_result, save_result

    path = folder / f"{name}.kept.nc"
    if path.is_file():
        return load_result(path)
    result = step()
    save_result(result, path)
    remove_folder(folder / name)
    return result


def _steps(train: Train, folder: Path | None) -> dict[str, Callable[[], xr.Dataset]]:
    """Everything a report shows, by name; the System is made once, when first asked for.

    folder : in which a verb that keeps what is done has one of its name.
    """
    from ..engine.source import system_of
    from ..questions.studies.parameter_studies import run_out_study, support_study

    system = cache(lambda: system_of(train))
    steps: dict[str, Callable[[], xr.Dataset]] = {
        name: partial(_run, verbs()[name], train, system, folder) for name in report_verbs()
    }
    if "contact" in steps:
        steps |= {"contact": partial(verbs()["contact"].run, train, tolerance=_CONTACT)}
    if "tolerance" in steps:
        steps |= {"tolerance": partial(verbs()["tolerance"].run, train, samples=_SAMPLES, effects="shares")}
        if not train.document.get("tolerance"):  # nothing is missing in a model without tolerances
            del steps["tolerance"]
    if "sweep" in steps:
        steps["sweep"] = partial(_sweep, system, folder, "operation", 0)
        steps[TO_MODES] = partial(_sweep, system, folder, "modes", 1)
    support, run_out = _STUDY_POINTS
    studies = (partial(support_study, train, points=support), partial(run_out_study, train, points=run_out))
    return steps | dict(zip(STUDIES, studies, strict=True))


def _sweep(system: Callable[[], System], folder: Path | None, speed_range: str, which: int) -> xr.Dataset:
    """One of the two sweeps of a report."""
    points = _POINTS if len(system().tones) < 2 else _POINTS_OF_MANY_TONES
    own = None if folder is None else folder / f"sweep-{speed_range}"
    more = {} if own is None else {"folder": own, "resume": True}
    result = verbs()["sweep"].run(system(), range=speed_range, points=points[which], **more)
    if speed_range == "modes":  # what is only far from operation is said to be so
        highest = 100 * float(result["speed"].max())
        found = json.loads(result.attrs.get("warnings", "[]"))
        far = [
            one if one in system().warnings else placed(f"up to {highest:.0f} % of the operating speed", one)
            for one in found
        ]
        result.attrs["warnings"] = json.dumps(far)
    return result


def _run(verb: Verb, train: Train, system: Callable[[], System], folder: Path | None) -> xr.Dataset:
    keeps = folder is not None and "folder" in signature(verb.run).parameters
    more: dict[str, Any] = {"folder": folder / verb.name, "resume": True} if keeps and folder is not None else {}
    return verb.run(train if verb.drawing else system(), **more)
