"""`flatpunch plugin`: files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flatpunch._support.paths import Plain
from flatpunch.cli.terminal import Output, command, say

plugin_app = typer.Typer(no_args_is_help=True, help="Use the media of this package in other programs: files for them.")


@command("plugin list", plugin_app)
def list_hosts() -> None:
    """List the programs, and what the file for each brings."""
    from flatpunch.plugins.hosts import HOSTS

    for name, host in HOSTS.items():
        say(f"{name:<18}{host.name}: {host.brings}{' (needs a case file)' if host.case else ''}")


@command("plugin write", plugin_app)
def write(
    host: Annotated[str, typer.Argument(metavar="HOST", help="Name in `flatpunch plugin list`.", show_default=False)],
    case: Annotated[
        Path | None, typer.Argument(metavar="[CASE.toml]", help="Case file: medium, and tip.", show_default=False)
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Python module; by default flatpunch_HOST.py."),
        Output((".py",)),
    ] = None,
    depths: Annotated[str | None, typer.Option(help='slippy: depths of stresses, "0.2um, 1um".')] = None,
    spacing: Annotated[str | None, typer.Option(help='slippy: side of the cells of the surface, "50nm".')] = None,
    cells: Annotated[int, typer.Option(help="slippy: their number along the longer side.", min=0)] = 0,
) -> None:
    """Write the file for a program.

    Files that carry a case (nanite, SoftMech, slippy) are written anew for another sample; the others take any medium.
    """
    from flatpunch._support.whole_file import check_target
    from flatpunch.files.units import LENGTH, named_si
    from flatpunch.fits.case import read_fit_case
    from flatpunch.plugins.hosts import write_plugin

    if output is None:
        output = Path(f"flatpunch_{host}.py")
        check_target("--output", output, (".py",), chosen=True)
    options: Plain = {}
    if depths is not None:
        options["depths"] = [named_si("--depths", entry.strip(), LENGTH) for entry in depths.split(",")]
    if spacing is not None or cells:
        if spacing is None or not cells:
            raise ValueError("--spacing and --cells describe one grid: give both or neither.")
        options |= {"spacing": named_si("--spacing", spacing, LENGTH), "cells": cells}
    say(f"Written: {write_plugin(host, output, read_fit_case(case) if case else None, **options)}")
