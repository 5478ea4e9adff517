"""An analysis made here alone: its options and findings are all that its tab, its answer and its command need.

Annotations stand as objects here, as records of verbs read them.
"""

import asyncio
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
import typer
import xarray as xr
from nicegui.element import Element
from nicegui.testing.user import User
from tests.unit.cockpit.test_page import PageSession, look, press, raise_in, texts
from typer.testing import CliRunner

from epicyclic.cli.command import command
from epicyclic.cockpit.computing.job_kinds import JOBS, JobKind
from epicyclic.cockpit.processes.jobs import task_of
from epicyclic.cockpit.state.frames import QUESTIONS
from epicyclic.cockpit.state.state import command_line, opened
from epicyclic.document.document import drive_text
from epicyclic.options import Option
from epicyclic.show import views
from epicyclic.show.elements import Company, Finding
from epicyclic.show.views import ResultView, sections_of_any, tables_of_any
from epicyclic.verbs import record
from epicyclic.verbs.record import Verb, takes

LIMIT = 50.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CrowdingOptions:
    factor: Annotated[float, Option("Teeth per tooth.", least=0.5)] = 1.0


@takes(CrowdingOptions)
def crowding(drive: Any, options: CrowdingOptions) -> xr.Dataset:
    """Teeth of each gear, times a factor."""
    gears = {body.member: body.gear.teeth for body in drive.train.bodies if body.gear is not None}
    teeth = ("member", options.factor * np.array(list(gears.values()), float), {"long_name": "teeth", "units": "1"})
    return xr.Dataset({"teeth": teeth}, {"member": list(gears)}, {"verb": "crowding"})


def findings(result: xr.Dataset, company: Company) -> list[Finding]:
    most = float(result["teeth"].max())
    text = f"The largest gear has {most:g} teeth, limit {LIMIT:g}."
    return [Finding(tone="bad", text=text, change="Take fewer.", value=most, limit=LIMIT)]


VIEW = ResultView("crowding", 500, tables_of_any, sections_of_any, findings=findings)
VERB = Verb(run=crowding, gives=("crowding",), question="", line="")
KIND = JobKind(
    name="crowding",
    label="Crowding",
    purpose="Teeth of every gear",
    about="Counts the teeth of every gear.",
    question="crowding",
)


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    """The verb, the view of its result, the question and the job: what each later capability adds."""
    verbs, view_of = {**record.verbs(), "crowding": VERB}, views.view_of
    monkeypatch.setattr(record, "verbs", lambda: verbs)
    monkeypatch.setattr(views, "view_of", lambda kind: VIEW if kind == "crowding" else view_of(kind))
    monkeypatch.setitem(QUESTIONS, "crowding", "Are there too many teeth?")
    monkeypatch.setitem(JOBS, "crowding", KIND)


def done(**options: Any) -> Any:
    """The frame of its job, as the process of a job makes it."""
    return KIND.run(tomllib.loads(drive_text("ren2021")), {}, options, lambda *_: None)[0]


def test_its_findings_are_what_tab_and_answer_say_and_its_variable_is_drawn() -> None:
    frame = done(factor=2.0)
    most = 2 * max(float(one) for one in done().arrays["job/bar"])
    job, (answer,) = frame.head["job"], frame.head["answers"]
    assert job["text"] == f"The largest gear has {most:g} teeth, limit 50."
    assert (answer["key"], answer["level"], answer["evidence"]) == ("crowding", "bad", "crowding")
    assert (answer["figure"], answer["limit"]["value"]) == (f"{most:g}", 50)
    assert answer["text"] == f"{job['text']} Take fewer."
    assert (job["bars"]["x_label"], len(job["bars"]["rows"])) == ("teeth [1]", 3)
    assert frame.arrays["job/bar"].max() == most
    with pytest.raises(Exception, match="out of range"):
        done(factor=0.1)
    assert task_of("crowding", {}, ({}, {}), 1, Path("job"))[0] == "Crowding"


def test_it_has_a_tab_with_fields_and_an_answer_that_waits_for_it() -> None:
    async def talk(user: User, session: PageSession) -> None:
        assert "Are there too many teeth?" not in texts(user, data_answer="crowding")  # what the job does stands there
        assert "Counts the teeth of every gear." in texts(user, data_answer="crowding")
        bar = next(one for one in user.find(kind=Element).elements if one.props.get("data-job") == "crowding")
        field = next(one for one in bar.descendants() if one.props.get("aria-label") == "Factor")
        raise_in(field, "change", "2")
        press(user, "Compute crowding")
        assert session.calls[-1] == ("job", "crowding", {"factor": 2.0})
        assert texts(user, role="tab", aria_selected="true") == "Crowding"
        job = session.started[0]
        job.frame, job.status = replace(done(factor=2.0), rev=job.rev), "done"
        session.tell("jobs")
        await asyncio.sleep(0)
        line = texts(user, data_answer="crowding")
        assert line.startswith("✗ | ")
        assert "50 | The largest gear has" in line
        assert "Take fewer." in line
        assert "The largest gear has" in texts(user, data_job="crowding")

    look(talk)


def test_its_command_prints_the_number_of_the_page() -> None:
    app = typer.Typer()
    app.command()(command(VERB))
    app.command("other")(lambda: None)
    words = command_line(opened("ren2021"), verb=KIND.verb).split()
    assert words == ["epicyclic", "crowding", "ren2021"]
    told = CliRunner().invoke(app, [*words[1:], "--factor", "2"])
    assert told.exit_code == 0, told.output
    assert done(factor=2.0).head["job"]["text"] in " ".join(told.output.split())
