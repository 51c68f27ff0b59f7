"""Memory that is free goes back to the system.

Solutions of many media, made and dropped by turns, leave the heap of the C library full of holes: a process that has seen two
thousand media held 300 MB for the sixty that it keeps. glibc gives holes back when it is asked to; other systems do so alone.
"""

from __future__ import annotations

import ctypes
import sys
from functools import lru_cache
from typing import Any

_EVERY = 16
_calls = 0


def now_and_then() -> None:
    """Give back free memory at every sixteenth call."""
    global _calls
    _calls += 1
    if _calls % _EVERY == 0 and (trim := _trim()) is not None:
        trim(0)


@lru_cache(maxsize=1)
def _trim() -> Any:
    """`malloc_trim` of glibc, or None."""
    if sys.platform != "linux":
        return None
    try:
        return ctypes.CDLL("libc.so.6").malloc_trim
    except (OSError, AttributeError):
        return None
