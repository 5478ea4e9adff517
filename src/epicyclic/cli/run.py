"""One run of a verb from the command line: progress, result on stdout or in a file, errors in words of the flags."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..errors import ModelError
from ..results.whole_file import write_text
from ..verbs.record import Verb, keywords
from ..verbs.relief import RECORD
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
from .kept import kept, kept_store
from .start import import_model_rooms

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FILES", "run_verb"]

FILES = (".nc", ".json", ".html")


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
    keeps = "folder" in signature(verb.run).parameters
    record = RECORD if keeps and keywords(verb.run)["resume"][1] is not bool else ""
    store = kept_store(Path(options["store"]) if options.get("store") else None) if "store" in flags else nullcontext()
    with (
        reported(),
        _flagged(flags),
        store,
        kept(output if keeps else None, keeps=keeps, record=record) as folder,
    ):
        if output is not None:
            target_of(output, (*FILES, *((".toml",) if verb.model_text else ())))
        if as_json or output is None:
            require_stdout()
        import_model_rooms()
        overrides = parsed_overrides(sets)
        with progress_bar(f"{verb.name} {model}") as step:
            more: dict[str, Any] = {} if folder is None else {"folder": folder}
            if "progress" in signature(verb.run).parameters:
                more["progress"] = lambda done, of=1: step(done if of == 1 else done / of)
            result = verb.run(model, overrides=overrides or None, **options, **more)
        _put(verb, result, as_json=as_json, output=output)
        if result.attrs.get("stopped"):
            raise KeyboardInterrupt


def _put(verb: Verb, result: xr.Dataset, *, as_json: bool, output: Path | None) -> None:
    """Write or print a result; beside a file its key figures are printed."""
    if output is not None and verb.model_text is not None and output.suffix.lower() == ".toml":
        write_text(output, verb.model_text(result))
        complain(f"written: {output}")
    elif output is not None:
        write_result(result, output)
        if not as_json:
            from ..show.console import show_pairs, stdout_console
            from ..show.views import key_figures_of

            show_pairs({words: value for value, words in key_figures_of({verb.name: result})}, stdout_console())
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
        rest = str(error).removeprefix(error.path)
        if error.path in flags and isinstance(error.given, bool):
            # a flag without a value, as it was typed
            path = path if error.given else path.replace("--", "--no-", 1)
            rest = rest.removeprefix(f" = {error.given!r}")
        raise ModelError(path + rest) from error
