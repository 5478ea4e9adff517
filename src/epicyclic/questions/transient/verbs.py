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
        history=options.history if options.torque is None else _history(options.torque),
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


def _history(path: str | Path) -> "History":
    """Torques of a CSV file as the analysis takes them."""
    import numpy as np

    from ...document.document import read_history
    from .scenario import History

    table = read_history(path)
    return History(
        time=np.array(table.time),
        torque={name: np.array(values) for name, values in table.torque.items()},
        where=tuple(f"{path}, line {line}" for line in table.line),
    )


VERBS = (Verb(run=transient, gives=("transient",), examples=({"cycles": 2},)),)
