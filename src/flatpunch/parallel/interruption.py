"""Ctrl-C where it may not be heard at once: while outcomes are kept, and while processes start."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Iterator


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
    """Start processes that ignore Ctrl-C from their first instruction on, not only when they have loaded what they call.

    This process hears what came meanwhile afterwards. Only the main thread may do so, and Windows hands nothing down.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        # None stands for a handler that is not Python's and cannot be put back
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def left_to_parent() -> None:
    """Ignore Ctrl-C from now on, in a worker, which reaches all processes of a terminal; end as soon as the first one has."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a parent that was killed cannot end its workers, and they may be at a long point
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Look once a second: workers that loky starts do not know their parent. Windows keeps the number of a parent that ended."""
    first = os.getppid()
    while os.getppid() == first:
        time.sleep(1.0)
    os._exit(1)
