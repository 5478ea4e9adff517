"""The verb modulation; window and transfer path of its sensor from CSV files."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...document.units import factor
from ...errors import ModelError
from ...verbs.record import RESPONSE, Verb, takes
from . import ModulationOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive
    from .spectrum import Transfer, Window


@takes(ModulationOptions, turning=True)
def modulation(drive: "Drive", options: ModulationOptions) -> "xr.Dataset":
    """Vibration at a fixed place beside the ring: sidebands by family and cause.

    Raises
    ------
    ModelError : the model or an option is wrong; a text without a unit, a file that cannot be read.
    ConvergenceError : no steady motion found.
    """
    from .modulation import modulation as run

    window, transfer = options.window, options.transfer
    options = replace(
        options,
        window=read_window(window) if _is_file(window) else window,  # type: ignore[arg-type]
        transfer=read_transfer(transfer) if isinstance(transfer, str | Path) else transfer,
    )
    return run(drive.system, options)


def _is_file(window: object) -> bool:
    """Whether a window is the path of a table rather than a name."""
    return isinstance(window, Path) or (isinstance(window, str) and window.lower().endswith(".csv"))


# a measured path of 100 000 frequencies is some 4 MB
_MAX_BYTES = 20_000_000
Columns = dict[str, tuple[str, list[float]]]


def read_window(path: str | Path) -> "Window":
    """A window from a CSV file whose first line names its columns: ``angle [deg], gain [1]``.

    Raises
    ------
    ModelError : the file cannot be read; as of `tabulated_window`.
    """
    from .spectrum import tabulated_window

    columns = _columns(path, ("angle", "gain"))
    return tabulated_window(_in(columns, "angle", "rad", path), _in(columns, "gain", "", path))


def read_transfer(path: str | Path) -> "Transfer":
    """A transfer path from a CSV file whose first line names its columns and their units.

    ``frequency [Hz], gain [1]`` or ``frequency [Hz], accelerance [m/s^2/N], phase [deg]``; without a phase it is 0.

    Raises
    ------
    ModelError : the file cannot be read; as of `tabulated_transfer`.
    """
    from .spectrum import ACCELERATION, tabulated_transfer

    columns = _columns(path, ("frequency",))
    name = next((name for name in ("accelerance", "gain") if name in columns), "")
    if not name:
        raise ModelError("no such column", path=str(path), given=", ".join(columns), allowed="accelerance or gain")
    wanted = "m/s^2/N" if name == "accelerance" else ""
    return tabulated_transfer(
        _in(columns, "frequency", "Hz", path),
        _in(columns, name, wanted, path),
        _in(columns, "phase", "rad", path) if "phase" in columns else 0.0,
        unit=ACCELERATION if wanted else "1",
    )


def _columns(path: str | Path, needed: tuple[str, ...]) -> Columns:
    """Columns of a CSV file by name: unit and numbers."""
    from ...document.document import read_table  # brings pydantic, which completion does not wait for

    table = read_table(path, most=_MAX_BYTES, allowed=f"the columns {', '.join(needed)}")
    names = [name.lower() for name, _ in table.columns]
    if any(name not in names for name in needed) or len(set(names)) < len(names):
        raise ModelError(
            "the first line names the columns", path=str(path), given=", ".join(names), allowed=", ".join(needed)
        )
    if not table.rows:
        raise ModelError("the table is empty", path=str(path), allowed="a row of numbers for each point")
    return {name: (table.columns[i][1], table.numbers(i)) for i, name in enumerate(names)}


def _in(columns: Columns, name: str, unit: str, path: str | Path) -> list[float]:
    """A column in the unit asked for; a plain number needs none."""
    said, values = columns[name]
    scale = 1.0 if said in (unit, "1" if not unit else unit) else factor(said, unit) if said and unit else None
    if scale is None:
        raise ModelError(f"the column {name} has another unit", path=str(path), given=said, allowed=unit or "1")
    return [value * scale for value in values]


VERBS = (
    Verb(
        run=modulation,
        gives=("modulation",),
        question="How does it vibrate?",
        line="What an accelerometer on the ring sees as planets pass.",
        needs=f"{RESPONSE} ring",
    ),
)
