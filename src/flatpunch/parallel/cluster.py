"""Calls made on a Dask cluster that runs already; results come back to this process, which keeps them.

A worker that is lost costs nothing: the scheduler gives its calls to another one. It gives up on all that was with workers it
has lost more often than its setting `distributed.scheduler.allowed-failures` says (3). Those are sent again at the end, one at
a time, so that only the call that is the reason fails.
"""

from __future__ import annotations

import pkgutil
import platform
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from flatpunch._support.checks import FlatpunchWarning, shown
from flatpunch._version import __version__

if TYPE_CHECKING:
    from distributed import Client

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
