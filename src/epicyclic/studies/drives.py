"""The ready drives and their titles."""

from __future__ import annotations

import tomllib
from importlib import resources

__all__ = ["drive_titles"]


def drive_titles() -> dict[str, str]:
    """Name -> title of every model file that comes with the package."""
    files = (file for file in resources.files("epicyclic.systems").iterdir() if file.name.endswith(".toml"))
    titles = {
        file.name.removesuffix(".toml"): str(tomllib.loads(file.read_text(encoding="utf-8"))["title"]) for file in files
    }
    return dict(sorted(titles.items()))
