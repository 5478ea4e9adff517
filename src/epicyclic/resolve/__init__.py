"""Document to Train: everything that follows from what the model file says."""

from .load import load

__all__ = ["load"]
