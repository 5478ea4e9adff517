"""Titles and texts of the ready drives, without NumPy: `epicyclic systems` answers at once."""

from __future__ import annotations

import tomllib
from importlib import resources

from ..errors import ModelError
from .document import ready_drives
from .schema import nearest


def drive_titles() -> dict[str, str]:
    """Name -> title of every ready drive, the model files that come with the package."""
    return {name: str(tomllib.loads(drive_text(name))["title"]) for name in ready_drives()}


def drive_text(name: str) -> str:
    """Model file of a ready drive, with its comments.

    Raises
    ------
    ModelError : no drive of this name.
    """
    names = ready_drives()
    if name not in names:
        raise ModelError(f"no ready drive{nearest(name, names)}", path="NAME", given=name, allowed=", ".join(names))
    return resources.files("epicyclic.systems").joinpath(f"{name}.toml").read_text(encoding="utf-8")
