"""Streams and files of all commands: overrides, progress, results on stdout or in whole files, errors as text.

Modules are imported with the collector of cycles at rest: they are no garbage, but while they come it goes through all
of them again and again, a tenth of a second of a command.  What has been imported is left out of its search for good.
"""

from __future__ import annotations

import gc
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..errors import ConvergenceError, ModelError
from ..input_files import as_output, outputs_apart
from ..results.files import require_writable

if TYPE_CHECKING:
    from ..engine.plan import Counted


def collect_again() -> None:
    """Let the collector work, on what is made from now on; it rests since `epicyclic.__main__` began."""
    gc.freeze()
    gc.enable()


def import_model_rooms() -> None:
    """Import what every verb reads its model with; nothing where that is done already, in a process that lives on."""
    if "epicyclic.engine.source" in sys.modules:
        return
    gc.disable()
    # xarray loads dask.array with its first variable wherever Dask is installed, 0.3 s that only blocks by Dask need:
    # a name without a module says that it is not there; `engine.dask_workers` takes the name away again
    # (where xarray is here already, in a process that lives on, it has asked for Dask and would miss it)
    if "xarray" not in sys.modules:
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]
    try:
        from ..engine import source  # noqa: F401
    finally:
        collect_again()


Step = Callable[[str | float], None]
# Cells of a workbook that take five seconds, on a busy machine fifteen.
_LARGE = 500_000
# what a terminal would take as an order, in names of files and texts that are quoted in messages
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def open_streams() -> None:
    """Make the standard streams safe to write to, before anything else is opened.

    Where one is closed its number would go to the next file that is opened, and what a library prints would go into it.
    What the encoding of a stream cannot say is escaped, not a fault.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def complain(text: str) -> None:
    """Write one line on stderr; control characters are escaped, and a stderr that takes no line is no fault."""
    try:
        typer.echo(_CONTROL.sub(lambda found: f"\\x{ord(found[0]):02x}", text), err=True)
    except OSError:
        _drop(sys.stderr)


def complain_of(warnings: Sequence[str]) -> None:
    """Write the physical warnings of a result on stderr, as a list; of none nothing."""
    if not warnings:
        return
    from ..show.console import show_warnings, stderr_console

    plain = [_CONTROL.sub(lambda found: f"\\x{ord(found[0]):02x}", text) for text in warnings]
    try:
        show_warnings(plain, stderr_console())
    except OSError:
        _drop(sys.stderr)


def require_stdout() -> None:
    """Make sure, before the work, that there is a stdout.

    Raises
    ------
    ModelError : it is closed.
    """
    if sys.stdout is None:
        raise ModelError("is closed", path="stdout", allowed="an open stream, or -o FILE")


@contextmanager
def on_stdout() -> Iterator[None]:
    """The block writes on stdout, all of it: a reader that has seen enough ends the command without an error.

    Raises
    ------
    ModelError : stdout is closed, or its disk is full.
    """
    require_stdout()
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _drop(sys.stdout)
        raise typer.Exit(0) from None
    except OSError as error:
        _drop(sys.stdout)
        raise ModelError(f"cannot be written: {error.strerror or error}", path="stdout") from None


@contextmanager
def help_on_stdout() -> Iterator[None]:
    """The block may print a help, outside of any command; raises typer.Exit with the status of `reported`."""
    try:
        with on_stdout() if sys.stdout is not None else nullcontext():
            yield
    except SystemExit as error:
        if isinstance(
            error.__context__, BrokenPipeError
        ):  # rich, which prints the help of a command, ends with 1 there
            raise typer.Exit(0) from None
        raise
    except ModelError as error:
        complain(f"error: {error}")
        raise typer.Exit(2) from None


def _drop(stream: Any) -> None:
    """Let what a stream still holds go nowhere, so that it does not raise again at the end."""
    with suppress(OSError, ValueError, AttributeError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)


@contextmanager
def reported() -> Iterator[None]:
    """Turn errors into a message on stderr and an exit status; a traceback only with EPICYCLIC_DEBUG set.

    No file is source and output.
    """
    try:
        with outputs_apart():
            yield
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
    from ..document.overrides import parse_setting

    return dict(parse_setting(text) for text in sets)


def target_of(path: Path, suffixes: tuple[str, ...]) -> None:
    """Make sure, before the work, that a result can be written there, and let the work not read from there.

    Raises
    ------
    ModelError : another suffix, a file that has been read, or as of `require_writable`.
    """
    if not path.suffix or not path.name.lower().endswith(suffixes):
        raise ModelError("no such kind of output", path="--output", given=str(path), allowed=" or ".join(suffixes))
    try:
        require_writable(path)
    except ModelError as error:
        raise ModelError(error.problem, path="--output", given=str(path), allowed=error.allowed) from None
    as_output(path)


def write_result(result: Any, path: Path) -> None:
    """Write a result as .nc, .json, .csv, .xlsx or .html, whole or not at all, and say so.

    Raises
    ------
    ModelError : it cannot be written.
    """
    kind = path.suffix.lower()
    if kind == ".html":
        from ..show.report import write_report

        write_report(path, {str(result.attrs["verb"]): result})
    else:
        from ..results.dataset import save_result
        from ..results.tables_out import cells_of

        if kind == ".xlsx" and (cells := cells_of(result)) > _LARGE:
            complain(f"a workbook of {cells} cells takes a while; .nc and .csv are quicker")
        save_result(result, path)
    complain(f"written: {path}")


@contextmanager
def progress_bar(title: str, steps: int = 0) -> Iterator[Step]:
    """Show progress on stderr: a bar with per cent, time spent and time left in a terminal, else a line for each named
    step.

    Yields a function to call with the name of the step that starts (``steps`` of them), or with the share done, 0..1.
    A share that is `Counted` shows the counts and their rate; without a terminal in a line now and then.
    """
    rate = _Rate()
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done: _tell(title, done, rate)
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

    from ..engine.plan import Counted  # numpy, which help does without

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
                words = rate.words(done) if isinstance(done, Counted) else ""
                progress.update(task, total=1.0, completed=done, description=f"{title}{words}")

        yield step


# Seconds between two lines of progress where there is no terminal: a job of a night leaves some hundreds.
_LINE = 60.0


class _Rate:
    """Rate of what is counted, since the first count: what lay in a store cost nothing."""

    def __init__(self) -> None:
        self.began: tuple[float, int] | None = None
        self.started = self.told = time.monotonic()

    def words(self, done: Counted) -> str:
        """``, 37 of 128, 4.1 a second``."""
        now = time.monotonic()
        self.began = self.began or (now, done.done)
        fresh, seconds = done.done - self.began[1], now - self.began[0]
        rate = f", {fresh / seconds:.3g} a second" if fresh and seconds > 0 else ""
        return f", {done.done} of {done.of}{rate}"

    def left(self, done: Counted) -> str:
        """``, 22 s left``."""
        if self.began is None or done.done == self.began[1]:
            return ""
        spent = time.monotonic() - self.began[0]
        return f", {spent / (done.done - self.began[1]) * (done.of - done.done):.0f} s left"


def _tell(title: str, done: str | float, rate: _Rate) -> None:
    """A line for a named step, and for a count or a share now and then."""
    from ..engine.plan import Counted  # numpy, which help does without

    if isinstance(done, str):
        complain(f"{title}: {done}")
    elif isinstance(done, Counted):
        words = rate.words(done)
        if time.monotonic() - rate.told >= _LINE:
            rate.told = time.monotonic()
            complain(f"{title}{words}{rate.left(done)}")
    elif time.monotonic() - rate.told >= _LINE:
        rate.told = time.monotonic()
        spent = rate.told - rate.started
        left = f", {spent / done * (1 - done):.0f} s left" if done > 0 else ""
        complain(f"{title}: {done:.0%}, {spent:.0f} s{left}")
