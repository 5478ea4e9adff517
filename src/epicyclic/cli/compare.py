"""``epicyclic compare A B [C ...]``: models or saved results beside each other."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import ModelError
from .command import Json, Output, Sets
from .completion import source_names
from .console import complain, on_stdout, parsed_overrides, reported, require_stdout, target_of, write_result
from .run import FILES
from .start import import_model_rooms

__all__ = ["compare"]

Sources = Annotated[
    list[str],
    typer.Argument(
        metavar="A B ...",
        help="Model files, ready drives or saved results (.nc, .json); A is the first.",
        autocompletion=source_names,
    ),
]
Variants = Annotated[
    list[str] | None,
    typer.Option(
        "--with",
        metavar="PATH=VALUE",
        help='A variant of A, beside it; may be repeated. Several values of one: "PATH=VALUE; PATH=VALUE".',
    ),
]


def compare(
    sources: Sources, variants: Variants = None, sets: Sets = None, as_json: Json = False, output: Output = None
) -> None:
    """What differs between trains, and what it does to speeds, modes, load sharing and mesh forces.

    Saved results are compared variable by variable. --set applies to all models, --with makes one more of A.
    """
    with reported():
        if output is not None:
            target_of(output, FILES)
        if as_json or output is None:
            require_stdout()
        import_model_rooms()
        from ..studies.compare.compare import compare_of

        try:
            result = compare_of(
                sources, overrides=parsed_overrides(sets) or None, variants=[_variant(text) for text in variants or ()]
            )
        except ModelError as error:
            raise _flagged(error) from None
        _put(result, as_json=as_json, output=output)


def _variant(text: str) -> dict[str, object]:
    """Overrides of one variant.

    Raises
    ------
    ModelError : no path or no = in a part of the text.
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    if not parts:
        raise ModelError("says nothing", path="--with", given=text, allowed="PATH=VALUE")
    return parsed_overrides(parts)


def _flagged(error: ModelError) -> ModelError:
    """The same error at the flag or argument in place of the keyword."""
    names = {"overrides": "--set", "variants": "--with", "sources": "A B ..."}
    return error.at(names.get(error.path, error.path)) if error.path in names else error


def _put(result: Any, *, as_json: bool, output: Path | None) -> None:
    """Write or print the comparison; beside a file its key figures are printed."""
    from ..show.console import show, show_pairs, stdout_console

    if output is not None:
        write_result(result, output)
    if as_json:
        from ..results.dataset import to_json

        for text in json.loads(result.attrs["warnings"]):
            complain(f"warning: {text}")
        with on_stdout():
            typer.echo(to_json(result))
        return
    with on_stdout():
        if output is None:
            show(result, stdout_console())
        else:
            from ..show.views import key_figures_of

            show_pairs({words: value for value, words in key_figures_of({"compare": result})}, stdout_console())
