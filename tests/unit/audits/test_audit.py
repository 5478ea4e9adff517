"""`audit`: claims are checked, runs are shared, and the command line says how it ended."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.audits import audit as module
from epicyclic.cli.main import app
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.verbs.record import Verb

HEAD = 'format = 1\nsource = "A. Author 2020"\ndrive = "lin1999-n3"\n[runs.modes]\nverb = "modes"\n'
OURS = 'ours = { run = "modes", take = "frequency", reduce = "max" }'  # 11775.266 Hz


def row(verdict: str, published: object = 11775.3, *, ours: str = OURS, extra: str = "tolerance = 0.05") -> str:
    given = json.dumps(published)
    because = 'because = "printed"' if "tolerance" in extra or "relative" in extra else ""
    words = 'reading = "so read"\nreason = "not printed"'
    return (
        f'[[rows]]\nquantity = "q {{}}"\nplace = "Table 1"\npublished = {given}\nunit = "Hz"\n{ours}\n'
        f'verdict = "{verdict}"\n{extra}\n{because}\n{words}\n'
    )


Auditor = Callable[..., xr.Dataset]


@pytest.fixture
def run(tmp_path: Path) -> Auditor:
    def audited(*rows: str, head: str = HEAD) -> xr.Dataset:
        path = tmp_path / "x.audit.toml"
        path.write_text(head + "".join(rows), encoding="utf-8")
        return epicyclic.audit(path)

    return audited


HOLDING = [
    row("reproduced"),
    row("under a reading"),
    row("reproduced", "> 11000", extra=""),
    row("reproduced", "11775 .. 11776", extra=""),
    row("reproduced", 11775.3, extra="relative = 1e-5"),
    row("not reproducible", 11776.0),
    row("not reproducible", "< 11000", extra=""),
    row("not reproducible", "a curve", ours="", extra=""),
    row("not reproducible", "a curve", extra=""),
    row("not reproducible", 5.0, ours="", extra=""),
    row("not reproducible", 11775.3, extra=""),  # without a tolerance ours stands there to be seen, not checked
]
CONTRADICTED = [
    row("reproduced", 11775.4),
    row("under a reading", 11775.4),
    row("reproduced", "< 11000", extra=""),
    row("reproduced", "> 11776", extra=""),
    row("reproduced", "0 .. 11775", extra=""),
    row("reproduced", 11775.3, extra="relative = 1e-6"),
    row("not reproducible"),
    row("not reproducible", "> 11000", extra=""),
    row("not reproducible", "11775 .. 11776", extra=""),
]


@pytest.mark.parametrize("text", HOLDING)
def test_a_claim_that_holds(text: str, run: Auditor) -> None:
    assert run(text).outcome.values.tolist() == ["holds"]


def test_a_run_that_needs_what_is_not_installed_is_told(run: Auditor) -> None:
    head = HEAD.replace(
        "[runs.modes]", '[runs.plain]\nverb = "check"\nneeds = "no_such_package"\n[runs.modes]\nbased_on = "plain"'
    )
    (outcome,) = run(row("reproduced"), head=head).outcome.values
    assert "no_such_package is not installed" in outcome
    fine = run(row("reproduced"), head=head.replace("no_such_package", "numpy"))
    assert fine.outcome.values.tolist() == ["holds"]


@pytest.mark.parametrize("text", CONTRADICTED)
def test_a_claim_that_does_not_hold_is_seen(text: str, run: Auditor) -> None:
    result = run(text)
    assert result.outcome.values.tolist() == ["contradicted"]
    assert json.loads(result.attrs["warnings"]) == ["lin1999-n3: q {}: contradicted"]


def test_a_list_is_taken_apart(run: Auditor) -> None:
    each = 'ours = { run = "modes", take = "frequency", pick = [0, -1], reduce = "each" }'
    result = run(row("reproduced", [0.0, 11775.3], ours=each), row("reproduced", [11770.0], ours=OURS))
    assert result.quantity.values.tolist() == ["q 1", "q 2", "q 1"]
    assert result.outcome.values.tolist() == ["holds", "holds", "contradicted"]
    assert result.difference.values == pytest.approx([0, -0.034, 5.266], abs=1e-3)  # printed digits of the values
    with pytest.raises(ModelError, match="2 of ours for 3 published") as error:
        run(row("reproduced", [1.0, 2.0, 3.0], ours=each))
    assert error.value.path == "rows.0.ours"


def test_a_model_file_of_ones_own(tmp_path: Path) -> None:
    from epicyclic.model.model_writer import model_text
    from epicyclic.resolve.resolved_document import resolved_document

    (tmp_path / "mine.toml").write_text(model_text(resolved_document(epicyclic.load("lin1999-n3"))), encoding="utf-8")
    text = HEAD.replace('drive = "lin1999-n3"\n', "") + row("reproduced")
    (tmp_path / "mine.audit.toml").write_text(text, encoding="utf-8")
    result = epicyclic.audit(tmp_path / "mine.audit.toml")
    assert result.outcome.values.tolist() == ["holds"]


def test_overrides_and_another_drive(run: Auditor) -> None:
    runs = """
