"""A handful of calls shared with processes that stay: everything is done once, in order, whatever becomes of them."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.refined.refinement import refinement
from flatpunch.parallel.engine import MOST, shared_out
from flatpunch.parallel.worker import _kept
from support import pool_calls as calls
from support.platforms import FORK, SIGNALS

HERE = os.getpid()


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    """One worker, as on a machine of two cores, however many there are."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setattr("flatpunch._support.threads.cores", lambda: 2)


OTHERS = set()
"""Worker processes that earlier tests have left: those of a page stay until this process ends."""


def dismiss():
    """End the workers that are kept for the next round."""
    while _kept:
        _kept.pop().end()


@pytest.fixture(scope="module", autouse=True)
def none_left():
    dismiss()
    OTHERS.update(living())
    yield
    dismiss()


@pytest.fixture
def no_worker():
    dismiss()


def living():
    """Worker processes of this one, but for those of earlier tests."""
    children = psutil.Process().children()
    return [c.pid for c in children if c.pid not in OTHERS and any("popen_loky" in word for word in c.cmdline())]


@pytest.fixture
def worker():
    """Process id of the worker, when it is ready."""
    while True:
        found = {pid for pid, _ in shared_out(calls.worker, HERE, [0.1] * 4)} - {HERE}
        if found:
            return found.pop()


def test_each_call_once_in_order_and_shared(worker):
    found = shared_out(calls.worker, HERE, [0.05] * 8)
    assert [item for _, item in found] == [0.05] * 8
    assert {pid for pid, _ in found} == {HERE, worker}


def test_work_begins_before_workers_are_ready(no_worker):
    """One call is made here at once: the first, as workers begin with the last."""
    found = shared_out(calls.worker, HERE, [0.0] * 8)
    assert [item for _, item in found] == [0.0] * 8
    assert found[0][0] == HERE


def test_workers_are_kept_for_the_next_round(worker):
    for _ in range(3):
        assert worker in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}


def test_they_take_another_function_and_one_thread_of_linear_algebra(worker):
    found = shared_out(calls.threads, HERE, [0] * 6)
    assert {threads for pid, threads in found if pid == worker} == {"1"}


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_none_are_started_for_a_few_calls(no_worker, count):
    assert shared_out(calls.worker, HERE, [0.01] * count) == [(HERE, 0.01)] * count
    assert not living()


def test_none_where_they_would_take_too_much_memory(no_worker):
    assert {pid for pid, _ in shared_out(calls.worker, HERE, [0.01] * 8, helped=False)} == {HERE}
    assert not living()


def test_none_on_one_core(no_worker, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert {pid for pid, _ in shared_out(calls.worker, HERE, [0.01] * 8)} == {HERE}
    assert not living()


def test_no_more_than_their_number_however_many_cores(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "64")
    monkeypatch.setattr("flatpunch._support.threads.cores", lambda: 64)
    assert len({pid for pid, _ in shared_out(calls.worker, HERE, [0.1] * 40)} - {HERE}) <= MOST


def test_outcomes_are_reported_as_they_come(worker):
    seen = []
    shared_out(calls.worker, HERE, [0.05] * 8, done=lambda outcome: seen.append((time.monotonic(), outcome)))
    assert sorted({pid for _, (pid, _) in seen}) == sorted({HERE, worker})
    assert len(seen) == 8
    # those of the worker are not kept back until all are made
    assert next(i for i, (_, (pid, _)) in enumerate(seen) if pid == worker) < 4


@SIGNALS
def test_a_worker_that_dies_leaves_its_calls_to_this_process(worker):
    found = shared_out(calls.deadly_elsewhere, HERE, range(8))
    assert found == [(HERE, item) for item in range(8)]
    assert worker not in living()
    # the next round has a new one
    shared_out(calls.worker, HERE, [0.05] * 4)
    assert living()


def test_an_error_is_raised_here(worker):
    with pytest.raises(ValueError, match="5 is refused"):
        shared_out(calls.refused, HERE, range(8))


def test_a_warning_is_heard_here(worker):
    with pytest.warns(UserWarning, match="is odd") as heard:
        found = shared_out(calls.warned, HERE, range(8))
    assert sorted(str(warning.message) for warning in heard) == [f"{i} is odd" for i in (1, 3, 5, 7)]
    assert [item for _, item in found] == list(range(8))


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_deprecation_in_a_library_is_no_reason_to_call_again(worker):
    assert worker in {pid for pid, _ in shared_out(calls.deprecated, HERE, range(8))}


def test_an_interruption_ends_the_workers(worker):
    with pytest.raises(KeyboardInterrupt):
        shared_out(calls.interrupted_here, HERE, range(8))
    assert not psutil.pid_exists(worker)
    assert len(shared_out(calls.worker, HERE, [0.0] * 8)) == 8


def test_closures_are_shared_too(worker):
    """For example an indenter with an outline that a script defines."""
    found = shared_out(lambda here, item: (time.sleep(item), os.getpid()), HERE, [0.05] * 8)
    assert {pid for _, pid in found} == {HERE, worker}


def test_what_cannot_be_handed_over_is_done_here(worker):
    lock = threading.Lock()
    found = shared_out(lambda here, item: (lock.locked(), os.getpid()), HERE, range(8))
    assert found == [(False, HERE)] * 8


def test_large_calls_and_large_outcomes_pass_each_other(worker):
    items = [bytes(5_000_000)] * 8
    found = shared_out(calls.echo, HERE, items)
    assert [outcome for _, outcome in found] == items
    assert worker in {pid for pid, _ in found}


def test_what_another_process_cannot_unpack_is_done_here(worker):
    """And not with what it had unpacked before."""
    assert worker in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}
    assert {pid for pid, _ in shared_out(calls.worker, calls.Homesick(), [0.05] * 6)} == {HERE}
    assert worker in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 6)}


