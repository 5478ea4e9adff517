"""One run of a verb from the command line: progress, result on stdout or in a file, errors in words of the flags."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..errors import ModelError
from ..results.locked_folder import remove_folder
from ..results.whole_file import write_text
from ..verbs.record import Verb
from .console import (
    complain,
    on_stdout,
    parsed_overrides,
    progress_bar,
    reported,
    require_stdout,
    target_of,
    write_result,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FILES", "run_verb"]

FILES = (".nc", ".json", ".html")
STOPPED = 130
_OWN = "run.json equation.npz [0-9][0-9][0-9][0-9][0-9][0-9].npy"  # files of a run in its folder


def run_verb(
    verb: Verb,
    model: str,
    options: Mapping[str, Any],
    *,
    flags: Mapping[str, str],
    sets: list[str] | None,
    as_json: bool,
    output: Path | None,
) -> None:
    """Run one verb; print its result for people or as JSON, or write it to a file.

    Parameters
    ----------
    options : keyword -> value of the verb.  flags : keyword -> flag, for errors.
    sets, as_json, output : as on the command line.

    Raises
    ------
    typer.Exit : 2 wrong input, 3 no convergence, 130 stopped, 1 a fault of the program.
    """
    with reported(), _flagged(flags), _kept(verb, output) as keeping:
        if output is not None:
            target_of(output, (*FILES, *((".toml",) if verb.model_text else ())))
        if as_json or output is None:
            require_stdout()
        overrides = parsed_overrides(sets)
        with progress_bar(f"{verb.name} {model}") as step:
            if "progress" in signature(verb.run).parameters:
                keeping["progress"] = lambda done, of=1: step(done / of)
            result = verb.run(model, overrides=overrides or None, **options, **keeping)
        _put(verb, result, as_json=as_json, output=output)
    if result.attrs.get("stopped"):
        raise typer.Exit(STOPPED)


def _put(verb: Verb, result: xr.Dataset, *, as_json: bool, output: Path | None) -> None:
    """Write or print a result."""
    if output is not None and verb.model_text is not None and output.suffix.lower() == ".toml":
        write_text(output, verb.model_text(result))
        complain(f"written: {output}")
    elif output is not None:
        write_result(result, output)
    if not as_json and (output is None or output.suffix.lower() == ".toml"):
        from ..show.console import show, stdout_console

        with on_stdout():
            show(result, stdout_console())
        return
    for text in json.loads(result.attrs["warnings"]):
        complain(f"warning: {text}")
    if as_json:
        from ..results.dataset import to_json

        with on_stdout():
            typer.echo(to_json(result))


@contextmanager
def _flagged(flags: Mapping[str, str]) -> Iterator[None]:
    """Name keywords by their flags in errors."""
    names = {"overrides": "--set", **flags}
    try:
        yield
    except ModelError as error:
        path = ", ".join(names.get(part, part) for part in error.path.split(", "))
        raise ModelError(path + str(error).removeprefix(error.path)) from error


@contextmanager
def _kept(verb: Verb, output: Path | None) -> Iterator[dict[str, Any]]:
    """Keyword `folder` of a verb that keeps what is done: beside the output, until the run is whole."""
    folder = None if output is None or not output.name else output.with_name(output.name + ".parts")
    if folder is None or "folder" not in signature(verb.run).parameters or not folder.absolute().parent.is_dir():
        yield {}
        return
    try:
        yield {"folder": folder}
    except (KeyboardInterrupt, ModelError) as error:
        if not any(folder.glob("*.npy")):
            remove_folder(folder, _OWN)  # nothing to go on from
        elif isinstance(error, KeyboardInterrupt) or error.problem.startswith("cannot be written"):
            complain(f"what is done is kept in {folder}; the same command with --resume continues it")
        raise
    remove_folder(folder, _OWN)
