"""Streams and files of all commands: overrides, progress, results on stdout or in whole files, figures, errors as text.

Modules are imported with the collector of cycles at rest: they are no garbage, but while they come it goes through all
of them again and again, a tenth of a second of a command.  What has been imported is left out of its search for good.
"""

from __future__ import annotations

import gc
import json
import os
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ..errors import ConvergenceError, ModelError
from ..options import ALL_CASES
from ..results.files import require_writable, write_text
from ..show.plot import FIGURE_FILES, companions, figure_names, plot, require_figures, write_figure
from ..user_input import as_output, outputs_apart

if TYPE_CHECKING:
    import xarray as xr

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
        from ..engine import source, workers  # noqa: F401

        workers.keep_freed_memory()
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


def put_text(text: str, output: Path | None, suffix: str, *, force: bool = True) -> None:
    """Write the text of a file, or print it, in UTF-8 whatever the encoding of stdout: escapes of a terminal are none
    of TOML.

    Raises
    ------
    ModelError : as of `target_of`; stdout is closed.
    """
    if output is not None:
        target_of(output, (suffix,), force=force)
        write_text(output, text)
        return complain(f"written: {output}")
    with on_stdout():
        typer.echo(text.encode("utf-8"), nl=False)


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
        # where an interrupt passed through the text of an `exec`, as dataclasses have at import, `python -m` ends by
        # the signal and not with the status; another `exec` takes that back
        exec("")
        raise typer.Exit(130) from None
    except Exception as error:
        if os.environ.get("EPICYCLIC_DEBUG"):
            raise
        complain(f"a fault of epicyclic itself, {type(error).__name__}: {error}")
        complain("please report it, with the model file and the output of the same command with EPICYCLIC_DEBUG=1")
        raise typer.Exit(1) from None


def parsed_overrides(sets: list[str] | None, case: str | None = None) -> dict[str, object]:
    """Overrides of repeated ``--set PATH=VALUE``, the last one of a path counts, and of ``--case NAME``.

    Raises
    ------
    ModelError : no path or no = in a text.
    """
    chosen: dict[str, object] = {} if case is None else {"case": case}
    if not sets:
        return chosen
    from ..document.overrides import parse_setting

    return {**dict(parse_setting(text) for text in sets), **chosen}


def every_case(sets: list[str] | None, case: str | None) -> bool:
    """Whether ``--case all``, or a setting that says the same, asks for all load cases."""
    return f"case={ALL_CASES}" in (sets or ()) if case is None else case == ALL_CASES


def target_of(path: Path, suffixes: tuple[str, ...], *, name: str = "--output", force: bool = True) -> None:
    """Make sure, before the work, that a result can be written there, and let the work not read from there.

    name : of the option, for an error.  force : whether a file that is there is replaced.

    Raises
    ------
    ModelError : another suffix, a file that is there or has been read, or as of `require_writable`.
    """
    if not path.suffix or not path.name.lower().endswith(suffixes):
        raise ModelError("no such kind of output", path=name, given=str(path), allowed=" or ".join(suffixes))
    if not force and (path.exists() or path.is_symlink()):
        raise ModelError("is there already", path=name, given=str(path), allowed="another name, or --force")
    try:
        require_writable(path)
    except ModelError as error:
        raise ModelError(error.problem, path=name, given=str(path), allowed=error.allowed) from None
    as_output(path)


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
    from rich import progress as bars
    from rich.console import Console

    from ..engine.plan import Counted  # numpy, which help does without

    text = bars.TextColumn("{task.description}")
    columns = (bars.SpinnerColumn(), text, bars.BarColumn(), bars.TaskProgressColumn(), bars.TimeElapsedColumn())
    left = (bars.TextColumn("left"), bars.TimeRemainingColumn())
    # points may take tens of seconds each: the time left follows the speed of the last five minutes
    look: dict[str, Any] = {"console": Console(stderr=True), "transient": True, "speed_estimate_period": 300}
    with bars.Progress(*columns, *left, **look) as progress:
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


FILES = (".nc", ".json", ".csv", ".xlsx", ".html")
"""Kinds of files of a result."""
FORMATS = ".nc, .json, .csv, .xlsx or .html"


def figure_option(kinds: Iterable[str]) -> Any:
    """The option ``--figure``, whose help names the figures of some kinds of result."""
    names = _names(kinds)
    words = f"Write this figure to -o FILE.svg, .png, .pdf or .html; may be repeated: {', '.join(names)}."
    return typer.Option("--figure", metavar="NAME", help=words, hidden=not names)


def _names(kinds: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for kind in kinds for name in figure_names(kind)))


