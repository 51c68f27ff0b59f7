"""Worker processes of the page: each has loaded what it calls and does one job at a time; a job is stopped by ending its process.

The page stays usable while they calculate, and no calculation can take the page down with it. Workers end by themselves when this
process is gone: their pipe is closed then.
"""

from __future__ import annotations

import contextlib
import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from flatpunch._support.threads import allowed_threads
from flatpunch.app.limits import LIMITS
from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.processes import fresh, no_main
from flatpunch.parallel.threads import one_thread

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
    call: tuple[str, tuple[Any, ...]]
    long: bool
    state: str = "waiting"
    progress: tuple[int, int] | None = None
    outcome: Any = None
    started: float = field(default_factory=time.monotonic)
    asked: float = field(default_factory=time.monotonic)
    ended: threading.Event = field(default_factory=threading.Event)
    stop: Callable[[], None] = lambda: None
    keep: Callable[[Any], None] = lambda outcome: None

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

    Starting takes seconds: one process is always kept ready, and a job goes to the one that is ready first.

    Parameters
    ----------
    most : int, optional
        Processes at most; two more than there are cores if left out. One of them is left to short jobs.
    """

    def __init__(self, most: int | None = None) -> None:
        self.most = max(2, most or allowed_threads() + 2)
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._waiting: list[Job] = []
        self._starting: list[_Worker] = []
        self._idle: list[_Worker] = []
        self._busy: dict[str, _Worker] = {}
        self._lock = threading.Lock()
        self._closed = False

    def submit(
        self, function: str, *arguments: Any, long: bool = False, keep: Callable[[Any], None] = lambda outcome: None
    ) -> Job:
        """Queue a call.

        Parameters
        ----------
        function : str
            "module:name" of a function below `flatpunch.app.jobs`.
        *arguments
            What it is called with; goes through a pipe.
        long : bool
            Whether it may take longer than a second; one process is always left for those that do not.
        keep : callable, optional
            Called with the outcome before anybody hears of it.
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
                worker = _Worker()
                self._starting.append(worker)
            except Exception as error:  # of the system, of any kind: jobs that wait must hear of it
                reason = f"{type(error).__name__}: {error}"
        ready = worker is not None and worker.is_ready()
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

    def _run(self, job: Job, worker: _Worker) -> None:
        try:
            end = ("stopped", None) if job.ended.is_set() else worker.run(job)
        except Exception as error:  # of the pipe, of any kind: no job may be left without an end
            worker.usable = False
            end = ("failed", f"the calculation could not be started ({type(error).__name__}: {error}).")
        with self._lock:
            # before anybody hears of the end: the next job may follow at once
            del self._busy[job.key]
            kept = worker.usable and not self._closed
            if kept:
                self._idle.append(worker)
        job.finish(*end)
        if not kept:
            worker.end()
        self._next()


class _Worker:
    """A process and the pipe to it."""

    def __init__(self) -> None:
        self._pipe, end = fresh.Pipe()
        # not a daemon: boundary elements may share their work out to processes of their own
        self._process = fresh.Process(target=_work, args=(end,), name="flatpunch-app", daemon=False)
        with one_thread(), unheard_by_children(), no_main():
            self._process.start()
        end.close()
        self.usable = True

    def is_ready(self) -> bool:
        """Wait until it has loaded what it calls; return whether it has."""
        try:
            self._pipe.recv()
        except (EOFError, OSError):
            self.usable = False
        return self.usable

    def run(self, job: Job) -> tuple[str, Any]:
        """Do a job; return its last state and outcome."""
        job.state = "running"
        try:
            self._pipe.send(job.call)
            while not job.ended.is_set():
                if not self._pipe.poll(1.0):
                    if time.monotonic() - job.asked > LIMITS.forgotten:
                        break
                    continue
                kind, what = self._pipe.recv()
                if kind != "progress":
                    return kind, what
                job.progress = what
        except (EOFError, OSError):
            self.usable = False
            return "failed", "the process that calculated ended unexpectedly; there may not have been enough memory."
        self.usable = False
        return "stopped", None

    def end(self) -> None:
        """End the process, whatever it does."""
        self.usable = False
        self._process.kill()
        with contextlib.suppress(OSError):
            self._pipe.close()
        self._process.join(5)


def _work(pipe: Connection) -> None:
    """Main function of the process."""
    left_to_parent()
    from flatpunch._support.messages import message
    from flatpunch._support.progress import listening

    import_module("flatpunch.app.jobs.press").warm_up()
    for name in _JOBS:
        import_module(f"flatpunch.app.jobs.{name}")
    pipe.send("ready")
    last = [0.0]

    def report(done: int, total: int) -> None:
        # a pipe that nobody reads as fast as this writes would hold the calculation up
        if time.monotonic() - last[0] > 0.1 or done == total:
            last[0] = time.monotonic()
            pipe.send(("progress", (done, total)))

    while True:
        try:
            function, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            module, name = function.split(":")
            with listening(report):
                outcome = ("done", getattr(import_module(f"flatpunch.app.jobs.{module}"), name)(*arguments))
        except Exception as error:
            outcome = ("failed", message(error))
        try:
            pipe.send(outcome)
        except OSError:
            return
