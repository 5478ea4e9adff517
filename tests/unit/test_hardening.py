"""Bad input, full disks, closed streams, kills and damage end in one kind of error, and lose nothing.

The full sizes run by benchmarks/hardening.py.
"""

from __future__ import annotations

import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import hardening
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.document.tables import dotted_line
from epicyclic.engine.run_folder import locked_folder, remove_folder
from epicyclic.errors import ModelError
from epicyclic.results.dataset import load_result, save_result
from epicyclic.results.files import require_writable, seal, write_text
from epicyclic.verbs.record import verbs

DRIVES = Path(epicyclic.__file__).parent / "systems"
TEXT = (DRIVES / "lin1999-n3.toml").read_text(encoding="utf-8")


def titled(title: str) -> str:
    """The text of a model file under another title."""
    return re.sub(r"^title *=.*$", lambda _: f'title = "{title}"', TEXT, count=1, flags=re.MULTILINE)


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments))


def refused(*arguments: str) -> str:
    """What a command that must be refused says, in one line."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    return " ".join(result.output.replace("│", " ").split())


@contextmanager
def small_files(size: int) -> Iterator[None]:
    """Files of this process end at so many bytes, as on a full disk; no bytecode is kept, which would be cut too."""
    before, kept = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = kept


# full disks and streams


@pytest.mark.parametrize("kind", ["nc", "json", "html"])
def test_a_full_disk_is_refused_and_left_as_it_was(kind: str, tmp_path: Path) -> None:
    target = tmp_path / f"out.{kind}"
    target.write_text("before")
    with small_files(1000):
        text = refused("modes", "lin1999-n3", "-o", str(target))
    assert "cannot be written: File too large" in text
    assert target.read_text() == "before"
    assert list(tmp_path.iterdir()) == [target]


def test_a_run_whose_segments_find_no_room_is_refused(tmp_path: Path) -> None:
    with small_files(200_000), pytest.raises(ModelError, match="cannot be written"):
        epicyclic.transient("ren2021", cycles=100, folder=tmp_path / "parts")
    assert not list(tmp_path.rglob("*.part"))


def test_a_report_whose_sections_find_no_room_is_refused(tmp_path: Path) -> None:
    with small_files(40_000):  # the model has room, the results have none
        text = refused("report", "lin1999-n3", "-o", str(tmp_path / "page.html"))
    assert ".kept: cannot be written: File too large" in text


def on_stream(arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command in a shell, with its redirections."""
    command = f"{sys.executable} -m epicyclic {arguments}"
    variables = {**os.environ, **environment}
    return subprocess.run(["bash", "-c", command], capture_output=True, env=variables, check=False, encoding="utf-8")


@pytest.mark.parametrize(("stream", "said"), [("> /dev/full", "No space left"), (">&-", "is closed")])
def test_a_stdout_that_takes_nothing_is_refused(stream: str, said: str) -> None:
    result = on_stream(f"systems {stream}")
    assert result.returncode == 2
    assert result.stderr.startswith("error: stdout: ")
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_reader_that_has_seen_enough_is_no_error() -> None:
    shown = on_stream("systems | (exec 0<&-); exit ${PIPESTATUS[0]}")
    assert shown.returncode == 0
    assert not shown.stderr


@pytest.mark.parametrize("arguments", ["--help", "--version", "relief -h"])
def test_a_help_that_is_not_taken_is_no_fault(arguments: str) -> None:
    full = on_stream(f"{arguments} > /dev/full")
    assert (full.returncode, full.stderr) == (2, "error: stdout: cannot be written: No space left on device\n")
    shown = on_stream(f"{arguments} | (exec 0<&-); exit ${{PIPESTATUS[0]}}")
    assert (shown.returncode, shown.stderr) == (0, "")


def test_a_closed_stderr_is_no_fault() -> None:
    assert on_stream("systems > /dev/null 2>&-").returncode == 0
    assert on_stream("modes no-such-model > /dev/null 2>&-").returncode == 2


