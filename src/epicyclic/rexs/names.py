"""Names of REXS files: asked of every model before any of the rooms that read XML is imported."""

from __future__ import annotations

from pathlib import Path

__all__ = ["SUFFIXES", "is_rexs_name"]

SUFFIXES = (".rexs", ".rexsj", ".rexsz", ".rexs.xml", ".rexs.json", ".rexs.zip")


def is_rexs_name(name: str | Path) -> bool:
    """Whether a file is a REXS file by its name."""
    return str(name).lower().endswith(SUFFIXES)
