"""The share of a job that is done, which knows of how many parts it speaks."""

from __future__ import annotations

__all__ = ["Counted"]


class Counted(float):
    """Share done, 0..1, with the counts it comes from: whoever shows it can tell a rate.

    done, of : parts done, and all of them.
    """

    done: int
    of: int

    def __new__(cls, done: int, of: int) -> Counted:
        share = super().__new__(cls, done / of if of else 1.0)
        share.done, share.of = done, of
        return share
