"""Points on several cores: the bits of one process, errors of their type, nothing left behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.engine import workers
from epicyclic.engine.workers import each, processes, runs
from epicyclic.errors import ModelError

METHODS = ("fork", "spawn") if sys.platform == "linux" else ("spawn",)


@pytest.fixture
def two_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two workers for everything after the first item, however short."""
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    monkeypatch.setattr(workers, "_WORTH", dict.fromkeys(METHODS, 0.0))


def place_and_process(item: int) -> tuple[int, int]:
    return item * item, os.getpid()


def refused(item: int) -> int:
    if item == 2:
        raise ModelError("too much", path="mesh_frequency", given=item, allowed="1")
    return item


def killed(own: int, item: int) -> int:
    if os.getpid() != own and item == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


@pytest.mark.usefixtures("two_at_once")
def test_what_takes_a_result_may_raise_an_error_of_the_system() -> None:
    """Else it would be taken for a process that may not be started, and the result be lost."""

    def arrived(place: int, result: tuple[int, int]) -> None:
        if place == 3:
            raise BrokenPipeError("nobody reads")

    with pytest.raises(BrokenPipeError, match="nobody reads"):
        each(place_and_process, range(8), arrived=arrived)


@pytest.mark.usefixtures("two_at_once")
def test_results_come_in_order_from_other_processes() -> None:
    seen = dict[int, tuple[int, int]]()
    found = each(place_and_process, range(20), arrived=seen.__setitem__)
    assert [square for square, _ in found] == [item**2 for item in range(20)]
    assert [seen[place] for place in range(20)] == found
    others = {process for _, process in found} - {os.getpid()}
    assert len(others) in (1, 2), "workers take the points after the first; one may be quick enough for all"
    assert found[0][1] == os.getpid()


def test_what_is_called_meanwhile_is_called_once_beside_workers_and_may_fail(two_at_once: None) -> None:
    called = list[int]()

    def meanwhile() -> None:
        called.append(os.getpid())
        raise ImportError("no such room")

    found = each(place_and_process, range(20), meanwhile=meanwhile)
    assert [square for square, _ in found] == [item**2 for item in range(20)]
    assert called == [os.getpid()]


def test_nothing_is_called_meanwhile_without_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "1")
    called = list[int]()
    each(place_and_process, range(20), meanwhile=lambda: called.append(1))
    assert not called


def test_short_work_stays_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "8")
    assert {process for _, process in each(place_and_process, range(20))} == {os.getpid()}


def test_long_work_is_elsewhere_from_the_first_item_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    found = each(place_and_process, range(4), long=True)
    assert [square for square, _ in found] == [0, 1, 4, 9]
    assert os.getpid() not in {process for _, process in found}


@pytest.mark.usefixtures("two_at_once")
def test_an_error_comes_back_as_it_is() -> None:
    with pytest.raises(ModelError) as caught:
        each(refused, range(8))
    assert caught.value.path == "mesh_frequency"
    assert "too much" in str(caught.value)


@pytest.mark.usefixtures("two_at_once")
def test_an_exception_of_the_caller_ends_the_work() -> None:
    def enough(place: int, _: object) -> None:
        if place == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        each(place_and_process, range(50), arrived=enough)


@pytest.mark.usefixtures("two_at_once")
def test_a_worker_that_is_killed_is_replaced_by_this_process() -> None:
    seen: list[int] = []
    assert each(partial(killed, os.getpid()), range(6), arrived=lambda place, _: seen.append(place)) == list(range(6))
    assert sorted(seen) == list(range(6)), "every place once"


@pytest.mark.usefixtures("two_at_once")
def test_stability_has_the_bits_of_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    several = epicyclic.stability("ren2021", points=6)
    monkeypatch.setenv("EPICYCLIC_JOBS", "1")
    assert_same_bits(several, epicyclic.stability("ren2021", points=6))


