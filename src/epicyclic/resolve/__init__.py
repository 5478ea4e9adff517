"""Document to Train: everything that follows from what the model file says."""

from .resolve import load

__all__ = ["load"]
