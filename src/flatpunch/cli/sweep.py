"""The command `flatpunch sweep`, which the command line adds with `add_commands`."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch._support.messages import toml
from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import StyleOption, friendly, progress, say_written

if TYPE_CHECKING:
    import xarray as xr


def add_commands(app: typer.Typer) -> None:
    """Register the command on the command line."""

    @app.command(epilog=examples("sweep"))
    def sweep(
        case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
        vary: Annotated[
            list[str] | None,
            typer.Option(
                metavar="PATH=VALUES",
                help="What to vary: layers.0.thickness=0.2um:5um:40:log, or values with commas in between. Repeat it for a grid.",
                show_default="the table [vary] of the case file",
            ),
        ] = None,
        output: Annotated[Path | None, typer.Option("--output", "-o", help="Result file: .nc (NetCDF).")] = None,
        csv: Annotated[
            Path | None, typer.Option(help="Table as CSV, a line for each point and step, besides the output.")
        ] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
        style: StyleOption = "screen",
        quantity: Annotated[
            str | None,
            typer.Option(help="What to print and draw at the last step instead of the force: radius, stiffness, ..."),
        ] = None,
        step: Annotated[int, typer.Option(help="At which step; -1 is the last, 0 the first.")] = -1,
        workers: Annotated[int | None, typer.Option(help="Processes.", show_default="as many as are worth it")] = None,
        scheduler: Annotated[
            str | None, typer.Option(help="Dask scheduler whose cluster does the work: tcp://host:8786.")
        ] = None,
        resume: Annotated[
            bool, typer.Option("--resume/--fresh", help="Use the finished points of earlier runs, or solve all again.")
        ] = True,
        retry_failed: Annotated[
            bool, typer.Option("--retry-failed", help="Try again what failed in an earlier run.")
        ] = False,
        contours: Annotated[bool, typer.Option("--contours", help="Keep the contact outlines too.")] = False,
    ) -> None:
        """Solve a case for ranges of any of its values: one data set over all of them.

        With an output, finished points are kept beside it (study.points): after an interruption the same command goes on from
        there, and with more values it solves only the new ones. Delete that folder when the study is done.
        """
        with friendly():
            _check_targets(output, csv, plot)
            wanted = _wanted(vary) if vary else None
            from flatpunch._support.progress import listening
            from flatpunch.sweeps.study import sweep as solve

            store = output.with_suffix(".points") if output else None
            kept = f"Finished points are in {store}; the same command goes on from there." if store else ""
            with friendly(kept), progress("Sweep", 1) as step_to:
                step_to("reading")
                with listening(lambda done, total: step_to(f"{done} of {total} points", advance=0)):
                    result = solve(
                        case,
                        wanted,
                        contours=contours,
                        store=store,
                        workers=workers,
                        scheduler=scheduler,
                        retry_failed=retry_failed,
                        anew=not resume,
                    )
            _finish(result, output, csv, (plot, style), quantity, step)


def _finish(
    result: xr.Dataset,
    output: Path | None,
    csv: Path | None,
    picture: tuple[Path | None, str],
    quantity: str | None,
    step: int,
) -> None:
    """Write what was asked for, then print: a picture that cannot be drawn costs no result."""
    from flatpunch.files import save
    from flatpunch.sweeps.table import save_table

    written = [save(result, output)] if output else []
    if csv:
        written.append(save_table(result, csv))
    failed = int((result["status"] == "failed").sum())
    if failed < result["status"].size:
        plot, style = picture
        if plot:
            from flatpunch.plots.result import save_figure
            from flatpunch.plots.style import style_of
            from flatpunch.sweeps.failure import is_map, map_figure
            from flatpunch.sweeps.picture import figure

            chosen = style_of(style)
            sizes = {} if chosen.width is None else {"width": chosen.width, "settings": chosen.settings}
            drawn = (
                map_figure(result, **sizes)
                if is_map(result, quantity)
                else figure(result, quantity=quantity, step=step, **sizes)
            )
            written.append(save_figure(drawn, plot))
        _print(result, quantity, step)
    out = Console()
    out.print(f"{result['status'].size} points, {failed} failed.", highlight=False)
    for line in _failures(result)[:5]:
        out.print(line, style="red", markup=False, highlight=False, soft_wrap=True)
    say_written(written)
    if failed == result["status"].size:
        raise typer.Exit(1)


def _print(result: xr.Dataset, quantity: str | None, step: int) -> None:
    """Print the quantity at a step: down the first parameter, across the second, at the first values of the others."""
    import numpy as np
    from rich.table import Table

    from flatpunch.files.units import readable
    from flatpunch.sweeps.picture import checked, heading, parameters, value_text, where

    names = parameters(result)
    values = checked(result, quantity, step)
    part = values.isel(step=step).isel(dict.fromkeys(names[2:], 0)).values.reshape(values.shape[0], -1)
    failed = (result["status"].isel(dict.fromkeys(names[2:], 0)).values == "failed").reshape(part.shape)
    finite = np.abs(part[np.isfinite(part)])
    factor, unit = readable(float(finite.max()) if finite.size else 0.0, str(values.attrs.get("units", "")))
    rows, columns = (
        np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))
        for count, most in zip(part.shape, (12, 6), strict=True)
    )
    rest = "".join(f", {name} = {value_text(result[name], 0)}" for name in names[2:])
    place = where(result, str(values.name), step)
    if not place and not str(values.name).startswith("critical_"):
        place = f" at step {step % result.sizes['step']}"
    title = f"{values.name} [{unit}]{place}{rest}"
    table = Table()
    table.add_column(heading(names[0], names), justify="right")
    for i in columns:
        across = f"{heading(names[1], names)} {value_text(result[names[1]], i)}" if len(names) > 1 else str(values.name)
        table.add_column(across, justify="right")
    for i in rows:
        table.add_row(
            value_text(result[names[0]], i),
            *("failed" if failed[i, j] else _cell(part[i, j] * factor) for j in columns),
        )
    out = Console()
    out.print(title, markup=False, highlight=False)
    out.print(table)


def _cell(value: float) -> str:
    """Four digits, or a dash where the point has no value, as where a critical load is not reached."""
    return "-" if math.isnan(value) else f"{value:.4g}"


def _failures(result: xr.Dataset) -> list[str]:
    """One line for each point that failed."""
    import numpy as np

    from flatpunch.sweeps.picture import parameters, value_text

    names = parameters(result)
    return [
        f"Failed at {', '.join(f'{name} = {value_text(result[name], i)}' for name, i in zip(names, at, strict=True))}: "
        + re.sub(
            r"^(ValueError|TypeError|NotConverged|UnresolvedLayer): ", "", toml(str(result["reason"].values[tuple(at)]))
        )
        for at in np.argwhere(result["status"].values == "failed")
    ]


def _wanted(vary: list[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for entry in vary:
        path, equals, values = entry.partition("=")
        if not equals or not path.strip() or not values.strip():
            raise ValueError(
                f"--vary {entry!r} must be PATH=VALUES, such as layers.0.thickness=0.2um:5um:40:log or indenter.sides=3,4,6."
            )
        if path.strip() in found:
            raise ValueError(f"--vary {entry!r}: {path.strip()} is varied twice; give all its values at once.")
        found[path.strip()] = values
    return found


def _check_targets(output: Path | None, csv: Path | None, plot: Path | None) -> None:
    """Refuse endings and folders that cannot work before anything is solved."""
    from flatpunch._support.whole_file import check_target

    check_target("--output", output, (".nc",))
    check_target("--csv", csv, (".csv",))
    check_target("--plot", plot, (".png", ".pdf", ".svg"))
