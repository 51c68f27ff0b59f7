"""The commands `flatpunch correct` and `flatpunch compare`: reported moduli and published formulas against the exact contact."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from flatpunch._support.paths import Plain
from flatpunch.cli.terminal import (
    CaseFile,
    PlotOption,
    ResultOption,
    StyleOption,
    command,
    drawn,
    say,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    import xarray as xr


@command("correct")
def correct(
    case: CaseFile,
    reported: Annotated[str | None, typer.Option(help="Young's modulus that was reported, '8 kPa'.")] = None,
    depth: Annotated[str | None, typer.Option(help="Depth of that fit, '300 nm'.")] = None,
    model: Annotated[str | None, typer.Option(help="hertz, sneddon, flat, bilodeau, rico or oliver-pharr.")] = None,
    poisson: Annotated[float | None, typer.Option(help="Poisson ratio that was assumed there.")] = None,
    over: Annotated[
        Literal["curve", "depth"] | None,
        typer.Option(help="'curve' (default) if the curve was fitted, 'depth' if the force at the depth."),
    ] = None,
    output: ResultOption = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """From a reported half-space modulus to the true modulus of the layer.

    Of Berkovich tips and area functions, or with --model oliver-pharr, the modulus is one after Oliver and Pharr, and --depth
    is the contact depth.

    The case file describes layers, base and indenter; the modulus of its top layer does not matter. What was reported is
    given here, or in a table [bold]correct[/bold] of the case file: reported, depth, model, poisson, over. Beside the
    result are those of published corrections.
    """
    from flatpunch.files import units
    from flatpunch.fits.case import read_fit_case
    from flatpunch.fits.half_space.correction import correct as corrected

    options: Plain = {"reported": reported, "depth": depth, "model": model, "reported_poisson": poisson, "over": over}
    given = {name: value for name, value in options.items() if value is not None}
    loaded = read_fit_case(case)
    for name, dimension in (("reported", units.PRESSURE), ("depth", units.LENGTH)):
        if name in given:
            given[name] = units.named_si(f"--{name}", given[name], dimension)
        elif name not in loaded.correct:
            raise ValueError(f"--{name} is missing; give it, or a table [correct] in {case} with reported and depth.")
    arguments = {**loaded.correct, **given}
    found = corrected(medium=loaded.medium, indenter=loaded.indenter, method=loaded.settings.method, **arguments)
    say(str(found))

    picture = drawn("fits.pictures:correction_figure", found, title=loaded.title, style=style)
    _write(output, plot, found.dataset, found.to_csv, picture)


@command("compare")
def compare(
    case: CaseFile,
    output: ResultOption = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Compare published thin-layer and substrate formulas with the exact contact of a case.

    Prints the error of each formula at the largest depth, and the largest depths at which it is within 1, 5 and 10 %.
    """
    from flatpunch.files import read_case
    from flatpunch.fits.half_space.formulas import compare_case, comparison_csv, comparison_table

    loaded = read_case(case)
    found = compare_case(loaded)
    table = comparison_table(found)
    left = [i for i in range(len(table.header)) if not 0 < i < 5]
    say_table(loaded.title or "Formulas", table.header, table.rows, table.title, left=left)
    for line in table.notes:
        say(f"Note: {line}")

    picture = drawn("fits.pictures:comparison_figure", found, title=loaded.title, style=style)
    _write(output, plot, lambda: found, lambda: comparison_csv(found), picture)


def _write(
    output: Path | None,
    plot: Path | None,
    dataset: Callable[[], xr.Dataset],
    table: Callable[[], str],
    picture: Callable[[Path], object],
) -> None:
    from flatpunch.files import save
    from flatpunch.files.results import write

    def kept(path: Path) -> Path:
        return save(dataset(), path) if path.suffix.lower() == ".nc" else write(path, table().encode("utf-8"))

    write_all((output, kept), (plot, picture))
