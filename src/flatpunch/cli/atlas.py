"""`flatpunch atlas`: list, show, query, export."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch._support.checks import AT_ONCE, Array, BadValue, real, shown
from flatpunch._support.paths import FORMS, spaced
from flatpunch.cli.terminal import Output, command, say, say_table

if TYPE_CHECKING:
    from flatpunch.atlas import Table


Name = Annotated[
    str, typer.Argument(metavar="FAMILY", help="Name of a shipped table, or a file name.nc.", show_default=False)
]
Beta = Annotated[
    str, typer.Option(help="Punch radius over the length of the medium: 0.5, or 0.1,1,10, or 0.1:10:21:log.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUES", help="A parameter: poisson=0.45, or 0,0.25,0.5, or 0:0.5:6."),
]
Moments = Annotated[str, typer.Option(help="Exponents n of the moments kappa_n, with commas between them.")]


_FOR_PROGRAMS = {"Conventions", "institution", "references", "description", "evaluation", "responses", "family_file"}
"""Attributes of a file that describe its layout to those who read it without this package, and the text it was made from."""

_PRINTED = 40
"""Rows of a screen."""

atlas_app = typer.Typer(no_args_is_help=True, help="The library of flat-punch solutions: read it.")


@command("atlas list", atlas_app)
def list_tables() -> None:
    """List the tables that come with the package."""
    from rich.table import Table as Listing

    from flatpunch import atlas

    listing = Listing(title="Tables of flat-punch solutions", title_justify="left", show_lines=True)
    for column in ("family", "medium", "parameters", "a/l", "error"):
        listing.add_column(column, no_wrap=column != "medium")
    for table in map(atlas.table, (*atlas.families(), "power-law")):
        parameters = "\n".join(f"{p.name}\n  {p.low:g} ... {p.high:g}" for p in table.parameters)
        low, high = table.beta_range
        beta = f"{low:g}\n... {high:g}" if high < float("inf") else "any"
        listing.add_row(table.name, table.title, parameters, beta, f"{table.bound:.0e}")
    Console().print(listing)


@command("atlas show", atlas_app)
def show(family: Name) -> None:
    """Say what a table holds: parameters, ranges, measured errors, where it comes from."""
    from flatpunch import atlas

    table = atlas.table(family)
    about = {key: value for key, value in table.attributes.items() if key not in _FOR_PROGRAMS}
    series = [one for panel in table.panels for one in panel.series.values()]

    def line(label: str, value: object) -> None:
        say(f"{label:<24}{value}")

    line("Family", table.name)
    line("Medium", table.title)
    for p in table.parameters:
        unit = f" {p.unit}" if p.unit not in ("", "1") else ""
        line("Parameter", f"{p.name}: {p.low:g} ... {p.high:g}{unit}, {p.meaning}")
    line("beta = a/l", "{:g} ... {:g}".format(*table.beta_range))
    line("Relative error", f"below {table.bound:.0e} for Kbar, kappa_1 and kappa_2")
    line("Responses to outlines", "n = 1 and 2" if table.panels[0].orders.size else "solved directly")
    line("Coefficients", sum(one.value.size for one in series))
    if (path := _path(family)) is not None:
        line("File", f"{path} ({path.stat().st_size / 1e3:.0f} kB)")
    line("Licence", f"{about.pop('license')} (data)")
    for key, value in about.items():
        line(key.replace("_", " ").capitalize(), f"{value:.2g}" if isinstance(value, float) else value)


@command("atlas query", atlas_app)
def query(family: Name, beta: Beta = "1", set_: Set = None, moments: Moments = "1,2") -> None:
    """Print stiffness, edge coefficient and moments."""
    from flatpunch import atlas

    table = atlas.table(family)
    inputs, outputs = _values(table, beta, set_ or [], moments, fill=False)
    count = inputs["beta"].size
    if count > _PRINTED:
        raise ValueError(
            f"{count} values are too many to print ({_PRINTED}); `flatpunch atlas export` writes them as CSV."
        )
    rows = [
        (*(f"{v[i]:.6g}" for v in inputs.values()), *(f"{v[i]:.11g}" for v in outputs.values())) for i in range(count)
    ]
    say_table(table.title, [*inputs, *outputs], rows, f"relative error below {table.bound:.0e}")


@command("atlas export", atlas_app)
def export(
    family: Name,
    csv: Annotated[Path, typer.Option(help="File to write."), Output((".csv",))],
    beta: Annotated[str | None, typer.Option(help="As for query; the whole range by default.")] = None,
    set_: Set = None,
    moments: Moments = "1,2",
    terms: Annotated[int, typer.Option(help="How many of the coefficients c_n to write too.", min=0)] = 0,
) -> None:
    """Write values as CSV, over all combinations of radii and parameters."""
    import numpy as np
    import pandas as pd

    from flatpunch import atlas
    from flatpunch._support.whole_file import write_whole

    table = atlas.table(family)
    low, high = table.beta_range
    if beta is None:
        beta = f"{low}:{high}:41:log" if np.isfinite(high) else "0.001:100:41:log"
    inputs, outputs = _values(table, beta, set_ or [], moments, fill=True)
    columns = {**inputs, **outputs}
    if terms:
        columns |= {f"c_{n}": column for n, column in enumerate(_coefficients(table, inputs, terms).T)}
    source = f"{table.attributes.get('created_by', 'flatpunch')}; {table.attributes['license']}"
    head = (
        f"# {table.title}: rigid flat punch, F = 2 E* a d Kbar, beta = a/l\n"
        f"# relative error below {table.bound:.0e}; {source}\n"
    )
    text = pd.DataFrame(columns).to_csv(index=False, float_format="%.12g", lineterminator="\n")
    write_whole(csv, (head + text).encode())
    say(f"Written: {csv} ({inputs['beta'].size} rows)")


def _path(name: str) -> Path | None:
    from flatpunch import atlas
    from flatpunch.atlas.library import folder

    found = folder() / f"{name}.nc" if name in atlas.families() else Path(name)
    return found if found.is_file() else None


def numbers(text: str, name: str) -> list[float]:
    """Values of "0.5", "0.1,1,10", "0:0.5:6" or "0.1:10:21:log"."""
    if ":" in text:
        return spaced(name, text, lambda end: _number(name, end))[0]
    return [_number(name, entry) for entry in text.split(",")]


def _number(name: str, text: str) -> float:
    try:
        found = float(text)
    except ValueError:
        raise BadValue(name, shown(text), f"is neither a number nor a range. {FORMS}.") from None
    return real(name, found)


def _grid(table: Table, beta: list[float], given: list[str], *, fill: bool) -> tuple[Array, dict[str, Array]]:
    """All combinations of radii and parameters, flat."""
    import numpy as np

    wanted = {}
    for entry in given:
        name, sign, text = entry.partition("=")
        if not sign:
            raise ValueError(f"--set {entry!r}: write NAME=VALUES, for instance poisson=0.45.")
        wanted[name.strip()] = numbers(text, name.strip())
    for p in table.parameters:
        if p.name not in wanted and fill:
            wanted[p.name] = p.at(np.linspace(-1, 1, 6)).tolist()
    names = [p.name for p in table.parameters]
    if set(wanted) != set(names):
        takes = " ".join(f"--set {name}=..." for name in names) or "no --set"
        raise ValueError(f"The table {table.name!r} takes {takes}, not {', '.join(wanted) or 'nothing'}.")
    count = math.prod(map(len, (*wanted.values(), beta)))
    if count > AT_ONCE:
        raise ValueError(f"{count} combinations of radii and parameters are too many; {AT_ONCE} are the most.")
    axes = np.meshgrid(*(wanted[n] for n in names), beta, indexing="ij")
    return axes[-1].ravel(), {name: axis.ravel() for name, axis in zip(names, axes, strict=False)}


def _values(
    table: Table, beta: str, given: list[str], moments: str, *, fill: bool
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Inputs and outputs by name, one entry for each combination."""
    exponents = numbers(moments, "--moments") if moments else []
    radii, parameters = _grid(table, numbers(beta, "--beta"), given, fill=fill)
    stiffness, *kappa = table.stiffness_and_moments(radii, exponents, **parameters)
    outputs = {"Kbar": stiffness, "edge": table.edge_coefficients(radii, **parameters)}
    outputs |= {f"kappa_{n:g}": value for n, value in zip(exponents, kappa, strict=True)}
    return {**parameters, "beta": radii}, outputs


def _coefficients(table: Table, inputs: dict[str, Array], terms: int) -> Array:
    """c_n of every combination, shape (rows, terms)."""
    import numpy as np

    names = [p.name for p in table.parameters]
    rows = np.zeros((inputs["beta"].size, terms))
    for row, beta, *values in zip(rows, inputs["beta"], *(inputs[name] for name in names), strict=True):
        solution = table.at(**dict(zip(names, map(float, values), strict=True)))
        flat = solution.coefficients(np.array([beta]))[0][0, :terms]
        row[: flat.size] = flat
    return rows
