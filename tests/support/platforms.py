"""Marks of tests that need what some systems do not have."""

import os
import sys

import pytest

SIGNALS = pytest.mark.skipif(os.name == "nt", reason="Windows has no signals that interrupt or kill other processes")
PIPES = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes among the files")
FORK = pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows does not fork processes")
PROC = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc, a folder that nobody can write to")
PEAK_IN_KILOBYTES = pytest.mark.skipif(
    sys.platform != "linux", reason="the peak of memory is in kilobytes on Linux only, and Windows has no module for it"
)
