"""`flatpunch cite`: the references of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flatpunch.cli.terminal import check_targets, command, say, say_written


@command("cite")
def cite(
    result: Annotated[Path, typer.Argument(metavar="RESULT.nc", help="Result file.", show_default=False)],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write them as BibTeX: .bib.")] = None,
) -> None:
    """Print what to cite for a result: the package, its method, and what its medium, adhesion or relaxation rest on.

    In Python, [bold]flatpunch.cite(result)[/bold] does the same for results in memory, fits included.
    """
    check_targets(output=output, endings=(".bib",))
    from flatpunch._support.whole_file import write_whole
    from flatpunch.files import load
    from flatpunch.literature import cite as references

    found = references(load(result))
    say(found.text)
    if output is not None:
        write_whole(output, found.bibtex.encode("utf-8"))
        say_written([output])
