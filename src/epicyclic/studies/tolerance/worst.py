"""The worst samples of a tolerance study as model files that give their value by themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...model.model_writer import model_text
from ...resolve import load
from ...results.whole_file import write_text
from ...train.train import Train
from ..source import Overrides, Source
from .sample_map import SampleMap
from .sampling import SamplingPlan, scramble_uniforms

__all__ = ["worst_overrides", "write_worst"]

Array = NDArray[np.float64]


def worst_overrides(
    drawn: SampleMap, plan: SamplingPlan, number: NDArray[np.int64]
) -> tuple[Mapping[str, object], ...]:
    """Overrides that make each sample of the file; number : (n,) of the samples, as of `sample_number`."""
    found = []
    for one in number.tolist():
        scramble, row = divmod(one, plan.rows)
        found.append(drawn.overrides(scramble_uniforms(plan, scramble, drawn.dimension_entry.size)[row]))
    return tuple(found)


def write_worst(
    folder: Path,
    source: Source,
    overrides: Overrides | None,
    samples: Sequence[Mapping[str, object]],
    value: Array,
    number: NDArray[np.int64],
) -> tuple[Path, ...]:
    """Write each sample as a model file ``worst-01.toml``, ``worst-02.toml``, ...; the worst first.

    The files have no tolerances: what was drawn stands in the place of the nominal numbers.

    Parameters
    ----------
    folder : made where it is not there; its parent must be.  value : K_gamma of the samples [1].  number : of them.

    Raises
    ------
    ModelError : a file cannot be written.
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        raise ModelError(problem, path="worst", given=str(folder), allowed="a folder") from error
    paths = []
    for place, (changes, k, sample) in enumerate(zip(samples, value.tolist(), number.tolist(), strict=True), start=1):
        path = folder / f"worst-{place:02d}.toml"
        write_text(path, _sample_text(source, overrides, changes, f"sample {sample}, K_gamma {k:.9g}"))
        paths.append(path)
    return tuple(paths)


def _sample_text(source: Source, overrides: Overrides | None, changes: Mapping[str, object], words: str) -> str:
    """Model file of a source with the changes of a sample; words : added to its title."""
    base = train_document(source, overrides)
    title = f"{base['title']}, {words}"
    return model_text(dict(load(base, {**changes, "tolerance": None, "title": title}).document))


def train_document(source: Source, overrides: Overrides | None) -> dict[str, object]:
    """The document of a source with its overrides, as nested tables."""
    train = source if isinstance(source, Train) else load(source, overrides)  # type: ignore[arg-type]
    return dict(train.document)
