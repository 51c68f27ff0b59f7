"""What all tests share."""

import signal


def pytest_configure() -> None:
    """Take interrupts also where the shell ignores them, as for jobs in the background: some tests send them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
