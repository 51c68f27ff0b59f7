"""The commands `flatpunch correct` and `flatpunch compare`: reported moduli and published formulas against the exact contact."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from flatpunch._support.whole_file import check_target
from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import PICTURES, CaseFile, StyleOption, friendly, say, say_written

if TYPE_CHECKING:
    import xarray as xr

    from flatpunch.fit.half_space.correction import Correction

OutputOption = Annotated[Path | None, typer.Option("--output", "-o", help="Result file: .csv or .nc (NetCDF).")]
PlotOption = Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")]


def add_commands(app: typer.Typer) -> None:
    """Register the commands on the command line."""

    @app.command(epilog=examples("correct"))
    def correct(
        case: CaseFile,
        reported: Annotated[str | None, typer.Option(help="Young's modulus that was reported, '8 kPa'.")] = None,
        depth: Annotated[str | None, typer.Option(help="Depth of that fit, '300 nm'.")] = None,
        model: Annotated[str | None, typer.Option(help="hertz, sneddon, flat, bilodeau or rico.")] = None,
        poisson: Annotated[float | None, typer.Option(help="Poisson ratio that was assumed there.")] = None,
        over: Annotated[
            Literal["curve", "depth"] | None,
            typer.Option(help="'curve' (default) if the curve was fitted, 'depth' if the force at the depth."),
        ] = None,
        output: OutputOption = None,
        plot: PlotOption = None,
        style: StyleOption = "screen",
    ) -> None:
        """From a reported half-space modulus to the true modulus of the layer.

        The case file describes layers, base and indenter; the modulus of its top layer does not matter. What was reported is
        given here, or in a table [bold]correct[/bold] of the case file: reported, depth, model, poisson, over. Beside the
        result are those of published corrections.
        """
        with friendly():
            check_target("--output", output, (".csv", ".nc"))
            check_target("--plot", plot, PICTURES)
            given = {
                "reported": reported,
                "depth": depth,
                "model": model,
                "reported_poisson": poisson,
                "over": over,
            }
            _correct(case, {name: value for name, value in given.items() if value is not None}, output, plot, style)

    @app.command(epilog=examples("compare"))
    def compare(
        case: CaseFile,
        output: OutputOption = None,
        plot: PlotOption = None,
        style: StyleOption = "screen",
    ) -> None:
        """Compare published thin-layer and substrate formulas with the exact contact of a case.

        Prints the error of each formula at the largest depth, and the largest depths at which it is within 1, 5 and 10 %.
        """
        with friendly():
            check_target("--output", output, (".csv", ".nc"))
            check_target("--plot", plot, PICTURES)
            _compare(case, output, plot, style)


def _correct(case: Path, given: dict[str, Any], output: Path | None, plot: Path | None, style: str) -> None:
    from flatpunch.files import units
    from flatpunch.fit.case import read_fit_case
    from flatpunch.fit.half_space.correction import correct

    loaded = read_fit_case(case)
    for name, dimension in (("reported", units.PRESSURE), ("depth", units.LENGTH)):
        if name in given:
            given[name] = units.named_si(f"--{name}", given[name], dimension)
        elif name not in loaded.correct:
            raise ValueError(f"--{name} is missing; give it, or a table [correct] in {case} with reported and depth.")
    arguments = {**loaded.correct, **given}
    found = correct(medium=loaded.medium, indenter=loaded.indenter, method=loaded.settings.method, **arguments)
    say(found.summary())
    written = []
    if output is not None:
        written.append(_write(found, found.to_csv(), output))
    if plot is not None:
        from flatpunch.fit.half_space.pictures import correction_figure
        from flatpunch.plots.result import save_figure

        written.append(save_figure(correction_figure(found, title=loaded.title, style=style), plot))
    say_written(written)


def _compare(case: Path, output: Path | None, plot: Path | None, style: str) -> None:
    from rich.console import Console
    from rich.table import Table

    from flatpunch.files import read_case
    from flatpunch.fit.half_space.comparison import (
        compare_case,
        comparison_columns,
        comparison_csv,
        comparison_rows,
    )

    loaded = read_case(case)
    found = compare_case(loaded)
    table = Table(
        title=loaded.title or "Formulas", title_justify="left", caption=f"exact force: {found.attrs['method']}"
    )
    for i, heading in enumerate(comparison_columns(found)):
        table.add_column(heading, justify="right" if 0 < i < 5 else "left")
    for row in comparison_rows(found):
        table.add_row(*row)
    Console().print(table)
    for line in found.attrs["notes"].splitlines():
        say(f"Note: {line}")
    written = []
    if output is not None:
        written.append(_write(found, comparison_csv(found), output))
    if plot is not None:
        from flatpunch.fit.half_space.pictures import comparison_figure
        from flatpunch.plots.result import save_figure

        written.append(save_figure(comparison_figure(found, title=loaded.title, style=style), plot))
    say_written(written)


def _write(found: Correction | xr.Dataset, table: str, path: Path) -> Path:
    """Write a result as CSV or NetCDF."""
    import xarray as xr

    from flatpunch.files import save
    from flatpunch.files.results import write

    if path.suffix.lower() == ".nc":
        return save(found if isinstance(found, xr.Dataset) else found.dataset(), path)
    write(path, table.encode("utf-8"))
    return path
