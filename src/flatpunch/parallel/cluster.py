"""Points solved on a Dask cluster that runs already; results come back to this process, which keeps them.

A worker that is lost costs nothing: the scheduler gives its points to another one. It gives up on all that was with workers it
has lost more often than its setting `distributed.scheduler.allowed-failures` says (3). Those are sent again at the end, one at
a time, so that only the point becomes a record that is the reason.
"""

from __future__ import annotations

import pkgutil
import platform
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING

from flatpunch._support.checks import shown
from flatpunch._version import __version__
from flatpunch.parallel.work import Function, Item, Outcome, Waiting, call_packed, solve_chunk

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 15.0
"""Seconds to wait for a scheduler, and for its first worker; clusters that start slowly take a few."""


def on_cluster(
    function: Function, items: Sequence[Item], scheduler: str | Client
) -> Iterator[list[tuple[Item, Outcome]]]:
    """Yield outcomes as they come from the cluster of a scheduler, whose workers must be able to import the function."""
    with _client(scheduler) as client:
        yield from _outcomes(client, function, Waiting(items, _workers(client), tries=1))


def _outcomes(client: Client, function: Function, waiting: Waiting) -> Iterator[list[tuple[Item, Outcome]]]:
    import cloudpickle
    from distributed import as_completed

    called = partial(call_packed, function)
    running: dict[
        Future[list[Outcome]], tuple[int, list[Item]]
    ] = {}  # future -> worker it was meant for, and what it solves
    futures = as_completed([], loop=client.loop)

    def fill() -> None:
        """Keep all workers busy, those too that have joined meanwhile; suspects come when nothing else is on its way."""
        busy = {slot for slot, _ in running.values()}
        # two chunks for each worker: one in progress and one that waits there
        for slot in sorted(set(range(2 * _workers(client))) - busy):
            if items := waiting.take(slot, suspects=not running):
                packed = [cloudpickle.dumps(item.point) for item in items]
                future = client.submit(solve_chunk, called, packed, pure=False)
                running[future] = slot, items
                futures.add(future)

    try:
        fill()
        while running:
            future = next(futures)
            _, items = running.pop(future)
            if found := _finished(client, future, items, waiting):
                yield found
            fill()
    finally:
        if client.status == "running":
            client.cancel(list(running))


def _finished(
    client: Client, future: Future[list[Outcome]], items: list[Item], waiting: Waiting
) -> list[tuple[Item, Outcome]]:
    """Outcomes of a chunk that came back; what it did not get to, or lost, waits again."""
    from distributed import KilledWorker

    if client.status != "running":
        raise ConnectionError(
            "The connection to the scheduler was lost. Finished points are kept: start it and run this again."
        )
    try:
        outcomes = future.result()
    except (KilledWorker, CancelledError) as error:  # given up by the scheduler, or lost on the way back
        why = str(error).splitlines()[0] if isinstance(error, KilledWorker) else "the result did not arrive"
        alone = waiting.suspected(items[0])  # it was sent out alone then
        return [(item, Outcome(None, f"WorkerLost: {why}")) for item in waiting.lose(items, alone=alone)]
    except Exception as error:  # not of the function, whose exceptions are outcomes: it could not be called at all
        return [(item, Outcome(None, f"{type(error).__name__}: {error}")) for item in items]
    done = list(zip(items, outcomes, strict=False))
    waiting.give_back(items[len(done) :])
    waiting.learn(outcomes)
    return done


def _workers(client: Client) -> int:
    return max(1, len(client.nthreads()))  # none for the moment: what is sent waits for one


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
