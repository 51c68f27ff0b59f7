"""Worker processes of the page: each has loaded what it calls and does one job at a time; a job is stopped by ending its process.

The page stays usable while they calculate, and no calculation can take the page down with it. A job whose process is lost is
done by another one, once.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from flatpunch._support.paths import Plain
from flatpunch._support.threads import allowed_threads
from flatpunch.app.limits import LIMITS
from flatpunch.parallel.worker import PAUSE, Worker, how_it_ended, report

_JOBS = ("coating", "fit", "formulas")
"""Modules that workers load before their first job, besides `press`, which warms up the rest."""


@dataclass
class Job:
    """One calculation: what has become of it so far.

    Attributes
    ----------
    key : str
        Names it in requests; cannot be guessed.
    state : {"waiting", "running", "done", "failed", "stopped"}
    progress : (int, int) or None
        Steps done, steps in all.
    outcome : object
        What it returned, or the message of its error.
    """

    key: str
    call: tuple[str, tuple[object, ...]]
    long: bool
    state: str = "waiting"
    progress: tuple[int, int] | None = None
    outcome: Any = None
    lost: bool = False
    started: float = field(default_factory=time.monotonic)
    asked: float = field(default_factory=time.monotonic)
    ended: threading.Event = field(default_factory=threading.Event)
    stop: Callable[[], None] = lambda: None
    keep: Callable[[Plain], None] = lambda outcome: None

    def finish(self, state: str, outcome: Any = None) -> None:
        """Set the outcome, once."""
        if not self.ended.is_set():
            self.state, self.outcome = state, outcome
            if state == "done":
                self.keep(outcome)
            self.ended.set()

    @property
    def seconds(self) -> float:
        """Time since it was submitted [s]."""
        return time.monotonic() - self.started

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the end of the job; return whether it has ended."""
        limit = None if seconds is None else time.monotonic() + seconds
        while not self.ended.is_set():
            self.asked = time.monotonic()
            left = 1.0 if limit is None else min(1.0, limit - time.monotonic())
            if left <= 0:
                break
            self.ended.wait(left)
        return self.ended.is_set()


