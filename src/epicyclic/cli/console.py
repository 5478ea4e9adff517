"""Streams and files of all commands: overrides, progress, files that appear whole or not at all, errors as text."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from ..errors import ConvergenceError, ModelError

__all__ = [
    "complain",
    "parsed_overrides",
    "progress_bar",
    "reported",
    "target_of",
    "write_result",
]

Step = Callable[[str | float], None]


def complain(text: str) -> None:
    """Write one line on stderr."""
    typer.echo(text, err=True)


@contextmanager
def reported() -> Iterator[None]:
    """Turn errors into a message on stderr and an exit status; a traceback only with EPICYCLIC_DEBUG set.

    Old spellings, which warn, are told on stderr too.
    """
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("always", category=DeprecationWarning, module=r"epicyclic\.(cli|audits)")
            warnings.showwarning = lambda message, *_, **__: complain(f"warning: {message}")
            yield
        sys.stdout.flush()
    except typer.Exit:
        raise
    except ModelError as error:
        complain(f"error: {error}")
        raise typer.Exit(2) from None
    except ConvergenceError as error:
        complain(f"no convergence: {error}")
        raise typer.Exit(3) from None
    except KeyboardInterrupt:
        complain("stopped")
        raise typer.Exit(130) from None
    except BrokenPipeError:  # the reader has seen enough; what is still buffered must not raise again at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None
    except Exception as error:
        if os.environ.get("EPICYCLIC_DEBUG"):
            raise
        complain(f"a fault of epicyclic itself, {type(error).__name__}: {error}")
        complain("please report it, with the model file and the output of the same command with EPICYCLIC_DEBUG=1")
        raise typer.Exit(1) from None


def parsed_overrides(sets: list[str] | None) -> dict[str, object]:
    """Overrides of repeated ``--set PATH=VALUE``; the last one of a path counts.

    Raises
    ------
    ModelError : no path or no = in a text.
    """
    if not sets:
        return {}
    from ..model.overrides import parse_setting

    return dict(parse_setting(text) for text in sets)


def target_of(path: Path, suffixes: tuple[str, ...]) -> None:
    """Make sure, before the work, that a result can be written there.

    Raises
    ------
    ModelError : another suffix, a directory, or no directory to write it into.
    """
    if path.suffix.lower() not in suffixes:
        raise ModelError("no such kind of output", path="--output", given=str(path), allowed=" or ".join(suffixes))
    if path.is_dir():
        raise ModelError("is a directory", path="--output", given=str(path), allowed="a file")
    if not path.absolute().parent.is_dir():
        raise ModelError(
            "its directory does not exist", path="--output", given=str(path), allowed="a file in a directory"
        )
    if not os.access(path.absolute().parent, os.W_OK):
        raise ModelError(
            "its directory cannot be written", path="--output", given=str(path), allowed="a writable place"
        )


def write_result(result: Any, path: Path) -> None:
    """Write a result as .nc, .json or .html, whole or not at all, and say so.

    Raises
    ------
    ModelError : it cannot be written.
    """
    if path.suffix.lower() == ".html":
        from ..show.report import write_report

        write_report(path, {str(result.attrs["verb"]): result})
    else:
        from ..results.dataset import save_result

        save_result(result, path)
    complain(f"written: {path}")


@contextmanager
def progress_bar(title: str, steps: int = 0) -> Iterator[Step]:
    """Show progress on stderr: a bar with per cent, time spent and time left in a terminal, else a line for each named
    step.

    Yields a function to call with the name of the step that starts (``steps`` of them), or with the share done, 0..1.
    """
    if not sys.stderr.isatty():
        yield lambda done: complain(f"{title}: {done}") if isinstance(done, str) else None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        SpinnerColumn,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    # points may take tens of seconds each: the time left follows the speed of the last five minutes
    with Progress(*columns, console=Console(stderr=True), transient=True, speed_estimate_period=300) as progress:
        task = progress.add_task(title, total=float(steps) if steps else None)
        started = 0

        def step(done: str | float) -> None:
            nonlocal started
            if isinstance(done, str):
                progress.update(task, description=f"{title}: {done}", completed=started)
                started += 1
            else:
                progress.update(task, total=1.0, completed=done)

        yield step
