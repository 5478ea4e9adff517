"""Which of the jobs of a name is shown beside the present state."""

from __future__ import annotations

from typing import Any

from epicyclic.cockpit.processes.jobs import Job, newest_of


def test_of_the_jobs_of_a_name_that_of_the_present_state_is_shown() -> None:
    def job(number: int, rev: int, status: Any, origin: str = "a") -> Job:
        return Job(id=number, name="relief", label="", rev=rev, status=status, origin=(None, None, origin))

    def shown(*jobs: Job) -> int | None:
        found = newest_of(jobs, 7, (None, None, "a"))
        return found["relief"].id if found else None

    assert shown(job(1, 7, "done"), job(2, 5, "done")) == 1  # after undo
    assert shown(job(1, 7, "done"), job(2, 7, "cancelled")) == 2
    assert shown(job(1, 7, "done"), job(2, 5, "runs")) == 2
    assert shown(job(1, 3, "done"), job(2, 5, "done")) == 2
    assert shown(job(1, 3, "done"), job(2, 5, "failed")) == 1
    assert shown(job(1, 5, "failed"), job(2, 5, "cancelled")) is None
    assert shown(job(1, 5, "runs", "b"), job(2, 5, "done", "b")) is None
    assert shown(job(1, 7, "done", "b")) == 1  # the same model under another name
    died = job(2, 5, "failed")
    died.died = True
    assert shown(job(1, 3, "done"), died) == 2  # of no state's fault
    assert shown(job(1, 7, "done"), died) == 1
