"""Audit files: what is refused, with the place and what is allowed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

from epicyclic.audits.audit_file import Audit, Verdict, attempts, audited_drives, claim_of
from epicyclic.audits.audit_file import read_audit as read_file
from epicyclic.errors import ModelError

HEAD = 'format = 2\nsource = "A. Author 2020"\n[runs.modes]\nverb = "modes"\n'
OURS = 'ours = { run = "modes", take = "frequency", reduce = "max" }'
ROW = f"""
[[rows]]
quantity = "highest frequency"
place = "Table 1"
published = 11775.3
unit = "Hz"
{OURS}
verdict = "reproduced"
tolerance = 0.06
because = "printed to 0.1 Hz"
"""

# what is replaced, by what, where the error is, what it says
WRONG = [
    ("format = 2", "format = 1", "format", "allowed: 2"),
    ('source = "A. Author 2020"', "", "source", "missing"),
    ('source = "A. Author 2020"', 'sources = "A. Author 2020"', "sources", "unknown key"),
    ('verb = "modes"', 'verb = "shapes"', "runs.modes", "no verb 'shapes'"),
    ('verb = "modes"', "", "runs.modes", "neither verb nor based_on"),
    ('verb = "modes"', 'based_on = "mods"', "runs.modes.based_on", "no such run"),
    ('verb = "modes"', 'based_on = "modes"', "runs.modes.based_on", "based on itself"),
    ('verb = "modes"', 'verb = "modes"\nfitted = ["a.b"]', "runs.modes.fitted", "fitted, but not set"),
    ('verb = "modes"', 'verb = "modes"\noverrides = {}', "runs.modes.overrides", "unknown key"),
    ('quantity = "highest frequency"', "", "rows.0.quantity", "missing"),
    ('place = "Table 1"', 'place = ""', "rows.0.place", "empty; allowed: a text"),
    ("published = 11775.3", 'published = "large"', "rows.0", "a text cannot be checked"),
    (OURS, "", "rows.0", "nothing is computed"),
    ('run = "modes"', 'run = "modse"', "rows.0.ours.run", "no such run"),
    ('run = "modes", ', "", "rows.0.ours", "belong together"),
    (', take = "frequency"', "", "rows.0.ours", "nothing to compute"),
    ('reduce = "max"', "value = 1", "rows.0.ours", "both take and value"),
    ('reduce = "max"', 'reduce = "maximum"', "rows.0.ours", "no reduction 'maximum'"),
    ('reduce = "max"', 'reduce = "argmax"', "rows.0.ours", "`read`"),
    ('reduce = "max"', 'read = "mode"', "rows.0.ours", "`read`"),
    ('reduce = "max"', 'reduction = "max"', "rows.0.ours.reduction", "unknown key"),
    (
        OURS,
        "ours = { difference = [{ value = 1 }, { amount = 2 }] }",
        "rows.0.ours.difference.1.amount",
        "unknown key",
    ),
    ('verdict = "reproduced"', 'verdict = "fine"', "rows.0.verdict", '"reproduced"'),
    ('verdict = "reproduced"', 'verdict = "under a reading"', "rows.0", "the reading is not stated"),
    ('verdict = "reproduced"', 'verdict = "not reproducible"', "rows.0", "no reason"),
    ('verdict = "reproduced"', 'verdict = "reproduced"\nfitted = true', "rows.0", "with a fitted value"),
    ("tolerance = 0.06", "", "rows.0", "no tolerance"),
    ("tolerance = 0.06", "tolerance = -1", "rows.0.tolerance", "out of range; allowed: >= 0.0"),
    ("tolerance = 0.06", "tolerance = inf", "rows.0.tolerance", "a finite number"),
    ("published = 11775.3", "published = nan", "rows.0.published", "a finite number"),
    ("tolerance = 0.06", "tolerance = 0.06\nrelative = 1e-4", "rows.0", "both tolerance and relative"),
    ('because = "printed to 0.1 Hz"', "", "rows.0", "without its reason"),
    ('because = "printed', 'labels = ["a"]\nbecause = "printed', "rows.0", "labels"),
    ('because = "printed', 'why = "?"\nbecause = "printed', "rows.0.why", "unknown key"),
    ("[[rows]]", "[[rows]", "x.audit.toml", "not TOML"),
]


READING = """
[[rows.readings]]
reading = "a heavier sun"
run = "modes"
tolerance = 0.1
because = "as printed"
"""
ROW_2 = ROW.replace('"reproduced"', '"under a reading"') + READING
WRONG_2 = [
    ('run = "modes"\ntol', 'run = "mods"\ntol', "rows.0.readings.0.run", "no such run"),
    ('run = "modes"\ntol', f'run = "modes"\n{OURS}\ntol', "rows.0.readings.0", "both ours and run"),
    ('run = "modes"\ntol', "tol", "rows.0.readings.0", "no number and no reason"),
    ('run = "modes"\ntol', 'why = "?"\ntol', "rows.0.readings.0.why", "fitted"),
    ('run = "modes"\ntol', 'ours = { run = "modes", tke = "frequency" }\ntol', "rows.0.readings.0.ours.tke", "unknown"),
    ('because = "as printed"', "", "rows.0.readings.0", "without its reason"),
    ("tolerance = 0.1", "tolerance = 0.1\nrelative = 0.1", "rows.0.readings.0", "both tolerance and relative"),
    ("tolerance = 0.1", "tolerance = -0.1", "rows.0.readings.0.tolerance", "out of range; allowed: >= 0.0"),
    ('"a heavier sun"', '"as printed"', "rows.0", "two readings of the same text"),
    ('"a heavier sun"', '""', "rows.0.readings.0.reading", "empty; allowed: a text"),
    (OURS, "", "rows.0", "ours of the row is not computed from one"),
    (OURS, "ours = { value = 1 }", "rows.0", "ours of the row is not computed from one"),
    ("tolerance = 0.06", "", "rows.0", "no tolerance"),
    ('"under a reading"', '"not compared"', "rows.0", "belong together"),
    ('"under a reading"', '"not compared"\npublished_as = "drawn"', "rows.0", "with a tolerance or readings"),
    ('"under a reading"', '"not compared"\npublished_as = "seen"', "rows.0.published_as", '"measured" or "drawn"'),
    ('"under a reading"', '"under a reading"\npublished_as = "drawn"', "rows.0", "belong together"),
    ('"under a reading"', '"under a reading"\nnothing_to_try = "no"', "rows.0", "a number came out"),
    (
        '"under a reading"',
        '"not reproducible"\nreason = "x"\norigin = "hand calculation"',
        "rows.0",
        "hand calculation that is not reproducible",
    ),
    ('"under a reading"', '"under a reading"\norigin = "us"', "rows.0.origin", '"source" or "hand calculation"'),
]
"""Faults in readings and in what is not compared."""


def read_audit(source: str | Path) -> tuple[str, Audit]:
    """Drive and audit of a file without a wrong row; the error of the first wrong one otherwise."""
    found = read_file(source)
    for wrong in found.wrong:
        raise wrong.error
    return found.drive, found.audit


def write(folder: Path, text: str) -> Path:
    path = folder / "x.audit.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_example_is_right(tmp_path: Path) -> None:
    name, audit = read_audit(write(tmp_path, HEAD + ROW))
    assert name == "x"
    assert audit.rows[0].published == 11775.3


@pytest.mark.parametrize(("old", "new", "path", "says"), WRONG, ids=[f"{w[2]}: {w[3]}" for w in WRONG])
def test_what_is_wrong_is_said(old: str, new: str, path: str, says: str, tmp_path: Path) -> None:
    assert old in HEAD + ROW
    with pytest.raises(ModelError) as error:
        read_audit(write(tmp_path, (HEAD + ROW).replace(old, new, 1)))
    assert error.value.path.endswith(path)
    assert says in str(error.value)


@pytest.mark.parametrize("source", ["ren2020", "nothing", "missing.audit.toml", ""])
def test_no_such_audit(source: str) -> None:
    with pytest.raises(ModelError, match="no such audit") as error:
        read_audit(source)
    assert "ren2021" in error.value.allowed


def test_an_audit_beside_a_model_file_is_of_that_file(tmp_path: Path) -> None:
    path = write(tmp_path, HEAD + ROW)
    (tmp_path / "x.toml").write_text("format = 2", encoding="utf-8")
    assert read_audit(path)[0] == str(tmp_path / "x.toml")
    assert read_audit(write(tmp_path, 'drive = "ren2021"\n' + HEAD + ROW))[0] == "ren2021"


def test_a_run_starts_from_another(tmp_path: Path) -> None:
    runs = """
