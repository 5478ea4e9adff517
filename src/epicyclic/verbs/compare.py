"""`compare`: several models or saved results beside each other.  No verb of one source, so without a record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..arguments import checked

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr

    from ..system.system import System
    from ..train.train import Train


@checked
def compare(
    *sources: str | Path | Mapping[str, Any] | Train | System | xr.Dataset,
    overrides: Mapping[str, Any] | None = None,
    variants: Sequence[Mapping[str, Any]] = (),
) -> xr.Dataset:
    """What differs between the drawings of several trains, and what it does to modes, load sharing and forces.

    Parameters
    ----------
    sources : model files, ready drives, dicts, Trains; or saved results (.nc, .json) and Datasets of results.  The
        first is what the others are compared with.  Results alone are compared variable by variable.
    overrides : path -> value, laid over every model.
    variants : path -> value, laid over the first model: one more train each.

    Returns
    -------
    Dataset of kind `compare` along `train`: difference_text, difference_value (difference, train); transmission_ratio,
    k_gamma, worst_mesh (train); speed (member, train) [rpm]; frequency, mode_kind, modal_assurance (mode, train), modes
    paired as `mode_pairing` says; mean_load_sharing, mesh_force_mean, mesh_force_peak (mesh, train) [N] at operation.

    Raises
    ------
    ModelError : fewer than two to compare, a wrong model or result.
    """
    from ..questions.compare.compare import compare_of

    return compare_of(sources, overrides=overrides, variants=variants)
