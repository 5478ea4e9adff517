"""The verb transient."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import ModelError
from ...options import Progress
from ...verbs.record import Verb, takes
from . import TransientOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive
    from .scenario import History

_MOST_BYTES, _HEADING = 200_000_000, "time [s], sun [N m]"  # of the file of a history


@takes(TransientOptions, turning=True)
def transient(drive: "Drive", options: TransientOptions, progress: Progress | None = None) -> "xr.Dataset":
    """Motion over time: start-up, torque steps and histories, speed ramps through resonance.

    Raises
    ------
    ModelError : the model, a file or an option is wrong.  ConvergenceError : no equilibrium to start from.
    """
    from .transient import transient as run

    options = replace(
        options,
        mesh_frequency=_ends(options),
        history=options.history if options.torque is None else read_history(options.torque),
        initial=_state(options.initial),
    )
    return run(drive.system, options, progress=progress)


def _ends(options: TransientOptions) -> float | tuple[float, float] | None:
    """Mesh frequency, or that at the beginning and at the end [Hz]."""
    first, last = options.start, options.stop
    if first is None:
        if last is not None:
            raise ModelError("needs the frequency at the beginning too", path="stop", given=last)
        return options.mesh_frequency
    if options.mesh_frequency is not None:
        raise ModelError("give start and stop, or mesh_frequency, not both", path="start", given=first)
    return first if last is None else (first, last)


def _state(initial: Any) -> Any:
    """Initial state as the analysis takes it: the result in a .nc file where it is the path of one."""
    if isinstance(initial, str | Path) and Path(initial).suffix == ".nc":
        from ...results.dataset import load_result

        return load_result(initial)
    return initial


def read_history(path: str | Path) -> "History":
    """Read the CSV file ``time [s], sun [N m], ...``.

    Raises
    ------
    ModelError : no such file, a header without time, names or units, a hole, a text that is no finite number, times
        that do not rise, fewer than two rows; with the number of the line.
    """
    import numpy as np

    from ...document.document import read_table
    from .scenario import History

    table = read_table(path, most=_MOST_BYTES, allowed=_HEADING)
    names = [name for name, _ in table.columns]
    kinds = ["time" if name == "time" else "torque" for name in names]
    for column, kind in enumerate(kinds):
        table.scale(column, kind, allowed=_HEADING)
    if "time" not in names or len(names) < 2:
        problem = "a history needs a column of time and one of a member"
        raise table.error(table.lines[0], problem, given=", ".join(names), allowed=_HEADING)
    if len(set(names)) < len(names):
        raise table.error(table.lines[0], "a name stands in two columns", given=", ".join(names))
    if len(table.rows) < 2:
        raise ModelError("too few rows", path=str(path), given=len(table.rows), allowed="two or more")
    read = [table.quantities(column, kind, allowed=_HEADING) for column, kind in enumerate(kinds)]
    values = {name: np.array(column) for name, column in zip(names, read, strict=True)}
    time = values.pop("time")
    table.check_rising(time.tolist())
    return History(time=time, torque=values, where=[f"{path}, line {line}" for line in table.lines[1:]])


VERBS = (
    Verb(
        run=transient,
        gives=("transient",),
        question="How does it vibrate?",
        line="Motion in time: start-up, torque steps, ramps.",
        needs="equations inertia speed balance",
        examples=({"cycles": 2},),
    ),
)
