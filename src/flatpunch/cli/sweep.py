"""The command `flatpunch sweep`."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch._support.messages import toml
from flatpunch.cli.terminal import (
    CaseFile,
    Output,
    PlotOption,
    ResultOption,
    StyleOption,
    command,
    drawn,
    friendly,
    progress,
    say,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    import xarray as xr


@command("sweep")
def sweep(
    case: CaseFile,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUES",
            help="What to vary: layers.0.thickness=0.2um:5um:40:log, or values with commas in between. Repeat it for a grid.",
            show_default="the table [vary] of the case file",
        ),
    ] = None,
    output: ResultOption = None,
    csv: Annotated[
        Path | None,
        typer.Option(help="Table as CSV, a line for each point and step, besides the output."),
        Output((".csv",)),
    ] = None,
    plot: PlotOption = None,
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
    """Print, then write what was asked for."""
    from flatpunch.files import save
    from flatpunch.sweeps.study import save_table

    failed = int((result["status"] == "failed").sum())
    if failed < result["status"].size:
        _print(result, quantity, step)
    say(f"{result['status'].size} points, {failed} failed.")
    out = Console()
    for line in _failures(result)[:5]:
        out.print(line, style="red", markup=False, highlight=False, soft_wrap=True)
    drawable = picture[0] if failed < result["status"].size else None
    write_all(
        (output, lambda path: save(result, path)),
        (csv, lambda path: save_table(result, path)),
        (drawable, lambda path: _draw(result, path, picture[1], quantity, step)),
    )
    if failed == result["status"].size:
        raise typer.Exit(1)


def _draw(result: xr.Dataset, path: Path, style: str, quantity: str | None, step: int) -> None:
    from flatpunch.plots.style import style_of
    from flatpunch.sweeps.picture import is_map

    chosen = style_of(style)
    sizes = {} if chosen.width is None else {"width": chosen.width, "settings": chosen.settings}
    if is_map(result, quantity):
        drawn("sweeps.picture:map_figure", result, **sizes)(path)
    else:
        drawn("sweeps.picture:figure", result, quantity=quantity, step=step, **sizes)(path)


def _print(result: xr.Dataset, quantity: str | None, step: int) -> None:
    """Print the quantity at a step: down the first parameter, across the second, at the first values of the others."""
    import numpy as np

    from flatpunch.files.descriptions import spread
    from flatpunch.files.units import readable
    from flatpunch.sweeps.picture import checked, heading, parameters, value_text, where

    names = parameters(result)
    values = checked(result, quantity, step)
    part = values.isel(step=step).isel(dict.fromkeys(names[2:], 0)).values.reshape(values.shape[0], -1)
    failed = (result["status"].isel(dict.fromkeys(names[2:], 0)).values == "failed").reshape(part.shape)
    finite = np.abs(part[np.isfinite(part)])
    factor, unit = readable(float(finite.max()) if finite.size else 0.0, str(values.attrs.get("units", "")))
    rows, columns = (spread(count, most) for count, most in zip(part.shape, (12, 6), strict=True))
    rest = "".join(f", {name} = {value_text(result[name], 0)}" for name in names[2:])
    place = where(result, str(values.name), step)
    if not place and not str(values.name).startswith("critical_"):
        place = f" at step {step % result.sizes['step']}"
    title = f"{values.name} [{unit}]{place}{rest}"
    across = (
        [f"{heading(names[1], names)} {value_text(result[names[1]], j)}" for j in columns]
        if names[1:]
        else [str(values.name)]
    )
    lines = [
        [
            value_text(result[names[0]], i),
            *("failed" if failed[i, j] else _cell(part[i, j] * factor) for j in columns),
        ]
        for i in rows
    ]
    Console().print(title, markup=False, highlight=False)
    say_table(None, [heading(names[0], names), *across], lines)


def _cell(value: float) -> str:
    """Four digits, or a dash where the point has no value, as where a critical load is not reached."""
    return "-" if math.isnan(value) else f"{value:.4g}"


def _failures(result: xr.Dataset) -> list[str]:
    import numpy as np

    from flatpunch.sweeps.picture import parameters, value_text

    names = parameters(result)
    return [
        f"Failed at {', '.join(f'{name} = {value_text(result[name], i)}' for name, i in zip(names, at, strict=True))}: "
        + re.sub(
            r"^(BadValue|ValueError|TypeError|NotConverged|UnresolvedLayer): ",
            "",
            toml(str(result["reason"].values[tuple(at)])),
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
