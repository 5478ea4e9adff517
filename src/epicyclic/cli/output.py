"""What every command does with a result: files of all kinds, figures by name, tables on the screen."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..errors import ModelError
from ..show.plot import companions, figure_names
from .console import complain, complain_of, on_stdout, require_stdout, target_of, write_result

if TYPE_CHECKING:
    import xarray as xr

FILES = (".nc", ".json", ".csv", ".xlsx", ".html")
"""Kinds of files of a result."""
FORMATS = ".nc, .json, .csv, .xlsx or .html"
# those of one figure; `show.plot` has the same
_FIGURES = (".svg", ".png", ".pdf", ".html")


def figure_option(kinds: Iterable[str]) -> Any:
    """The option ``--figure``, whose help names the figures of some kinds of result."""
    names = _names(kinds)
    words = f"Write this figure to -o FILE.svg, .png, .pdf or .html; may be repeated: {', '.join(names)}."
    return typer.Option("--figure", metavar="NAME", help=words, hidden=not names)


def _names(kinds: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for kind in kinds for name in figure_names(kind)))


def require_output(
    output: Path | None,
    figures: Sequence[str] | None,
    kinds: Iterable[str],
    *,
    as_json: bool,
    further: Sequence[str] = (),
) -> None:
    """Make sure, before the work, that its result can be written and printed as asked for.

    Parameters
    ----------
    figures : of ``--figure``.  kinds : kinds of result that may come.  further : suffixes of this command alone.

    Raises
    ------
    ModelError : no such figure or kind of file, a figure without a file, what kaleido needs is missing, or the file
        cannot be written.
    """
    if as_json or output is None:
        require_stdout()
    names = _names(kinds)
    for figure in figures or ():
        if figure not in names:
            allowed = ", ".join(names) or "none: this result has no figures"
            raise ModelError("no such figure", path="--figure", given=figure, allowed=allowed)
        if output is None:
            raise ModelError("needs a file", path="--figure", given=figure, allowed=f"-o FILE, {' or '.join(_FIGURES)}")
    if output is None:
        return
    if not figures:
        if output.suffix.lower() in _FIGURES and output.suffix.lower() not in (*FILES, *further):
            allowed = f"--figure NAME beside it, of {', '.join(names)}" if names else " or ".join(FILES)
            raise ModelError("is a file of one figure", path="--output", given=str(output), allowed=allowed)
        return target_of(output, (*FILES, *further))
    from ..show.plot import require_figures

    for target in _targets(figures, output).values():
        target_of(target, _FIGURES)
    require_figures(output)


def _targets(figures: Sequence[str], output: Path) -> dict[str, Path]:
    """File of each figure: that of ``-o``, of several each with the name of its figure."""
    several = len(set(figures)) > 1
    return {name: output.with_stem(f"{output.stem}-{name}") if several else output for name in figures}


def put(
    results: Mapping[str, xr.Dataset],
    *,
    output: Path | None,
    figures: Sequence[str] | None = None,
    as_json: bool = False,
    make: Callable[[str], xr.Dataset] | None = None,
    computed: bool = True,
    whole: bool = False,
) -> None:
    """Write a result, or figures of it, and print it: tables, or JSON with the warnings on stderr.

    Parameters
    ----------
    results : name -> Dataset; one, or several that are read from files.
    make : makes the result of a verb of the same model, which a figure needs too.
    computed : now, so that a result that cannot be written as asked for is kept; False of one from a file.
    whole : of `print_result`.

    Raises
    ------
    ModelError : the file cannot be written, the figure not drawn; a stream is closed.
    """
    if output is not None:
        try:
            _write(results, output, figures or (), make)
        except ModelError as error:
            if computed and not error.problem.startswith("cannot be written"):
                _rescue(results, output)
            raise
    for result in results.values():
        print_result(result, as_json=as_json, beside_file=output is not None, whole=whole)


def _write(
    results: Mapping[str, xr.Dataset],
    output: Path,
    figures: Sequence[str],
    make: Callable[[str], xr.Dataset] | None,
) -> None:
    if figures:
        from ..show.plot import plot, write_figure

        for name, target in _targets(figures, output).items():
            further = _company(name, results, make)
            try:
                figure = plot(name, *results.values(), *further)
            except ModelError as error:
                raise ModelError(error.problem, path="--figure", given=name, allowed=error.allowed) from None
            write_figure(figure, target)
            complain(f"written: {target}")
    elif len(results) == 1:
        (result,) = results.values()
        write_result(result, output)
    else:
        from ..show.report import write_report

        write_report(output, results)
        complain(f"written: {output}")


def _company(
    name: str, results: Mapping[str, xr.Dataset], make: Callable[[str], xr.Dataset] | None
) -> list[xr.Dataset]:
    """Further results that a figure needs, of the same model.

    Raises
    ------
    ModelError : one is needed, and there is only what stands in files.
    """
    kinds = [str(result.attrs.get("verb", "")) for result in results.values()]
    wanted = dict.fromkeys(one for kind in kinds for one in companions(kind, name) if one not in kinds)
    if wanted and make is None:
        words = " and ".join(f"`epicyclic {kind.replace('_', '-')}`" for kind in wanted)
        allowed = f"the result of {words} beside it: epicyclic show FILE FILE --figure {name}"
        raise ModelError("needs one more result of the same model", path="--figure", given=name, allowed=allowed)
    return [make(kind) for kind in wanted] if make else []


def _rescue(results: Mapping[str, xr.Dataset], output: Path) -> None:
    """Keep what has been computed, where no file is in the way."""
    from ..results.dataset import save_result

    (result,) = results.values()
    kept = output.with_suffix(".nc")
    if not kept.exists():
        save_result(result, kept)
        complain(f"the result is kept in {kept}; `epicyclic show` prints, draws and converts it")


def print_result(result: xr.Dataset, *, as_json: bool, beside_file: bool = False, whole: bool = False) -> None:
    """Print a result: tables, or JSON with its warnings on stderr.

    Parameters
    ----------
    beside_file : it stands in a file too: a stdout that is closed is no error then.
    whole : all tables with all rows, also those that a brief view leaves out.

    Raises
    ------
    ModelError : stdout is closed, or its disk is full.
    """
    if as_json:
        from ..results.dataset import to_json

        complain_of(json.loads(result.attrs.get("warnings", "[]")))
        with on_stdout():
            typer.echo(to_json(result))
    elif not beside_file or sys.stdout is not None:
        from ..show.console import show, stdout_console

        with on_stdout():
            show(result, stdout_console(), whole=whole)
