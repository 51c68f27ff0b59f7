"""The command `flatpunch`: one module a command, and what they share."""

import signal
import sys


def main() -> None:
    """Run the command line."""
    try:
        from flatpunch.cli.app import main as run
    except KeyboardInterrupt:
        # Ctrl-C while libraries load
        print("\nInterrupted.", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)

    run()