@pytest.mark.usefixtures("two_at_once")
@pytest.mark.parametrize("name", ["ren2021", "encased-differential"])
def test_sweep_has_the_bits_of_one_process(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    several = epicyclic.sweep(name, points=24 if name == "ren2021" else 4)
    monkeypatch.setenv("EPICYCLIC_JOBS", "1")
    assert_same_bits(several, epicyclic.sweep(name, points=24 if name == "ren2021" else 4))


def assert_same_bits(one: object, other: object) -> None:
    from epicyclic.results.dataset import to_json

    assert to_json(one) == to_json(other)  # type: ignore[arg-type]


def stepped(own: int, how: str, count: int) -> Iterator[tuple[int, int]]:
    """Points of a run, and the process; the second run, where it is not this process, ends as told."""
    for step in range(count):
        if how == "killed" and step == 3 and os.getpid() != own:
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "refused" and step == 3 and count == 7:
            raise ModelError("too much", path="mesh_frequency", given=step, allowed="1")
        yield step, os.getpid()


@pytest.mark.usefixtures("two_at_once")
@pytest.mark.parametrize("how", ["whole", "killed"])
def test_runs_of_two_processes_come_whole_and_in_their_order(how: str) -> None:
    seen: dict[int, list[tuple[int, int]]] = {0: [], 1: [], 2: []}
    runs(partial(stepped, os.getpid(), how), (5, 7, 2), arrived=lambda place, result: seen[place].append(result))
    assert [[step for step, _ in points] for points in seen.values()] == [[*range(5)], [*range(7)], [*range(2)]]
    assert {process for _, process in seen[0] + seen[2]} == {os.getpid()}
    elsewhere = [process != os.getpid() for _, process in seen[1]]
    assert elsewhere == ([True] * 7 if how == "whole" else [True] * 3 + [False] * 4)


@pytest.mark.usefixtures("two_at_once")
def test_an_error_of_a_run_comes_back_as_it_is_and_nothing_is_left() -> None:
    others = set(multiprocessing.active_children())  # of other tests: a process of the page that waits
    with pytest.raises(ModelError, match="too much") as caught:
        runs(partial(stepped, os.getpid(), "refused"), (5, 7), arrived=lambda _, __: None)
    assert caught.value.path == "mesh_frequency"
    with pytest.raises(KeyboardInterrupt):
        runs(partial(stepped, os.getpid(), "whole"), (5, 10**9), arrived=interrupted)
    assert set(multiprocessing.active_children()) <= others


def interrupted(place: int, _: object) -> None:
    if place == 1:
        raise KeyboardInterrupt


def test_short_runs_stay_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "8")
    seen = set[int]()
    runs(partial(stepped, 0, "whole"), (3, 4), arrived=lambda _, result: seen.add(result[1]))
    assert seen == {os.getpid()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "start", "stop", "points"), [("xu2020", 859.4, 1006.6, 3), ("ren2021", 1080.0, 1170.0, 2)]
)
def test_contact_loss_has_the_bits_of_one_process(
    name: str, start: float, stop: float, points: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bands in which motions lose their symmetry, double their period or are integrated."""
    options: dict[str, Any] = {"start": start, "stop": stop, "points": points, "contact_loss": True}
    monkeypatch.setenv("EPICYCLIC_JOBS", "1")
    one = epicyclic.sweep(name, **options)
    assert (name == "xu2020") == ("symmetry broken" in one.motion.values)
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    monkeypatch.setattr(workers, "_WORTH", dict.fromkeys(METHODS, 0.0))
    steps = list[tuple[int, int]]()
    assert_same_bits(epicyclic.sweep(name, progress=lambda *step: steps.append(step), **options), one)
    assert steps == sorted(steps)
    assert steps[-1][0] == steps[-1][1]


@pytest.mark.parametrize("text", ["0", "-1", "many", "1.5"])
def test_a_wrong_number_of_processes_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", text)
    with pytest.raises(ModelError, match="EPICYCLIC_JOBS"):
        processes()


def test_cores_are_shared_with_the_threads_of_linear_algebra(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("EPICYCLIC_JOBS", *workers.BLAS_THREADS):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(workers, "_cores", lambda: 8)
    assert processes() == 1, "linear algebra takes all cores unless told"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    assert processes() == 8
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    assert processes() == 2


# A script as a user writes it, without `if __name__ == "__main__"`.  It prints when workers are at work.
SCRIPT = """
import sys, time
from epicyclic.engine import workers
workers._WORTH = {"fork": 0.0, "spawn": 0.0}
sys.platform = sys.argv[1]
print("started", flush=True)
found = workers.each(time.sleep, [float(text) for text in sys.argv[2:]], arrived=lambda i, _: print(i, flush=True))
print("done", len(found), flush=True)
"""


def started(tmp_path: Path, method: str, *seconds: float) -> subprocess.Popen[str]:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    return subprocess.Popen(
        [sys.executable, str(script), "linux" if method == "fork" else "darwin", *map(str, seconds)],
        env={**os.environ, "EPICYCLIC_JOBS": "2"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_script_without_a_guard_runs_once(method: str, tmp_path: Path) -> None:
    with started(tmp_path, method, 0.01, 0.02, 0.03, 0.02) as running:
        out, err = running.communicate(timeout=60)
    assert running.returncode == 0, err
    assert out.count("started") == 1
    assert out.endswith("done 4\n")


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("by", ["Ctrl-C", "SIGINT", "SIGTERM", "SIGKILL"])
def test_nothing_is_left_behind(by: str, method: str, tmp_path: Path) -> None:
    with started(tmp_path, method, 0.01, 0.01, 30.0, 30.0, 30.0) as running:
        assert running.stdout is not None
        wait_for(lambda: len(session(running.pid)) >= 3)
        if by == "Ctrl-C":  # to the whole group, as a terminal does
            os.killpg(running.pid, signal.SIGINT)
        else:
            running.send_signal(getattr(signal, by))
        running.wait(timeout=20)
        assert running.returncode != 0
        wait_for(lambda: not session(running.pid))
        errors = running.stderr.read() if running.stderr else ""
    if by in ("Ctrl-C", "SIGINT"):
        assert errors.count("Traceback") <= 1
        assert errors.rstrip().endswith("KeyboardInterrupt")


def session(leader: int) -> list[int]:
    """Processes of the session of a process that still run."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, of = entry.read_text().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(of) == leader and state != "Z":
            found.append(int(entry.parent.name))
    return found


def wait_for(condition: object, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end
        time.sleep(0.05)


def test_numbers_of_numpy_are_kept() -> None:
    found = each(np.sqrt, [np.float64(2.0)])
    assert found[0] == np.sqrt(2.0)


def test_long_runs_have_workers_from_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", "2")
    seen = set[int]()
    runs(partial(stepped, 0, "whole"), (3, 4), arrived=lambda _, result: seen.add(result[1]), long=True)
    assert len(seen) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="pages are asked of Linux")
def test_freed_memory_is_kept() -> None:
    """Eight arrays of a megabyte, time and again, ask for their pages once."""
    script = (
        "import resource, sys, numpy as np; from epicyclic.engine.workers import keep_freed_memory\n"
        "if sys.argv[1] == 'kept': keep_freed_memory()\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        "for _ in range(50): [np.ones(2**17) for _ in range(8)]\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)"
    )
    kept, anew = (
        int(subprocess.run([sys.executable, "-c", script, how], capture_output=True, check=True).stdout)
        for how in ("kept", "anew")
    )
    assert kept < 0.2 * anew
