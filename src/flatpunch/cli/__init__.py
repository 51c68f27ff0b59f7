"""The command `flatpunch`: one module a command, and what they share."""


def main() -> None:
    """Run the command line."""
    from flatpunch.cli.app import main as run

    run()
