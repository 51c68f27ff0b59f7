"""The command `flatpunch rough`: contact of a rough surface, or of asperities, from a case file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flatpunch.cli.terminal import (
    CaseFile,
    PlotOption,
    ResultOption,
    StyleOption,
    command,
    progress,
    say_notes,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from flatpunch.files.rough import RoughCase

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
    output: ResultOption = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Press a rough surface, or asperities at given places, into a body.

    A table [bold]surface[/bold] describes a random or measured surface, a table [bold]asperities[/bold] tips and their
    places. The picture shows the area in contact beside theories, pressure, gap and patches of the last step.
    """
    from flatpunch.files import save
    from flatpunch.files.rough import read_rough_case
    from flatpunch.plots.result import save_figure

    read = read_rough_case(case)
    with progress(read.title or "Rough contact", 1) as step:
        step("solving")
        result = read.solve()
    _print(read, result)
    write_all(
        (output, lambda path: save(result, path)),
        (plot, lambda path: save_figure(_drawn(read, result, style), path)),
    )


def _drawn(case: RoughCase, result: xr.Dataset, style: str) -> Figure:
    from flatpunch.plots.rough import asperities_figure, rough_figure
    from flatpunch.rough import rough_theories

    if case.surface is None:
        assert case.asperities is not None
        return asperities_figure(result, case.asperities[1], title=case.title, style=style)
    theories = rough_theories(result, case.medium, case.surface) if all(case.surface.periodic) else None
    return rough_figure(result, case.solve(last=True), theories, title=case.title, style=style)


def _print(case: RoughCase, result: xr.Dataset) -> None:
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
