"""Files of all kinds beside the tables, figures by name, saved results shown again."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import openpyxl
import pandas as pd
import pytest
import xarray as xr
from kaleido import _page_generator
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.results.dataset import has_digest
from epicyclic.show.plot import figure_names, write_figure
from epicyclic.verbs.record import verbs

DRIVE = "lin1999-n4"


class Ran(NamedTuple):
    status: int
    out: str
    err: str


Command = Callable[..., Ran]


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Command:
    """Run the command line in this process and in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Ran:
        with pytest.raises(SystemExit) as stop:
            app(list(arguments), prog_name="epicyclic")
        streams = capsys.readouterr()
        return Ran(int(stop.value.code or 0), streams.out, streams.err)

    return run


@pytest.mark.parametrize("suffix", [".nc", ".json", ".csv", ".xlsx", ".html"])
def test_a_file_leaves_the_screen_as_it_is(command: Command, suffix: str) -> None:
    plain = command("check", DRIVE)
    filed = command("check", DRIVE, "-o", f"x{suffix}")
    assert filed.status == 0
    assert filed.out == plain.out
    assert filed.err == f"{plain.err}written: x{suffix}\n"
    assert [path.name for path in Path().iterdir()] == [f"x{suffix}"]


def test_tables_of_a_file_are_those_of_the_result(command: Command) -> None:
    result = epicyclic.modes(DRIVE)
    command("modes", DRIVE, "-o", "m.csv")
    table = pd.read_csv("m.csv", low_memory=False)
    assert table[table["variable"] == "frequency"]["value"].tolist() == result["frequency"].values.tolist()
    command("modes", DRIVE, "-o", "m.xlsx")
    found = pd.read_excel("m.xlsx", sheet_name="mode")
    assert found["frequency [Hz]"].tolist() == result["frequency"].values.tolist()


def test_a_title_stays_text_through_the_command_line(command: Command) -> None:
    command("check", DRIVE, "--set", 'title="=cmd()"', "-o", "x.xlsx")
    about = {row[0].value: row[1] for row in openpyxl.load_workbook("x.xlsx")["about"].iter_rows()}
    assert (about["title"].value, about["title"].data_type != "f") == ("=cmd()", True)
    command("check", DRIVE, "--set", 'title="=cmd()"', "-o", "x.csv")
    assert "\ntitle,attribute,," in Path("x.csv").read_text()
    assert ",'=cmd()\n" in Path("x.csv").read_text()


def test_an_audit_goes_into_every_format(command: Command) -> None:
    plain = command("audit", DRIVE)
    for suffix in (".nc", ".csv", ".xlsx", ".html"):
        filed = command("audit", DRIVE, "-o", f"x{suffix}")
        assert (filed.status, filed.out) == (plain.status, plain.out)
    assert command("show", "x.nc").out == plain.out


@pytest.mark.parametrize("verb", ["check", "sharing", "sweep"])
def test_show_prints_what_the_verb_did(command: Command, verb: str) -> None:
    options = ("--points", "5") if verb == "sweep" else ()
    plain = command(verb, "ren2021", *options, "-o", "x.nc")
    assert command("show", "x.nc") == Ran(0, plain.out, "")
    assert command("show", "x.nc", "-o", "x.json") == Ran(0, plain.out, "written: x.json\n")
    assert command("show", "x.json").out == plain.out
    xr.testing.assert_identical(epicyclic.load_result("x.json"), epicyclic.load_result("x.nc"))


def test_every_table_on_demand(command: Command) -> None:
    brief, whole = command("check", DRIVE), command("check", DRIVE, "--all", "-o", "x.nc")
    assert len(whole.out.splitlines()) > 2 * len(brief.out.splitlines())
    assert command("check", DRIVE, "--all").out == whole.out
    assert command("show", "x.nc", "--all").out == whole.out
    assert command("show", "x.nc").out == brief.out


def test_show_of_several(command: Command) -> None:
    for verb in ("check", "modes"):
        command(verb, DRIVE, "-o", f"{verb}.nc")
    both = command("show", "modes.nc", "check.nc", "-o", "both.html")
    assert both.status == 0
    assert "Vibration modes" in Path("both.html").read_text()
    assert command("show", "modes.nc", "check.nc", "-o", "both.csv").status == 2
    assert "given twice" in command("show", "modes.nc", "modes.nc").err
    refused = command("show", "modes.nc", "--figure", "shapes", "-o", "x.html")
    assert (refused.status, "epicyclic check" in refused.err) == (2, True)
    assert command("show", "modes.nc", "check.nc", "--figure", "shapes", "-o", "x.html").status == 0
    assert sorted(path.name for path in Path().glob("*.html")) == ["both.html", "x.html"]


def test_results_of_one_name_in_two_folders_are_both_shown(command: Command) -> None:
    for folder, changed in (("one", ()), ("two", ("--set", "title=Other"))):
        Path(folder).mkdir()
        command("modes", DRIVE, *changed, "-o", f"{folder}/x.nc")
    assert command("show", "one/x.nc", "two/x.nc", "-o", "both.html").status == 0
    page = Path("both.html").read_text()
    assert all(f"{folder}/x.nc" in page for folder in ("one", "two"))