def test_what_ascii_cannot_say_is_escaped(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text(titled("Z\u00e4hne"), encoding="utf-8")
    shown = on_stream(f"modes {path}", PYTHONIOENCODING="ascii")
    assert shown.returncode == 0
    assert "Z\\xe4hne" in shown.stdout
    resolved = on_stream(f"check --resolved {path}", PYTHONIOENCODING="ascii")
    assert "Z\u00e4hne" in resolved.stdout  # a model file is UTF-8 whatever the terminal


# targets


@pytest.mark.parametrize("kind", ["folder", "pipe", "loop", "device", "missing"])
def test_targets_that_are_no_files_are_refused_before_the_work(kind: str, tmp_path: Path) -> None:
    target = tmp_path / "out.nc"
    if kind == "folder":
        target.mkdir()
    elif kind == "pipe":
        os.mkfifo(target)
    elif kind == "loop":
        target.symlink_to(target)
    elif kind == "device":
        target.symlink_to("/dev/null")
    else:
        target = tmp_path / "no" / "out.nc"
    with pytest.raises(ModelError, match="cannot be written"):
        require_writable(target)
    assert "--output" in refused("modes", "no-such-model", "-o", str(target))
    assert not Path("/dev/null").is_file()


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of files that commands have written."""
    folder = tmp_path_factory.mktemp("written")
    epicyclic.write_rexs("industrial-stage", folder / "x.rexs")
    for name in ("x.nc", "y.json"):
        save_result(epicyclic.modes("lin1999-n3"), folder / name)
    return folder


@pytest.fixture
def sources(written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder, the current one, of files that commands read and of further names of them."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    Path("in.toml").write_text(TEXT, encoding="utf-8")
    Path("table.csv").write_text("deflection [um], force [kN]\n0, 0\n4, 1\n")
    Path("torques.csv").write_text("time [s], sun [N m]\n0, 1\n1, 1\n")
    Path("job.toml").write_text('verb = "check"\nmodel = "in.toml"\n[grid]\n"stages.main.sun.mass" = ["1 kg"]\n')
    Path("hard.rexs").hardlink_to("x.rexs")
    Path("in.json").symlink_to("in.toml")
    Path("job.json").symlink_to("job.toml")
    return tmp_path


OF_VERBS = {
    "allocate": "--target 1.1",
    "relief": "--vary tip_relief.amount=1..2",
    "track": "--over stages.main.sun.mass",
}


@pytest.mark.parametrize(
    "arguments",
    [
        *(f"{name} in.toml {OF_VERBS.get(name, '')} -o in.json".replace("_", "-") for name in verbs()),
        "allocate in.toml --target 1.1 -o in.toml",
        "check in.toml --resolved -o in.toml",
        'check in.toml --set stages.main.sun.support.radial={file="table.csv"} -o table.csv',
        "transient in.toml --torque torques.csv -o torques.csv",
        "compare lin1999-n4 in.toml -o in.json",
        "compare x.nc y.json -o y.json",
        "show x.nc -o x.nc",
        "show x.nc -o sub/../x.nc",
        "study job.toml -o job.json",
        "study job.toml -o in.json",
        "import x.rexs -o x.toml",
        "export x.rexs -o x.rexs",
        "export x.rexs -o hard.rexs",
    ],
)
def test_an_output_that_is_a_source_is_refused(arguments: str, sources: Path) -> None:
    (sources / "sub").mkdir()
    (sources / "x.toml").symlink_to("x.rexs")
    before = {path: path.read_bytes() for path in sources.glob("*.*")}
    assert "which is read" in refused(*arguments.split())
    assert {path: path.read_bytes() for path in sources.glob("*.*")} == before


def test_write_rexs_does_not_write_over_its_source(sources: Path) -> None:
    (sources / "other.rexs").symlink_to("x.rexs")
    before = (sources / "x.rexs").read_bytes()
    with pytest.raises(ModelError, match="which is read"):
        epicyclic.write_rexs(sources / "x.rexs", sources / "other.rexs")
    assert (sources / "x.rexs").read_bytes() == before


@pytest.mark.parametrize("header", ["", "[stages.{}]", "[stages.main.{}]"])
def test_a_message_leaves_out_the_middle_of_a_long_key(header: str, tmp_path: Path) -> None:
    key = "k" * 1_000_000
    line = "teeth = 1" if header else f"{key} = 1"
    (tmp_path / "long.toml").write_text(f"format = 2\n{header.format(key)}\n{line}\n")
    told = refused("modes", str(tmp_path / "long.toml"))
    assert "kkk...kkk" in told
    assert len(told) < 1000


def test_many_stages_in_one_line_are_not_one_long_key() -> None:
    stages = ", ".join(f"s{i}.sun.teeth = 20" for i in range(400))
    assert dotted_line(f'stages = {{ {stages} }}\ntitle = "{"a." * 400}"') is None
    assert dotted_line(f"title = 1\nstages = {{ {'a . ' * 200}{chr(34)}b.c{chr(34)}{'.a' * 200} = 1 }}") == 2


@pytest.mark.parametrize(
    ("columns", "least", "most"),
    [("10", 20, 40), ("60", 41, 60), ("90", 61, 90), ("0", 91, 160), ("many", 91, 160), ("", 91, 160)],
)
def test_tables_are_as_wide_as_columns_says(columns: str, least: int, most: int) -> None:
    result = CliRunner().invoke(app, ["modes", "wind-stage"], env={"COLUMNS": columns})
    rules = [len(line) for line in result.stdout.splitlines() if line.startswith("─")]  # below the heads of columns
    assert least <= max(rules) <= most


def test_an_output_of_before_is_replaced(tmp_path: Path) -> None:
    model, output = tmp_path / "in.toml", tmp_path / "out.nc"
    model.write_text(TEXT, encoding="utf-8")
    for verb in ("check", "modes"):
        assert run(verb, str(model), "-o", str(output)).exit_code == 0
        assert load_result(output).attrs["verb"] == verb


def test_a_long_name_keeps_room_for_the_temporary_one(tmp_path: Path) -> None:
    target = tmp_path / ("ä" * 120 + ".json")
    write_text(target, "{}")
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_keeps_its_permissions(tmp_path: Path) -> None:
    target = tmp_path / "out.txt"
    target.touch(mode=0o600)
    write_text(target, "new")
    assert target.stat().st_mode & 0o777 == 0o600


# kills, races


@pytest.mark.parametrize("number", range(4))
def test_a_writer_that_is_killed_leaves_one_whole_file(number: int, tmp_path: Path) -> None:
    target = tmp_path / "out.txt"
    texts = ("a" * 3_000_000, "b" * 3_000_000)
    write_text(target, texts[0])
    program = (
        "from epicyclic.results.files import write_text\n"
        "print('ready', flush=True)\n"
        f"while True:\n for c in 'ab': write_text({str(target)!r}, c * 3_000_000)\n"
    )
    writer = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE)
    assert writer.stdout is not None
    assert writer.stdout.readline() == b"ready\n"
    time.sleep(random.Random(number).uniform(0, 0.1))
    writer.send_signal(signal.SIGKILL)
    writer.communicate()
    assert target.read_text() in texts
    left = [path for path in tmp_path.iterdir() if path != target]
    assert all(path.name.startswith(".out.txt.") and path.name.endswith(".part") for path in left)
    write_text(target, "next")  # what the killed one left is in nobody's way
    assert target.read_text() == "next"


def test_two_runs_do_not_write_to_one_folder(tmp_path: Path) -> None:
    folder = tmp_path / "parts"
    with locked_folder(folder), pytest.raises(ModelError, match="another run writes there"):
        epicyclic.transient("ren2021", cycles=1, folder=folder)
    epicyclic.transient("ren2021", cycles=1, folder=folder)  # the lock goes with its holder
    (folder / "mine.txt").touch()
    with locked_folder(folder):
        remove_folder(folder)
    assert (folder / "000000.kept").is_file()
    remove_folder(folder)
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]


def test_what_a_killed_run_left_is_in_nobodys_way(tmp_path: Path) -> None:
    folder = tmp_path / "parts"
    folder.mkdir()
    left = folder / ".run.json.0123456789ab.part"
    left.touch()
    found = epicyclic.transient("ren2021", cycles=1, folder=folder)
    xr.testing.assert_identical(found, epicyclic.transient("ren2021", cycles=1))
    assert left.is_file()  # of another run: it goes with the folder alone
    remove_folder(folder)
    assert not folder.exists()


# damaged files


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_result(epicyclic.modes("lin1999-n3"), tmp_path_factory.mktemp("saved") / "modes.nc")


def test_damaged_results_are_refused(tmp_path: Path) -> None:
    found = hardening.damages(60, tmp_path)
    assert found["refused"] >= 55
    assert set(found) <= {"refused", "the bytes were the same"}


def test_other_programs_read_a_result_and_what_they_write_is_read(saved: Path, tmp_path: Path) -> None:
    with xr.open_dataset(saved, engine="h5netcdf") as opened:
        opened.load().to_netcdf(tmp_path / "again.nc", engine="h5netcdf")
    xr.testing.assert_identical(load_result(tmp_path / "again.nc"), load_result(saved))


def test_files_without_a_digest_load(saved: Path, tmp_path: Path) -> None:
    raw = saved.read_bytes()
    earlier = tmp_path / "earlier.nc"
    earlier.write_bytes(raw[: -len(seal(b""))])
    xr.testing.assert_identical(load_result(earlier), load_result(saved))
    earlier.write_bytes(raw[:-1])  # but not those that have lost a part of it
    with pytest.raises(ModelError, match="damaged"):
        load_result(earlier)


def test_a_flipped_digit_in_json_is_refused(saved: Path, tmp_path: Path) -> None:
    whole = load_result(saved)
    path = save_result(whole, tmp_path / "modes.json")
    text = path.read_text(encoding="utf-8")
    random_ = random.Random(5)
    digits = [found.start() for found in re.finditer(r"\d", text)]
    for at in [*random_.sample(digits, 40), text.rindex("sha256") + 4, digits[-1]]:  # the name of the digest, and it
        other = text[:at] + str((int(text[at]) + 1 + random_.randrange(9)) % 10) + text[at + 1 :]
        if other == text:
            continue
        path.write_text(other, encoding="utf-8")
        with pytest.raises(ModelError, match="not a result file"):
            load_result(path)
    # laid out anew by another program, or written by an earlier version
    table = json.loads(text)
    path.write_text(json.dumps(table, indent=2), encoding="utf-8")
    xr.testing.assert_identical(load_result(path), whole)
    del table["sha256"]
    path.write_text(json.dumps(table), encoding="utf-8")
    xr.testing.assert_identical(load_result(path), whole)


def test_data_in_other_files_are_refused(saved: Path, tmp_path: Path) -> None:
    path = tmp_path / "made.nc"
    made: dict[str, Callable[[h5py.File], object]] = {
        "is a link": lambda file: file.__setitem__("a", h5py.ExternalLink(str(saved), "/frequency")),
        "in another file": lambda file: file.create_dataset("a", (8,), "f8", external=[(str(saved), 0, 64)]),
        "declares": lambda file: file.create_dataset("a", (10**12,), "f8", chunks=(1000,)),
        "is a group": lambda file: file.create_group("a"),
    }
    for problem, write in made.items():
        with h5py.File(path, "w") as file:
            write(file)
        with pytest.raises(ModelError, match=problem):
            load_result(path)


def test_a_damaged_segment_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "parts"
    epicyclic.transient("ren2021", cycles=1, folder=folder)
    segment = folder / "000000.kept"
    raw = bytearray(segment.read_bytes())
    raw[len(raw) // 2] ^= 1
    segment.write_bytes(raw)
    with pytest.raises(ModelError, match="not a segment of a run: damaged"):
        epicyclic.transient("ren2021", cycles=1, folder=folder, resume=True)


# input without end or measure


@pytest.mark.parametrize("device", ["/dev/zero", "pipe"])
def test_files_that_never_end_are_refused(device: str, tmp_path: Path) -> None:
    if device == "pipe":
        device = str(tmp_path / "pipe.csv")
        os.mkfifo(device)
    pitch = ("modes", "lin1999-n3", "--set", f"deviations.sun.pitch={device}")
    force = ("modes", "lin1999-n3", "--set", f"stages.main.meshes.sun-planet.stiffness={{file='{device}'}}")
    relief = ("relief", "ren2021", "--mesh", "sun-planet", "--vary", "crown=0..9 um", "--resume", device)
    for arguments in (
        ("modes", device),
        pitch,
        force,
        relief,
        ("transient", "ren2021", "--torque", device),
        ("modulation", "ren2021", "--transfer", device),
        ("transient", "ren2021", "--initial", device if device.endswith(".nc") else "/dev/zero.nc"),
    ):
        said = refused(*arguments)
        wanted = ("is no folder of a run",) if "--resume" in arguments else ("no regular file", "no such file")
        assert any(words in said for words in wanted), arguments


def test_a_cell_of_200_000_characters_is_refused(tmp_path: Path) -> None:
    table = tmp_path / "torque.csv"
    table.write_text("time [s], sun [N m]\n0, 1\n1, " + "1" * 200_000)
    message = refused("transient", "ren2021", "--torque", str(table))
    assert "torque.csv, line 3 = 1, 111" in message
    assert "no row of a table" in message


def test_a_nested_record_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text("[" * 100_000)
    text = refused("relief", "ren2021", "--mesh", "sun-planet", "--vary", "crown=0..9 um", "--resume", str(tmp_path))
    assert "not a run that can be continued" in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("sharing ren2021 --samples 1000000000", "--samples"),
        ("sharing ren2021 --cycles 1000000000", "would take some 13.5 h"),
        ("static ren2021 --cycles 1000000000", "would need some 1.61e+04 GB"),
        ("transient ren2021 --start 1e-9Hz", "would take some 674 years"),
        ("transient ren2021 --decimate 100000000", "1 to 3200"),
        ("transient ren2021 --cycles nan", "--cycles"),
        ("transient ren2021 --torque-step 1e300@0s", "no torque of a machine"),
        ("stability ren2021 --over damping --values 0..1 --value-points 10000 --points 100000", "some 579 days"),
        ("stability ren2021 --variation 1e300", "--variation"),
        ("sweep ren2021 --tolerance -1", "--tolerance"),
        ("sweep ren2021 --tolerance nan", "--tolerance"),
        ("contact ren2021 --linear-at 0", "> 0"),
        ("contact ren2021 --samples 100000 --slices 1000", "would need some"),
        ("contact ren2021 --load-points 3", "is the number of loads in a range"),
        ("steady ren2021 --relative-speed nan", "--relative-speed"),
        ("sensitivity ren2021 --relative-speed inf", "--relative-speed"),
        ("steady ren2021 --relative-speed 1e300 --contact-loss", "--relative-speed"),
        ("sharing ren2021 --method static --relative-speed 2", "moves nothing at rest"),
        ("modes ren2021 --set " + ".".join(["a"] * 30_000) + "=1", "nested too deeply"),
    ],
)
def test_numbers_without_measure_are_refused_at_once(arguments: str, said: str) -> None:
    assert said in refused(*arguments.split())


def test_the_package_refuses_the_same_numbers() -> None:
    for options in ({"relative_speed": np.inf}, {"samples": 10**9}, {"cycles": 0}):
        with pytest.raises(ModelError, match="out of range"):
            epicyclic.sharing("ren2021", **options)


def test_dotted_keys_and_many_stages_are_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text("format = 2\n" + ".".join(["a"] * 100_000) + " = 1\n")
    with pytest.raises(ModelError, match=r"nested too deeply \(line 2\)"):
        epicyclic.load(path)
    table = hardening._tables()[-1]
    stage = next(iter(table["stages"].values()))
    many = {**table, "stages": {f"s{i}": stage for i in range(60)}}
    with pytest.raises(ModelError, match=r"stages|s0"):
        epicyclic.load({"format": 2, "title": "many", "stages": many["stages"]})


def test_control_characters_do_not_reach_the_terminal(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text(titled("\\u001b[31m"), encoding="utf-8")
    result = run("modes", str(path))
    assert result.exit_code == 2
    assert "title" in result.output
    assert "holds a control character, U+001B" in result.output
    assert "\x1b" not in result.output
    assert "\x1b" not in run("modes", "no\x1b[31m.toml").output


def test_mutated_model_files_are_read_or_refused() -> None:
    told: list[str] = []
    found = hardening.mutations(60, seed=3, report=told.append)
    assert found["fault"] == 0, told
    assert found["modes answered"] > 5
    assert found["load refused"] > 15


@pytest.mark.parametrize("text", ["{}", "[]", '{"data_vars": []}', '{"data_vars": {}}'])
def test_json_that_is_no_result_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "none.json"
    path.write_text(text)
    with pytest.raises(ModelError, match="not a result file: no data_vars"):
        load_result(path)


def test_a_speed_of_too_many_steps_is_refused_with_the_least() -> None:
    with pytest.raises(ModelError, match=r"steps of the highest mode; .*allowed: from .* or unstable"):
        epicyclic.sweep("ren2021", contact_loss=True, mesh_frequency=[1e-9, 30.0])


def test_one_speed_of_too_many_steps_has_a_motion_of_unknown_stability() -> None:
    slow = epicyclic.steady("ren2021", contact_loss=True, relative_speed=1e-9)
    (text,) = (text for text in json.loads(slow.attrs["warnings"]) if "[stability-unknown]" in text)
    assert re.search(r"not known: a mesh cycle would take \S+ steps of the highest mode", text)
    still = epicyclic.static("ren2021", cycles=1024, samples=64)  # with phases enough for a bound over all
    assert slow["mesh_force_bound"].values == pytest.approx(still["mesh_force"].values.max(axis=1), rel=1e-4)