def test_threads_of_a_program_have_workers_of_their_own(worker):
    other = []
    thread = threading.Thread(target=lambda: other.extend(shared_out(calls.worker, HERE, [0.05] * 8)))
    thread.start()
    mine = shared_out(calls.worker, HERE, [0.05] * 8)
    thread.join(30)
    assert [item for _, item in other] == [item for _, item in mine] == [0.05] * 8
    # each of them may have had the one that was ready
    assert not {pid for pid, _ in other} & {pid for pid, _ in mine} - {HERE}


@FORK
def test_a_fork_leaves_the_workers_of_its_parent_alone(worker):
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        alone = {pid for pid, _ in shared_out(calls.worker, HERE, [0.01] * 8)} == {os.getpid()}
        os.write(writing, b"none" if alone else b"some")
        os._exit(0)
    os.waitpid(child, 0)
    assert os.read(reading, 4) == b"none"
    assert worker in {pid for pid, _ in shared_out(calls.worker, HERE, [0.05] * 8)}


_SCRIPT = """
import numpy as np
import flatpunch as fp
import flatpunch._support.threads
flatpunch._support.threads.cores = lambda: 2
film = fp.Medium([fp.Layer(4.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
result = fp.indent(film, fp.Pyramid(4, 0.35), depth=np.geomspace(0.05, 2.0, 50), method=fp.Refined(cells=64))
print(repr(float(result.force[-1])))
"""


@pytest.mark.long
def test_an_unguarded_script_is_not_run_again(tmp_path):
    """Its output comes once, and nothing is left on its error stream."""
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
    assert run.stderr == ""


@pytest.mark.long
def test_solutions_do_not_depend_on_who_makes_them(monkeypatch):
    film = fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    tip, depth = fp.Pyramid(3, 0.35), np.geomspace(0.05, 3.0, 60)
    results = []
    for threads in ("1", "2"):
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        refinement.cache_clear()
        results.append(fp.indent(film, tip, depth=depth, method=fp.Refined(cells=64)))
    alone, shared = results
    assert living()
    for name in ("force", "stiffness", "area", "contour"):
        assert np.array_equal(alone[name], shared[name], equal_nan=True), name


@pytest.mark.long
def test_long_rows_of_close_steps_are_shared_and_reported():
    kernel, told = compliance(fp.HalfSpace(1.0, 0.3)), []
    depths = np.linspace(1.0, 1.1, 60)
    found = bem.solve(kernel, fp.Pyramid(4, 0.35), depths=depths, grid=48, progress=lambda *done: told.append(done[0]))
    assert sorted(np.diff([0, *told])) == [12, 16, 16, 16]
    assert living()
    # force grows like the square of the depth, whoever began where
    np.testing.assert_allclose([s.force / s.depth**2 for s in found], found[0].force / depths[0] ** 2, rtol=3e-3)


@pytest.mark.long
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
    assert living()
    for alone, shared in zip(*results, strict=True):
        assert alone.force == shared.force
        assert np.array_equal(alone.pressure, shared.pressure)
    (single,) = bem.solve(kernel, tip, depths=depths[4], grid=64)
    assert np.array_equal(single.pressure, results[0][4].pressure)
