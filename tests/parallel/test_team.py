"""A handful of calls shared with processes that stay: everything is done once, in order, whatever becomes of them."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance
from flatpunch.contact.refined.solutions import correction
from flatpunch.parallel import team
from flatpunch.parallel.team import call_helpers, shared_out
from support import team_calls as calls

HERE = os.getpid()


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    """Helpers as on a machine of two cores, however many there are, and none left behind."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setattr("flatpunch._support.threads.cores", lambda: 2)
    team._team.dismiss()
    yield
    team._team.dismiss()


@pytest.fixture
def helper():
    """One helper that is ready."""
    call_helpers(calls.__name__, HERE, 8)
    (found,) = team._team._helpers
    assert found.pipe.poll(60)
    return found


def test_each_call_once_in_order_and_shared(helper):
    found = shared_out(calls.worker, HERE, [0.05] * 8)
    assert [item for _, item in found] == [0.05] * 8
    assert {pid for pid, _ in found} == {HERE, helper._process.pid}


def test_work_begins_before_helpers_are_ready():
    """One call is made here at once: the last, as long ones stand at the end."""
    found = shared_out(calls.worker, HERE, [0.0] * 8)
    assert found[-1][0] == HERE
    assert len(team._team._helpers) == 1


def test_helpers_stay_for_the_next_round(helper):
    for _ in range(3):
        assert helper._process.pid in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}


def test_what_is_needed_later_is_loaded_here_while_they_work():
    later = "zipapp"
    assert later not in sys.modules
    call_helpers(calls.__name__, HERE, 8, meanwhile=[later])
    assert later not in sys.modules
    assert [item for _, item in shared_out(calls.worker, HERE, [0.0] * 8)] == [0.0] * 8
    assert later in sys.modules
    assert team._team.meanwhile == []


def test_they_take_up_another_function(helper):
    shared_out(calls.worker, HERE, [0.05] * 6)
    found = shared_out(calls.threads, HERE, [0] * 6)
    assert {threads for pid, threads in found if pid == helper._process.pid} == {"1"}


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_none_are_started_for_a_few_calls(count):
    assert [item for _, item in shared_out(calls.worker, HERE, [0.0] * count)] == [0.0] * count
    assert team._team._helpers == []


def test_none_where_they_would_take_too_much_memory():
    assert {pid for pid, _ in shared_out(calls.worker, HERE, [0.0] * 8, helped=False)} == {HERE}
    assert team._team._helpers == []


def test_none_on_one_core(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    call_helpers(calls.__name__, HERE, 8)
    assert {pid for pid, _ in shared_out(calls.worker, HERE, [0.0] * 8)} == {HERE}
    assert team._team._helpers == []


def test_no_more_than_their_number_however_many_cores(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "64")
    monkeypatch.setattr("flatpunch._support.threads.cores", lambda: 64)
    call_helpers(calls.__name__, HERE, 40)
    assert len(team._team._helpers) == team._MOST


def test_a_helper_that_dies_leaves_its_calls_to_others(helper):
    found = shared_out(calls.deadly_elsewhere, HERE, range(8))
    assert found == [(HERE, item) for item in range(8)]
    assert not helper.alive
    # the next round has a new one
    call_helpers(calls.__name__, HERE, 8)
    assert team._team._helpers[0] is not helper


def test_an_error_is_raised_here(helper):
    with pytest.raises(ValueError, match="5 is refused"):
        shared_out(calls.refused, HERE, range(8))


def test_a_warning_is_heard_here(helper):
    with pytest.warns(UserWarning, match="is odd") as heard:
        found = shared_out(calls.warned, HERE, range(8))
    assert sorted(str(warning.message) for warning in heard) == [f"{i} is odd" for i in (1, 3, 5, 7)]
    assert [item for _, item in found] == list(range(8))


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_what_libraries_say_to_their_developers_is_no_warning(helper):
    assert helper._process.pid in {pid for pid, _ in shared_out(calls.deprecated, HERE, range(8))}


def test_an_interruption_lets_them_go(helper):
    with pytest.raises(KeyboardInterrupt):
        shared_out(calls.interrupted_here, HERE, range(8))
    assert team._team._helpers == []
    assert len(shared_out(calls.worker, HERE, [0.0] * 8)) == 8


def test_what_cannot_be_handed_over_is_done_here():
    """Closures, for example an indenter with an outline that a script defines."""
    found = shared_out(lambda here, item: (os.getpid(), item), HERE, range(8))
    assert found == [(HERE, item) for item in range(8)]
    assert team._team._helpers == []


def test_large_calls_and_large_answers_pass_each_other(helper):
    """A helper with a large answer to give cannot read a large call at the same time."""
    items = [bytes(5_000_000)] * 8
    found = shared_out(calls.echo, HERE, items)
    assert [answer for _, answer in found] == items
    assert helper._process.pid in {pid for pid, _ in found}


def test_what_another_process_cannot_unpack_is_done_here(helper):
    """And not with what it had unpacked before."""
    assert helper._process.pid in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}
    assert {pid for pid, _ in shared_out(calls.worker, calls.Homesick(), [0.05] * 6)} == {HERE}
    assert helper._process.pid in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}


