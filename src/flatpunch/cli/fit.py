"""Commands for measured curves: `flatpunch fit` and `read`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch._support.paths import Plain
from flatpunch._support.reading import is_folder
from flatpunch.cli.terminal import (
    PICTURES,
    Output,
    PlotOption,
    StyleOption,
    command,
    drawn,
    progress,
    say,
    write_all,
)

if TYPE_CHECKING:
    from flatpunch.fits.batch import Batch
    from flatpunch.fits.case import FitCase
    from flatpunch.fits.measured.curve import Curve
    from flatpunch.fits.report.result import FitResult

CurveFile = Annotated[
    Path, typer.Argument(metavar="CURVE", help="Measured curve, force map, or a folder of them.", show_default=False)
]
FitCaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file of the fit.", show_default=False)]


@command("fit")
def fit(
    curve: CurveFile,
    case: Annotated[
        Path | None,
        typer.Argument(metavar="[CASE.toml]", help="Case file of the fit; alone if it names its curves itself."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Table (.csv) or result (.nc)."), Output((".csv", ".nc"))
    ] = None,
    plot: PlotOption = None,
    drift: Annotated[
        Path | None,
        typer.Option(help="Picture of the modulus over the fitted depth, beside a half-space model's."),
        Output(PICTURES),
    ] = None,
    profile: Annotated[bool, typer.Option("--profile", help="Intervals from the likelihood profile as well.")] = False,
    posterior: Annotated[
        Path | None,
        typer.Option(help="Draw from the posterior: corner picture (.png, .pdf, .svg), or the draws (.nc, .csv)."),
        Output((*PICTURES, ".nc", ".csv")),
    ] = None,
    values: Annotated[
        Path | None,
        typer.Option(
            help="Known values of each curve of a folder or map: CSV with the line curve,NAME [UNIT] on top, such as "
            "curve,layers\\[0].thickness \\[nm]."
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Processes for a folder.")] = None,
    resume: Annotated[
        bool,
        typer.Option("--resume/--fresh", help="Use the curves that an interrupted run has fitted, or fit all again."),
    ] = True,
    style: StyleOption = "screen",
) -> None:
    """Fit a case to a measured curve, or to every curve in a folder.

    In the case file, what is looked for is written [bold]young = { fit = "5 kPa", min = "1 kPa", max = "50 kPa" }[/bold];
    start, and limits if there are any. The contact point and the baseline are fitted with the rest. With
    [bold]work_of_adhesion[/bold] the retract of a sticking tip is fitted, with a table for relaxation the force over time.

    A case file with tables [bold]curves[/bold] is fitted to all of these together, one sample: give it alone.

    With an output, records of a folder or map are kept beside it (table.records) until all curves are done: after an
    interruption the same command goes on from there. Curves or a case that have changed are fitted again.
    """
    from flatpunch.fits.case import check_draws, read_fit_case

    check_order(curve, case)
    loaded = read_fit_case(curve if case is None else case)
    if posterior is not None:
        check_draws(loaded)
    if case is None or loaded.curves:
        _check_alone(curve, case, loaded, drift)
        _fit_together(loaded, output, plot, profile, posterior, style)
    elif is_folder(curve) or _many(curve, loaded):
        if drift is not None or profile or posterior is not None:
            raise ValueError("--drift, --profile and --posterior go with a single curve.")
        _fit_folder(curve, loaded, values, output, plot, workers, style, resume)
    else:
        _fit_one(curve, loaded, output, plot, drift, profile, posterior, style)


@command("read")
def read(
    curve: CurveFile,
    case: Annotated[
        Path | None,
        typer.Argument(metavar="[CASE.toml]", help="Case file of the fit: how to read, what is fitted."),
    ] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Show how a measured curve is read, or each of a folder or a map, before any fit.

    Columns, units and calibration with their origin, which way the tip goes, approach, hold and retract, the baseline, where
    the contact begins, and what a fit leaves out or why it refuses the curve.
    """
    check_order(curve, case)
    from flatpunch.fits.case import read_fit_case
    from flatpunch.fits.measured.curve import CurveError
    from flatpunch.fits.places import listed_in

    loaded = None if case is None else read_fit_case(case)
    reading = {} if loaded is None else loaded.reading
    places = listed_in(curve, reading)
    if plot is not None and len(places) > 1:
        raise ValueError(f"--plot goes with a single curve; {curve} holds {len(places)}.")
    if len(places) == 1:
        measured = places[0].read(reading)
        say(_read(measured, loaded))
        write_all((plot, drawn("fits.reading:measured_figure", measured, loaded, style=style)))
        return
    for place in places:
        try:
            say(_read(place.read(reading), loaded))
        except CurveError as error:
            say(f"{place.name}\n  not read: {error}")


