"""The command `epicyclic show`: a saved result again, on the screen, as a figure, in another format."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ModelError
from ..rexs.file import is_rexs_name
from .command import Json, file_name
from .console import reported
from .output import FORMATS, put, require_output

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["show"]


def show(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Results that -o has written: .nc or .json.", show_default=False),
    ],
    figure: Annotated[
        list[str] | None,
        typer.Option(
            "--figure",
            metavar="NAME",
            help="Write this figure to -o FILE.svg, .png, .pdf or .html; a wrong one lists all.",
        ),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Print every table with every row, also what its verb leaves out.")
    ] = False,
    as_json: Json = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            parser=file_name,
            metavar="FILE",
            help=f"Write the result in another format: {FORMATS}; several results in one .html.",
        ),
    ] = None,
) -> None:
    """Print a saved result again as its verb did, draw its figures, convert it."""
    with reported():
        _show(files, figure, as_json=as_json, output=output, whole=everything)


def _show(
    files: Sequence[str], figures: Sequence[str] | None, *, as_json: bool, output: Path | None, whole: bool
) -> None:
    several = len(files) > 1
    if several and as_json:
        raise ModelError("goes with one result alone", path="--json", given=", ".join(files))
    if several and output is not None and not figures and output.suffix.lower() != ".html":
        raise ModelError("holds one result", path="--output", given=str(output), allowed=".html, or one FILE at a time")
    results = _loaded(files)
    kinds = [str(result.attrs.get("verb", "")) for result in results.values()]
    require_output(output, figures, kinds, as_json=as_json)
    try:
        put(results, output=output, figures=figures, as_json=as_json, computed=False, whole=whole)
    except (KeyError, TypeError, ValueError) as error:
        from ..results.dataset import has_digest

        if isinstance(error, ModelError) or all(has_digest(file) for file in files):
            raise  # what the package wrote is no fault of the file
        problem = f"no whole result of its verb ({', '.join(kinds)}): {type(error).__name__}: {error}"
        raise ModelError(problem, path=", ".join(files), allowed="a file as epicyclic wrote it") from error


def _loaded(files: Sequence[str]) -> dict[str, xr.Dataset]:
    """Results by the names of their files, by their paths where two have one name.

    Raises
    ------
    ModelError : a file given twice, or as of `load_result`.
    """
    from ..results.dataset import load_result

    if len(set(files)) < len(files):
        raise ModelError("given twice", path="FILE", given=", ".join(files), allowed="each file once")
    stems = [Path(file).stem for file in files]
    names = [stem if stems.count(stem) == 1 else file for stem, file in zip(stems, files, strict=True)]
    for file in files:
        if file.lower().endswith(".toml") or is_rexs_name(file):
            raise ModelError("a model, no saved result", path=str(file), allowed=f"a result; epicyclic check {file}")
    return {name: load_result(file) for name, file in zip(names, files, strict=True)}
