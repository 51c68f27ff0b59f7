"""Ctrl-C where it may not be heard at once: while outcomes are kept, and while processes start."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Iterator
from multiprocessing import resource_tracker


@contextlib.contextmanager
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


@contextlib.contextmanager
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
