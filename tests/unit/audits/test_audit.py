"""`audit`: claims are checked, runs are shared, and the command line says how it ended."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.audits import audit as module
from epicyclic.audits.views import tables, tally
from epicyclic.cli.main import app
from epicyclic.document.writer import model_text
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.train.resolution import resolved_document
from epicyclic.verbs.record import Verb

ROOT = Path(__file__).parents[3]
HEAD = 'format = 2\nsource = "A. Author 2020"\ndrive = "lin1999-n3"\n[runs.modes]\nverb = "modes"\n'
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


def test_a_tolerance_in_parts_is_of_the_size_of_the_number(run: Auditor) -> None:
    for published in (11776.0, -11776.0):
        result = run(row("not reproducible", published, extra="relative = 1e-6"))
        assert result.tolerance.values.tolist() == pytest.approx([0.011776])


@pytest.mark.parametrize("text", HOLDING)
def test_a_claim_that_holds(text: str, run: Auditor) -> None:
    assert run(text).outcome.values.tolist() == ["holds"]


def test_a_run_that_needs_what_is_not_installed_is_told(run: Auditor) -> None:
    head = HEAD.replace(
        "[runs.modes]", '[runs.plain]\nverb = "check"\nneeds = "no_such_package"\n[runs.modes]\nbased_on = "plain"'
    )
    result = run(row("reproduced"), head=head)
    outcome = "not computed: no_such_package is not installed; pip install no_such_package"
    assert result.outcome.values.tolist() == [outcome]
    assert json.loads(result.attrs["warnings"]) == [f"lin1999-n3: q {{}}: {outcome} [audit-differs]"]
    kinds = ("reproduced", "under a reading", "not reproducible", "not compared", "contradicted")
    assert tally(result) == {"lin1999-n3": ", ".join([*(f"0 {kind}" for kind in kinds), "1 not computed"])}
    shown, verdicts = tables(result)
    assert str(shown.columns["verdict"][0]) == "reproduced (not computed)"
    assert verdicts.columns["not computed"] == [1]
    fine = run(row("reproduced"), head=head.replace("no_such_package", "numpy"))
    assert fine.outcome.values.tolist() == ["holds"]


def test_command_without_an_extra_fails_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """As a plain installation has it; a row that is contradicted besides still ends in 4."""
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    head = HEAD + '\n[runs.tip]\nverb = "relief"\nneeds = "pymoo"\noptions = { vary = "tip_relief.amount=0..40um" }\n'
    ours = 'ours = { run = "tip", take = "objective_after" }'
    file = tmp_path / "x.audit.toml"
    for more, status in (("", 0), (row("reproduced", 11776.0), 4)):
        file.write_text(head + row("reproduced", ours=ours) + more)
        assert command("audit", str(file)) == status
        assert "not computed: pymoo is not installed; pip install 'epicyclic[optimise]'" in capsys.readouterr().out


def test_extras_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for package, extra in module.EXTRAS.items():
        assert any(text.startswith(package) for text in project["optional-dependencies"][extra])


@pytest.mark.parametrize("text", CONTRADICTED)
def test_a_claim_that_does_not_hold_is_seen(text: str, run: Auditor) -> None:
    result = run(text)
    assert result.outcome.values.tolist() == ["contradicted"]
    assert json.loads(result.attrs["warnings"]) == ["lin1999-n3: q {}: contradicted [audit-differs]"]


def test_a_list_is_taken_apart(run: Auditor) -> None:
    each = 'ours = { run = "modes", take = "frequency", pick = [0, -1], reduce = "each" }'
    result = run(row("reproduced", [0.0, 11775.3], ours=each), row("reproduced", [11770.0], ours=OURS))
    assert result.quantity.values.tolist() == ["q 1", "q 2", "q 1"]
    assert result.outcome.values.tolist() == ["holds", "holds", "contradicted"]
    assert result.difference.values == pytest.approx([0, -0.034, 5.266], abs=1e-3)  # printed digits of the values
    with pytest.raises(ModelError, match="2 of ours for 3 published") as error:
        run(row("reproduced", [1.0, 2.0, 3.0], ours=each))
    assert error.value.path.endswith("x.audit.toml: rows.0.ours")


def test_a_model_file_of_ones_own(tmp_path: Path) -> None:
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

    monkeypatch.setattr(module, "verbs", lambda: {"modes": Verb(run=counting, gives=("modes",), question="", line="")})
    run(row("reproduced"), row("reproduced"), row("not reproducible", "a curve", ours="", extra=""))
    assert calls == [{}]


def test_no_convergence_is_an_outcome(run: Auditor, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(source: Any, **options: Any) -> xr.Dataset:
        raise ConvergenceError("no contact state found")

    monkeypatch.setattr(module, "verbs", lambda: {"modes": Verb(run=failing, gives=("modes",), question="", line="")})
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
    assert f"x.audit.toml: {path}" in error.value.path


WRONG_ROWS = [
    row("reproduced").replace("tolerance = 0.05", "margin = 0.05"),
    row("reproduced").replace(OURS, "ours = 5"),
    row("reproduced").replace('"modes"', '"shapes"'),
    row("reproduced").replace('"frequency"', '"frequencies"'),
    row("reproduced").replace('"modes"', '"refused"'),
]
SAID = [
    "rows.1.margin: unknown key; allowed: quantity, place",
    "rows.1.ours = 5: not a table; allowed: a table",
    "rows.1.ours.run = shapes: no such run; allowed: modes, refused",
    "rows.1.ours: q {}: take = frequencies: no such variable",
    "runs.refused.stages.main.sun.mas = 1: unknown key",
]
REFUSED = HEAD + '[runs.refused]\nbased_on = "modes"\nset = { "stages.main.sun.mas" = 1 }\n'


@pytest.mark.parametrize(("wrong", "says"), list(zip(WRONG_ROWS, SAID, strict=True)), ids=SAID)
def test_a_wrong_row_leaves_the_others(wrong: str, says: str, run: Auditor) -> None:
    result = run(row("reproduced"), wrong, row("reproduced", 11776.0), head=REFUSED)
    first, told, last = result.outcome.values.tolist()
    assert (first, last) == ("holds", "contradicted")
    assert told.startswith("wrong: ")
    assert f"x.audit.toml: {says}" in told
    assert result.quantity.values.tolist() == ["q {}"] * 3
    assert tally(result)["lin1999-n3"].endswith("1 contradicted, 1 wrong")
    shown, _ = tables(result)
    assert str(shown.columns["verdict"][1]) == "reproduced (wrong)"


def test_a_wrong_reading_supports_no_verdict(run: Auditor) -> None:
    text = bare("not reproducible", 5.0) + read("other", run='"modes"') + read("third", run='"refused"')
    result = run(text, bare("not reproducible", 5.0), head=REFUSED)
    assert result.outcome.values[0].startswith("wrong: ")
    assert result.outcome.values[1] == "holds"


def test_a_result_is_saved_and_reopened(run: Auditor, tmp_path: Path) -> None:
    plain = run(row("reproduced"), row("not reproducible", "a curve", ours="", extra=""))
    tried = run(bare("not reproducible", 5.0) + read("a sun of 0.5 kg", run='"heavy"'), head=HEAD_2)
    for result in (plain, tried):
        epicyclic.save_result(result, tmp_path / "audit.nc")
        xr.testing.assert_identical(epicyclic.load_result(tmp_path / "audit.nc"), result)


def test_progress_reaches_the_end(tmp_path: Path) -> None:
    seen: list[float] = []
    epicyclic.audit("lin1999-n3", progress=seen.append)
    assert seen[-1] == 1.0


# readings -------------------------------------------------------------------------------------------------------------

HEAD_2 = (
    HEAD
    + """
