"""A REXS file that was read, as the text of a commented model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..document.writer import commented_text

if TYPE_CHECKING:
    from ..rexs.import_train import RexsImport


def rexs_model_text(model: RexsImport, file: str) -> str:
    """A model file with the ids of the components it comes from.

    file : name of the REXS file, told in the head.
    """
    date = f", of {model.file.date}" if model.file.date else ""
    head = (
        f"From the REXS file {Path(file).name}{date}.",
        f"{len(model.read)} values read, {len(model.assumed)} assumed, {len(model.dropped)} dropped: the numbers in",
        "brackets are ids of components of that file; [assumed] at the end has what it does not say.",
        *model.warnings,
    )
    return commented_text(model.document, head=head, comments=model.comments)
