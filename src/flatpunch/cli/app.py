"""Command line: solve a case file, check one, or run the cases that come with the package.

Bad input ends with status 2 and one readable message, an interrupt (Ctrl-C) with status 130; neither leaves a half-written
file. Heavy imports happen inside the commands, so that `--help` and mistakes in the command itself are answered at once.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch.cli.atlas import atlas_app
from flatpunch.cli.design import add_commands as add_design
from flatpunch.cli.examples import examples
from flatpunch.cli.fit import add_commands
from flatpunch.cli.formulas import add_commands as add_formulas
from flatpunch.cli.page import add_commands as add_page
from flatpunch.cli.paper import paper
from flatpunch.cli.show import add_commands as add_show
from flatpunch.cli.streams import finish, prepare
from flatpunch.cli.stress import add_commands as add_stress
from flatpunch.cli.sweep import add_commands as add_sweep
from flatpunch.cli.terminal import PICTURES, CaseFile, StyleOption, friendly, progress, say, say_written

if TYPE_CHECKING:
    import xarray as xr

    from flatpunch.files import Case

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="Press rigid indenters into layered and graded elastic bodies.\n\n"
    "A case file (TOML) describes the layers from the surface down, what is below them, the indenter, and the depths, "
    'forces or radii to solve for. All quantities carry units: [bold]young = "5 kPa"[/bold].\n\n'
    "Start with [bold]flatpunch demo[/bold]: it solves the cases that come with the package and leaves their files behind "
    "for you to change.",
)


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


@app.command(epilog=examples("solve"))
def solve(
    case: CaseFile,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Result file: .nc (NetCDF) or .csv.")] = None,
    csv: Annotated[Path | None, typer.Option(help="Curve as CSV, besides the output.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
    style: StyleOption = "screen",
    outlines: Annotated[bool, typer.Option("--outlines", help="Contact outlines in the CSV too.")] = False,
) -> None:
    """Solve a case: print the curve, and write it if asked to.

    Read the result with [bold]flatpunch.load("gel.nc")[/bold] or any NetCDF reader; the CSV opens in a spreadsheet. NetCDF
    holds the contact outlines as well.
    """
    with friendly():
        _check_targets(output, csv, plot)
        from flatpunch.files import read_case

        _solve(read_case(case), [path for path in (output, csv) if path], plot, style=style, outlines=outlines)


@app.command(epilog=examples("check"))
def check(case: CaseFile) -> None:
    """Read a case file and report what would be solved or fitted: method, expected error, time and memory.

    Case files of fits are checked without their curve. Every problem found is listed with the field, its value and what to
    write instead.
    """
    with friendly():
        from flatpunch.files import describe, read_case
        from flatpunch.files.cases import is_fit_case
        from flatpunch.fit.case import read_fit_case
        from flatpunch.fit.describe import describe_fit

        lines = describe_fit(read_fit_case(case)) if is_fit_case(case) else describe(read_case(case))
        for line in lines:
            say(line)


app.command(epilog=examples("paper"))(paper)


@app.command(epilog=examples("demo"))
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for results and pictures.")] = Path(
        "demo-results"
    ),
) -> None:
    """Solve the cases that come with the package.

    Writes, for each of them, the case file itself, the result as NetCDF and CSV, and a picture; measured curves with the case
    files of their fits are in the folder `fit`. Case files that are there already are kept, and solved as you changed them.
    """
    with friendly():
        from flatpunch._support.whole_file import made_folder
        from flatpunch.files import read_case, shipped_cases
        from flatpunch.files.describe import shipped_fits

        made_folder("--output", output / "fit")
        for source in shipped_fits():
            _copy(source, output / "fit" / source.name)
        for source in shipped_cases():
            case = output / source.name
            _copy(source, case)
            _solve(read_case(case), [case.with_suffix(".nc"), case.with_suffix(".csv")], case.with_suffix(".png"))


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
    """Solve one case, write what was asked for, print the curve."""
    import flatpunch as fp
    from flatpunch._support.progress import listening
    from flatpunch.files import save
    from flatpunch.files.summary import pull_off_lines

    written = []
    with (
        progress(case.title or "Solving", 1 + len(outputs) + (plot is not None)) as step,
        warnings.catch_warnings(record=True) as caught,
    ):
        warnings.simplefilter("always", fp.FlatpunchWarning)
        step("solving")
        with listening(lambda done, total: step(f"solving, {done} of {total}", advance=0)):
            result = fp.indent(case.medium, case.indenter, **case.arguments)
        leaving = pull_off_lines(case)
        for path in outputs:
            step(f"writing {path.name}")
            written.append(save(result, path, outlines=outlines))
        if plot is not None:
            from flatpunch.plots import result as plots

            step(f"drawing {plot.name}")
            drawn = plots.figure(result, case.medium, case.indenter, title=case.title, style=style)
            written.append(plots.save_figure(drawn, plot))
    _print_curve(case, result)
    out = Console()
    for line in leaving:
        out.print(line, markup=False, highlight=False)
    for line in dict.fromkeys([*str(result.attrs.get("notes", "")).splitlines(), *(str(w.message) for w in caught)]):
        out.print(f"Note: {line}", style="yellow", markup=False, highlight=False)
    say_written(written)
    out.print()


def _print_curve(case: Case, result: xr.Dataset) -> None:
    """Print about ten evenly chosen steps as a table; every column in the unit that suits its largest value."""
    from rich.table import Table

    from flatpunch.files.summary import curve_table

    shown = curve_table(result)
    table = Table(title=case.title, caption=shown.caption, title_justify="left")
    for name, unit in shown.columns:
        table.add_column(f"{name}\n{unit}", justify="right")
    for row in shown.rows:
        table.add_row(*row)
    Console().print(table)


def _check_targets(output: Path | None, csv: Path | None, plot: Path | None) -> None:
    """Refuse endings and folders that cannot work before anything is solved."""
    from flatpunch._support.whole_file import check_target

    check_target("--output", output, (".nc", ".csv"))
    check_target("--csv", csv, (".csv",))
    check_target("--plot", plot, PICTURES)


add_show(app)
add_commands(app)
add_formulas(app)
add_sweep(app)
add_stress(app)
add_design(app)
add_page(app)
_atlas = atlas_app()
app.add_typer(_atlas, name="atlas")
for _each in (*app.registered_commands, *_atlas.registered_commands):
    # the terminal wraps paragraphs at its own width; of the lines of a docstring it would keep the ends too
    _each.help = "\n\n".join(" ".join(part.split()) for part in (_each.callback.__doc__ or "").split("\n\n"))


def main() -> None:
    """Entry point of the command `flatpunch`."""
    prepare()
    status: int | str | None = 0
    try:
        try:
            app()
        except SystemExit as end:
            status = end.code
        failed = finish()
    except KeyboardInterrupt:
        typer.echo("\nInterrupted. No file was left half-written.", err=True)
        sys.exit(130)
    except BrokenPipeError:
        # whoever read the output has had enough, as `head` has
        sys.exit(141)  # as a shell reports a process whose output nobody reads
    if failed is not None:
        typer.echo(f"Error: {failed}", err=True)
        status = 2
    sys.exit(status)
