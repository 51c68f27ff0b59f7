"""Commands that solve a case for more than its curve: `flatpunch stress`, `slip`, `rough` and `design`.

Fields of the last step of a case and its first failure; partial slip at that step; contact of a rough surface, or of asperities;
and numbers of a case that give a prescribed contact or the largest load.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch._support.endings import FIELDS, MAPS, RESULTS, listed
from flatpunch.cli.terminal import (
    CaseFile,
    NetCDFOption,
    Output,
    PlotOption,
    ResultOption,
    StyleOption,
    command,
    drawn,
    progress,
    say,
    say_notes,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from flatpunch.contact import Method
    from flatpunch.designs import Design
    from flatpunch.files import Case
    from flatpunch.files.analyses import Stresses
    from flatpunch.files.rough import RoughCase


@command("stress")
def stress(
    case: CaseFile,
    output: NetCDFOption = None,
    csv: Annotated[Path | None, typer.Option(help="Table of the points as CSV."), Output((".csv",))] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Compute the stresses inside the body at the last step of a case, and the load of its first failure.

    A table [bold]stress[/bold] of the case file names points, friction, residual stresses and strengths; without it
    the section y = 0 is shown.
    """
    from flatpunch.files import read_case, save
    from flatpunch.files.analyses import stress_csv, stresses
    from flatpunch.files.results import write

    read = read_case(case)
    with progress(read.title or "Stress", 1) as step:
        step("solving")
        found = stresses(read)
    _print_stress(read, found)
    about = {"strengths": found.strengths, "title": read.title, "style": style}
    write_all(
        (output, lambda path: save(found.fields, path)),
        (csv, lambda path: write(path, stress_csv(found.fields).encode("utf-8"))),
        (plot, drawn("plots.fields:figure", found.fields, read.medium, read.indenter, found.contact, **about)),
    )


def _print_stress(case: Case, found: Stresses) -> None:
    from flatpunch.files.analyses import STRESS_COLUMNS, first_failure_lines, load_lines, stress_rows
    from flatpunch.files.units import text

    attrs = found.fields.attrs
    title = f"{case.title or 'Stress'}: force {text(attrs['force'], 'N')}, depth {text(attrs['depth'], 'm')}"
    if found.peaks is not None:
        about = f"friction {attrs['friction']:g}, method {attrs['method']}"
        say_table(title, STRESS_COLUMNS, stress_rows(found), about)
    else:
        adhesive = case.physics.work_of_adhesion is not None
        why = "infinite at the rim of an adhesive contact" if adhesive else "not searched under this tip"
        say(f"{title}. Largest stresses are {why}; see the points of the result.")
    say(f"Estimated error of stresses: {attrs['stress_error']:.1g} of the size of the pressure.")
    for line in first_failure_lines(found.first) if found.first is not None else ():
        say(line)
    for line in load_lines(found.loads) if found.loads is not None else ():
        say(line)
    say_notes(str(attrs.get("notes", "")).splitlines())


@command("slip")
def slip(case: CaseFile, output: ResultOption = None, plot: PlotOption = None, style: StyleOption = "screen") -> None:
    """Pull the pressed tip of a case along the surface: it sticks in the middle and slips around.

    A table [bold]slip[/bold] of the case file gives the friction and, if wanted, tangential forces, displacements or stick radii;
    the normal force is that of the last step. The picture shows the first loading and the cycle of the largest displacement.
    """
    from flatpunch.files import read_case, save
    from flatpunch.files.analyses import slipping
    from flatpunch.files.descriptions import curve_table

    read = read_case(case)
    with progress(read.title or "Slip", 1) as step:
        step("solving")
        result = slipping(read)
    shown = curve_table(result)
    headings = [f"{name} {unit}".replace(" ", "\n") for name, unit in shown.columns]
    say_table(read.title, headings, shown.rows, shown.caption)
    say_notes(str(result.attrs["notes"]).splitlines())
    write_all(
        (output, lambda path: save(result, path)),
        (plot, drawn("plots.result:figure", result, read.medium, read.indenter, title=read.title, style=style)),
    )


_SURFACE = {
    "mean_pressure": "Pa",
    "depth": "m",
    "area_fraction_corrected": "%",
    "mean_gap": "m",
    "gap_stiffness": "N/m",
    "patches": "",
}
_ASPERITIES = {"depth": "m", "force": "N", "stiffness": "N/m", "contacts": "", "gap": "m"}


