"""Questions of a train, one folder each: analysis, options and record."""

import os

ROOMS = tuple(f"questions.{name}" for name in sorted(os.listdir(__path__[0])) if name.isidentifier() and name[0] != "_")
"""Folders of the questions, as modules of the package."""
