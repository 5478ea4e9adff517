"""Results of jobs as the page draws them: lines over an axis, or bars, with one sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..computing.frames import PageFrame

__all__ = ["bars", "lines"]

# Curves that are drawn strong; the rest is grey.
_STRONG = 4


def lines(
    name: str,
    title: str,
    text: str,
    *,
    x_label: str,
    y_label: str,
    x: Any,
    curves: Sequence[tuple[str, Any]],
    strong: Sequence[int] | None = None,
    more: Mapping[str, Any] | None = None,
) -> PageFrame:
    """A frame of curves (label, y (n,)) over x (n,).

    strong : places of those that are drawn in colour; None: the first four.  more : of the head, such as ``apply``.
    """
    chosen = range(_STRONG) if strong is None else strong
    told = [{"label": label, "strong": place in chosen} for place, (label, _) in enumerate(curves)]
    head = {"name": name, "title": title, "text": text, "apply": None, "apply_label": "", **(more or {})}
    head["lines"] = {"x_label": x_label, "y_label": y_label, "curves": told}
    arrays = {
        "job/x": np.asarray(x, np.float32),
        "job/y": np.asarray([np.asarray(y, np.float32) for _, y in curves], np.float32),
    }
    return PageFrame(rev=0, kind="job", head={"job": head}, arrays=arrays)


def bars(name: str, title: str, text: str, *, x_label: str, rows: Sequence[tuple[str, float]]) -> PageFrame:
    """A frame of bars (label, length), the longest first."""
    head: dict[str, Any] = {"name": name, "title": title, "text": text, "apply": None, "apply_label": ""}
    head["bars"] = {"x_label": x_label, "rows": [label for label, _ in rows], "line": 0.0}
    return PageFrame(
        rev=0, kind="job", head={"job": head}, arrays={"job/bar": np.asarray([size for _, size in rows], np.float32)}
    )
