"""The command `epicyclic report`: all that a model allows in one page, or several models side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ConvergenceError, ModelError
from .command import Sets, file_name
from .console import complain, on_stdout, parsed_overrides, progress_bar, reported, require_stdout, target_of
from .kept import kept

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["report"]

# Trains side by side: more columns than that nobody reads on a screen.
_MOST = 4


def report(
    models: Annotated[
        list[str],
        typer.Argument(metavar="MODEL", help="Model files (.toml) or ready drives; several are put side by side."),
    ],
    sets: Sets = None,
    sections: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Compute only these, with commas between: modes,sharing; a wrong one lists them all."
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", parser=file_name, metavar="FILE", help="The HTML file to write.")
    ] = Path("epicyclic-report.html"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue a report that was stopped; needs the same -o and options.")
    ] = False,
) -> None:
    """What passes and what to change, and everything the model allows, in one HTML file that opens offline."""
    _report(models, sets, sections, output, resume)


def _report(models: Sequence[str], sets: list[str] | None, sections: str | None, output: Path, resume: bool) -> None:
    several = len(models) > 1
    with reported(), kept(output, keeps=not several) as folder:
        target_of(output, (".html",))
        require_stdout()
        if len(models) > _MOST:
            raise ModelError("too many models", path="MODEL", given=len(models), allowed=f"{_MOST} at most")
        if several and resume:
            raise ModelError("goes with one model alone", path="--resume", given=", ".join(models))
        from ..verbs.report import STUDIES, report_verbs

        if several:
            _require_models(models, sets)
        names = None if sections is None else sections.split(",")
        each = len(names) + 1 if names else len(report_verbs()) + len(STUDIES) + 1
        found: dict[str, dict[str, Any]] = {}
        with progress_bar(f"report {' '.join(models)}", each * len(models) + 1) as step:
            for name, model in _named(models).items():
                more = {} if several else {"folder": folder, "resume": resume}
                found[name] = _run(model, sets, names, step, more)
            step("figures")
            _write(found, output, _compared(models, sets) if several else None)
        with on_stdout():
            _print(found, output)


def _require_models(models: Sequence[str], sets: list[str] | None) -> None:
    """Read every model before the first is computed, which takes seconds. Raises ModelError."""
    from ..engine.source import train_of

    for model in models:
        train_of(model, overrides=parsed_overrides(sets))


def _named(models: Sequence[str]) -> dict[str, str]:
    """What each model is called in the page: its file without folder and ending; one that comes again is numbered."""
    found: dict[str, str] = {}
    for model in models:
        name, number = Path(model).stem or model, 2
        short = name
        while name in found:
            name, number = f"{short} ({number})", number + 1
        found[name] = model
    return found


def _run(
    model: str, sets: list[str] | None, sections: list[str] | None, step: Any, more: dict[str, Any]
) -> dict[str, Any]:
    from ..verbs.report import run_report

    try:
        return run_report(model, overrides=parsed_overrides(sets), sections=sections, progress=step, **more)
    except ModelError as error:
        if error.path != "sections":
            raise
        raise ModelError(error.problem, path="--sections", given=error.given, allowed=error.allowed) from None


def _compared(models: Sequence[str], sets: list[str] | None) -> Any:
    """What differs between the models, as `compare` says it; None where it cannot."""
    from ..studies.compare.compare import compare_of

    try:
        return compare_of(models, overrides=parsed_overrides(sets) or None)
    except (ModelError, ConvergenceError) as error:
        complain(f"left out: what differs between the models: {error}")
        return None


def _write(found: dict[str, dict[str, Any]], output: Path, compared: Any) -> None:
    from ..show.report import write_report, write_variants_report
    from ..verbs.report import side_by_side

    if len(found) == 1:
        write_report(output, next(iter(found.values())), each=side_by_side)
    else:
        write_variants_report(output, found, compared=compared)


def _print(found: dict[str, dict[str, Any]], output: Path) -> None:
    """Key figures and warnings of one train, differences of several."""
    from ..show.console import show_pairs, show_table, show_warnings, stdout_console, warnings_of
    from ..show.report import difference_table
    from ..show.views import key_figures_of

    console = stdout_console()
    for name, results in found.items():
        title = results["check"].attrs["title"]
        console.print(title if len(found) == 1 else f"{name}: {title}", style="bold", markup=False)
        show_warnings(list(dict.fromkeys(text for result in results.values() for text in warnings_of(result))), console)
        for text in json.loads(results["check"].attrs.get("not_run", "[]")):
            console.print(f"left out: {text}", markup=False, soft_wrap=True)
    if len(found) == 1:
        show_pairs({words: value for value, words in key_figures_of(next(iter(found.values())))}, console)
    else:
        show_table(difference_table(found), console)
    console.print(f"written: {output}", markup=False, soft_wrap=True)
