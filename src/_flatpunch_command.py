"""Entry point of the command `flatpunch`: outside the package, so that Ctrl-C while it is imported ends quietly too."""

import sys


def main() -> None:
    """Run the command line."""
    try:
        from flatpunch.cli import main as command
    except KeyboardInterrupt:
        print("\nInterrupted. No file was left half-written.", file=sys.stderr)
        sys.exit(130)
    command()