def require_output(
    output: Path | None,
    figures: Sequence[str] | None,
    kinds: Iterable[str],
    *,
    as_json: bool,
    further: Sequence[str] = (),
) -> None:
    """Make sure, before the work, that its result can be written and printed as asked for.

    Parameters
    ----------
    figures : of ``--figure``.  kinds : kinds of result that may come.  further : suffixes of this command alone.

    Raises
    ------
    ModelError : no such figure or kind of file, a figure without a file, what kaleido needs is missing, or the file
        cannot be written.
    """
    if as_json or output is None:
        require_stdout()
    names = _names(kinds)
    for figure in figures or ():
        if figure not in names:
            allowed = ", ".join(names) or "none: this result has no figures"
            raise ModelError("no such figure", path="--figure", given=figure, allowed=allowed)
        if output is None:
            raise ModelError(
                "needs a file", path="--figure", given=figure, allowed=f"-o FILE, {' or '.join(FIGURE_FILES)}"
            )
    if output is None:
        return
    if not figures:
        if output.suffix.lower() in FIGURE_FILES and output.suffix.lower() not in (*FILES, *further):
            allowed = f"--figure NAME beside it, of {', '.join(names)}" if names else " or ".join(FILES)
            raise ModelError("is a file of one figure", path="--output", given=str(output), allowed=allowed)
        return target_of(output, (*FILES, *further))
    for target in _targets(figures, output).values():
        target_of(target, FIGURE_FILES)
    require_figures(output)


def _targets(figures: Sequence[str], output: Path) -> dict[str, Path]:
    """File of each figure: that of ``-o``, of several each with the name of its figure."""
    several = len(set(figures)) > 1
    return {name: output.with_stem(f"{output.stem}-{name}") if several else output for name in figures}


def put(
    results: Mapping[str, xr.Dataset],
    *,
    output: Path | None,
    figures: Sequence[str] | None = None,
    as_json: bool = False,
    make: Callable[[str], xr.Dataset] | None = None,
    computed: bool = True,
    whole: bool = False,
) -> None:
    """Write a result, or figures of it, and print it: tables, or JSON with the warnings on stderr.

    Parameters
    ----------
    results : name -> Dataset; one, or several that are read from files.
    make : makes the result of a verb of the same model, which a figure needs too.
    computed : now, so that a result that cannot be written as asked for is kept; False of one from a file.
    whole : of `print_result`.

    Raises
    ------
    ModelError : the file cannot be written, the figure not drawn; a stream is closed.
    """
    if output is not None:
        try:
            _write(results, output, figures or (), make)
        except ModelError as error:
            if computed and not error.problem.startswith("cannot be written"):
                _rescue(results, output)
            raise
    for result in results.values():
        print_result(result, as_json=as_json, beside_file=output is not None, whole=whole)


def _write(
    results: Mapping[str, xr.Dataset],
    output: Path,
    figures: Sequence[str],
    make: Callable[[str], xr.Dataset] | None,
) -> None:
    for name, target in _targets(figures, output).items():
        further = _company(name, results, make)
        try:
            figure = plot(name, *results.values(), *further)
        except ModelError as error:
            raise ModelError(error.problem, path="--figure", given=name, allowed=error.allowed) from None
        write_figure(figure, target)
        complain(f"written: {target}")
    if figures:
        return
    if len(results) > 1 or output.suffix.lower() == ".html":
        from ..show.report import write_report

        named = {str(result.attrs["verb"]): result for result in results.values()}
        write_report(output, results if len(results) > 1 else named)
    else:
        from ..results.dataset import cells_of, save_result

        (result,) = results.values()
        if output.suffix.lower() == ".xlsx" and (cells := cells_of(result)) > _LARGE:
            complain(f"a workbook of {cells} cells takes a while; .nc and .csv are quicker")
        save_result(result, output)
    complain(f"written: {output}")


def _company(
    name: str, results: Mapping[str, xr.Dataset], make: Callable[[str], xr.Dataset] | None
) -> list[xr.Dataset]:
    """Further results that a figure needs, of the same model.

    Raises
    ------
    ModelError : one is needed, and there is only what stands in files.
    """
    kinds = [str(result.attrs.get("verb", "")) for result in results.values()]
    wanted = dict.fromkeys(one for kind in kinds for one in companions(kind, name) if one not in kinds)
    if wanted and make is None:
        words = " and ".join(f"`epicyclic {kind.replace('_', '-')}`" for kind in wanted)
        allowed = f"the result of {words} beside it: epicyclic show FILE FILE --figure {name}"
        raise ModelError("needs one more result of the same model", path="--figure", given=name, allowed=allowed)
    return [make(kind) for kind in wanted] if make else []


def _rescue(results: Mapping[str, xr.Dataset], output: Path) -> None:
    """Keep what has been computed, where no file is in the way."""
    from ..results.dataset import save_result

    (result,) = results.values()
    kept = output.with_suffix(".nc")
    if not kept.exists():
        save_result(result, kept)
        complain(f"the result is kept in {kept}; `epicyclic show` prints, draws and converts it")


def print_result(result: xr.Dataset, *, as_json: bool, beside_file: bool = False, whole: bool = False) -> None:
    """Print a result: tables, or JSON with its warnings on stderr.

    Parameters
    ----------
    beside_file : it stands in a file too: a stdout that is closed is no error then.
    whole : all tables with all rows, also those that a brief view leaves out.

    Raises
    ------
    ModelError : stdout is closed, or its disk is full.
    """
    if as_json:
        from ..results.dataset import to_json

        complain_of(json.loads(result.attrs.get("warnings", "[]")))
        with on_stdout():
            typer.echo(to_json(result))
    elif not beside_file or sys.stdout is not None:
        from ..show.console import show, stdout_console

        with on_stdout():
            show(result, stdout_console(), whole=whole)
