"""Document to Train: everything that follows from the model file."""

from .resolve import load

__all__ = ["load"]
