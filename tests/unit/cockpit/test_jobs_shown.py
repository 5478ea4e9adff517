"""Which of the jobs of a name is shown beside the present state."""

from __future__ import annotations

from typing import Any

from epicyclic.cockpit.processes.jobs import Job, Jobs, newest_of
from epicyclic.cockpit.state.frames import PageFrame
from epicyclic.cockpit.state.state import opened, request_of, with_value, with_values


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


def test_a_result_stands_where_what_it_proposes_is_applied() -> None:
    state = opened("ren2021")
    relief: dict[str, object] = {"stages.main.flank.tip_relief.amount": "20 um"}
    follow: dict[str, object] = {"stages.main.meshes.sun-planet.stiffness": "contact"}
    kept = [
        {
            "overrides": relief,
            "answers": [{"key": "relief", "text": "is drawn"}],
            "job": {"text": "drawn", "apply": follow},
        },
        {"overrides": {**relief, **follow}, "answers": [], "job": {"text": "followed", "apply": None}},
    ]
    found = {
        "job": {"name": "relief", "text": "grind it", "apply": relief},
        "answers": [{"key": "relief"}],
        "kept": kept,
    }
    job = Job(id=1, name="relief", label="", rev=1, status="done", state=state, model=request_of(state))
    job.frame = PageFrame(rev=1, kind="job", head=found)
    jobs = Jobs(lambda _: None)
    jobs.all.append(job)
    said = []
    drawn = with_values(state, relief)
    for rev, one in enumerate((drawn, with_values(drawn, follow), with_value(drawn, "torque.sun", "1 N m"), state), 2):
        jobs.follow(request_of(one), rev)
        said.append((job.rev, job.frame.rev, job.head["job"]["text"], len(job.head["answers"])))
    assert said == [(2, 2, "drawn", 1), (3, 3, "followed", 0), (3, 3, "followed", 0), (5, 5, "grind it", 1)]