def _read(curve: Curve, case: FitCase | None) -> str:
    from flatpunch.fits.reading import reading_of

    return "\n".join((curve.name, *(f"  {line}" for line in reading_of(curve, case).lines)))


def _announce(case: FitCase) -> None:
    """Say before a fit that it takes minutes."""
    from flatpunch.files.descriptions import duration
    from flatpunch.fits.description import seconds_of

    if (seconds := seconds_of(case)) >= 60:
        typer.echo(f"This fit takes {duration(seconds)}.", err=True)


def check_order(curve: Path, case: Path | None) -> None:
    """Refuse the case file in the place of the curve."""
    if case is not None and curve.suffix == ".toml" and case.suffix != ".toml":
        raise ValueError(f"{curve}: this is the case file; give the curve before it: {case} {curve}.")


def _check_alone(curve: Path, case: Path | None, loaded: FitCase, drift: Path | None) -> None:
    if not loaded.curves:
        raise ValueError(f"{curve}: the case names no curves (tables [[curves]]); give the curve before the case file.")
    if case is not None:
        raise ValueError(f"{case}: the case names its own curves; leave {curve} out.")
    if drift is not None:
        raise ValueError("--drift goes with a single curve.")


def _fit_together(
    case: FitCase, output: Path | None, plot: Path | None, profile: bool, posterior: Path | None, style: str
) -> None:
    from flatpunch.fits.case import read_measured
    from flatpunch.fits.together import fit_together

    if output is not None and output.suffix.lower() != ".csv":
        raise ValueError(f"--output {output}: the table of a joint fit is kept as .csv.")
    shared = {name: free for name, free in case.free.items() if name not in case.own}
    own = {name: case.free[name] for name in case.own}
    settings = {name: value for name, value in case.arguments.items() if name != "quick"}
    _announce(case)
    result = fit_together(read_measured(case), case.medium, case.indenter, shared, own, **settings)
    _finish(result, case, output, plot, profile, posterior, style)


def _finish(
    result: FitResult,
    case: FitCase,
    output: Path | None,
    plot: Path | None,
    profile: bool,
    posterior: Path | None,
    style: str,
    *more: tuple[Path | None, Callable[[Path], object]],
) -> None:
    """Print a fit and write what was asked for."""
    say(result.summary())
    if profile:
        _say_profiles(result)
    write_all(
        (output, result.save),
        (plot, drawn("fits.pictures:fit_figure", result, style=style)),
        (posterior, lambda path: _posterior(result, case, path, style)),
        *more,
        bar=False,
    )


def _say_profiles(result: FitResult) -> None:
    from flatpunch._support.prefixes import text
    from flatpunch.fits.report.table import label, unit_of

    for name in result.shared:
        found = result.profile(name)
        number = result.problem.numbers[name]
        unit = unit_of(number)
        say(f"  {label(number):<24} profile: {text(found.low, unit)} .. {text(found.high, unit)}")


def _posterior(result: FitResult, case: FitCase, path: Path, style: str) -> None:
    """Draw from the posterior, print its summary and write a picture of it or the draws."""
    with progress("Posterior", 1) as step:
        found = result.posterior(
            priors=case.priors,
            progress=lambda done, total: step(f"step {done} of about {total}", advance=0),
            **case.posterior,
        )
    say(found.summary())
    if path.suffix.lower() in (".nc", ".csv"):
        found.save(path)
    else:
        drawn("fits.distributions:posterior_figure", found, style=style)(path)


def _many(path: Path, case: FitCase) -> bool:
    """Whether a file holds more than one curve."""
    from flatpunch.fits.measured.files.readers import curves_in

    return case.reading.get("index") is None and curves_in(path, **case.reading) > 1


