"""What a REXS file may be at most: bounds on size, depth and count, so that no file costs long or much memory."""

from __future__ import annotations

__all__ = ["MAX_BYTES", "MAX_DEPTH", "MAX_MARKS", "MAX_RATIO", "MAX_TEXT"]

# A gear unit of 100 components is 0.1 MB; 16 MB leaves room for long load spectra and is parsed in a few seconds.
MAX_BYTES = 16_000_000
# Tags, attributes of tags, braces and keys: each becomes an object of up to 400 bytes. A file then stays below
# 250 MB and 3 s.
MAX_MARKS = 400_000
# model / load_spectrum / load_case / component / attribute / matrix / r / c is 8 deep.
MAX_DEPTH = 16
# The real files shrink to 1/17; a file of nothing but blanks and repeated tags to about 1/100.
MAX_RATIO = 300
# Names and texts: longer ones say nothing that a model file could carry.
MAX_TEXT = 2_000
