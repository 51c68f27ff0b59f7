"""The command `flatpunch fit-film`: hard films by their contact stiffness."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch._support.whole_file import check_target
from flatpunch.cli.fit import CurveFile, FitCaseFile, check_order
from flatpunch.cli.terminal import (
    Output,
    PlotOption,
    StyleOption,
    command,
    drawn,
    say,
    write_all,
)

if TYPE_CHECKING:
    from flatpunch.fits.films.film import FilmResult


@command("fit-film")
def fit_film(
    curve: CurveFile,
    case: FitCaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Table of the points (.csv)."), Output((".csv",))
    ] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Fit a hard film to contact stiffness: continuous stiffness (CSM), or the unloading of load cycles.

    The modulus of film or substrate is written [bold]{ fit = ... }[/bold] in the case file; a table [bold]film[/bold] has the
    tip's area_coefficients (nm; a workbook's own if left out), beta, epsilon, frame, fit_frame, imprint, fit_imprint, depth_min,
    depth_max.
    """
    check_order(curve, case)
    from flatpunch.fits.case import read_fit_case
    from flatpunch.fits.films.film import fit_film as fit_film_to
    from flatpunch.fits.films.unloading import film_curves, film_tip
    from flatpunch.fits.measured.curve import CurveError

    loaded = read_fit_case(case)
    film = dict(loaded.film)
    tip = film_tip(curve, film)
    beside = [name for name in ("frame", "imprint") if film.get(f"fit_{name}")]
    names = [*(loaded.free or ()), *beside] or None
    curves = film_curves(curve, loaded.reading)
    tables, pictures = (_numbered(*given, len(curves)) for given in (("--output", output), ("--plot", plot)))
    wanted: list[tuple[Path | None, Callable[[Path], object]]] = []
    failed = []
    try:
        for test, table, picture in zip(curves, tables, pictures, strict=True):
            try:
                result = fit_film_to(
                    test,
                    loaded.medium,
                    tip,
                    names,
                    depths=film.get("depths", (0.0, float("inf"))),
                    frame=film.get("frame", 0.0),
                    imprint=film.get("imprint", 0.0),
                )
            except CurveError as error:
                # one bad test costs one test
                failed.append(str(error))
                if len(failed) == len(curves):
                    raise
                continue
            for line in test.meta.get("read", ()):
                say(f"Read {line}")
            say(str(result))
            wanted += [
                (picture, drawn("fits.pictures:film_figure", result, style=style)),
                (table, partial(_film_table, result)),
            ]
        for reason in failed:
            say(f"Left out: {reason}")
    finally:
        write_all(*wanted)


def _numbered(option: str, path: Path | None, count: int) -> list[Path | None]:
    """Files of several tests, numbered from 1; those replace nothing."""
    if path is None or count == 1:
        return [path] * count
    found = [path.with_stem(f"{path.stem}-{number + 1}") for number in range(count)]
    for each in found:
        check_target(option, each, (path.suffix.lower(),), chosen=True)
    return [*found]


def _film_table(result: FilmResult, path: Path) -> None:
    from flatpunch._support.whole_file import write_whole
    from flatpunch.fits.report.table import csv_of

    points = result.points
    columns = {
        "depth": points.depth,
        "contact depth": points.contact_depth,
        "contact radius": points.radius,
        "apparent modulus": points.apparent,
        "fitted modulus": result.model,
    }
    units = {name: "Pa" if name.endswith("modulus") else "m" for name in columns}
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    write_whole(path, csv_of([dict(zip(columns, row, strict=True)) for row in rows], units).encode())
