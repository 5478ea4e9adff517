"""Titles of the ready drives, without NumPy: `epicyclic systems` answers at once."""

from __future__ import annotations

import tomllib
from importlib import resources

from ..model.document import ready_drives

__all__ = ["drive_titles"]


def drive_titles() -> dict[str, str]:
    """Name -> title of every ready drive, the model files that come with the package."""
    folder = resources.files("epicyclic.systems")
    texts = {name: folder.joinpath(f"{name}.toml").read_text(encoding="utf-8") for name in ready_drives()}
    return {name: str(tomllib.loads(text)["title"]) for name, text in texts.items()}
