"""Worker processes of the page: each has loaded what it calls and does one job at a time; a job is stopped by ending its process.

The page stays usable while they calculate, and no calculation can take the page down with it.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from flatpunch._support.paths import Plain
from flatpunch._support.threads import allowed_threads
from flatpunch.app.limits import LIMITS
from flatpunch.parallel.worker import Report, Worker

_JOBS = ("compare", "coating", "correct", "fit")
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
    """A few processes, started when they are needed, and the jobs that wait for them.

    Starting takes seconds: one process is always kept ready, and a job goes to the one that is ready first. By default there are
    two processes more than cores at most; one of them is left to short jobs.
    """

    def __init__(self, most: int | None = None) -> None:
        self.most = max(2, most or allowed_threads() + 2)
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._waiting: list[Job] = []
        self._starting: list[Worker] = []
        self._idle: list[Worker] = []
        self._busy: dict[str, Worker] = {}
        self._lock = threading.Lock()
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
        job = Job(secrets.token_urlsafe(16), (function, arguments), long, keep=keep)
        job.stop = lambda: self._stop(job)
        with self._lock:
            self._jobs[job.key] = job
            while len(self._jobs) > LIMITS.jobs:
                _, old = self._jobs.popitem(last=False)
                if not old.ended.is_set():
                    self._jobs[old.key] = old
                    break
            self._waiting.append(job)
        self._next()
        return job

    def find(self, key: str) -> Job | None:
        """Return the job of a key."""
        job = self._jobs.get(key)
        if job is not None:
            job.asked = time.monotonic()
        return job

    def close(self) -> None:
        """Stop all jobs and end all processes."""
        with self._lock:
            self._closed = True
            waiting, self._waiting = self._waiting, []
            workers = [*self._starting, *self._idle, *self._busy.values()]
            self._idle = []
        for job in waiting:
            job.finish("stopped")
        for worker in workers:
            worker.end()

    def _stop(self, job: Job) -> None:
        with self._lock:
            if job in self._waiting:
                self._waiting.remove(job)
            worker = self._busy.get(job.key)
        job.finish("stopped")
        if worker is not None:
            worker.end()

    def _next(self) -> None:
        """Give waiting jobs to processes that are ready, and start as many as are missing."""
        with self._lock:
            if self._closed:
                return
            for job in list(self._waiting):
                long = sum(self._jobs[key].long for key in self._busy if key in self._jobs)
                if self._idle and not (job.long and long >= self.most - 1):
                    self._waiting.remove(job)
                    worker = self._busy[job.key] = self._idle.pop()
                    threading.Thread(
                        target=self._run, args=(job, worker), daemon=True, name=f"job-{job.key[:4]}"
                    ).start()
            ready = len(self._idle) + len(self._starting)
            missing = min(max(len(self._waiting), 1) - ready, self.most - len(self._busy) - ready)
        for _ in range(missing):
            threading.Thread(target=self._start, daemon=True).start()

    def _start(self) -> None:
        """Start a process and wait until it is ready."""
        worker, reason = None, "it ended while it was started"
        with self._lock:
            if self._closed or len(self._starting) + len(self._idle) + len(self._busy) >= self.most:
                return
            try:
                worker = _worker()
                self._starting.append(worker)
            except Exception as error:  # of the system, of any kind: jobs that wait must hear of it
                reason = f"{type(error).__name__}: {error}"
        ready = worker is not None and _is_ready(worker)
        with self._lock:
            if worker is not None:
                self._starting.remove(worker)
            if ready and worker is not None and not self._closed:
                self._idle.append(worker)
                worker = None
            lost = [] if ready or self._idle or self._starting or self._busy else self._waiting
            if lost:
                self._waiting = []
        if worker is not None:
            worker.end()
        for job in lost:
            job.finish("failed", f"the calculation could not be started ({reason}).")
        if ready:
            self._next()

    def _run(self, job: Job, worker: Worker) -> None:
        try:
            state, outcome, usable = ("stopped", None, True) if job.ended.is_set() else _done(worker, job)
        except Exception as error:  # of the pipe, of any kind: no job may be left without an end
            state, usable = "failed", False
            outcome = f"the calculation could not be started ({type(error).__name__}: {error})."
        with self._lock:
            # before anybody hears of the end: the next job may follow at once
            del self._busy[job.key]
            kept = usable and not self._closed
            if kept:
                self._idle.append(worker)
        job.finish(state, outcome)
        if not kept:
            worker.end()
        self._next()


def _worker() -> Worker:
    """Start a process of the page; boundary elements may share their work out to processes of their own."""
    return Worker(_prepared, "flatpunch-app", shares=True)


def _is_ready(worker: Worker) -> bool:
    """Wait until a process has loaded what it calls; return whether it has."""
    try:
        return worker.problem() is None
    except (EOFError, OSError):
        return False


def _done(worker: Worker, job: Job) -> tuple[str, object, bool]:
    """Do a job; return its last state and outcome, and whether the worker can be used again."""
    job.state = "running"
    try:
        worker.give(*job.call)
        while not job.ended.is_set():
            if not worker.pipe.poll(1.0):
                if time.monotonic() - job.asked > LIMITS.forgotten or (not job.long and job.seconds > LIMITS.longest):
                    break
                continue
            final, what = worker.answer()
            if final:
                return *what, True
            job.progress = what
    except (EOFError, OSError):
        return (
            "failed",
            "the process that calculated ended unexpectedly; there may not have been enough memory.",
            False,
        )
    return "stopped", None, False


def _prepared() -> Callable[..., tuple[str, object]]:
    """Load what jobs call, in the process."""
    import_module("flatpunch.app.jobs.press").warm_up()
    for name in _JOBS:
        import_module(f"flatpunch.app.jobs.{name}")
    return _call


def _call(report: Report, function: str, arguments: tuple[object, ...]) -> tuple[str, object]:
    """Call a function of `flatpunch.app.jobs`, in the process; return the state and outcome of the job."""
    from flatpunch._support.messages import message
    from flatpunch._support.progress import listening

    try:
        module, name = function.split(":")
        with listening(report):
            return "done", getattr(import_module(f"flatpunch.app.jobs.{module}"), name)(*arguments)
    except Exception as error:
        return "failed", message(error)