def test_what_cannot_be_shown(command: Command) -> None:
    Path("x.nc").write_text("no result")
    for arguments in (("show", "nosuch.nc"), ("show", "x.nc"), ("show",)):
        refused = command(*arguments)
        assert refused.status == 2
        assert "Traceback" not in refused.err


def test_a_result_that_another_program_cut_is_no_fault(command: Command) -> None:
    epicyclic.modes(DRIVE).drop_vars("frequency").to_netcdf("cut.nc", engine="h5netcdf")
    refused = command("show", "cut.nc")
    assert (refused.status, "no whole result of its verb (modes)" in refused.err) == (2, True)
    assert not has_digest("cut.nc")
    for own in ("own.nc", "own.json"):  # of these a KeyError stays a fault of the program
        epicyclic.save_result(epicyclic.modes(DRIVE).drop_vars("frequency"), own)
        assert has_digest(own)
        assert command("show", own).status == 1


def test_wrong_figures_and_files_are_told_before_the_work(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("epicyclic.cli.command.import_model_rooms", lambda: pytest.fail("work has begun"))
    wrong = command("modes", DRIVE, "--figure", "nosuch", "-o", "x.svg")
    assert wrong.status == 2
    assert "frequencies, shapes, energy, campbell" in wrong.err
    assert "needs a file" in command("modes", DRIVE, "--figure", "energy").err
    assert "--figure NAME" in command("modes", DRIVE, "-o", "x.svg").err
    assert ".svg" in command("modes", DRIVE, "--figure", "energy", "-o", "x.nc").err
    assert list(Path().iterdir()) == []


def test_a_figure_without_its_extra_or_without_a_browser(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BROWSER_PATH", "/nowhere/chromium")
    refused = command("modes", DRIVE, "--figure", "energy", "-o", "x.png")
    assert refused.status == 2
    assert "Chromium" in refused.err
    assert "epicyclic[figures]" in refused.err
    monkeypatch.setitem(__import__("sys").modules, "kaleido", None)
    refused = command("modes", DRIVE, "--figure", "energy", "-o", "x.png")
    assert (refused.status, "kaleido, which is not installed" in refused.err) == (2, True)
    assert command("modes", DRIVE, "--figure", "energy", "-o", "x.html").status == 0
    assert [path.name for path in Path().iterdir()] == ["x.html"]


def test_what_cannot_be_drawn_is_not_lost(command: Command) -> None:
    # the verb has such a figure, with --contact-loss alone
    failed = command("sweep", "ren2021", "--points", "2", "--figure", "contact-sweep", "-o", "x.html")
    assert failed.status == 2
    assert "--figure = contact-sweep" in failed.err
    assert "the result is kept in x.nc" in failed.err
    assert epicyclic.load_result("x.nc").attrs["verb"] == "sweep"
    assert not Path("x.html").exists()


def test_several_figures_are_files_of_their_names(command: Command) -> None:
    done = command("modes", DRIVE, "--figure", "shapes", "--figure", "frequencies", "-o", "x.html")
    assert done.out == command("modes", DRIVE).out
    assert sorted(path.name for path in Path().iterdir()) == ["x-frequencies.html", "x-shapes.html"]


def test_help_names_the_figures(command: Command) -> None:
    for name, verb in verbs().items():
        drawn = any(figure_names(kind) for kind in verb.gives)
        assert ("--figure" in command(name.replace("_", "-"), "--help").out) == drawn


@pytest.mark.browser
def test_pictures_are_drawn_offline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    page = _page_generator.PageGenerator
    whole = page.generate_index

    def seen(self: Any) -> str:
        made.append(whole(self))
        return made[-1]

    monkeypatch.setattr(page, "generate_index", seen)
    figure = epicyclic.plot("energy", epicyclic.modes(DRIVE))
    svg = write_figure(figure, tmp_path / "x.svg")
    text = svg.read_text()
    assert ElementTree.fromstring(text).attrib["width"] == "900"
    assert re.search(r"<text[^>]*>", text)
    assert write_figure(figure, tmp_path / "x.pdf").read_bytes().startswith(b"%PDF-1")
    png = write_figure(figure, tmp_path / "x.png").read_bytes()
    assert png.startswith(b"\x89PNG")
    assert int.from_bytes(png[16:20]) == 1800  # two dots a point
    # all that the browser loads lies on this machine
    assert len(made) == 3
    assert [source for text in made for source in re.findall(r'src="(.*?)"', text) if source[:7] != "file://"] == []


def test_show_of_a_model_names_check(tmp_path: Path) -> None:
    for name in ("gearbox.toml", "gearbox.rexs"):
        file = tmp_path / name
        file.write_text("format = 2\n", encoding="utf-8")
        told = CliRunner().invoke(app, ["show", str(file)])
        assert told.exit_code == 2
        assert f"epicyclic check {file}" in " ".join(told.stderr.split())