[runs.heavy]
based_on = "modes"
set = { "stages.main.sun.inertia" = "0.5 kg" }
[runs.fitted]
based_on = "modes"
set = { "stages.main.sun.inertia" = "0.3 kg" }
fitted = ["stages.main.sun.inertia"]
"""
)


def read(text: str, **keys: str) -> str:
    """A reading of the row before it; values of the keys as TOML."""
    said = "".join(f"{key} = {value}\n" for key, value in keys.items())
    return f'[[rows.readings]]\nreading = "{text}"\n{said}'


def bare(verdict: str, published: object = 11775.3, *, ours: str = OURS, unit: str = "Hz") -> str:
    """A row without a reading of its own."""
    text = row(verdict, published, ours=ours).replace('reading = "so read"\n', "")
    return text.replace('unit = "Hz"', f'unit = "{unit}"')


HEAVY = float(epicyclic.modes("lin1999-n3", overrides={"stages.main.sun.inertia": "0.5 kg"}).frequency.values.max())
FITTED = float(epicyclic.modes("lin1999-n3", overrides={"stages.main.sun.inertia": "0.3 kg"}).frequency.values.max())


def test_the_best_reading_stands_in_the_row(run: Auditor) -> None:
    """Three numbers for one that is printed; the second holds, and the others stay in sight."""
    result = run(
        bare("under a reading", HEAVY)
        + read("a sun of 0.5 kg", run='"heavy"', reason='"why"')
        + read("a sun of 0.3 kg", run='"fitted"')
        + read("no number", reason='"a datum is missing"'),
        head=HEAD_2,
    )
    assert result.outcome.values.tolist() == ["holds"]
    assert result.reading.values.tolist() == ["a sun of 0.5 kg"]
    assert result.ours.values == pytest.approx([HEAVY], rel=1e-12)
    assert result.attempt_row.values.tolist() == [0] * 4
    assert result.attempt_reading.values.tolist() == ["as printed", "a sun of 0.5 kg", "a sun of 0.3 kg", "no number"]
    assert result.attempt_outcome.values.tolist() == ["outside", "within", "outside", "no number"]
    assert result.attempt_fitted.values.tolist() == [False, False, True, False]
    assert result.attempt_reason.values.tolist() == ["not printed", "why", "", "a datum is missing"]
    assert result.attempt_ours.values[:3] == pytest.approx([11775.266, HEAVY, FITTED], rel=1e-7)
    assert result.attempt_difference.values[:3] == pytest.approx(result.attempt_ours.values[:3] - HEAVY, abs=1e-9)
    shown, verdicts = tables(result)
    assert shown.columns["quantity"][:3] == ["q {}", "- as printed", "- a sun of 0.5 kg"]
    assert [str(cell) for cell in shown.columns["verdict"]] == [
        "only under a stated reading",
        "outside",
        "within",
        "outside, fitted",
        "no number",
    ]
    assert verdicts.columns["under a reading"] == [1]
    assert shown.notes == ("reason: not printed", "tolerance: printed", "reason: why", "reason: a datum is missing")
    assert shown.columns["remark"] == ["1 2", "", "3", "", "4"]  # of an attempt only what its row has not said


def test_a_fitted_reading_makes_the_row_fitted(run: Auditor) -> None:
    text = bare("under a reading", FITTED) + read("a sun of 0.3 kg", run='"fitted"')
    assert run(text, head=HEAD_2).fitted.values.tolist() == [True]
    both = text + read("a sun of 0.5 kg", run='"heavy"', tolerance="1e6", because='"wide"')
    better = run(both, head=HEAD_2)
    assert better.reading.values.tolist() == ["a sun of 0.5 kg"]  # without a fitted value, though it comes later
    assert better.fitted.values.tolist() == [False]
    assert better.tolerance.values.tolist() == [1e6]


TRIED = read("a sun of 0.5 kg", run='"heavy"') + read("a sun of 0.3 kg", run='"fitted"')


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        (bare("not reproducible", 5.0) + TRIED, "holds"),
        (bare("not reproducible", HEAVY) + TRIED, "contradicted"),  # a reading gives it
        (bare("not reproducible", 11775.3) + TRIED, "contradicted"),  # no reading is needed
        (bare("under a reading", 5.0) + TRIED, "contradicted"),  # none gives it
        (bare("under a reading", 11775.3) + TRIED, "contradicted"),  # no reading is needed
        (bare("reproduced", 11775.3) + TRIED, "holds"),
        (bare("reproduced", HEAVY) + TRIED, "contradicted"),
        (bare("not reproducible", "> 20000") + TRIED, "holds"),
        (bare("not reproducible", "> 11000") + TRIED, "contradicted"),
        (bare("not reproducible", "a curve") + TRIED, "holds"),
        (row("under a reading", 11775.3) + TRIED, "holds"),  # the row's own number is a reading
    ],
)
def test_the_verdict_is_the_best_that_holds(text: str, outcome: str, run: Auditor) -> None:
    assert run(text, head=HEAD_2).outcome.values.tolist() == [outcome]


def test_of_a_list_a_reading_gives_all_numbers_or_none(run: Auditor) -> None:
    """One of two numbers comes out by chance of each reading: neither gives the list."""
    each = 'ours = { run = "modes", take = "frequency", pick = [0, -1], reduce = "each" }'
    one = read("a sun of 0.5 kg", run='"heavy"')
    result = run(bare("not reproducible", [0.0, 5.0], ours=each) + one, head=HEAD_2)
    assert result.outcome.values.tolist() == ["holds", "holds"]
    assert result.attempt_row.values.tolist() == [0, 0, 1, 1]
    assert result.attempt_outcome.values.tolist() == ["within", "within", "outside", "outside"]
    result = run(bare("under a reading", [0.0, HEAVY], ours=each) + one, head=HEAD_2)
    assert result.outcome.values.tolist() == ["holds", "holds"]
    result = run(bare("not reproducible", [0.0, HEAVY], ours=each) + one, head=HEAD_2)
    assert result.outcome.values.tolist() == ["contradicted", "contradicted"]


def test_a_reading_without_its_package(run: Auditor) -> None:
    absent = '[runs.absent]\nbased_on = "heavy"\nneeds = "no_such_package"\n'
    text = bare("under a reading", HEAVY) + read("not installed", run='"absent"')
    (outcome,) = run(text, head=HEAD_2 + absent).outcome.values.tolist()
    assert outcome.startswith("not computed: no_such_package")
    other = text + read("a sun of 0.5 kg", run='"heavy"')
    result = run(other, head=HEAD_2 + absent)
    assert result.outcome.values.tolist() == ["holds"]
    assert result.attempt_outcome.values[1].startswith("not computed: no_such_package")


def test_what_is_measured_or_drawn_is_not_compared(run: Auditor) -> None:
    rows = [
        f'[[rows]]\nquantity = "q"\nplace = "Fig. 1"\npublished = {published}\nunit = "Hz"\n{ours}'
        f'verdict = "not compared"\npublished_as = "{kind}"\n'
        for published, ours, kind in (("1.12", "", "measured"), ('"a curve"', OURS + "\n", "drawn"))
    ]
    result = run(*rows, head=HEAD_2)
    assert result.outcome.values.tolist() == ["holds", "holds"]
    assert tally(result)["lin1999-n3"].endswith("0 not reproducible, 2 not compared, 0 contradicted")
    words = [str(cell) for cell in tables(result)[0].columns["verdict"]]
    assert words == ["not compared: measured", "not compared: drawn"]


def test_a_hand_calculation_is_counted_apart(run: Auditor) -> None:
    hand = row("reproduced", extra='tolerance = 0.05\norigin = "hand calculation"')
    wrong = row("reproduced", 5.0, extra='tolerance = 0.05\norigin = "hand calculation"')
    result = run(row("reproduced"), hand, head=HEAD_2)
    expected = (
        "1 reproduced, 0 under a reading, 0 not reproducible, 0 not compared, 0 contradicted, 1 hand calculations"
    )
    assert tally(result)["lin1999-n3"] == expected
    assert str(tables(result)[0].columns["verdict"][1]) == "agrees with our hand calculation"
    assert tally(run(hand, wrong, head=HEAD_2))["lin1999-n3"].endswith("1 contradicted, 1 hand calculations")


def test_what_agrees_is_told_before_it_is_summed_up(run: Auditor) -> None:
    """Of eight rows six agree: one by hand, one zero, one count, one inequality, two values."""
    hand = row("reproduced", extra='tolerance = 0.05\norigin = "hand calculation"')
    zero = row("reproduced", 0.0, ours='ours = { run = "modes", take = "frequency", reduce = "min" }')
    count = row(
        "reproduced", 18, ours='ours = { run = "modes", take = "frequency", reduce = "count" }', extra="tolerance = 0"
    ).replace('unit = "Hz"', 'unit = "1"')
    others = [row("under a reading"), row("reproduced", 5.0)]
    values = [row("reproduced"), row("reproduced")]
    result = run(hand, zero, count, row("reproduced", "> 11000", extra=""), *values, *others, head=HEAD_2)
    assert result.outcome.values.tolist() == ["holds"] * 7 + ["contradicted"]
    assert tables(result)[-1].lead == (
        "6 of 8 rows agree without a reading: 1 hand calculations of ours, 1 zeros, 1 counts, 1 inequalities, "
        "2 other numbers, inputs among them."
    )


def test_several_drives_keep_their_attempts_apart(tmp_path: Path) -> None:
    for name in ("a", "b"):
        text = HEAD_2 + row("reproduced") + bare("not reproducible", 5.0) + read(f"of {name}", run='"heavy"')
        (tmp_path / f"{name}.audit.toml").write_text(text.replace('drive = "lin1999-n3"\n', ""), encoding="utf-8")
        (tmp_path / f"{name}.toml").write_text(model_text(resolved_document(epicyclic.load("lin1999-n3"))))
    result = epicyclic.audit([tmp_path / "a.audit.toml", tmp_path / "b.audit.toml"])
    assert result.attempt_row.values.tolist() == [1, 1, 3, 3]
    first, second, _ = tables(result)
    assert first.columns["quantity"] == ["q {}", "q {}", "- as printed", "- of a"]
    assert second.columns["quantity"] == ["q {}", "q {}", "- as printed", "- of b"]


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
    # reproduced, under a reading, not reproducible, not compared, contradicted
    assert verdicts == ["lin1999-n3", "1", "1", "0", "0", "0"]
    assert "11775.3 Hz" in out
    assert "reading: so read" in out


def test_command_fails_where_a_row_is_contradicted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", written(tmp_path, row("reproduced") + row("reproduced", 11776.0))) == 4
    assert "- lin1999-n3: q {}: contradicted [audit-differs]" in capsys.readouterr().out
    assert command("audit", written(tmp_path, row("reproduced", 11776.0)), "--json") == 4
    streams = capsys.readouterr()
    assert xr.Dataset.from_dict(json.loads(streams.out)).outcome.values.tolist() == ["contradicted"]
    assert "q {}: contradicted" in streams.err


def test_command_tells_a_wrong_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = row("reproduced").replace(OURS, "ours = 5")
    path = written(tmp_path, row("reproduced") + wrong)
    assert command("audit", path, "--json") == 2
    streams = capsys.readouterr()
    assert xr.Dataset.from_dict(json.loads(streams.out)).outcome.values[0] == "holds"
    assert f"{path}: rows.1.ours = 5: not a table" in streams.err
    assert command("audit", written(tmp_path, row("reproduced", 11776.0) + wrong)) == 4


def test_command_calls_a_fitted_value_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", written(tmp_path, row("under a reading", extra="fitted = true\ntolerance = 0.05"))) == 0
    assert "fitted" in capsys.readouterr().out


def test_command_refuses_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command("audit", "ren2020") == 2
    assert "no such audit; did you mean 'ren2021'?" in capsys.readouterr().err
    assert command("audit", "ren2021", "-o", str(tmp_path / "x.txt")) == 2
    assert "no such kind of output" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".nc", ".json"])
def test_command_writes_a_file(suffix: str, tmp_path: Path) -> None:
    target = tmp_path / f"audit{suffix}"
    assert command("audit", written(tmp_path, row("reproduced")), "-o", str(target)) == 0
    assert target.stat().st_size > 500
