"""One run of a verb from the command line: progress, result on stdout and in a file, errors in words of the flags."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from ..results.files import write_text
from ..verbs.record import Verb, keywords, verbs
from ..verbs.relief import RECORD
from .console import complain, parsed_overrides, progress_bar, reported
from .kept import kept, kept_store
from .output import print_result, put, require_output
from .start import import_model_rooms

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["run_verb"]


def run_verb(
    verb: Verb,
    model: str,
    options: Mapping[str, Any],
    *,
    flags: Mapping[str, str],
    sets: list[str] | None,
    as_json: bool,
    output: Path | None,
    figures: list[str] | None = None,
    whole: bool = False,
) -> None:
    """Run one verb; print its result for people or as JSON, and write it, or figures of it, to a file.

    Parameters
    ----------
    options : keyword -> value of the verb.  flags : keyword -> flag, for errors.
    sets, as_json, output, figures, whole : as on the command line.

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
        further = (*verb.writers, *((".toml",) if verb.model_text else ()))
        require_output(output, figures, verb.gives, as_json=as_json, further=further)
        import_model_rooms()
        overrides = parsed_overrides(sets)
        with progress_bar(f"{verb.name} {model}") as step:
            more: dict[str, Any] = {} if folder is None else {"folder": folder}
            if "progress" in signature(verb.run).parameters:
                more["progress"] = lambda done, of=1: step(done if of == 1 else done / of)
            result = verb.run(model, overrides=overrides or None, **options, **more)
        if output is not None and not figures and (kind := output.suffix.lower()) in further:
            if verb.model_text is not None and kind == ".toml":
                write_text(output, verb.model_text(result))
            else:
                verb.writers[kind](result, output)
            complain(f"written: {output}")
            print_result(result, as_json=as_json, beside_file=True)
        else:
            make = partial(_result_of, model, overrides)
            put({verb.name: result}, output=output, figures=figures, as_json=as_json, make=make, whole=whole)
        if result.attrs.get("stopped"):
            raise KeyboardInterrupt


def _result_of(model: str, overrides: Mapping[str, object], name: str) -> xr.Dataset:
    """Result of another verb of the same model, which a figure needs too."""
    return verbs()[name].run(model, overrides=overrides or None)


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
