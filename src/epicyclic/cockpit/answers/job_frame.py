"""Results of jobs as the page draws them: a message, lines over something, or bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...results.ties import ranked
from ...show.series import label
from .answer import Answer

__all__ = ["Drawn", "JobFrame", "bars", "job_frame", "lines", "mesh_words"]

# Curves that are drawn strong: more are not told apart.
_STRONG = 4
# Points of a curve that are sent: some for each pixel of the pane.
_POINTS = 1200


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JobFrame:
    """One message of results; the fields of a frame of the page.

    rev : of the state, set by who started the job.  kind : ``job``.  head : with ``job`` and, where a job answers a
    question, ``answers``.  arrays : ``job/x`` (n,) and ``job/y`` (curve, n), or ``job/bar`` (row,).
    """

    rev: int = 0
    kind: str = "job"
    head: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """What a job draws.  head : ``lines`` or ``bars`` of its head.  arrays : by name."""

    head: Mapping[str, Any]
    arrays: Mapping[str, NDArray[np.float32]]


def lines(
    x_label: str, y_label: str, x: NDArray[np.float64], curves: Mapping[str, NDArray[np.float64]], *, strong: int = 4
) -> Drawn:
    """Curves (n,) over x (n,) by label; those with the largest values strong, thinned to what a pane shows."""
    labels = list(curves)
    y = np.array([np.asarray(curves[label], dtype=float) for label in labels]).reshape(len(labels), -1)
    every = max(1, -(-len(x) // _POINTS))
    with np.errstate(all="ignore"):
        most = np.nanmax(np.where(np.isfinite(y), y, -np.inf), axis=1, initial=-np.inf)
    first = set(ranked(most)[: min(strong, _STRONG)].tolist())
    found = [{"label": label, "strong": row in first} for row, label in enumerate(labels)]
    return Drawn(
        head={"lines": {"x_label": x_label, "y_label": y_label, "curves": found}},
        arrays={"job/x": np.asarray(x[::every], np.float32), "job/y": np.asarray(y[:, ::every], np.float32)},
    )


def bars(x_label: str, rows: Sequence[str], values: NDArray[np.float64], *, line: float | None = None) -> Drawn:
    """Bars (row,) with their labels; line : a value to compare with."""
    head: dict[str, Any] = {"x_label": x_label, "rows": list(rows)}
    return Drawn(
        head={"bars": head if line is None else {**head, "line": line}},
        arrays={"job/bar": np.asarray(values, np.float32)},
    )


def job_frame(
    name: str,
    title: str,
    text: str,
    drawn: Drawn,
    *,
    apply: Mapping[str, object] | None = None,
    apply_label: str = "",
    answers: Sequence[Answer] = (),
) -> JobFrame:
    """The frame of a job that is done."""
    job = {"name": name, "title": title, "text": text, **drawn.head}
    job |= {"apply": dict(apply) if apply else None, "apply_label": apply_label if apply else ""}
    head: dict[str, Any] = {"job": job}
    if answers:
        head["answers"] = [asdict(one) for one in answers]
    return JobFrame(head=head, arrays=drawn.arrays)


def mesh_words(names: Sequence[str]) -> list[str]:
    """``sun-planet 2 L`` of ``main/sun-planet/2/left``, with the stage before it where there are several."""
    several = len({name.split("/")[0] for name in names}) > 1
    return [label(name, stage=several) for name in names]
