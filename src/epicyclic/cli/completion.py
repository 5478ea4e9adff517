"""Completion in the shell: ready drives, model files and saved results; quick, and never an error."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["explained_names", "model_names", "source_names"]

_MODELS = (".toml", ".rexs", ".rexsj", ".rexsz")
_RESULTS = (".nc", ".json")
# folder of the ready drives: reading its names must not import the model, which takes longer than a key stroke
_DRIVES = Path(__file__).parents[1] / "systems"


def model_names(incomplete: str) -> list[str]:
    """Ready drives, model files and folders that begin with what is typed; none where a folder cannot be read."""
    return _names(incomplete, _MODELS)


def source_names(incomplete: str) -> list[str]:
    """The same and saved results."""
    return _names(incomplete, (*_MODELS, *_RESULTS))


def explained_names(incomplete: str) -> list[str]:
    """Codes of warnings and variables of results that begin with what is typed."""
    from ..results.variables import VARIABLES
    from ..warning_codes import WARNING_CODES

    return [name for name in (*WARNING_CODES, *VARIABLES) if name.startswith(incomplete)]


def _names(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    try:
        drives = sorted(path.stem for path in _DRIVES.glob("*.toml") if "." not in path.stem)
        return [*(name for name in drives if name.startswith(incomplete)), *_files(incomplete, suffixes)]
    except (OSError, ValueError, RuntimeError):  # a folder that cannot be read, a name with a zero byte, no such home
        return []


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    """Files and folders below the folder that is typed; hidden ones where a point is typed."""
    head, begin = os.path.split(incomplete)
    folder = Path(head).expanduser() if head else Path()
    found = []
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        hidden = entry.name.startswith(".") and not begin.startswith(".")
        if hidden or not entry.name.startswith(begin):
            continue
        name = os.path.join(head, entry.name)  # as it is typed: ~ and ./ stay
        if entry.is_dir():
            found.append(f"{name}/")
        elif entry.name.lower().endswith(suffixes):
            found.append(name)
    return found
