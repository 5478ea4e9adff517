"""A REXS file that was read, as the text of a commented model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..document.writer import commented_text

if TYPE_CHECKING:
    from ..rexs.import_train import RexsImport


def rexs_model_text(found: RexsImport, file: str) -> str:
    """A model file with the ids of the components it comes from.

    file : name of the REXS file, told in the head.
    """
    date = f", of {found.file.date}" if found.file.date else ""
    head = (
        f"From the REXS file {Path(file).name}{date}.",
        f"{len(found.read)} values read, {len(found.assumed)} assumed, {len(found.dropped)} dropped: the numbers in",
        "brackets are ids of components of that file; [assumed] at the end has what it does not say.",
        *found.warnings,
    )
    return commented_text(found.document, head=head, comments=found.comments)
