"""The worst samples of a tolerance study as model files that give their value by themselves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...document.writer import model_text
from ...engine.sampling import SamplingPlan, scramble_uniforms
from ...errors import ModelError
from ...results.files import write_text
from ...train.resolution import load
from ...train.train import Train
from .sample_map import SampleMap

__all__ = ["make_folder", "worst_uniforms", "write_worst"]

Array = NDArray[np.float64]


def worst_uniforms(drawn: SampleMap, plan: SamplingPlan, number: NDArray[np.int64]) -> Array:
    """Uniforms (n, d) of samples; number : (n,) as of `sample_number`."""
    dimensions = drawn.dimension_entry.size
    rows = [scramble_uniforms(plan, one // plan.rows, dimensions)[one % plan.rows] for one in number.tolist()]
    return np.array(rows).reshape(-1, dimensions)


def write_worst(
    folder: Path, train: Train, samples: Sequence[Mapping[str, object]], value: Array, number: NDArray[np.int64]
) -> tuple[Path, ...]:
    """Write each sample as a model file ``worst-01.toml``, ``worst-02.toml``, ...; the worst first.

    The files have no tolerances: what was drawn stands in the place of the nominal numbers.

    Parameters
    ----------
    folder : made where it is not there; its parent must be.  samples : overrides of each.
    value : K_gamma of the samples [1].  number : of them.

    Raises
    ------
    ModelError : a file cannot be written.
    """
    make_folder(folder)
    paths = []
    for place, (changes, k, sample) in enumerate(zip(samples, value.tolist(), number.tolist(), strict=True), start=1):
        title = f"{train.title}, sample {sample}, K_gamma {k:.9g}"
        drawn = load(_without_tolerances(train.document, changes), {**changes, "title": title})
        path = folder / f"worst-{place:02d}.toml"
        write_text(path, model_text(drawn.document))
        paths.append(path)
    return tuple(paths)


def _without_tolerances(document: Mapping[str, object], changed: Iterable[str]) -> dict[str, object]:
    """The tables of a file without its tolerances, and without reasons for what is drawn now."""
    paths = [*changed, "tolerance"]
    reasons = document.get("assumed", {})
    assert isinstance(reasons, Mapping)
    left = {
        path: reason
        for path, reason in reasons.items()
        if not any(f"{one}.".startswith(f"{path}.") or f"{path}.".startswith(f"{one}.") for one in paths)
    }
    kept = {name: value for name, value in document.items() if name not in ("tolerance", "assumed")}
    return {**kept, "assumed": left} if left else kept


def make_folder(folder: Path) -> None:
    """Make a folder where it is not there.

    Raises
    ------
    ModelError : it cannot be made, or something lies there, of which nothing is overwritten.
    """
    try:
        folder.mkdir(exist_ok=True)
        there = sorted(path.name for path in folder.iterdir())
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        raise ModelError(problem, path="worst", given=str(folder), allowed="a folder") from error
    if there:
        problem = f"the folder is not empty ({there[0]})"
        raise ModelError(problem, path="worst", given=str(folder), allowed="a new or empty folder")
