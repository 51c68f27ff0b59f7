"""The command `flatpunch stress`: fields of the last step of a case, and its first failure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import friendly, progress, say, say_written

if TYPE_CHECKING:
    import xarray as xr

    from flatpunch.fields import CriticalLoad
    from flatpunch.files import Case


def add_commands(app: typer.Typer) -> None:
    """Register the command on the command line."""

    @app.command(epilog=examples("stress"))
    def stress(
        case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
        output: Annotated[Path | None, typer.Option("--output", "-o", help="Result file: .nc (NetCDF).")] = None,
        csv: Annotated[Path | None, typer.Option(help="Table of the points as CSV.")] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
    ) -> None:
        """Compute the stresses inside the body at the last step of a case, and the load of its first failure.

        A table [bold][[stress]][/bold] of the case file names points, friction, residual stresses and strengths; without it
        the section y = 0 is shown.
        """
        with friendly():
            from flatpunch._support.whole_file import check_target

            check_target("--output", output, (".nc",))
            check_target("--csv", csv, (".csv",))
            check_target("--plot", plot, (".png", ".pdf", ".svg"))
            from flatpunch.files import read_case

            _run(read_case(case), output, csv, plot)


def _run(case: Case, output: Path | None, csv: Path | None, plot: Path | None) -> None:
    import flatpunch as fp
    from flatpunch.files import save
    from flatpunch.files.tables.stress import StressCase

    if case.time is not None:
        raise ValueError(
            "stresses of histories of relaxing bodies are not computed; give a [control] instead of a [history]."
        )
    asked = case.stress or StressCase(None, None, None)
    contact = {case.control: float(case.values[-1]), "method": case.method, **asked.arguments}
    if case.work_of_adhesion is not None:
        contact["work_of_adhesion"] = case.work_of_adhesion
    written: list[Path] = []
    with progress(case.title or "Stress", 1 + sum(path is not None for path in (output, csv, plot))) as step:
        step("solving")
        reach, deep = _extent(case, contact)
        result = fp.fields(case.medium, case.indenter, *asked.points(reach, deep), **contact)
        first = None
        if asked.judged:
            first = fp.critical_load(case.medium, case.indenter, **asked.critical(case.medium))
        if output is not None:
            step(f"writing {output.name}")
            written.append(save(result, output))
        if csv is not None:
            step(f"writing {csv.name}")
            written.append(_table(result, csv))
        if plot is not None:
            step(f"drawing {plot.name}")
            written.append(_draw(case, result, contact, asked.strengths, plot))
    _print(case, result, first)
    say_written(written)


def _extent(case: Case, contact: dict[str, Any]) -> tuple[float, float]:
    """Half-width and depth of the section that is shown where the case names none."""
    import flatpunch as fp
    from flatpunch.media import Medium, RigidBase, underlying

    known = {name: contact[name] for name in (case.control, "method", "work_of_adhesion") if name in contact}
    radius = float(fp.indent(case.medium, case.indenter, **known)["radius"].values[0])
    if not radius > 0:
        raise ValueError(
            "the last step has no contact, so there are no stresses to show. Give a larger depth or force."
        )
    body = underlying(case.medium)
    thickness = body.thickness if isinstance(body, Medium) else 0.0
    deep = max(2.5 * radius, min(1.5 * thickness, 10 * radius))
    if isinstance(body, Medium) and isinstance(body.base, RigidBase):
        deep = min(deep, thickness)
    return 3 * radius, deep


def _draw(case: Case, result: xr.Dataset, contact: dict[str, Any], strengths: Any, plot: Path) -> Path:
    from flatpunch.plots import fields as pictures
    from flatpunch.plots.result import save_figure

    return save_figure(
        pictures.figure(result, case.medium, case.indenter, contact, strengths=strengths, title=case.title), plot
    )


def _table(result: xr.Dataset, path: Path) -> Path:
    """Write a line for each point."""
    import pandas as pd

    from flatpunch._support.whole_file import whole_file

    columns = {f"{name} [m]": result[name].values.ravel() for name in ("x", "y", "z")}
    columns |= {
        f"stress_{name} [Pa]": result["stress"].sel(component=name).values.ravel()
        for name in result["component"].values
    }
    columns |= {
        f"displacement_{name} [m]": result["displacement"].sel(axis=name).values.ravel()
        for name in result["axis"].values
    }
    columns |= {f"{name} [Pa]": result[name].values.ravel() for name in ("von_mises", "max_shear", "hydrostatic")}
    columns["layer"] = result["layer"].values.ravel()
    with whole_file(path) as temporary:
        pd.DataFrame(columns).to_csv(temporary, index=False, lineterminator="\n")
    return path


def _print(case: Case, result: xr.Dataset, first: CriticalLoad | None) -> None:
    import numpy as np
    from rich.table import Table

    from flatpunch.files.units import text

    attrs = result.attrs
    title = f"{case.title or 'Stress'}: force {text(attrs['force'], 'N')}, depth {text(attrs['depth'], 'm')}"
    table = Table(
        title=title, title_justify="left", caption=f"friction {attrs['friction']:g}, method {attrs['method']}"
    )
    for heading in ("layer", "largest von Mises", "at x", "at z", "largest tension", "at x", "at z"):
        table.add_column(heading, justify="right")
    layer = result["layer"].values.ravel()
    x, z = result["x"].values.ravel(), result["z"].values.ravel()
    for i in np.unique(layer):
        here = np.flatnonzero(layer == i)
        row = [str(int(i) + 1)]
        for values in (result["von_mises"].values.ravel(), result["principal"].values[0].ravel()):
            worst = here[int(np.argmax(values[here]))]
            row += [text(float(values[worst]), "Pa"), text(float(x[worst]), "m"), text(float(z[worst]), "m")]
        table.add_row(*row)
    out = Console()
    out.print(table)
    say(f"Estimated error of stresses: {attrs['stress_error']:.1g} of the largest pressure.")
    if first is not None:
        _print_first(first)
    for line in str(attrs.get("notes", "")).splitlines():
        out.print(f"Note: {line}", style="yellow", markup=False, highlight=False)


def _print_first(first: CriticalLoad) -> None:
    """Say which failure comes first."""
    import math

    from flatpunch.files.units import text

    two = any(name.startswith(("upper", "lower")) for name in first.margins)
    where = f"layer {first.layer + 1}" + (f" of the {first.body} body" if two else "")
    if first.force == 0:
        say(f"First failure: {first.kind} in {where} at the first touch: the tip is sharp.")
        return
    if math.isinf(first.force):
        say("No failure up to the largest contact that the tip or the layers allow.")
        return
    at = f"x = {text(first.place[0], 'm')}, z = {text(first.place[2], 'm')}"
    say(
        f"First failure: {first.kind} in {where} at {at}, force {text(first.force, 'N')}, depth "
        f"{text(first.depth, 'm')}, contact radius {text(first.radius, 'm')}."
    )
    margins = ", ".join(
        f"{name} {value:.3g}" for name, value in sorted(first.margins.items(), key=lambda item: item[1])
    )
    say(f"Strength over stress there: {margins}.")
    if first.error > 1e-3:
        say(f"Estimated relative error of that stress: {first.error:.1g}.")
