"""Command line: the commands that need few lines of their own. Others register themselves in modules beside this one."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch._support.paths import Plain
from flatpunch.cli import analyses, film, fit, formulas, show, sweep  # noqa: F401  (they register their commands)
from flatpunch.cli.atlas import atlas_app
from flatpunch.cli.examples import EXAMPLES
from flatpunch.cli.terminal import (
    INTERRUPTED,
    CaseFile,
    Output,
    PlotOption,
    ResultOption,
    StyleOption,
    app,
    command,
    drawn,
    finish,
    prepare,
    progress,
    say,
    say_notes,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    from flatpunch.app.server import AppServer
    from flatpunch.files import Case


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


@command("app", interrupted="")
def page(
    port: Annotated[int, typer.Option(help="Port of the page; 0 takes a free one.")] = 8517,
    host: Annotated[
        str, typer.Option(help="Address to listen at. Other machines reach the page unless it is 127.0.0.1.")
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option(help="Whether to open the page in the browser.")] = True,
) -> None:
    """Open a page in the browser: press, fit, correct a reported modulus, coatings, slip, compare formulas.

    The page runs on this machine, and no data leaves it; Ctrl-C ends it. Nothing is written but what you save.
    """
    from flatpunch.app.server import serve

    def ready(server: AppServer) -> None:
        say(f"The page is at {server.address}   Ctrl-C ends it.")
        if not server.is_local:
            typer.echo(
                f"Warning: --host {host} lets other machines use this page and its calculations. It asks for no "
                "password; leave --host out to serve this machine only.",
                err=True,
            )
        if browser and _has_display():
            import webbrowser

            webbrowser.open(server.address)

    serve(host, port, ready=ready)


def _has_display() -> bool:
    """Whether a browser with windows can be opened; one in the terminal would take the terminal."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


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


def _version(asked: bool) -> None:
    if asked:
        from flatpunch._version import __version__

        typer.echo(f"flatpunch {__version__}")
        raise typer.Exit


@app.callback()
def flatpunch(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Take the options that come before a command."""


@command("solve")
def solve(
    case: CaseFile,
    output: ResultOption = None,
    csv: Annotated[Path | None, typer.Option(help="Curve as CSV, besides the output."), Output((".csv",))] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
    outlines: Annotated[bool, typer.Option("--outlines", help="Contact outlines in the CSV too.")] = False,
) -> None:
    """Solve a case: print the curve, and write it if asked to.

    Read the result with [bold]flatpunch.load("gel.nc")[/bold] or any NetCDF reader; the CSV opens in a spreadsheet. NetCDF
    holds the contact outlines as well.
    """
    from flatpunch.files import read_case

    _solve(read_case(case), [path for path in (output, csv) if path], plot, style=style, outlines=outlines)


@command("check")
def check(case: CaseFile) -> None:
    """Read a case file and report what would be solved or fitted: method, expected error, time and memory.

    Case files of fits are checked without their curve. Every problem found is listed with the field, its value and what to
    write instead.
    """
    from flatpunch.files import describe, read_case
    from flatpunch.files.cases import is_fit_case
    from flatpunch.files.rough import describe_rough, is_rough_case, read_rough_case
    from flatpunch.fits.case import read_fit_case
    from flatpunch.fits.description import describe_fit

    if is_fit_case(case):
        lines = describe_fit(read_fit_case(case))
    elif is_rough_case(case):
        lines = describe_rough(read_rough_case(case))
    else:
        lines = describe(read_case(case))
    for line in lines:
        say(line)


@command("demo")
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for results and pictures.")] = Path(
        "demo-results"
    ),
) -> None:
    """Solve the cases that come with the package.

    Writes, for each of them, the case file itself, the result as NetCDF and CSV, and a picture; measured curves with the case
    files of their fits are in the folder `fit`, case files of rough surfaces in `rough`. Files that are there already are
    kept: case files are solved as you changed them, unless there is a result.
    """
    from flatpunch._support.whole_file import made_folder
    from flatpunch.files import read_case, shipped_cases
    from flatpunch.files.descriptions import shipped_beside

    for folder in ("fit", "rough"):
        made_folder("--output", output / folder)
        for source in shipped_beside(folder):
            _copy(source, output / folder / source.name)
    for source in shipped_cases():
        case = output / source.name
        _copy(source, case)
        *results, picture = targets = [case.with_suffix(ending) for ending in (".nc", ".csv", ".png")]
        if there := [path.name for path in targets if path.exists()]:
            say(f"{case}: not solved again; {', '.join(there)} would be replaced.")
            continue
        _solve(read_case(case), results, picture)


def _copy(source: Path, target: Path) -> None:
    """Put a shipped case into the user's folder, unless a changed one is there."""
    from flatpunch._support.whole_file import write_whole
    from flatpunch.files.cases import case_text

    text = source.read_text(encoding="utf-8")
    if not target.exists():
        write_whole(target, text.encode("utf-8"))
    elif case_text(target) != text:
        typer.echo(f"{target} differs from the shipped case; it is kept and solved as it is.", err=True)


def _solve(
    case: Case, outputs: list[Path], plot: Path | None, *, style: str = "screen", outlines: bool = False
) -> None:
    """Solve one case, print the curve, write what was asked for."""
    import flatpunch as fp
    from flatpunch._support.progress import listening
    from flatpunch.files import save
    from flatpunch.files.descriptions import curve_table, pull_off_lines

    with (
        progress(case.title or "Solving", 1) as step,
        warnings.catch_warnings(record=True) as caught,
    ):
        warnings.simplefilter("always", fp.FlatpunchWarning)
        step("solving")
        with listening(lambda done, total: step(f"solving, {done} of {total}", advance=0)):
            result = fp.indent(case.medium, case.indenter, **case.arguments)
        leaving = pull_off_lines(case)
    # about ten evenly chosen steps; every column in the unit that suits its largest value
    shown = curve_table(result)
    say_table(case.title, [f"{name}\n{unit}" for name, unit in shown.columns], shown.rows, shown.caption)
    for line in leaving:
        say(line)
    notes = [*str(result.attrs.get("notes", "")).splitlines(), *(str(each.message) for each in caught)]
    say_notes(dict.fromkeys(notes))
    write_all(
        *((path, lambda path: save(result, path, outlines=outlines)) for path in outputs),
        (plot, drawn("plots.result:figure", result, case.medium, case.indenter, title=case.title, style=style)),
    )
    say("")


app.registered_commands.sort(key=lambda each: list(EXAMPLES).index(each.name or ""))
app.add_typer(atlas_app, name="atlas")
app.add_typer(plugin_app, name="plugin")


def main() -> None:
    """Entry point of the command `flatpunch`."""
    prepare()
    status: int | str | None = 0
    try:
        app()
    except SystemExit as end:
        status = end.code
    except KeyboardInterrupt:
        typer.echo("\nInterrupted. No file was left half-written.", err=True)
        status = INTERRUPTED
    sys.exit(finish() or status)
