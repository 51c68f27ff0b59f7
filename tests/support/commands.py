"""The commands, called as on the command line."""

from typer.testing import CliRunner

from flatpunch.cli.app import app


def run(*arguments, exits=None, columns=None):
    """Run `flatpunch` with arguments of any type, on a terminal of a width; `exits` is the exit status that is expected."""
    env = {"COLUMNS": str(columns), "NO_COLOR": "1"} if columns else None
    done = CliRunner().invoke(app, [str(a) for a in arguments], env=env)
    assert exits is None or done.exit_code == exits, done.output
    return done
