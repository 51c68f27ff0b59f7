"""Calls that helping processes load: well behaved ones, and all kinds of others. Here is the process that shares them out."""

import os
import signal
import time
import warnings


def worker(here, item):
    """Who did it, after as many seconds as the item says."""
    time.sleep(item)
    return os.getpid(), item


def deadly_elsewhere(here, item):
    """Kills every process but `here`."""
    time.sleep(0.02)
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid(), item


def refused(here, item):
    time.sleep(0.02)
    if item == 5:
        raise ValueError("5 is refused")
    return os.getpid(), item


def warned(here, item):
    time.sleep(0.02)
    warnings.warn(f"{item} is odd", UserWarning, stacklevel=1) if item % 2 else None
    return os.getpid(), item


def deprecated(here, item):
    """As a library may warn of its own affairs."""
    time.sleep(0.05)
    warnings.warn("old", DeprecationWarning, stacklevel=1)
    return os.getpid(), item


def interrupted_here(here, item):
    """Ctrl-C while `here` is at its second call."""
    time.sleep(0.05)
    if os.getpid() == here and item > 0:
        raise KeyboardInterrupt
    return os.getpid(), item


def threads(here, item):
    time.sleep(0.05)
    return os.getpid(), os.environ.get("OMP_NUM_THREADS", "")


def echo(here, item):
    time.sleep(0.05)
    return os.getpid(), item


class Homesick:
    """Cannot be unpickled in another process."""

    def __reduce__(self):
        return _at_home, (os.getpid(),)


def _at_home(pid):
    if os.getpid() != pid:
        raise RuntimeError("not at home")
    return Homesick()
