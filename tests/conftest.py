"""What all tests share."""

import os
import signal
from pathlib import Path

import pytest

MEASURED = Path(__file__).resolve().parents[2] / "shared" / "data"


def pytest_configure() -> None:
    """Take interrupts also where the shell ignores them, as for jobs in the background: some tests send them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # tests share the cores already, and some count what is solved in this process
    os.environ["OMP_NUM_THREADS"] = "1"


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of measured files of others, which are not part of this repository but lie beside it where it is developed.

    A clone without them can run every other test; what it leaves out is listed with this reason at the end of the run.
    """
    if not MEASURED.is_dir():
        pytest.skip(f"needs the measured files of {MEASURED}, which are not part of the repository")
    return MEASURED
