"""The verb transient."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from ...errors import ModelError
from ...verbs.options import Folder, Resume, frequency, seconds
from ...verbs.options import torque_step as step_of
from ...verbs.record import Option, Progress, Verb, bounded

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from ...engine.source import Overrides, Source
    from .scenario import History


@bounded
def transient(
    source: "Source",
    *,
    overrides: "Overrides | None" = None,
    duration: Annotated[
        float | str | None, Option('Length of the run [s], or e.g. "0.5 s".', default="100 mesh cycles")
    ] = None,
    cycles: Annotated[float | None, Option("Length in mesh cycles instead.", above=0, default="100")] = None,
    start: Annotated[
        float | str | None,
        Option('Mesh frequency at the beginning [Hz], or e.g. "20 Hz".', default="operating"),
    ] = None,
    stop: Annotated[
        float | str | None,
        Option("Mesh frequency at the end; a straight ramp between.", default="that at the beginning"),
    ] = None,
    mesh_frequency: Annotated[
        float | tuple[float, float] | None,
        Option("Mesh frequency [Hz], or that at the beginning and at the end.", flag=None),
    ] = None,
    torque: Annotated[
        str | Path | None, Option("Torques over time: CSV, time [s], sun [N m], ...", metavar="FILE")
    ] = None,
    history: Annotated["History | None", Option("Torques of members over time, [s] and [N m].", flag=None)] = None,
    torque_step: Annotated[
        tuple[float, float] | str | None,
        Option('Factor of all torques and from when [s], or e.g. "1.5@0.2 s".', metavar="FACTOR@TIME"),
    ] = None,
    torque_ramp: Annotated[
        float | str | None, Option("Time in which all torques grow from zero [s]: a start-up.")
    ] = None,
    initial: Annotated[
        "str | Path | NDArray[np.float64] | xr.Dataset",
        Option(
            "Initial state: equilibrium, rest, or the .nc file of a run, which goes on from its end; in Python also a "
            "result, or q and its rate (2, n) [m, m/s].",
        ),
    ] = "equilibrium",
    samples: Annotated[int, Option("Instants per mesh cycle at the highest speed.", least=1, most=1_000_000)] = 32,
    decimate: Annotated[int, Option("Keep every so many of them.", least=1)] = 1,
    contact: Annotated[Literal["unilateral", "linear"], Option("Teeth that part, or a linear model.")] = "unilateral",
    method: Annotated[Literal["rk4", "dop853", "radau"], Option("Fixed steps, or scipy's variable ones.")] = "rk4",
    folder: Folder = None,
    resume: Resume = False,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Motion over time: start-up, torque steps and histories, speed ramps through resonance.

    Raises
    ------
    ModelError : the model, a file or an option is wrong.  ConvergenceError : no equilibrium to start from.
    """
    from ...engine.source import system_of
    from .transient import transient as run

    return run(
        system_of(source, overrides=overrides),
        duration=None if duration is None else seconds(duration, "duration"),
        cycles=cycles,
        mesh_frequency=_ends(start, stop, mesh_frequency),
        torque_ramp=None if torque_ramp is None else seconds(torque_ramp, "torque_ramp"),
        torque_step=None if torque_step is None else step_of(torque_step),
        history=history if torque is None else _history(torque),
        start=_state(initial),
        samples=samples,
        decimate=decimate,
        contact=contact,
        method=method,
        folder=folder,
        resume=resume,
        progress=progress,
    )


def _ends(
    start: float | str | None, stop: float | str | None, mesh_frequency: float | tuple[float, float] | None
) -> float | tuple[float, float] | None:
    """Mesh frequency, or that at the beginning and at the end [Hz]."""
    if start is None:
        if stop is not None:
            raise ModelError("needs the frequency at the beginning too", path="stop", given=stop)
        return mesh_frequency
    if mesh_frequency is not None:
        raise ModelError("give start and stop, or mesh_frequency, not both", path="start", given=start)
    first = frequency(start, "start")
    return first if stop is None else (first, frequency(stop, "stop"))


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
