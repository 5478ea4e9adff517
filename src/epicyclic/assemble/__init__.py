"""Train -> System: the one room that knows both sides.

Every mesh, bearing, pin and support becomes rows of gaps; rigid connections are eliminated; displaced features become
excitation lines of exact frequency.  Frames, rows, signs and phases are those of docs/conventions.md.

Depends on: train, teeth, system.
"""

from __future__ import annotations

from .assembly import assemble

__all__ = ["assemble"]