[runs.heavy]
based_on = "modes"
set = { "stages.main.sun.mass" = "4 kg" }
[runs.four]
verb = "modes"
drive = "lin1999-n4"
"""
    lower = (
        'ours = { difference = [{ run = "heavy", take = "frequency", pick = 3 }, '
        '{ run = "modes", take = "frequency", pick = 3 }] }'
    )
    four = 'ours = { run = "four", take = "frequency", reduce = "max" }'
    result = run(
        row("reproduced", "< 0", ours=lower, extra=""), row("reproduced", 13071.1, ours=four), head=HEAD + runs
    )
    assert result.outcome.values.tolist() == ["holds", "holds"]


def test_a_run_is_computed_once(run: Auditor, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[Any] = []

    def counting(source: Any, **options: Any) -> xr.Dataset:
        calls.append(options)
        return epicyclic.modes(source, **options)

    monkeypatch.setattr(module, "verbs", lambda: {"modes": Verb(run=counting, gives=("modes",))})
    run(row("reproduced"), row("reproduced"), row("not reproducible", "a curve", ours="", extra=""))
    assert calls == [{}]


def test_no_convergence_is_an_outcome(run: Auditor, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(source: Any, **options: Any) -> xr.Dataset:
        raise ConvergenceError("no contact state found")

    monkeypatch.setattr(module, "verbs", lambda: {"modes": Verb(run=failing, gives=("modes",))})
    result = run(row("reproduced"), row("not reproducible"))
    assert result.outcome.values.tolist() == ["no convergence: no contact state found"] * 2
    assert np.isnan(result.ours.values).all()


@pytest.mark.parametrize(
    ("old", "new", "path", "says"),
    [
        ('verb = "modes"', 'verb = "modes"\nset = { "stages.main.sun.mas" = 1 }', "runs.modes", "unknown key"),
        ('verb = "modes"', 'verb = "modes"\noptions = { damp = true }', "runs.modes.options", "relative_speed, damped"),
        ('drive = "lin1999-n3"', 'drive = "lin1999-n2"', "runs.modes.lin1999-n2", "no such file or ready drive"),
        ('take = "frequency"', 'take = "frequencies"', "rows.0.ours", "no such variable"),
        ('unit = "Hz"', 'unit = "kg"', "rows.0.ours", "cannot become"),
    ],
)
def test_what_shows_only_when_it_runs(old: str, new: str, path: str, says: str, run: Auditor) -> None:
    text = HEAD + row("reproduced")
    assert old in text
    with pytest.raises(ModelError, match=says) as error:
        run(head=text.replace(old, new, 1))
    assert error.value.path.startswith(path)


def test_a_result_is_saved_and_reopened(run: Auditor, tmp_path: Path) -> None:
    result = run(row("reproduced"), row("not reproducible", "a curve", ours="", extra=""))
    epicyclic.save_result(result, tmp_path / "audit.nc")
    xr.testing.assert_identical(epicyclic.load_result(tmp_path / "audit.nc"), result)


def test_progress_reaches_the_end(tmp_path: Path) -> None:
    seen: list[float] = []
    epicyclic.audit("lin1999-n3", progress=seen.append)
    assert seen[-1] == 1.0


# the command line ----------------------------------------------------------------------------------------------------


def command(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stop:
        app(list(arguments), prog_name="epicyclic")
    return int(stop.value.code or 0)


def written(folder: Path, text: str) -> str:
    (folder / "x.audit.toml").write_text(HEAD + text, encoding="utf-8")
    return str(folder / "x.audit.toml")


def test_command_prints_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", written(tmp_path, row("reproduced") + row("under a reading"))) == 0
    out = capsys.readouterr().out
    verdicts = next(line.split() for line in out.splitlines()[::-1] if line.strip())
    assert verdicts == ["lin1999-n3", "1", "1", "0", "0"]  # reproduced, under a reading, not reproducible, contradicted
    assert "11775.3 Hz" in out
    assert "reading: so read" in out


def test_command_fails_where_a_row_is_contradicted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", written(tmp_path, row("reproduced") + row("reproduced", 11776.0))) == 4
    assert "warning: lin1999-n3: q {}: contradicted" in capsys.readouterr().out
    assert command("audit", written(tmp_path, row("reproduced", 11776.0)), "--json") == 4
    streams = capsys.readouterr()
    assert xr.Dataset.from_dict(json.loads(streams.out)).outcome.values.tolist() == ["contradicted"]
    assert "q {}: contradicted" in streams.err


def test_command_calls_a_fitted_value_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", written(tmp_path, row("under a reading", extra="fitted = true\ntolerance = 0.05"))) == 0
    assert "fitted" in capsys.readouterr().out


def test_command_refuses_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", "ren2020") == 2
    assert "no such audit; did you mean 'ren2021'?" in capsys.readouterr().err
    assert command("audit", "ren2021", "-o", str(tmp_path / "x.html")) == 2
    assert "no such kind of output" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".nc", ".json"])
def test_command_writes_a_file(suffix: str, tmp_path: Path) -> None:
    target = tmp_path / f"audit{suffix}"
    assert command("audit", written(tmp_path, row("reproduced")), "-o", str(target)) == 0
    assert target.stat().st_size > 500
