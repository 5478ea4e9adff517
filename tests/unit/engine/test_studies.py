"""Verbs, one-parameter studies and the report's run."""

from __future__ import annotations

import json

import numpy as np
import pytest

import epicyclic
from epicyclic.document.document import drive_titles
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.questions.studies.parameter_studies import run_out_study, support_study
from epicyclic.verbs import record
from epicyclic.verbs.record import STUDIES, TO_MODES, report_verbs, run_report, verbs

pytestmark = pytest.mark.usefixtures("few_turning_trains")


def test_a_verb_takes_a_name_a_train_or_a_system() -> None:
    train = epicyclic.load("lin1999-n3")
    results = [epicyclic.modes(source) for source in ("lin1999-n3", train, epicyclic.assemble(train))]
    assert all(result.identical(results[0]) for result in results)


def test_overrides_belong_to_a_file() -> None:
    train = epicyclic.load("lin1999-n3")
    for source in (train, epicyclic.assemble(train)):
        with pytest.raises(ModelError, match="overrides"):
            epicyclic.modes(source, overrides={"stages.main.sun.mass": 1.0})
    with pytest.raises(ModelError, match="drawing"):
        epicyclic.check(epicyclic.assemble(train))


@pytest.mark.parametrize("verb", ["campbell", "static", "sharing"])
def test_progress_ends_at_one(verb: str) -> None:
    seen: list[float] = []
    verbs()[verb].run("ren2021", progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_sweep_range() -> None:
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    result = epicyclic.sweep(system, start=20.0, stop=40.0, points=3)
    np.testing.assert_allclose(result.mesh_frequency, [20.0, 30.0, 40.0], rtol=1e-14)  # through relative speed and back
    highest = epicyclic.modes(system).frequency.values.max()
    wide = epicyclic.sweep(system, start=1000.0, points=2)
    np.testing.assert_allclose(wide.mesh_frequency, [1000.0, 1.2 * highest], rtol=1e-12)  # rounding of the eigenvalue


def test_vary() -> None:
    masses = [0.4, 0.8, -1.0]
    result = epicyclic.vary(
        "lin1999-n4",
        {"stages.main.sun.mass": masses},
        quantity=lambda system: float(epicyclic.modes(system).frequency[1]),
        unit="Hz",
    )
    nominal = float(epicyclic.modes("lin1999-n4").frequency[1])
    assert float(result.quantity[0]) == pytest.approx(nominal, rel=1e-12)  # 0.4 kg is what the model says
    assert float(result.quantity[1]) < nominal - 1.0  # Hz; a doubled mass is felt
    assert np.isnan(result.quantity[2])
    assert [text[:2] for text in result.status.values[:2]] == ["ok", "ok"]
    assert "stages.main.sun.mass" in str(result.status.values[2])
    assert result.quantity.attrs["units"] == "Hz"
    reason = result.status.values[2]
    said = f"1 of 3 points failed, the first with: {reason} [points-failed]"
    assert json.loads(result.attrs["warnings"]) == [said]


def test_vary_together_and_failures() -> None:
    def never(_: object) -> float:
        raise ConvergenceError("no")

    values = {"stages.main.sun.mass": [0.4], "stages.main.ring.mass": [2.35]}
    assert epicyclic.vary("lin1999-n4", values, quantity=never).status.values.tolist() == ["no"]
    for wrong in ({}, {"a": [1], "b": [1, 2]}):
        with pytest.raises(ModelError, match="same number"):
            epicyclic.vary("lin1999-n4", wrong)


def test_design_studies_in_kind() -> None:
    train = epicyclic.load("ren2021", overrides={"operation.torque.sun": "28.75 kN m"})
    support = support_study(train, points=3).system_load_sharing
    # stiffer supports carry more of the errors into the teeth, for every member
    assert (support.diff("support_stiffness") > 0).all()
    run_out = run_out_study(train, points=3).system_load_sharing
    assert set(run_out.member.values) == {"main.sun", "main.ring", "main.carrier", "main.planet"}
    carrier = run_out.sel(member="main.carrier").values
    # load sharing less one is linear in each error once it is the leading one; 5 % covers the others at the small end
    assert carrier[2] - carrier[1] == pytest.approx(carrier[1] - carrier[0], rel=0.05)
    # equal in-phase run-outs of three planets add next to nothing
    planets = run_out.sel(member="main.planet").values
    assert np.ptp(planets) < 0.05 * np.ptp(carrier)


def test_run_outs_are_varied_to_four_times_the_largest() -> None:
    given = {"operation.torque.sun": "28.75 kN m", "deviations.sun.run_out": "40 um"}
    result = run_out_study(epicyclic.load("ren2021", overrides=given), points=3)
    assert result.run_out.values == pytest.approx([0.0, 80.0, 160.0])


def test_design_studies_need_something_to_vary() -> None:
    with pytest.raises(ModelError, match="run-out"):
        run_out_study(epicyclic.load("lin1999-n4"))
    with pytest.raises(ModelError):
        support_study(epicyclic.load("lin1999-n4"), points=2)  # no load


def test_report_runs_everything(monkeypatch: pytest.MonkeyPatch) -> None:
    # which analyses run does not follow from their points
    for name, few in (("_POINTS", (4, 4)), ("_STUDY_POINTS", (3, 2)), ("_SAMPLES", 256)):
        monkeypatch.setattr(record, name, few)
    begun: list[str] = []
    with_bearings = record.verbs()["life"].examples[0]["overrides"]
    results = run_report("ren2021", overrides=with_bearings, progress=begun.append)
    assert list(results) == begun == [*report_verbs(), TO_MODES, *STUDIES]


def test_report_says_what_is_left_out() -> None:
    results = run_report("lin1999-n4")
    assert list(results) == ["check", "stiffness", "modes"]
    left_out = json.loads(results["check"].attrs["not_run"])
    for name in ("campbell", "sharing", "sweep", *STUDIES):
        assert any(text.startswith(f"{name}, as ") for text in left_out), left_out
    sentence = 'run-out, as no member has a run-out; it needs run_out = "20 um" in deviations [section-left-out]'
    assert sentence in left_out
    # a model without tolerances lacks nothing
    assert not any("tolerance" in text for text in left_out)


def test_report_of_a_wrong_model() -> None:
    with pytest.raises(ModelError, match=r"stages\.main\.sun\.teeth"):
        run_report("ren2021", overrides={"stages.main.sun.teeth": -1})


def test_titles() -> None:
    assert list(drive_titles()) == sorted(drive_titles())
    assert "Lin & Parker" in drive_titles()["lin1999-n4"]
