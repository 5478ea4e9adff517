"""What several commands share: arguments, options, and how one verb is run and shown."""

from __future__ import annotations

import json
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ..results.whole_file import write_text
from .console import complain, frequency, parsed_overrides, progress_bar, reported, target_of, write_result

__all__ = [
    "Cycles",
    "FrameSpeed",
    "From",
    "Json",
    "Model",
    "Of",
    "Output",
    "RelativeSpeed",
    "Samples",
    "Sets",
    "To",
    "Turns",
    "range_end",
    "run_verb",
]


class FrameSpeed(StrEnum):
    """Which frame speed the gyroscopic terms of a sweep see."""

    kinematic = "kinematic"
    operating = "operating"


Model = Annotated[str, typer.Argument(metavar="MODEL", help="A model file (.toml) or the name of a ready drive.")]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Put a value in place of the file's; may be repeated."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, xarray's Dataset.to_dict(), on stdout.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write the result: .nc, .json or .html.")
]
RelativeSpeed = Annotated[
    float, typer.Option("--relative-speed", help="Speed per operating speed; 0 is standstill, 1 the operating point.")
]


From = Annotated[str | None, typer.Option("--from", help='Lowest mesh frequency or speed: "20 Hz", "50 rpm", "50 %".')]
To = Annotated[str | None, typer.Option("--to", help='Highest, e.g. "0.6 kHz", "2000 rpm".')]
Cycles = Annotated[
    int | None, typer.Option("--cycles", min=1, help="Length of the record in mesh cycles.", show_default="chosen")
]
Turns = Annotated[
    int | None, typer.Option("--turns", min=1, help="Length in turns of a body (--of).", show_default="chosen")
]
Of = Annotated[str | None, typer.Option("--of", metavar="BODY", help="Count turns of this body, e.g. main/sun.")]
Samples = Annotated[
    int | None, typer.Option("--samples", min=1, help="Instants per mesh cycle or turn.", show_default="chosen")
]


def range_end(text: str | None, option: str) -> float | str | None:
    """An end of a range: Hz as a number, rpm and % as they stand, for whoever knows the train."""
    return text if text is None or text.rstrip().endswith(("rpm", "%")) else frequency(text, option)


def run_verb(
    verb: str,
    model: str,
    sets: list[str] | None,
    as_json: bool,
    output: Path | None,
    *,
    write_model: Callable[[Any], str] | None = None,
    **options: Any,
) -> Any:
    """Run one verb; print it for people or as JSON, or write it to a file; return its result.

    write_model : result -> text of a model file, where the verb makes one that can be written as .toml.
    """
    with reported():
        if output is not None:
            target_of(output, (".nc", ".json", ".html", *((".toml",) if write_model else ())))
        overrides = parsed_overrides(sets)
        from ..verbs.job import Job, run

        with progress_bar(f"{verb} {model}") as step:
            result = run(Job(verb=verb, source=model, overrides=overrides, options=options), progress=step)
        if output is not None and write_model is not None and output.suffix.lower() == ".toml":
            write_text(output, write_model(result))
            complain(f"written: {output}")
        elif output is not None:
            write_result(result, output)
        if as_json:
            from ..results.dataset import to_json

            for text in json.loads(result.attrs["warnings"]):
                complain(f"warning: {text}")
            typer.echo(to_json(result))
        elif output is None or output.suffix.lower() == ".toml":
            from ..show.console import show, stdout_console

            show(result, stdout_console())
        return result
