"""Start of the command line: modules are imported with the collector of cycles at rest.

They are no garbage, but while they come it goes through all of them again and again: a tenth of a second of a command.
What has been imported is then left out of its search for good.
"""

from __future__ import annotations

import gc
import sys

__all__ = ["collect_again", "import_model_rooms"]


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