def _fit_one(
    path: Path,
    case: FitCase,
    output: Path | None,
    plot: Path | None,
    drift: Path | None,
    profile: bool,
    posterior: Path | None,
    style: str,
) -> None:
    from flatpunch._support.progress import listening
    from flatpunch.fits.fitting import fit
    from flatpunch.fits.measured.curve import CurveError
    from flatpunch.fits.measured.files.readers import read_curve

    curve = read_curve(path, **case.reading)
    _announce(case)
    try:
        with progress("Fitting", 1) as step:
            step(curve.name)
            with listening(lambda done, total: step(f"{done} force curves solved", advance=0)):
                result = fit(curve, case.medium, case.indenter, case.free, **case.arguments)
    except CurveError:
        from flatpunch.fits.reading import reading_of

        say("\n".join(line for line in reading_of(curve, case).lines if not line.startswith("refused")))
        raise
    more = drift, lambda path: _drift(curve, case, path, style)
    _finish(result, case, output, plot, profile, posterior, style, more)


def _drift(curve: Curve, case: FitCase, path: Path, style: str) -> None:
    """Draw the modulus over the largest fitted depth, beside that of a half-space."""
    from flatpunch.fits.case import DRIFTING, drift

    layered, bulk = drift(curve, case)
    drawn("fits.pictures:drift_figure", layered, DRIFTING, bulk, "base.young", style=style)(path)


def _fit_folder(
    folder: Path,
    case: FitCase,
    values: Path | None,
    output: Path | None,
    plot: Path | None,
    workers: int | None,
    style: str,
    resume: bool,
) -> None:
    from dataclasses import replace

    from flatpunch.fits.batch import Batch, fit_rows, placed
    from flatpunch.fits.places import Records, listed_in, values_in

    items = listed_in(folder, case.reading)
    known = {} if values is None else values_in(values, items, case.sample.numbers)
    places = placed(items, known, case.sample, case.free)
    settings = replace(case.settings, quick=True)
    records = Records(output.with_suffix(".records")) if output is not None else None
    if records is not None and not resume:
        records.known.clear()
    before = len(records.known) if records is not None else 0
    rows: list[Plain] = []
    try:
        with progress("Fitting", len(items)) as step:
            for done in fit_rows(places, case.sample, case.free, settings, case.reading, workers, records):
                rows.extend(done)
                step(f"{len(rows)} of {len(items)}", len(done))
    except KeyboardInterrupt:
        # fits that are finished are kept in the table
        if output is not None and records is not None and rows:
            Batch(tuple(rows), case.sample.numbers).save(output)
            say(
                f"Interrupted after {len(rows)} of {len(items)} curves; these are in {output}. The same command goes on from "
                f"there with the help of {records.path}."
            )
        raise
    if before and records is not None:
        say(f"{records.reused} of {len(items)} curves were fitted by an earlier run ({records.path})")
    batch = Batch(tuple(rows), case.sample.numbers)
    _say_batch(batch, case)

    def table(path: Path) -> None:
        batch.save(path)
        if records is not None:
            records.remove()

    name = next(iter(case.free), None)
    picture = drawn("fits.distributions:map_figure", batch, name, style=style)
    write_all((output, table), (plot if name else None, picture))
    if len(batch.failed) == len(batch.rows):
        raise ValueError("no curve could be fitted.")


def _say_batch(batch: Batch, case: FitCase) -> None:
    """Print how many curves count, the median of each parameter, and why the others are left out."""
    import numpy as np
    from scipy.special import ndtr

    from flatpunch._support.prefixes import text
    from flatpunch.fits.report.table import label, unit_of

    say(f"{len(batch.rows) - len(batch.failed)} of {len(batch.rows)} curves fitted")
    for name in case.free:
        values, unit = batch.trusted(name), unit_of(batch.number(name))
        if np.isfinite(values).any():
            low, high = (text(float(v), unit) for v in np.nanquantile(values, ndtr([-1, 1])))
            median = batch.median(name)
            middle, *ends = (text(v, unit) for v in (median.value, median.low, median.high))
            within = f" (95 % in {ends[0]} .. {ends[1]})" if np.isfinite(median.low) else ""
            say(f"  {label(batch.number(name)):<20} median {middle}{within}, middle two thirds {low} .. {high}")
    for row in batch.failed:
        say(f"  {row['reason']}")
