"""Points in processes of their own: those that die, those that are interrupted, threads, groups."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest

from flatpunch.parallel import solve_points
from support import sample_points as functions
from support.platforms import SIGNALS

HERE = Path(__file__).parents[1]
_POINTS = 30
_KILL = getattr(signal, "SIGKILL", signal.SIGTERM)  # which Windows does not have

_SCRIPT = """
import sys
sys.path.insert(0, {here!r})
from support import sample_points as points_for_tests
from flatpunch.parallel import solve_points
solve_points(points_for_tests.slowly, [(0.1, {marks!r}, i) for i in range(30)], store={store!r}, workers=2)
"""


@pytest.mark.long
def test_one_thread_in_each_process(monkeypatch):
    """However many this process may use: BLAS, OpenMP, and what reads the environment (the transforms of `bem`)."""
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    found = solve_points(functions.threads, range(4), workers=2)
    assert [outcome.numbers["threads"] for outcome in found.values()] == [1] * 4
    assert all(outcome.numbers["pools"] >= 1 and outcome.numbers["omp"] == 1 for outcome in found.values())
    assert os.environ["OMP_NUM_THREADS"] == "4"


@pytest.mark.long
@SIGNALS
def test_a_process_that_dies_costs_no_other_point(tmp_path):
    marks = str(tmp_path)
    points = {x: (x, marks) for x in ("once", "always", *range(10))}
    found = solve_points(functions.deadly, points, workers=2, tries=2, store=tmp_path / "points")
    assert found.failed == {"always": "WorkerLost: its process ended with signal SIGKILL, 2 times in a row"}
    assert [found[x].numbers["x"] for x in ("once", *range(10))] == ["once", *range(10)]
    assert solve_points(functions.deadly, points, workers=2, store=tmp_path / "points").fresh == 0


def test_a_process_killed_before_its_first_point_costs_nothing():
    before, killed = set(_workers()), []

    def kill_first():
        _until(lambda: set(_workers()) - before)
        killed.append((set(_workers()) - before).pop())
        os.kill(killed[0], signal.SIGKILL)

    killer = threading.Thread(target=kill_first)
    killer.start()
    found = solve_points(functions.slowly_in_process, range(6), workers=2)
    killer.join()
    assert not found.failed
    assert killed[0] not in {int(outcome.numbers["pid"]) for outcome in found.values()}


def _workers():
    """Worker processes of this one."""
    found = []
    for child in psutil.Process().children():
        with contextlib.suppress(psutil.Error):
            if "popen_loky" in " ".join(child.cmdline()):
                found.append(child.pid)
    return found


def test_groups_share_a_process():
    points = [(group, 1, i) for i in range(4) for group in "ab"]
    found = solve_points(functions.which_process, points, workers=2, group=functions.group_of, cost=functions.cost_of)
    at = {group: {int(found[i].numbers["pid"]) for i, p in enumerate(points) if p[0] == group} for group in "ab"}
    assert os.getpid() not in at["a"] | at["b"]
    # a process that starts late finds its group taken over by the other one
    assert at["a"] == at["b"] or len(at["a"]) == 1 or len(at["b"]) == 1


@pytest.mark.long
@SIGNALS
@pytest.mark.parametrize("how", [signal.SIGINT, _KILL], ids=["interrupt", "kill"])
def test_after_an_interruption_the_rest_is_solved(how, tmp_path):
    marks, store = tmp_path / "marks", tmp_path / "points"
    marks.mkdir()
    # a script without `if __name__ == "__main__":`, which new processes must not run again
    script = tmp_path / "script.py"
    script.write_text(_SCRIPT.format(here=str(HERE), marks=str(marks), store=str(store)), encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, str(script)], stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as run:
        _until(lambda: store.exists() and len(_finished(store)) >= 4)
        if how is signal.SIGINT:
            os.killpg(run.pid, how)  # as a terminal does: to all processes at once
        else:
            run.kill()
        told = run.stderr.read()
    assert run.returncode == -how
    assert told.count("KeyboardInterrupt") == (1 if how is signal.SIGINT else 0), told  # nothing from the workers
    _until(lambda: not any(_alive(pid) for pid in _pids(marks)))  # which do not outlive their parent
    kept = {path: path.stat().st_mtime_ns for path in _finished(store)}
    assert 4 <= len(kept) < _POINTS
    points = [(0.1, str(marks), i) for i in range(_POINTS)]
    assert solve_points(functions.slowly, points, workers=1, store=store).fresh == _POINTS - len(kept)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept


@SIGNALS
@pytest.mark.parametrize("how", [signal.SIGTERM, _KILL], ids=["terminate", "kill"])
def test_workers_at_a_long_point_end_with_their_parent(how, tmp_path):
    marks, script = tmp_path / "marks", tmp_path / "script.py"
    marks.mkdir()
    text = _SCRIPT.format(here=str(HERE), marks=str(marks), store=str(tmp_path / "points")).replace("(0.1,", "(600,")
    script.write_text(text, encoding="utf-8")
    with subprocess.Popen([sys.executable, str(script)]) as run:
        _until(lambda: len(_pids(marks)) == 2)
        run.send_signal(how)
    _until(lambda: not any(_alive(pid) for pid in _pids(marks)))


_SLOW_TO_START = """
import pathlib, sys, time
if any("popen_loky" in part for part in sys.orig_argv):
    pathlib.Path({mark!r}).touch()
    time.sleep(1.0)
"""


@SIGNALS
def test_an_interruption_while_processes_start_is_heard_by_one(tmp_path):
    marks, mark = tmp_path / "marks", tmp_path / "starting"
    marks.mkdir()
    (tmp_path / "sitecustomize.py").write_text(_SLOW_TO_START.format(mark=str(mark)), encoding="utf-8")
    script = tmp_path / "script.py"
    script.write_text(
        _SCRIPT.format(here=str(HERE), marks=str(marks), store=str(tmp_path / "points")), encoding="utf-8"
    )
    with subprocess.Popen(
        [sys.executable, str(script)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
    ) as run:
        _until(mark.exists)
        time.sleep(0.1)
        os.killpg(run.pid, signal.SIGINT)
        told = run.stderr.read()
    assert run.returncode == -signal.SIGINT
    assert told.count("KeyboardInterrupt") == 1, told
    assert told.count("Traceback") == 1, told


@pytest.mark.long
def test_functions_of_an_unguarded_script_are_called_in_processes(tmp_path):
    """They go there by value, and the script is not run again."""
    script = tmp_path / "script.py"
    script.write_text(
        "import os\nfrom flatpunch.parallel import solve_points\n"
        "class Half:\n    of = 2\n"
        "def mine(x):\n    return {'x': x / Half.of, 'pid': os.getpid()}\n"
        "found = solve_points(mine, [1, 2, 3, 4], workers=2)\n"
        "assert not found.failed, found.failed\n"
        "assert os.getpid() not in {int(found[i].numbers['pid']) for i in range(4)}\n"
        "print([float(found[i].numbers['x']) for i in range(4)])\n",
        encoding="utf-8",
    )
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr
    assert (run.stdout, run.stderr) == ("[0.5, 1.0, 1.5, 2.0]\n", "")


def _until(true, seconds=40):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def _finished(store):
    """Points kept whole: a file that is being written begins with a dot."""
    return list(store.glob("[!.]*.npz"))


def _pids(marks):
    return {int(path.name.split("-")[2]) for path in marks.iterdir()}


def _alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    # a process that nobody has waited for is there by name only
    return "Z" not in Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] if Path("/proc").exists() else True
