"""The command `epicyclic study`: a verb over many points, from a job file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from ..errors import ModelError
from .console import progress_bar, reported
from .kept import kept_store
from .output import FORMATS, figure_option, put, require_output
from .start import import_model_rooms

__all__ = ["study"]


def study(
    job: Annotated[str, typer.Argument(metavar="JOB", help="A job file (.toml): verb, model, options, what varies.")],
    store: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder that keeps every point that is done; --resume goes on from it."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the store of the same job.")] = False,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, max=1024, help="Local processes.", show_default="this process")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="URL", help="A Dask scheduler that runs: tcp://HOST:8786.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON on stdout.")] = False,
    figure: Annotated[list[str] | None, figure_option(["study"])] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help=f"Write the result: {FORMATS}.")
    ] = None,
) -> None:
    """A verb over a grid, a list or a sample of values in the model file and of options, as one labelled Dataset."""
    with reported(), _flagged(), kept_store(store):
        _study(job, store, resume, workers, scheduler, as_json=as_json, figures=figure, output=output)


def _study(
    job: str,
    store: Path | None,
    resume: bool,
    workers: int | None,
    scheduler: str | None,
    *,
    as_json: bool,
    figures: list[str] | None,
    output: Path | None,
) -> None:
    require_output(output, figures, ["study"], as_json=as_json)
    import_model_rooms()
    from ..verbs.study import study as run

    with progress_bar(f"study {job}") as step:
        result = run(job, store=store, resume=resume, workers=workers, scheduler=scheduler, progress=step)
    put({"study": result}, output=output, figures=figures, as_json=as_json)


@contextmanager
def _flagged() -> Iterator[None]:
    """Name keywords by their flags in errors."""
    flags = {"store", "resume", "workers", "scheduler"}
    try:
        yield
    except ModelError as error:
        if not error.path or not set(error.path.split(", ")) <= flags:
            raise
        path = ", ".join(f"--{part}" for part in error.path.split(", "))
        raise ModelError(path + str(error).removeprefix(error.path)) from error