def test_one_round_at_a_time(helper):
    """A second thread of the program does its calls itself, rather than wait."""
    other = []

    team._team.lock.acquire()
    try:
        worker = threading.Thread(target=lambda: other.extend(shared_out(calls.worker, HERE, [0.0] * 8)))
        worker.start()
        worker.join(20)
    finally:
        team._team.lock.release()
    assert {pid for pid, _ in other} == {HERE}


def test_a_fork_leaves_the_helpers_of_its_parent_alone(helper):
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        mine = team._team.called(2, "")
        os.write(writing, b"none" if not mine else b"some")
        os._exit(0)
    os.waitpid(child, 0)
    assert os.read(reading, 4) == b"none"
    assert helper._process.pid in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 8)}


def test_an_idle_helper_goes(monkeypatch):
    """Told in the new process by its module, so asked of the function itself."""
    monkeypatch.setattr(team, "_IDLE", 0.1)
    here, there = team.fresh.Pipe()

    before = signal.getsignal(signal.SIGINT)
    try:
        here.send(calls.__name__)
        start = time.perf_counter()
        team._help(there, team._Turns())
    finally:
        signal.signal(signal.SIGINT, before)
    assert here.recv() == (0, None, None)
    assert time.perf_counter() - start >= 0.1


_SCRIPT = """
import sys, os, warnings
import numpy as np
import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance
from flatpunch.parallel import team
import flatpunch._support.threads
flatpunch._support.threads.cores = lambda: 2
film = fp.Medium([fp.Layer(4.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
result = fp.indent(film, fp.Pyramid(4, 0.35), depth=np.geomspace(0.05, 2.0, 50), method="refined", cells=64)
print(len(team._team._helpers), repr(float(result.force[-1])))
"""


def test_an_unguarded_script_is_not_run_again(tmp_path):
    """Its output comes once, and no helper outlives it."""
    script = tmp_path / "script.py"
    script.write_text(_SCRIPT, encoding="utf-8")
    run = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "OMP_NUM_THREADS": "2"},
    )
    assert run.returncode == 0, run.stderr
    assert len(run.stdout.splitlines()) == 1
    assert run.stdout.startswith("1 ")
    assert run.stderr == ""


def test_solutions_do_not_depend_on_who_makes_them(monkeypatch):
    film = fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    tip, depth = fp.Pyramid(3, 0.35), np.geomspace(0.05, 3.0, 60)
    results = []
    for threads in ("1", "2"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        correction.cache_clear()
        results.append(fp.indent(film, tip, depth=depth, method="refined", cells=64))
    alone, shared = results
    assert len(team._team._helpers) == 1
    for name in ("force", "stiffness", "area", "contour"):
        assert np.array_equal(alone[name], shared[name], equal_nan=True), name


def test_long_rows_of_close_steps_are_shared_and_told_of():
    kernel, told = compliance(fp.HalfSpace(1.0, 0.3)), []
    depths = np.linspace(1.0, 1.1, 60)
    found = bem.solve(kernel, fp.Pyramid(4, 0.35), depths=depths, grid=48, progress=lambda *done: told.append(done[0]))
    assert sorted(np.diff([0, *told])) == [12, 16, 16, 16]
    assert len(team._team._helpers) == 1
    # force grows like the square of the depth, whoever began where
    np.testing.assert_allclose([s.force / s.depth**2 for s in found], found[0].force / depths[0] ** 2, rtol=3e-3)


def test_boundary_elements_do_not_depend_on_who_solves_them(monkeypatch):
    """Nor on what else is asked for, but for steps so close that they start from the one before."""
    kernel, tip = compliance(fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))), fp.Pyramid(4, 0.35)
    depths = [*np.linspace(0.2, 2.0, 9), 2.001, 2.002]
    results, told = [], []
    for threads in ("1", "2"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        told.clear()
        results.append(bem.solve(kernel, tip, depths=depths, grid=64, progress=lambda *done: told.append(done)))
        assert [steps for _, steps in told] == [11] * len(told)
        assert [done for done, _ in told] == sorted({done for done, _ in told})
        assert told[-1] == (11, 11)
    assert len(team._team._helpers) == 1
    for alone, shared in zip(*results, strict=True):
        assert alone.force == shared.force
        assert np.array_equal(alone.pressure, shared.pressure)
    (single,) = bem.solve(kernel, tip, depths=depths[4], grid=64)
    assert np.array_equal(single.pressure, results[0][4].pressure)
