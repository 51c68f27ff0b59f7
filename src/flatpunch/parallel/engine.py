"""`solve_points`: many points, each solved once and kept, in this process, in several, or on a cluster; few long calls as well.

`shared_out` shares few long calls with worker processes that are kept for the next ones.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import warnings
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from flatpunch._support.checks import follows, shown, switch
from flatpunch._support.progress import Report, reporting
from flatpunch._support.reading import as_path
from flatpunch._support.threads import allowed_threads, cores, one_thread
from flatpunch._version import __version__
from flatpunch.parallel.calls import Item, Missing, Team, map_calls
from flatpunch.parallel.store import Folder, Function, Memory, Outcome, Store, content_key, solved
from flatpunch.parallel.worker import held, processes

if TYPE_CHECKING:
    from distributed import Client

Name = Hashable


class Solved(Mapping[Name, Outcome]):
    """Outcomes of all points by name, read from where they are kept when asked for.

    Attributes
    ----------
    fresh : int
        Number of points that this run has solved or tried; the others were there.

    See Also
    --------
    flatpunch.parallel.solve_points : Makes it.
    flatpunch.parallel.Outcome : Each of its values.

    Examples
    --------
    >>> from flatpunch.parallel import solve_points
    >>> def root(x):
    ...     return {"root": np.sqrt(x)}
    >>> solved = solve_points(root, [4.0, 9.0], workers=1)
    >>> print(len(solved), solved.fresh, solved.failed)
    2 2 {}
    """

    def __init__(self, keys: Mapping[Name, str], store: Store, fresh: int) -> None:
        self._keys, self._store, self.fresh = dict(keys), store, fresh

    def __getitem__(self, name: Name) -> Outcome:
        return self._store.read(self._keys[name])

    def __iter__(self) -> Iterator[Name]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    @property
    def failed(self) -> dict[Name, str]:
        """Reasons of the points that failed."""
        states = self._store.states(set(self._keys.values()))
        return {name: self._store.read(key).reason for name, key in self._keys.items() if not states[key]}


def solve_points(
    function: Function,
    points: Mapping[Any, Any] | Sequence[Any],
    *,
    store: str | Path | Store | None = None,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    progress: bool | Report | None = None,
    title: str = "Solving",
    version: object = None,
    cost: Callable[[Any], float] | None = None,
    group: Callable[[Any], Hashable] | None = None,
    retry_failed: bool = False,
    anew: bool = False,
    tries: int = 3,
) -> Solved:
    """Solve many independent points, each once, and keep what is finished.

    Parameters
    ----------
    function : callable
        Point -> numbers, texts and arrays by name. A function of a module or of the script, or a `functools.partial` of one.
        An exception is the outcome of that point and of no other.
    points : mapping or sequence
        Inputs by name, or in order, which are then named 0, 1, ...: numbers, texts, arrays, dataclasses, and lists and mappings
        of them. Equal points are solved once.
    store : path or Store, optional
        Folder in which every finished point is kept before it counts. A later call with the same folder takes from there what
        it needs; without one everything stays in memory.
    workers : int, optional
        Processes; one for each core that this process may use by default. 1 works in this process.
    scheduler : str or distributed.Client, optional
        Address of the scheduler of a Dask cluster, "tcp://host:8786", which then does the work. Needs the extra `dask`.
    progress : bool or callable, optional
        True shows a bar; a function is called with (points there, points wanted).
    title : str
        What the bar says.
    version : object, optional
        Raise it when a change of the function moves its numbers: points of another version are solved anew, as are those of
        another version of this package, or of another function.
    cost : callable, optional
        Point -> how long it takes, in any unit; long ones are begun first.
    group : callable, optional
        Point -> what it shares with others of the group (its body, say), solved by the same worker one after the other.
    retry_failed : bool
        Try again what failed in an earlier run.
    anew : bool
        Solve everything, whatever is there.
    tries : int
        How often a point is tried that takes its process down with it, before it counts as failed. On a cluster its scheduler
        decides.

    Returns
    -------
    Solved
        Outcomes by name: `numbers`, or None and the `reason`.

    Raises
    ------
    TypeError, ValueError, OSError
        On input that cannot be used, a folder that cannot be written, a cluster that cannot be reached; before any work.

    See Also
    --------
    flatpunch.parallel.Solved : What it returns.
    flatpunch.sweep : A case file over ranges.

    Examples
    --------
    >>> from flatpunch.parallel import solve_points
    >>> def force(radius):
    ...     contact = fp.indent(fp.HalfSpace(young=1e6, poisson=0.5), fp.Sphere(radius), depth=1e-7)
    ...     return {"force": float(contact.force[0])}
    >>> solved = solve_points(force, {"small": 1e-6, "large": 4e-6}, workers=1)
    >>> print({name: f"{outcome.numbers['force'] * 1e9:.1f} nN" for name, outcome in solved.items()})
    {'small': '55.7 nN', 'large': '112.2 nN'}
    """
    named = dict(points) if isinstance(points, Mapping) else dict(enumerate(points))
    if workers is not None and (isinstance(workers, bool) or not follows(workers, int) or workers < 1):
        raise ValueError(f"workers = {shown(workers)} must be a whole number > 0: that many processes solve points.")
    anew, retry_failed = switch("anew", anew), switch("retry_failed", retry_failed)
    place = _place(store)
    keys = point_keys(function, named, version)
    wanted = {keys[name]: point for name, point in named.items()}
    there = {} if anew else place.states(wanted)
    missing = [key for key in wanted if key not in there or (retry_failed and not there[key])]
    missed = [wanted[key] for key in missing]

    def described(index: int) -> Item:
        point = missed[index]
        return Item(index, group(point) if group else None, float(cost(point)) if cost else 1.0)

    team = _team(min(workers or cores(), len(missing)), scheduler) if missing else None
    made = map_calls(
        partial(solved, function), missed, team, describe=described, tries=tries if scheduler is None else 1
    )
    with nullcontext() if team else one_thread(), reporting(title, progress) as report:
        done = len(wanted) - len(missing)
        report(done, len(wanted))
        for outcomes in made:
            with held():
                for index, found in outcomes:
                    place.write(missing[index], Outcome(None, found.reason) if isinstance(found, Missing) else found)
            done += len(outcomes)
            report(done, len(wanted))
    return Solved(keys, place, len(missing))


def _team(workers: int, scheduler: str | Client | None) -> AbstractContextManager[Team] | None:
    if scheduler is not None:
        from flatpunch.parallel.worker import cluster

        return cluster(scheduler)
    return processes(workers) if workers > 1 else None


def _place(store: str | Path | Store | None) -> Store:
    if store is None:
        return Memory()
    if isinstance(store, (str, Path)) or not all(hasattr(store, name) for name in ("states", "read", "write")):
        return Folder(as_path("store", store))
    return store


def point_keys(function: Function, points: Mapping[object, object], version: object = None) -> dict[Name, str]:
    """Return the keys under which `solve_points` keeps its outcomes, by the names of the points."""
    salt = content_key(function_name(function), __version__, version)
    return {name: content_key(salt, point) for name, point in points.items()}


def function_name(function: Any) -> list[object]:
    """What names a function in the keys: module and name, with the arguments of a partial."""
    if hasattr(function, "func") and hasattr(function, "keywords"):
        return [function_name(function.func), list(function.args), dict(function.keywords)]
    name = getattr(function, "__qualname__", None)
    if name is None or "<" in name:
        raise TypeError(
            f"function = {shown(function)} must be a function of a module: other processes cannot load lambdas and functions "
            "defined inside others. functools.partial adds arguments to one."
        )
    return [function.__module__, name]


FEWEST = 4
"""Calls for which processes are started: with half as many, loading the package takes longer than the calls saved."""

MOST = 3
"""Worker processes at most: twice as many hold another 300 MB, for rounds of some eight calls."""

_PROCESS = os.getpid()

Common = TypeVar("Common")
Given = TypeVar("Given")
Found = TypeVar("Found")


def shared_out(
    function: Callable[[Common, Given], Found],
    common: Common,
    items: Sequence[Given],
    *,
    done: Callable[[Found], None] = lambda outcome: None,
    helped: bool = True,
) -> list[Found]:
    """Return function(common, item) of every item, in order, called here and in worker processes.

    What the function returns depends on its arguments only; each worker unpickles `common` once. The last items come first: put
    those that take long at the end. `done` is called here with each outcome. `helped` says whether workers may take part, each of
    which needs as much memory as this process.
    """
    here = partial(function, common)
    worth = helped and len(items) >= FEWEST and _may_start()
    team = processes(min(allowed_threads() - 1, MOST), kept=True) if worth else None
    found: dict[int, Found] = {}
    for outcomes in map_calls(
        partial(_strictly, function, common),
        items,
        team,
        here=here,
        describe=lambda index: Item(index, cost=index),
        tries=0,
    ):
        for index, outcome in outcomes:
            found[index] = here(items[index]) if isinstance(outcome, Missing) else outcome
            done(found[index])
    return [found[index] for index in range(len(items))]


def _may_start() -> bool:
    """Whether this process has cores to spare and may have children: neither a fork nor a worker itself."""
    own = os.getpid() == _PROCESS and not multiprocessing.current_process().daemon
    return own and not getattr(sys, "frozen", False) and allowed_threads() > 1


def _strictly(function: Callable[[Common, Given], Found], common: Common, item: Given) -> Found:
    """Call in a worker; what warns fails here, and is called again where the caller sees the warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", DeprecationWarning)
        return function(common, item)
