"""Commands `flatpunch show-tip` and `flatpunch show-medium`: pictures of what a case file describes, without solving it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch.cli.terminal import PICTURES, CaseFile, Output, StyleOption, command, drawn, say, write_all

if TYPE_CHECKING:
    from flatpunch.files import Case
    from flatpunch.fits.case import FitCase


@command("show-tip")
def show_tip(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Picture: .png, .pdf or .svg.", show_default="CASE-tip.png"),
        Output(PICTURES),
    ] = None,
    extent: Annotated[
        str | None,
        typer.Option(help="Half the width of the picture, '500 nm'.", show_default="somewhat more than the contact"),
    ] = None,
    style: StyleOption = "screen",
) -> None:
    """Draw the tip of a case file: its surface, level lines and sections."""
    target = _target(case, output, "tip")
    read = _read(case)
    from flatpunch.files import units
    from flatpunch.files.descriptions import words

    half = _extent(read) if extent is None else units.named_si("--extent", extent, units.LENGTH)
    say(f"Indenter  {words(read.indenter)}")
    about = {"extent": half, "title": read.title, "style": style}
    write_all((target, drawn("plots.bodies:indenter_figure", read.indenter, **about)))


@command("show-medium")
def show_medium(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Picture: .png, .pdf or .svg.", show_default="CASE-medium.png"),
        Output(PICTURES),
    ] = None,
    style: StyleOption = "screen",
) -> None:
    """Draw the layers of a case file: Young's modulus over depth."""
    target = _target(case, output, "medium")
    read = _read(case)
    from flatpunch.files.descriptions import describe_bodies
    from flatpunch.plots.bodies import plot_medium
    from flatpunch.plots.result import save_figure
    from flatpunch.plots.style import panels, styled

    with styled(style) as chosen:
        figure, (axes,) = panels(chosen, 1, title=read.title)
        plot_medium(read.medium, axes)
    for line in describe_bodies(read.medium):
        say(line)
    write_all((target, lambda path: save_figure(figure, path)))


def _target(case: Path, output: Path | None, what: str) -> Path:
    from flatpunch._support.whole_file import check_target

    if output is None:
        output = case.with_name(f"{case.stem}-{what}.png")
        check_target("--output", output, PICTURES, chosen=True)
    return output


def _read(path: Path) -> Case | FitCase:
    from flatpunch.files import read_case
    from flatpunch.files.cases import is_fit_case
    from flatpunch.fits.case import read_fit_case

    return read_fit_case(path) if is_fit_case(path) else read_case(path)


def _extent(case: Case | FitCase) -> float | None:
    """Half the width of the picture: beside the largest contact, where the case has one; else the tip's own."""
    import numpy as np

    from flatpunch.bem.bounding_box import overlap_half_widths
    from flatpunch.files import Case
    from flatpunch.numerics.extents import ROOM

    if not isinstance(case, Case):
        length = float(case.medium.length)
        return min(length, float(case.indenter.reach)) if np.isfinite(length) else None
    largest = float(np.max(case.values))
    if case.control == "force" or not largest > 0:
        return None
    half = largest if case.control == "radius" else max(overlap_half_widths(case.indenter, largest))
    return min(ROOM * half, float(case.indenter.reach))
