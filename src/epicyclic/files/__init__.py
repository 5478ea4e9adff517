"""Text <-> Train: the model file, its units, overrides, schema and resolution.

Depends on: train, gears.
"""

from .load import load

__all__ = ["load"]