[runs.base]
verb = "sharing"
drive = "ren2021"
set = { "a" = 1, "b" = 2 }
options = { cycles = 23 }
fitted = ["a"]
[runs.next]
based_on = "base"
set = { "b" = 3 }
options = { method = "static" }
[runs.other]
based_on = "next"
verb = "modes"
"""
    _, audit = read_audit(write(tmp_path, HEAD + runs + ROW))
    following = audit.resolved("next")
    assert (following.verb, following.drive, following.fitted) == ("sharing", "ren2021", ("a",))
    assert following.set == {"a": 1, "b": 3}
    assert following.options == {"cycles": 23, "method": "static"}
    assert audit.resolved("other").options == {}  # those of another verb mean nothing


@pytest.mark.parametrize(("old", "new", "path", "says"), WRONG_2, ids=[f"{w[2]}: {w[3]}" for w in WRONG_2])
def test_what_is_wrong_in_readings_is_said(old: str, new: str, path: str, says: str, tmp_path: Path) -> None:
    text = HEAD + ROW_2
    read_audit(write(tmp_path, text))
    assert old in text
    with pytest.raises(ModelError) as error:
        read_audit(write(tmp_path, text.replace(old, new, 1)))
    assert error.value.path.endswith(path)
    assert says in str(error.value)


def test_a_reading_takes_the_same_from_another_run(tmp_path: Path) -> None:
    """Also where ours is composed."""
    ratio = 'ours = { ratio = [{ run = "modes", take = "frequency", pick = 1, reduce = "max" }, { value = 2 }] }'
    text = (HEAD + ROW_2).replace(OURS, ratio)
    more = text.replace('run = "modes"\ntol', 'run = "more"\ntol') + '[runs.more]\nbased_on = "modes"\n'
    _, audit = read_audit(write(tmp_path, more))
    own, other = attempts(audit.rows[0])
    assert own.ours is not None
    assert other.ours is not None
    assert [*own.ours.runs(), *other.ours.runs()] == ["modes", "more"]
    changed = other.ours.model_dump()
    changed["ratio"][0]["run"] = "modes"
    assert changed == own.ours.model_dump()
    assert (own.tolerance, other.tolerance, other.because) == (0.06, 0.1, "as printed")


def test_a_fitted_run_makes_the_row_fitted(tmp_path: Path) -> None:
    text = (HEAD + ROW).replace('verb = "modes"', 'verb = "modes"\nset = { "a" = 1 }\nfitted = ["a"]')
    with pytest.raises(ModelError, match="reproduced with a fitted value"):
        read_audit(write(tmp_path, text))
    read = text.replace('verdict = "reproduced"', 'verdict = "under a reading"\nreading = "a is fitted"')
    _, audit = read_audit(write(tmp_path, read))
    assert audit.fitted(audit.rows[0])


@pytest.mark.parametrize(
    ("text", "low", "high", "strict"),
    [
        ("> 0", 0.0, float("inf"), True),
        ("<= 1.5e-3", float("-inf"), 1.5e-3, False),
        ("-0.2 .. 0.3", -0.2, 0.3, False),
        (">=2", 2.0, float("inf"), False),
    ],
)
def test_claims(text: str, low: float, high: float, strict: bool) -> None:
    claim = claim_of(text)
    assert claim is not None
    assert (claim.low, claim.high, claim.strict) == (low, high, strict)


@pytest.mark.parametrize("text", ["a curve", "0", "> x", "1 ..", ""])
def test_words_are_no_claims(text: str) -> None:
    assert claim_of(text) is None


def test_the_example_of_the_documentation_is_right(tmp_path: Path) -> None:
    page = Path(__file__).parents[3] / "docs" / "papers" / "audit.md"
    readings, example = re.findall(r"^```toml\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    _, audit = read_audit(write(tmp_path, example))
    assert {row.verdict for row in audit.rows} == set(get_args(Verdict))
    assert [audit.fitted(row) for row in audit.rows] == [False, False, True, False, False, False]
    assert [row.origin for row in audit.rows][-1] == "hand calculation"
    runs = '[runs.gravity]\nverb = "sharing"\n[runs.no-gravity]\nbased_on = "gravity"\n'
    _, audit = read_audit(write(tmp_path, HEAD + runs + readings))
    assert [one.ours is not None for one in attempts(audit.rows[0])] == [True] * 3


def test_audits_are_no_drives() -> None:
    from epicyclic.document.document import drive_titles

    assert set(audited_drives()) <= set(drive_titles())
    assert not any("audit" in name for name in drive_titles())
