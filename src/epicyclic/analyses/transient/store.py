"""Runs kept on disk while they go: whole segments, each written aside and renamed, so that none is ever half there."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import ModelError
from ...results.whole_file import whole_file, write_text
from ...system.system import Array

__all__ = ["Store", "fingerprint", "open_store"]

_ABOUT = "run.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class Store:
    """A folder with segments 000000.npy, 000001.npy, ... of modal states (K, 2, n), and what run they belong to."""

    folder: Path

    def segments(self) -> list[Array]:
        """The segments that are there, without a gap.

        Raises
        ------
        ModelError : one of them cannot be read.
        """
        found: list[Array] = []
        while (path := self._path(len(found))).is_file():
            try:
                found.append(np.load(path, allow_pickle=False))
            except (OSError, ValueError, EOFError) as error:
                raise ModelError(f"not a segment of a run: {error}", path=str(path)) from error
        return found

    def add(self, number: int, states: Array) -> None:
        """Write a segment whole or not at all."""
        with whole_file(self._path(number)) as file:
            np.save(file, states, allow_pickle=False)

    def remove(self) -> None:
        """Delete the folder and what is in it."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:06d}.npy"


def open_store(folder: Path, run: str, *, resume: bool) -> Store:
    """The store of a run, made or taken up again.

    Parameters
    ----------
    run : `fingerprint` of the run.  resume : whether segments that lie there are wanted.

    Raises
    ------
    ModelError : segments lie there and are not asked for, or are of another run; or the folder cannot be written.
    """
    about = folder / _ABOUT
    begun = (folder / f"{0:06d}.npy").is_file()
    if about.is_file() and (begun or resume):
        if not resume:
            raise ModelError(
                "an interrupted run lies there", path=str(folder), allowed="resume (--resume), or delete the folder"
            )
        try:
            known = json.loads(about.read_text(encoding="utf-8"))["run"]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ModelError("not a run that can be continued", path=str(about)) from error
        if known != run:
            raise ModelError(
                "the run that lies there has another model, other options or another start",
                path=str(folder),
                allowed="the command it was begun with, or delete the folder",
            )
    elif folder.exists() and not about.is_file() and (not folder.is_dir() or any(folder.iterdir())):
        raise ModelError("is no folder of a run", path=str(folder), allowed="a new or empty folder")
    else:
        try:
            folder.mkdir(exist_ok=True)
            write_text(about, json.dumps({"run": run}))
        except OSError as error:
            raise ModelError(f"cannot be written: {error.strerror or error}", path=str(folder)) from error
    return Store(folder=folder)


def fingerprint(values: Iterable[object]) -> str:
    """A digest of numbers and arrays, equal where every bit is."""
    digest = hashlib.sha256()
    for value in values:
        array = np.ascontiguousarray(value)
        digest.update(f"{array.dtype}{array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
