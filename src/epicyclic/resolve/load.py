"""A model file, ready drive or dict to a Train, in one call."""

from __future__ import annotations

from collections.abc import Mapping

from ..model.toml import Source, read
from ..train.train import Train
from .resolve import resolve

__all__ = ["load"]


def load(source: Source, overrides: Mapping[str, object] | None = None) -> Train:
    """Read and resolve a train.

    Parameters
    ----------
    source : path of a model file, name of a ready drive, or the same as nested tables.
    overrides : values by path, ``{"stages.main.sun.mass": "750 kg"}``; None removes the key.

    Raises
    ------
    ModelError : whatever is wrong, with its path, what was given and what is allowed.
    """
    return resolve(read(source, overrides))