@command("rough")
def rough(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help=f"All steps: {listed(RESULTS)}; maps of a surface at the last step: {listed(FIELDS | MAPS)}.",
        ),
        Output((*RESULTS, *FIELDS, *MAPS)),
    ] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Press a rough surface, or asperities at given places, into a body.

    A table [bold]surface[/bold] describes a random or measured surface, a table [bold]asperities[/bold] tips and their
    places. Maps are pressure, gap and displacement of each cell; the picture shows the area in contact beside theories, and the
    pressure, gap and patches of the last step.
    """
    from flatpunch.files import save
    from flatpunch.files.rough import read_rough_case
    from flatpunch.plots.result import save_figure

    read = read_rough_case(case)
    maps = output is not None and output.suffix.lower() not in RESULTS
    if output is not None and maps:
        _check_maps(read, output)
    last = functools.cache(functools.partial(read.solve, last=True))
    with progress(read.title or "Rough contact", 1) as step:
        step("solving")
        result = read.solve()
    _print_rough(read, result)
    write_all(
        (output, lambda path: save(last() if maps else result, path)),
        (plot, lambda path: save_figure(_rough_figure(read, result, last, style), path)),
    )


def _check_maps(case: RoughCase, output: Path) -> None:
    """Refuse maps of asperities, and files without their library, before anything is solved."""
    from flatpunch.files.exports import check_library

    if case.surface is None:
        raise ValueError(f"--output {output}: asperities have no maps; the ending must be {listed(RESULTS)}.")
    if (kind := output.suffix.lower()) in FIELDS:
        check_library(kind)


def _rough_figure(case: RoughCase, result: xr.Dataset, last: Callable[[], xr.Dataset], style: str) -> Figure:
    from flatpunch.plots.rough import asperities_figure, rough_figure
    from flatpunch.rough import rough_theories

    if case.surface is None:
        assert case.asperities is not None
        return asperities_figure(result, case.asperities[1], title=case.title, style=style)
    theories = rough_theories(result, case.medium, case.surface) if all(case.surface.periodic) else None
    return rough_figure(result, last(), theories, title=case.title, style=style)


def _print_rough(case: RoughCase, result: xr.Dataset) -> None:
    import numpy as np

    from flatpunch.plots.style import scale_of

    columns = _SURFACE if case.surface is not None else _ASPERITIES
    titles, shown = [], []
    for name, unit in columns.items():
        values = result[name].values
        if not np.isfinite(values).any():
            continue
        factor, printed = (100.0, "%") if unit == "%" else scale_of(values, unit) if unit else (1.0, "")
        titles.append(f"{name.removesuffix('_corrected').replace('_', ' ')}\n{printed}")
        shown.append([f"{value:.4g}" for value in values * factor])
    say_table(case.title, titles, list(zip(*shown, strict=True)), "")
    say_notes(str(result.attrs["notes"]).splitlines())


@command("design")
def design(
    case: CaseFile,
    csv: Annotated[Path | None, typer.Option(help="Table of the numbers found as CSV."), Output((".csv",))] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Find the numbers of a case that give what its table [bold]design[/bold] prescribes.

    A force, depth, stiffness or contact radius, at one load or along a curve; or the largest load before failure.
    """
    from flatpunch.designs import design
    from flatpunch.files import read_case

    read = read_case(case)
    asked = read.design
    if asked is None:
        raise ValueError("the case has no table [design]; it names what to vary and what is prescribed.")
    with progress(read.title or "Design", asked.starts) as step:
        found = design(
            read.medium,
            read.indenter,
            vary=asked.vary,
            objective=asked.objective,
            limits=asked.limits,
            starts=asked.starts,
            method=None if read.indenter.round else _method(read),
            progress=lambda done, total: step(f"start {done} of {total}"),
        )
    _print_design(read.title, found)
    picture = drawn("plots.sensitivity:design_figure", found, title=read.title, style=style)
    write_all((csv, lambda path: _design_table(found, path)), (plot, picture))


def _method(case: Case) -> Method | None:
    """All but the refined method have derivatives under tips that are not round."""
    from flatpunch.contact import method_of

    chosen = None if case.method is None else method_of(case.method)
    return None if chosen is None or chosen.name == "refined" else chosen


def _design_table(found: Design, path: Path) -> None:
    """Write a line for each varied number, SI."""
    import pandas as pd

    from flatpunch._support.whole_file import write_whole

    columns = ["name", "unit", "start", "found", "low", "high", "at_bound"]
    rows = [[getattr(each, column) for column in columns] for each in found.values]
    write_whole(path, pd.DataFrame(rows, columns=columns).to_csv(index=False, lineterminator="\n").encode())


def _print_design(title: str, found: Design) -> None:
    from flatpunch.designs.statement import UNITS

    rows = []
    for each in found.values:
        start, value, low, high = (_written(n, each.unit) for n in (each.start, each.found, each.low, each.high))
        bound = {"low": "lower bound", "high": "upper bound"}.get(each.at_bound, "")
        rows.append((each.name, start, value, f"{low} to {high}", bound))
    headings = ("number", "start", "found", "bounds", "at")
    say_table(title or "Design", headings, rows, f"{found.evaluations} contacts solved", left=(0, 4))
    if not found.control:
        before, after = (_written(float(each[0]), "N") for each in (found.before, found.achieved))
        say(f"Critical load {after}, before the design {before}.")
    else:
        unit, at = UNITS[found.quantity], UNITS[found.control]
        for place, *numbers in zip(found.at, found.achieved, found.wanted, found.before, strict=True):
            achieved, wanted, before = (_written(float(each), unit) for each in numbers)
            where = f"{found.quantity} at {found.control} {_written(float(place), at)}"
            say(f"{where}: {achieved}, prescribed {wanted}, before {before}")
    say_notes(found.notes)


def _written(value: float, unit: str) -> str:
    from flatpunch.files.units import text

    if unit == "rad":
        return f"{math.degrees(value):.4g} deg"
    return text(value, unit) if unit in ("m", "Pa", "N", "N/m") else f"{value:.4g} {unit}".rstrip()
