"""Commands `flatpunch fit`, `flatpunch correct` and `flatpunch nanite-model`.

The command line adds them with `add_commands`. Heavy imports happen inside the commands.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flatpunch._support.reading import is_folder
from flatpunch._support.whole_file import check_target
from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import PICTURES, StyleOption, friendly, progress, say, say_written

if TYPE_CHECKING:
    from flatpunch.fit.batch import Batch
    from flatpunch.fit.case import FitCase

CurveFile = Annotated[
    Path, typer.Argument(metavar="CURVE", help="Measured curve, force map, or a folder of them.", show_default=False)
]
FitCaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file of the fit.", show_default=False)]


def add_commands(app: typer.Typer) -> None:
    """Register the commands on the command line."""

    @app.command(epilog=examples("fit"))
    def fit(
        curve: CurveFile,
        case: Annotated[
            Path | None,
            typer.Argument(metavar="[CASE.toml]", help="Case file of the fit; alone if it names its curves itself."),
        ] = None,
        output: Annotated[Path | None, typer.Option("--output", "-o", help="Table (.csv) or result (.nc).")] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
        drift: Annotated[
            Path | None, typer.Option(help="Picture of the modulus over the fitted depth, beside a half-space model's.")
        ] = None,
        profile: Annotated[
            bool, typer.Option("--profile", help="Intervals from the likelihood profile as well.")
        ] = False,
        posterior: Annotated[
            Path | None,
            typer.Option(help="Draw from the posterior: corner picture (.png, .pdf, .svg), or the draws (.nc, .csv)."),
        ] = None,
        workers: Annotated[int | None, typer.Option(help="Processes for a folder.")] = None,
        resume: Annotated[
            bool,
            typer.Option(
                "--resume/--fresh", help="Use the curves that an interrupted run has fitted, or fit all again."
            ),
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
        with friendly():
            check_target("--output", output, (".csv", ".nc"))
            check_target("--plot", plot, PICTURES)
            check_target("--drift", drift, PICTURES)
            check_target("--posterior", posterior, (*PICTURES, ".nc", ".csv"))
            from flatpunch.fit.case import read_fit_case

            _check_order(curve, case)
            loaded = read_fit_case(curve if case is None else case)
            if case is None or loaded.curves:
                _check_alone(curve, case, loaded, drift)
                _fit_together(loaded, output, plot, profile, posterior, style)
            elif is_folder(curve) or _many(curve, loaded):
                if drift is not None or profile or posterior is not None:
                    raise ValueError("--drift, --profile and --posterior go with a single curve.")
                _fit_folder(curve, loaded, output, plot, workers, style, resume)
            else:
                _fit_one(curve, loaded, output, plot, drift, profile, posterior, style)

    @app.command("fit-film", epilog=examples("fit-film"))
    def fit_film(
        curve: CurveFile,
        case: FitCaseFile,
        output: Annotated[Path | None, typer.Option("--output", "-o", help="Table of the points (.csv).")] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
        style: StyleOption = "screen",
    ) -> None:
        """Fit a hard film to contact stiffness: continuous stiffness (CSM), or the unloading of load cycles.

        The modulus of film or substrate is written [bold]{ fit = ... }[/bold] in the case file; a table [bold]film[/bold] has the
        tip's area_coefficients (nm; a workbook's own if left out), beta, epsilon, frame, fit_frame, depth_min, depth_max.
        """
        with friendly():
            check_target("--output", output, (".csv",))
            check_target("--plot", plot, PICTURES)
            _check_order(curve, case)
            _fit_film(curve, case, output, plot, style)

    @app.command("nanite-model", epilog=examples("nanite-model"))
    def nanite_model(
        case: FitCaseFile,
        output: Annotated[Path, typer.Option("--output", "-o", help="Python module to write, model_thin_gel.py.")],
    ) -> None:
        """Write a case as a model file for nanite and PyJibe.

        Load it there as a user-defined model; flatpunch must be installed in that environment.
        """
        with friendly():
            check_target("--output", output, (".py",))
            from flatpunch.fit.case import read_fit_case
            from flatpunch.fit.half_space.nanite_model import write_nanite_model

            loaded = read_fit_case(case)
            method = loaded.settings.method
            say_written([write_nanite_model(output, loaded.medium, loaded.indenter, title=loaded.title, method=method)])


def _check_order(curve: Path, case: Path | None) -> None:
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
    from flatpunch.fit.case import read_measured
    from flatpunch.fit.together import fit_together

    shared = {name: free for name, free in case.free.items() if name not in case.own}
    own = {name: case.free[name] for name in case.own}
    settings = {name: value for name, value in case.arguments.items() if name != "engine"}
    result = fit_together(read_measured(case), case.medium, case.indenter, shared, own, **settings)
    say(result.summary())
    if profile:
        _say_profiles(result, result.shared)
    written = [_posterior(result, case, posterior, style)] if posterior is not None else []
    if output is not None:
        if output.suffix.lower() != ".csv":
            raise ValueError(f"--output {output}: the table of a joint fit is kept as .csv.")
        written.append(result.save(output))
    if plot is not None:
        from flatpunch.fit.pictures import together_figure
        from flatpunch.plots.result import save_figure

        written.append(save_figure(together_figure(result, style=style), plot))
    say_written(written)


def _say_profiles(result: Any, names: Any) -> None:
    from flatpunch.fit.report.quantities import label, quantity, unit_of

    for name in names:
        found = result.profile(name)
        unit = unit_of(name)
        say(f"  {label(name):<24} profile: {quantity(found.low, unit)} .. {quantity(found.high, unit)}")


def _posterior(result: Any, case: FitCase, path: Path, style: str) -> Path:
    """Draw from the posterior, print its summary and write a picture of it or the draws."""
    with progress("Posterior", 1) as step:
        found = result.posterior(
            priors=case.priors,
            progress=lambda done, total: step(f"step {done} of about {total}", advance=0),
            **case.posterior,
        )
    say(found.summary())
    if path.suffix.lower() in (".nc", ".csv"):
        return Path(found.save(path))
    from flatpunch.fit.posterior_picture import posterior_figure
    from flatpunch.plots.result import save_figure

    return save_figure(posterior_figure(found, style=style), path)


def _many(path: Path, case: FitCase) -> bool:
    """Whether a file holds more than one curve."""
    from flatpunch.fit.measured.readers import curves_in

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
    from flatpunch.fit.batch import Batch
    from flatpunch.fit.fitting import fit
    from flatpunch.fit.measured.readers import read_curve

    curve = read_curve(path, **case.reading)
    result = fit(curve, case.medium, case.indenter, case.free, **case.arguments)
    say(result.summary())
    if profile:
        _say_profiles(result, result.objective.model.free)
    written = [_posterior(result, case, posterior, style)] if posterior is not None else []
    if output is not None:
        if output.suffix.lower() == ".csv":
            written.append(Batch((result.row(),)).save(output))
        else:
            from flatpunch.files.results import save

            written.append(save(result.dataset(), output))
    if plot is not None:
        from flatpunch.fit.pictures import fit_figure
        from flatpunch.plots.result import save_figure

        written.append(save_figure(fit_figure(result, style=style), plot))
    if drift is not None:
        written.append(_drift(curve, case, drift, style))
    say_written(written)


def _drift(curve: Any, case: FitCase, path: Path, style: str) -> Path:
    """Draw the modulus over the largest fitted depth, beside that of a half-space."""
    from flatpunch.fit.case import DRIFTING, drift
    from flatpunch.fit.pictures import drift_figure
    from flatpunch.plots.result import save_figure

    layered, bulk = drift(curve, case)
    return save_figure(drift_figure(layered, DRIFTING, bulk, "base.young", style=style), path)


def _fit_folder(
    folder: Path, case: FitCase, output: Path | None, plot: Path | None, workers: int | None, style: str, resume: bool
) -> None:
    from dataclasses import replace

    from flatpunch.fit.batch import Batch, fit_rows
    from flatpunch.fit.places import files_in, listed
    from flatpunch.fit.records import Records

    items = listed(files_in(folder) if is_folder(folder) else [folder], case.reading)
    settings = replace(case.settings, engine="normal-equations")
    records = Records(output.with_suffix(".records")) if output is not None else None
    if records is not None and not resume:
        records.known.clear()
    before = len(records.known) if records is not None else 0
    rows: list[Any] = []
    try:
        with progress("Fitting", len(items)) as step:
            for done in fit_rows(items, case.sample, case.free, settings, case.reading, workers, records):
                rows.extend(done)
                step(f"{len(rows)} of {len(items)}", len(done))
    except KeyboardInterrupt:
        # fits that are finished are kept in the table
        if output is not None and records is not None and rows:
            Batch(tuple(rows)).save(output)
            say(
                f"Interrupted after {len(rows)} of {len(items)} curves; these are in {output}. The same command goes on from "
                f"there with the help of {records.path}."
            )
        raise
    if before and records is not None:
        say(f"{records.reused} of {len(items)} curves were fitted by an earlier run ({records.path})")
    batch = Batch(tuple(rows))
    _say_batch(batch, case)
    written = [batch.save(output)] if output is not None else []
    if records is not None:
        records.remove()
    if plot is not None and case.free:
        from flatpunch.fit.batch_pictures import map_figure
        from flatpunch.plots.result import save_figure

        written.append(save_figure(map_figure(batch, next(iter(case.free)), style=style), plot))
    say_written(written)
    if len(batch.failed) == len(batch.rows):
        raise ValueError("no curve could be fitted.")


def _say_batch(batch: Batch, case: FitCase) -> None:
    """Print how many curves count, the median of each parameter, and why the others are left out."""
    import numpy as np

    from flatpunch.fit.report.quantities import label, quantity, unit_of

    say(f"{len(batch.rows) - len(batch.failed)} of {len(batch.rows)} curves fitted")
    for name in case.free:
        values = batch.trusted(name)
        if np.isfinite(values).any():
            low, high = (quantity(float(v), unit_of(name)) for v in np.nanpercentile(values, [16, 84]))
            median = batch.median(name)
            middle, *ends = (quantity(v, unit_of(name)) for v in (median.value, median.low, median.high))
            within = f" (95 % in {ends[0]} .. {ends[1]})" if np.isfinite(median.low) else ""
            say(f"  {label(name):<20} median {middle}{within}, middle two thirds {low} .. {high}")
    for row in batch.failed:
        say(f"  {row['reason']}")


def _fit_film(path: Path, case: Path, output: Path | None, plot: Path | None, style: str) -> None:
    import csv
    import io

    from flatpunch._support.whole_file import whole_file
    from flatpunch.fit.case import read_fit_case
    from flatpunch.fit.films.film import fit_film
    from flatpunch.fit.films.measured import film_curves, film_tip

    loaded = read_fit_case(case)
    film = dict(loaded.film)
    tip = film_tip(path, film)
    names = [*(loaded.free or ()), *(["frame"] if film.get("fit_frame") else [])] or None
    written: list[Path] = []
    curves = film_curves(path, loaded.reading)
    for number, curve in enumerate(curves):
        result = fit_film(
            curve,
            loaded.medium,
            tip,
            names,
            depths=film.get("depths", (0.0, float("inf"))),
            frame=film.get("frame", 0.0),
        )
        for line in curve.meta.get("read", ()):
            say(f"Read {line}")
        say(f"{curve.name}: {result.summary()}")
        stem = "" if len(curves) == 1 else f"-{number + 1}"
        if plot is not None:
            from flatpunch.fit.pictures import film_figure
            from flatpunch.plots.result import save_figure

            written.append(save_figure(film_figure(result, style=style), plot.with_stem(plot.stem + stem)))
        if output is not None:
            text = io.StringIO()
            table = csv.writer(text)
            table.writerow(
                ["depth [m]", "contact depth [m]", "contact radius [m]", "apparent modulus [Pa]", "fitted modulus [Pa]"]
            )
            points = result.points
            table.writerows(
                zip(points.depth, points.contact_depth, points.radius, points.apparent, result.model, strict=True)
            )
            target = output.with_stem(output.stem + stem)
            with whole_file(target) as temporary:
                temporary.write_text(text.getvalue(), encoding="utf-8")
            written.append(target)
    say_written(written)
