"""Workers that make calls: processes of this machine, by loky, also those of the page; a Dask cluster; what Ctrl-C is to them.

Each worker is an executor of loky with a single process, so that one that dies costs only the call that it was at, and a call is
stopped by ending its process. Functions go to it by value where a script defines them, which is not run again. Workers end with
this process, however it ends, and leave Ctrl-C to it.

A Dask cluster runs already; results come back to this process, which keeps them. A worker that is lost costs nothing: the
scheduler gives its calls to another one. It gives up on all that was with workers it has lost more often than its setting
`distributed.scheduler.allowed-failures` says (3). Those are sent again at the end, one at a time, so that only the call that is
the reason fails.
"""

from __future__ import annotations

import multiprocessing
import os
import pkgutil
import platform
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

from flatpunch._support.checks import FlatpunchWarning, shown
from flatpunch._support.threads import ONE_THREAD
from flatpunch._version import __version__

if TYPE_CHECKING:
    from distributed import Client


@contextmanager
def held() -> Iterator[None]:
    """Let Ctrl-C wait until the block is done, so that what is finished is also kept.

    Only the main thread hears it, and only a handler of Python's can be put back: elsewhere nothing changes.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


@contextmanager
def unheard_by_children() -> Iterator[None]:
    """Start processes that do not hear Ctrl-C from their first instruction on, not only when they have loaded what they call.

    They inherit the mask of the thread that starts them, which hears what came meanwhile afterwards. Windows hands nothing down.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from loky.backend import resource_tracker as trackers_of_loky

    # processes of the libraries, started now, since their start takes the mask away
    resource_tracker.ensure_running()
    trackers_of_loky.ensure_running()
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def left_to_parent(parent: int) -> None:
    """Ignore Ctrl-C from now on, in a worker, which reaches all processes of a terminal; end as soon as the parent has."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a parent that was killed cannot end its workers, and they may be at a long point
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    """Check once a second: workers that loky starts do not know their parent. Windows keeps the number of a parent that ended."""
    first = parent if hasattr(os, "fork") else os.getppid()
    while os.getppid() == first:
        time.sleep(1.0)
    os._exit(1)


PAUSE = 0.1
"""Seconds between two reports of progress."""

_IDLE = 120
"""Seconds after which a kept worker process ends; then the next call has to start it again."""


class Worker:
    """A process that makes one call at a time, started with the first; `idle` seconds after its last call it ends."""

    def __init__(self, idle: float | None = None) -> None:
        from loky import ProcessPoolExecutor

        # loky replaces a process that has grown, which is no news for those who wait for results
        warnings.filterwarnings("ignore", "A worker (was restarted|stopped) ", UserWarning, "loky")
        self._heard, said = multiprocessing.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(
            1, timeout=idle, initializer=_begin, initargs=(said, os.getpid()), env=ONE_THREAD
        )

    def submit(self, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call; BrokenExecutor where the process was lost since the last one."""
        self.progress()
        with held(), unheard_by_children():
            future: Future[Any] = self._pool.submit(function, *arguments)
        return future

    def progress(self) -> tuple[int, int] | None:
        """Steps done and steps in all, as last reported by the call; None where nothing new was."""
        last = None
        with suppress(OSError, EOFError):
            while self._heard.poll():
                last = self._heard.recv()
        return last

    def end(self) -> None:
        """End the process, whatever it does."""
        self._pool.shutdown(wait=True, kill_workers=True)


_said: Connection | None = None
_last = 0.0


def _begin(said: Connection, parent: int) -> None:
    global _said
    _said = said
    left_to_parent(parent)


def report(done: int, total: int) -> None:
    """In a worker process: report the progress of a call, not more often than it is read."""
    global _last
    if _said is not None and (time.monotonic() - _last > PAUSE or done == total):
        _last = time.monotonic()
        _said.send((done, total))


def how_it_ended(error: BrokenExecutor) -> str:
    """How a process was lost; loky names the signal, if there was one, in its message."""
    named = [name.name for name in signal.Signals if f"{name.name}(" in str(error)]
    return "its process ended " + (f"with signal {named[0]}" if named else "unexpectedly")


_kept: list[Worker] = []
_lock = threading.Lock()


@contextmanager
def processes(count: int, *, kept: bool = False) -> Iterator[Processes]:
    """So many worker processes, at an error ended at once; `kept` leaves them to the next round of calls."""
    team = Processes(count, kept)
    try:
        yield team
    except BaseException:  # Ctrl-C too: no worker may go on for a caller that has left; raised again
        team.end()
        raise
    team.leave()


