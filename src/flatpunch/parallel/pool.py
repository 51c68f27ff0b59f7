"""A few long calls shared with worker processes that are kept for the next ones.

The processes are started when first worth it, and end when idle. This process works too. What a worker does not return, for
whatever reason, is called here, so that errors and warnings appear where the caller sees them.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from flatpunch._support.threads import allowed_threads
from flatpunch.parallel.calls import Item, Missing, map_calls
from flatpunch.parallel.worker import processes

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
        partial(_strictly, function, common), items, team, here=here, describe=_from_last, tries=0
    ):
        for index, outcome in outcomes:
            found[index] = here(items[index]) if isinstance(outcome, Missing) else outcome
            done(found[index])
    return [found[index] for index in range(len(items))]


def _from_last(index: int) -> Item:
    return Item(index, cost=index)


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
