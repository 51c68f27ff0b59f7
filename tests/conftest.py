"""What all tests share."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

BESIDE = Path(__file__).resolve().parents[2] / "shared"
"""Measured files of others: no part of this repository, they lie beside it where it is developed."""


def pytest_configure() -> None:
    """Take interrupts also where the shell ignores them, as for jobs in the background: some tests send them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # tests share the cores already, and some count what is solved in this process
    os.environ["OMP_NUM_THREADS"] = "1"
    # hundreds of media in turn: what one test has solved serves the next
    os.environ.setdefault("FLATPUNCH_CACHE_MB", "1000")


@pytest.fixture(autouse=True)
def no_figure_left_open() -> Iterator[None]:
    """Close what a test has drawn: whichever tests share a process, none of them meets the figures of twenty others."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of measured curves."""
    return _beside("data")


@pytest.fixture(scope="session")
def cases() -> Path:
    """Folder of small curves as users have reported them."""
    return _beside("cases")


def _beside(name: str) -> Path:
    """A folder; a clone without it runs every other test, and lists at the end what it leaves out, with this reason."""
    folder = BESIDE / name
    if not folder.is_dir():
        pytest.skip(f"needs the measured files of {folder}, which are not part of the repository")
    return folder
