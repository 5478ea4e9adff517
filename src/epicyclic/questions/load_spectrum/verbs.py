"""The verb spectrum, whose source is a load history and no model."""

from typing import TYPE_CHECKING

from ...errors import ModelError
from ...verbs.record import Verb, takes
from . import SpectrumOptions

if TYPE_CHECKING:
    import xarray as xr

    from ...engine.source import Drive


@takes(SpectrumOptions)
def spectrum(drive: "Drive", options: SpectrumOptions) -> "xr.Dataset":
    """Load cases from a history of torque and speed: hours and revolutions by bins, cycles of the torque by rainflow.

    Parameters
    ----------
    source : a history in time or a table of bins, .csv or .xlsx; or its columns, heading with unit -> values.
    overrides : path of the model file -> value, of the train.

    Raises
    ------
    ModelError : the history, with its line, the train or an option is wrong.
    """
    from .load_spectrum import load_spectrum, read_load_history

    if options.train is None and drive.overrides:
        raise ModelError("go with a train", path="overrides", given=", ".join(drive.overrides), allowed="train")
    train = None if options.train is None else type(drive)(options.train, drive.overrides).train
    return load_spectrum(read_load_history(drive.source, options), train, options)


def _cases_text(result: "xr.Dataset") -> str:
    """The load cases as a fragment of a model file."""
    from .load_spectrum import cases_text

    return cases_text(result)


_READS = "A history in time or a table of bins (.csv, .xlsx): time [s], torque [kN m], speed [rpm]."
VERBS = (Verb(run=spectrum, gives=("spectrum",), model_text=_cases_text, reads=_READS),)