class Processes:
    """A team of worker processes, each started with its first call."""

    shared = False

    def __init__(self, count: int, kept: bool) -> None:
        self._count, self._keep, self._workers = count, kept, dict[int, Worker]()

    def size(self) -> int:
        """Processes."""
        return self._count

    def submit(self, slot: int, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call."""
        if slot not in self._workers:
            with _lock:
                free = _kept.pop() if self._keep and _kept else None
            self._workers[slot] = free or Worker(_IDLE if self._keep else None)
        return self._workers[slot].submit(function, *arguments)

    def replace(self, slot: int) -> None:
        """End a worker; the next call starts another."""
        if worker := self._workers.pop(slot, None):
            worker.end()

    def lost(self, error: BaseException) -> str | None:
        """How a worker was lost."""
        return how_it_ended(error) if isinstance(error, BrokenExecutor) else None

    def wait(self) -> None:
        """A process that is lost is noticed at once."""

    def leave(self) -> None:
        """Keep the workers, none of which has anything to do, for the next team."""
        if not self._keep:
            self.end()
            return
        with _lock:
            _kept.extend(self._workers.values())

    def end(self) -> None:
        """End all workers."""
        for worker in self._workers.values():
            worker.end()


PATIENCE = 15.0
"""Seconds to wait for a scheduler, and for a worker; clusters that start slowly take a few."""


@contextmanager
def cluster(scheduler: str | Client) -> Iterator[Cluster]:
    """Workers of a scheduler, which must be able to import what they call."""
    with _client(scheduler) as client:
        team = Cluster(client)
        try:
            yield team
        finally:
            team.end()


class Cluster:
    """A team of Dask workers: two chunks for each, one in progress and one that waits there."""

    shared = True

    def __init__(self, client: Client) -> None:
        self._client, self._executor = client, client.get_executor(pure=False)
        self._deserted: float | None = None
        """Time since which there is no worker; infinite once that was reported."""

    def size(self) -> int:
        """Chunks; those of one worker where there is none for the moment, which wait for it."""
        self._connected()
        return 2 * max(1, len(self._client.nthreads()))

    def submit(self, slot: int, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Send a call to the scheduler."""
        future: Future[Any] = self._executor.submit(function, *arguments)
        return future

    def replace(self, slot: int) -> None:
        """The scheduler replaces workers."""

    def lost(self, error: BaseException) -> str | None:
        """How a call was lost: given up by the scheduler, or on the way back."""
        from distributed import KilledWorker

        self._connected()
        if isinstance(error, KilledWorker):
            return str(error).splitlines()[0]
        return "the result did not arrive" if isinstance(error, CancelledError) else None

    def wait(self) -> None:
        """Warn once where all workers are gone: what is sent waits for one."""
        self._connected()
        if self._client.nthreads():
            self._deserted = None
            return
        now = time.monotonic()
        self._deserted = now if self._deserted is None else self._deserted
        if now - self._deserted > PATIENCE:
            self._deserted = float("inf")
            address = self._client.scheduler_info()["address"]
            warnings.warn(
                f"All workers of the scheduler at {address} are gone. Finished points are kept; the others wait until one joins: "
                f"`dask worker {address} --nthreads 1`. Ctrl-C ends the run, and the same call goes on later.",
                FlatpunchWarning,
                stacklevel=2,
            )

    def end(self) -> None:
        """Call off what is under way."""
        if self._client.status == "running":
            self._executor.shutdown(wait=False)

    def _connected(self) -> None:
        if self._client.status != "running":
            raise ConnectionError(
                "The connection to the scheduler was lost. Finished points are kept: start it and run this again."
            )


@contextmanager
def _client(scheduler: str | Client) -> Iterator[Client]:
    """Connect, see that there are workers and that they have this package; a client that was given is left open."""
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            f"scheduler = {shown(scheduler)} needs dask.distributed: install it with `pip install flatpunch[dask]`."
        ) from None
    if not isinstance(scheduler, str):
        _check(scheduler)
        yield scheduler
        return
    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ConnectionError(
            f"scheduler = {shown(scheduler)} does not answer ({error}). Start one with `dask scheduler`, which says its address, "
            "and workers with `dask worker ADDRESS --nthreads 1`; the address looks like tcp://host:8786."
        ) from None
    with client:
        _check(client)
        yield client


def _check(client: Client) -> None:
    address = client.scheduler_info()["address"]
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise ConnectionError(
            f"The scheduler at {address} has no workers. Start some: `dask worker {address} --nthreads 1 --nworkers 8`."
        ) from None
    mine = ".".join(platform.python_version_tuple()[:2])
    for worker, version in _answers(client, platform.python_version):
        if str(version).rsplit(".", 1)[0] != mine:
            raise ValueError(f"The worker {worker} runs Python {version}, this is Python {mine}: use the same version.")
    # functions of the standard library: a worker that lacks this package can call them too
    for worker, found in _answers(client, pkgutil.resolve_name, "flatpunch._version:__version__"):
        if found != __version__:
            has = f"cannot import it ({found})" if isinstance(found, BaseException) else f"has {found}"
            raise ValueError(
                f"The worker {worker} needs flatpunch {__version__} and {has}. Install the same version wherever workers run."
            )


def _answers(client: Client, function: Callable[..., object], *arguments: object) -> Iterator[tuple[str, object]]:
    """What each worker returns or raises, by tasks: `Client.run` waits for ever for workers that are lost."""
    from distributed import as_completed

    asked = {
        worker: client.submit(function, *arguments, workers=[worker], allow_other_workers=False, pure=False)
        for worker in client.nthreads()
    }
    with suppress(TimeoutError):
        for _ in as_completed(list(asked.values()), loop=client.loop, timeout=PATIENCE):
            pass
    for worker, future in asked.items():
        if future.status == "finished":
            yield worker, future.result()
        elif future.status == "error":
            yield worker, future.exception()
    client.cancel(list(asked.values()))