class Workers:
    """A few processes, each with a thread that waits for it, and the jobs that wait for them.

    Starting takes seconds: one process is always kept ready, and a job goes to the one that is ready first. By default there are
    two processes more than cores at most; one of them is left to short jobs.
    """

    def __init__(self, most: int | None = None) -> None:
        self.most = max(2, most or allowed_threads() + 2)
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._waiting: deque[Job] = deque()
        self._changed = threading.Condition(threading.RLock())
        self._processes = 0
        self._workers: set[Worker] = set()
        self._busy: dict[str, tuple[Job, Worker]] = {}
        self._closed = False

    def submit(
        self,
        function: str,
        *arguments: object,
        long: bool = False,
        keep: Callable[[Plain], None] = lambda outcome: None,
    ) -> Job:
        """Queue a call of "module:name" below `flatpunch.app.jobs`, with arguments that go through a pipe.

        One process is always left for calls that are not `long`, more than a second; `keep` gets the outcome before anybody
        hears of it.
        """
        job = Job(secrets.token_urlsafe(), (function, arguments), long, keep=keep)
        job.stop = lambda: self._stop(job)
        with self._changed:
            self._jobs[job.key] = job
            while len(self._jobs) > LIMITS.jobs:
                _, old = self._jobs.popitem(last=False)
                if not old.ended.is_set():
                    self._jobs[old.key] = old
                    break
            self._waiting.append(job)
            self._start()
            self._changed.notify_all()
        return job

    def find(self, key: str) -> Job | None:
        """Return the job of a key."""
        job = self._jobs.get(key)
        if job is not None:
            job.asked = time.monotonic()
        return job

    def close(self) -> None:
        """Stop all jobs and end all processes."""
        with self._changed:
            self._closed = True
            jobs = [*self._waiting, *(job for job, _ in self._busy.values())]
            self._waiting.clear()
            workers = list(self._workers)
            self._changed.notify_all()
        for job in jobs:
            job.finish("stopped")
        for worker in workers:
            worker.end()

    def _stop(self, job: Job) -> None:
        with self._changed:
            if job in self._waiting:
                self._waiting.remove(job)
            _, worker = self._busy.get(job.key, (job, None))
        job.finish("stopped")
        if worker is not None:
            worker.end()

    def _start(self) -> None:
        """Start as many processes as are missing: one for each job that waits, and one that is ready for the next."""
        ready = self._processes - len(self._busy)
        missing = min(max(len(self._waiting), 1) - ready, self.most - self._processes)
        for _ in range(0 if self._closed else missing):
            self._processes += 1
            threading.Thread(target=self._serve, daemon=True, name="flatpunch-worker").start()

    def _serve(self) -> None:
        """Start a process and do jobs in it, one after the other, until it is lost or ended."""
        worker, reason = None, ""
        try:
            worker = _worker()
            with self._changed:
                self._workers.add(worker)
            _prepare_in(worker)
        except Exception as error:  # of the system, of any kind: jobs that wait must hear of it
            reason = f"the calculation could not be started ({type(error).__name__}: {error})."
        while worker and not reason and (job := self._next(worker)) is not None:
            if not self._made(worker, job):
                break
        if worker is not None:
            worker.end()
        self._over(worker, reason)

    def _over(self, worker: Worker | None, reason: str) -> None:
        """A process is gone: start another, or end the jobs where none could be started."""
        lost: list[Job] = []
        with self._changed:
            self._processes -= 1
            if worker is not None:
                self._workers.discard(worker)
            if not reason:
                self._start()
            elif not self._processes:
                lost = list(self._waiting)
                self._waiting.clear()
        for job in lost:
            job.finish("failed", reason)

    def _made(self, worker: Worker, job: Job) -> bool:
        """Do a job; return whether its process can do another."""
        try:
            state, outcome = ("stopped", None) if job.ended.is_set() else _done(worker, job)
        except Exception as error:  # of the pipe, of any kind: no job may be left without an end
            state, outcome = "failed", f"the calculation could not be started ({type(error).__name__}: {error})."
        usable, again = state in ("done", "failed"), state == "lost" and not job.lost
        with self._changed:
            # before anybody hears of the end: the next job may follow at once
            del self._busy[job.key]
            if again:
                job.state, job.progress, job.lost = "waiting", None, True
                self._waiting.appendleft(job)
        if not again:
            job.finish("failed" if state == "lost" else state, outcome)
        return usable

    def _next(self, worker: Worker) -> Job | None:
        """Wait for a job; None when the page is closed."""
        with self._changed:
            while not self._closed:
                long = sum(job.long for job, _ in self._busy.values())
                for job in self._waiting:
                    if not (job.long and long >= self.most - 1):
                        self._waiting.remove(job)
                        self._busy[job.key] = job, worker
                        self._start()
                        return job
                self._changed.wait()
        return None


def _worker() -> Worker:
    return Worker()


def _prepare_in(worker: Worker) -> None:
    """Wait until a process has loaded what it calls."""
    worker.submit(_prepare).result()


def _done(worker: Worker, job: Job) -> tuple[str, object]:
    """Do a job; return its last state and outcome: "lost" where its process was, and "stopped" where that is to end."""
    job.state = "running"
    try:
        future = worker.submit(_call, *job.call)
        while not job.ended.is_set():
            if wait_for([future], PAUSE).done:
                state, outcome = future.result()
                return state, outcome
            job.progress = worker.progress() or job.progress
            if time.monotonic() - job.asked > LIMITS.silent or (not job.long and job.seconds > LIMITS.longest):
                break
    except BrokenExecutor as error:
        lost = f"the process that calculated was lost twice ({how_it_ended(error)}); there may not be enough memory."
        return ("stopped", None) if job.ended.is_set() else ("lost", lost)
    except RuntimeError:
        if not job.ended.is_set():  # otherwise it was ended together with its process
            raise
    return "stopped", None


def _prepare() -> None:
    """Load what jobs call, in the process."""
    import_module("flatpunch.app.jobs.press").warm_up()
    for name in _JOBS:
        import_module(f"flatpunch.app.jobs.{name}")


def _call(function: str, arguments: tuple[object, ...]) -> tuple[str, object]:
    """Call a function of `flatpunch.app.jobs`, in the process; return the state and outcome of the job."""
    from flatpunch._support.messages import message
    from flatpunch._support.progress import listening

    try:
        module, name = function.split(":")
        with listening(report):
            return "done", getattr(import_module(f"flatpunch.app.jobs.{module}"), name)(*arguments)
    except Exception as error:
        return "failed", message(error)
