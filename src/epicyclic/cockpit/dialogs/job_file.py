"""The Dataset of a job that is done, as a file of another kind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...results.dataset import load_result
from ...results.tables_out import save_csv, save_xlsx
from ..processes.jobs import Job

__all__ = ["job_file", "jobs_done"]


def jobs_done(jobs: Sequence[Job], rev: int) -> dict[str, Job]:
    """Name -> the newest job of the state with this number whose Dataset is there."""
    return {job.name: job for job in jobs if job.rev == rev and job.status == "done" and job.dataset_path is not None}


def job_file(path: Path, kind: str) -> bytes:
    """Content of the Dataset at a path (.nc) as a file of a kind: nc, csv or xlsx."""
    if kind != "nc":
        target = path.with_suffix(f".{kind}")
        {"csv": save_csv, "xlsx": save_xlsx}[kind](load_result(path), target)
        content = target.read_bytes()
        target.unlink()
        return content
    return path.read_bytes()
