"""Processes of the page and the jobs that wait for them."""

import dataclasses
from concurrent.futures import Future

import pytest

from flatpunch.app import workers
from flatpunch.app.limits import LIMITS
from support import sample_points as functions


@pytest.fixture
def pool():
    found = workers.Workers(2)
    yield found
    found.close()


@pytest.mark.parametrize("how", ["start", "load"])
def test_jobs_end_where_no_process_can_be_had(pool, monkeypatch, how):
    """Too many processes, or a library that cannot be loaded: a message, and no job that waits for ever."""
    if how == "start":

        def refused():
            raise OSError(11, "Resource temporarily unavailable")

        monkeypatch.setattr(workers, "_worker", refused)
    else:

        def unloadable(worker):
            raise ImportError("no library")

        monkeypatch.setattr(workers, "_prepare_in", unloadable)
    jobs = [pool.submit("press:warm_up") for _ in range(3)]
    for job in jobs:
        assert job.wait(LIMITS.silent)
        assert job.state == "failed"
        assert "could not be started" in job.outcome


@pytest.mark.long
def test_more_jobs_than_processes_are_all_done(pool):
    jobs = [pool.submit("press:warm_up", long=i % 2 == 0) for i in range(6)]
    for job in jobs:
        assert job.wait(60)
        assert job.state == "done", job.outcome


@pytest.mark.long
def test_the_next_job_after_one_that_was_stopped_is_done(pool):
    first = pool.submit("press:warm_up")
    assert first.wait(60)
    for _ in range(3):
        stopped = pool.submit("press:warm_up")
        stopped.stop()
        assert stopped.state in ("stopped", "done")
    last = pool.submit("press:warm_up")
    assert last.wait(60)
    assert last.state == "done", last.outcome


def test_closing_ends_jobs_that_wait(pool):
    jobs = [pool.submit("press:warm_up") for _ in range(3)]
    pool.close()
    for job in jobs:
        assert job.wait(10)
        assert job.state in ("stopped", "failed", "done")


def test_short_jobs_and_waits_have_a_longest_time(monkeypatch):
    """A job that is not polled as a result, and a request that waits for a file."""
    from flatpunch.app import page

    limits = dataclasses.replace(LIMITS, longest=0.05)
    monkeypatch.setattr(workers, "LIMITS", limits)
    monkeypatch.setattr(page, "LIMITS", limits)

    class Endless:
        @staticmethod
        def submit(*call):
            return Future()

        @staticmethod
        def progress():
            return None

    assert workers._done(Endless, workers.Job("short", ("press:warm_up", ()), long=False)) == ("stopped", None)
    stopped = []
    job = workers.Job("long", ("press:warm_up", ()), long=True, stop=lambda: stopped.append(True))
    page._wait(job)
    assert (job.state, stopped) == ("failed", [True])
    assert "was stopped. Solve it on the page first." in job.outcome


@pytest.mark.long
def test_a_job_whose_process_is_killed_is_done_by_another(pool, monkeypatch, tmp_path):
    """Once: what costs two processes fails, with a sentence, and the next job is done."""
    monkeypatch.setattr(workers, "_call", functions.deadly_job)
    monkeypatch.setattr(workers, "_prepare", list)
    for deaths, state in ((1, "done"), (2, "failed"), (0, "done")):
        marks = tmp_path / str(deaths)
        marks.mkdir()
        job = pool.submit("any:job", str(marks), deaths)
        assert job.wait(60)
        assert job.state == state, job.outcome
        assert len(list(marks.iterdir())) == deaths
        if state == "failed":
            assert "lost twice (its process ended with signal SIGKILL); there may not be enough memory" in job.outcome
