"""``epicyclic compare A B [C ...]``: models or saved results beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import ModelError
from .command import Json, Output, Sets
from .completion import source_names
from .console import parsed_overrides, reported
from .output import figure_option, put, require_output
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
    sources: Sources,
    variants: Variants = None,
    sets: Sets = None,
    figure: Annotated[list[str] | None, figure_option(("compare",))] = None,
    as_json: Json = False,
    output: Output = None,
) -> None:
    """What differs between trains, and what it does to speeds, modes, load sharing and mesh forces.

    Saved results are compared variable by variable. --set applies to all models, --with makes one more of A.
    """
    with reported():
        _compare(sources, variants or [], sets, figures=figure, as_json=as_json, output=output)


def _compare(
    sources: list[str],
    variants: list[str],
    sets: list[str] | None,
    *,
    figures: list[str] | None,
    as_json: bool,
    output: Path | None,
) -> None:
    require_output(output, figures, ("compare",), as_json=as_json)
    import_model_rooms()
    from ..questions.compare.compare import compare_of

    overrides = parsed_overrides(sets) or None
    try:
        result = compare_of(sources, overrides=overrides, variants=[_variant(text) for text in variants])
    except ModelError as error:
        raise _flagged(error) from None
    put({"compare": result}, output=output, figures=figures, as_json=as_json)


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
