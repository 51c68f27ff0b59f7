"""`flatpunch cite`: the references of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flatpunch.cli.terminal import Output, command, say, write_all


@command("cite")
def cite(
    result: Annotated[Path, typer.Argument(metavar="RESULT.nc", help="Result file.", show_default=False)],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write them as BibTeX: .bib."), Output((".bib",))
    ] = None,
) -> None:
    """Print what to cite for a result: the package, its method, and what its medium, adhesion or relaxation rest on.

    In Python, [bold]flatpunch.cite(result)[/bold] does the same for results in memory, fits included.
    """
    from flatpunch._support.whole_file import write_whole
    from flatpunch.files import load
    from flatpunch.literature import cite as references

    found = references(load(result))
    say(found.text)
    write_all((output, lambda path: write_whole(path, found.bibtex.encode("utf-8"))))
