"""`flatpunch atlas`: list, show, query, export, build, verify."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from flatpunch._support.ceilings import POINTS
from flatpunch._support.checks import real, shown
from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import Step, friendly, progress, say

if TYPE_CHECKING:
    from flatpunch.atlas import Family, Table


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
Workers = Annotated[int | None, typer.Option(help="Processes.", show_default="one for each core")]
Scheduler = Annotated[
    str | None, typer.Option(help="Dask scheduler whose cluster does the work: tcp://host:8786.", show_default=False)
]


def atlas_app() -> typer.Typer:
    """Return the commands."""
    app = typer.Typer(no_args_is_help=True, help="The library of flat-punch solutions: read it, check it, extend it.")

    @app.command("list", epilog=examples("atlas list"))
    def list_tables() -> None:
        """List the tables that come with the package."""
        with friendly():
            _list()

    @app.command(epilog=examples("atlas show"))
    def show(family: Name) -> None:
        """Say what a table holds: parameters, ranges, measured errors, where it comes from."""
        with friendly():
            _show(_table(family), family)

    @app.command(epilog=examples("atlas query"))
    def query(family: Name, beta: Beta = "1", set_: Set = None, moments: Moments = "1,2") -> None:
        """Print stiffness, edge coefficient and moments."""
        with friendly():
            _query(_table(family), beta, set_ or [], moments)

    @app.command(epilog=examples("atlas export"))
    def export(
        family: Name,
        csv: Annotated[Path, typer.Option(help="File to write.")],
        beta: Annotated[str | None, typer.Option(help="As for query; the whole range by default.")] = None,
        set_: Set = None,
        moments: Moments = "1,2",
        terms: Annotated[int, typer.Option(help="How many of the coefficients c_n to write too.", min=0)] = 0,
    ) -> None:
        """Write values as CSV, over all combinations of radii and parameters."""
        with friendly():
            _export(_table(family), csv, beta, set_ or [], moments, terms)

    @app.command(epilog=examples("atlas build"))
    def build(
        families: Annotated[
            list[str],
            typer.Argument(metavar="FAMILY...", help="Shipped families by name, and files of your own (name.toml)."),
        ],
        output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the tables.")] = Path(),
        points: Annotated[
            Path | None,
            typer.Option(help="Folder for the solved media.", show_default="atlas-points in the output folder"),
        ] = None,
        check: Annotated[int, typer.Option(help="Random points at which the table is compared.", min=1)] = 2000,
        workers: Workers = None,
        scheduler: Scheduler = None,
    ) -> None:
        """Compute tables: solve a grid of media, refine it until the series end, measure the error at random points.

        Every solved medium is kept: after an interruption the same command goes on from there.
        """
        with friendly():
            store = points or output / "atlas-points"
            kept = f"Solved media are in {store}; the same command goes on from there."
            with friendly(kept), progress("Atlas", 1) as step:
                step("reading")
                _build(families, output, store, check, workers, scheduler, step)

    @app.command(epilog=examples("atlas verify"))
    def verify(
        family: Name,
        points: Annotated[int, typer.Option(help="How many random points.", min=1)] = 200,
        seed: Annotated[int, typer.Option(help="Makes them repeatable; another one, other points.")] = 1,
        workers: Workers = None,
        scheduler: Scheduler = None,
    ) -> None:
        """Compare a table with direct solutions at random points; status 1 if it does not keep its bound."""
        with friendly(), progress("Atlas", 1) as step:
            step("reading")
            kept = _verify(family, points, seed, workers, scheduler, step)
        if not kept:
            raise typer.Exit(1)

    return app


def _table(name: str) -> Any:
    from flatpunch import atlas

    return atlas.table(name)


def _list() -> None:
    from rich.table import Table as Listing

    from flatpunch import atlas
    from flatpunch.atlas.library import describe

    listing = Listing(title="Tables of flat-punch solutions", title_justify="left", show_lines=True)
    for column in ("family", "medium", "parameters", "a/l", "error"):
        listing.add_column(column, no_wrap=column != "medium")
    for name in (*atlas.families(), "power-law"):
        about = describe(atlas.table(name))
        parameters = "\n".join(f"{p}\n  {low:g} ... {high:g}" for p, (low, high) in about["parameters"].items())
        low, high = about["beta"]
        beta = f"{low:g}\n... {high:g}" if high < float("inf") else "any"
        listing.add_row(name, about["title"], parameters, beta, f"{about['bound']:.0e}")
    Console().print(listing)


def _show(table: Table, name: str) -> None:
    from flatpunch.atlas.library import describe
    from flatpunch.atlas.storage import LICENCE

    about = describe(table)
    out = Console()

    def line(label: str, value: Any) -> None:
        out.print(f"{label:<24}{value}", markup=False, highlight=False, soft_wrap=True)

    line("Family", about["name"])
    line("Medium", about["title"])
    for p in table.parameters:
        line(
            "Parameter",
            f"{p.name}: {p.low:g} ... {p.high:g}{f' {p.unit}' if p.unit not in ('', '1') else ''}, {p.meaning}",
        )
    line("beta = a/l", "{:g} ... {:g}".format(*about["beta"]))
    line("Relative error", f"below {about['bound']:.0e} for Kbar, kappa_1 and kappa_2")
    line("Responses to outlines", "n = 1 and 2" if about["responses"] else "solved directly")
    line("Coefficients", about["coefficients"])
    path = _path(name)
    if path is not None:
        line("File", f"{path} ({path.stat().st_size / 1e3:.0f} kB)")
    line("Licence", f"{LICENCE} (data)")
    known = {"name", "title", "parameters", "beta", "bound", "coefficients", "responses", "family_file"}
    for key, value in about.items():
        if key not in known:
            line(key.replace("_", " ").capitalize(), f"{value:.2g}" if isinstance(value, float) else value)


def _path(name: str) -> Path | None:
    from flatpunch import atlas
    from flatpunch.atlas.library import folder

    found = folder() / f"{name}.nc" if name in atlas.families() else Path(name)
    return found if found.is_file() else None


def numbers(text: str, name: str) -> list[float]:
    """Values of "0.5", "0.1,1,10", "0:0.5:6" or "0.1:10:21:log"."""
    import numpy as np

    match = re.fullmatch(r"([^:]+):([^:]+):([0-9]{1,9})(?::(log|lin))?", text.strip())
    try:
        if match is None:
            return [real(name, float(entry)) for entry in text.split(",")]
        start, stop, count = real(name, float(match[1])), real(name, float(match[2])), int(match[3])
    except ValueError:
        raise ValueError(
            f"{name} = {shown(text)} is neither numbers with commas between them nor a range start:stop:count, or "
            "start:stop:count:log."
        ) from None
    if count > POINTS:
        raise ValueError(f"{name} = {shown(text)}: {count} values are too many; {POINTS} are the most.")
    if match[4] == "log" and not (start > 0 and stop > 0):
        raise ValueError(f"{name} = {text!r}: a logarithmic range has no zero and no negative numbers.")
    return [float(v) for v in (np.geomspace if match[4] == "log" else np.linspace)(start, stop, count)]


def _grid(table: Any, beta: list[float], given: list[str], *, fill: bool) -> tuple[Any, dict[str, Any]]:
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
    missing, unknown = [n for n in names if n not in wanted], [n for n in wanted if n not in names]
    if missing or unknown:
        what = (
            f"needs {', '.join(f'--set {n}=...' for n in missing)}"
            if missing
            else f"does not know {', '.join(unknown)}"
        )
        raise ValueError(f"The table {table.name!r} {what}; its parameters are {', '.join(names) or 'none'}.")
    count = math.prod(map(len, (*wanted.values(), beta)))
    most = 2_000_000  # some hundred megabytes
    if count > most:
        raise ValueError(f"{count} combinations of radii and parameters are too many; {most} are the most.")
    axes = np.meshgrid(*(wanted[n] for n in names), beta, indexing="ij")
    return axes[-1].ravel(), {name: axis.ravel() for name, axis in zip(names, axes, strict=False)}


def _values(
    table: Any, beta: str, given: list[str], moments: str, *, fill: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Inputs and outputs by name, one entry for each combination."""
    exponents = numbers(moments, "--moments") if moments else []
    radii, parameters = _grid(table, numbers(beta, "--beta"), given, fill=fill)
    stiffness, *kappa = table.stiffness_and_moments(radii, exponents, **parameters)
    outputs = {"Kbar": stiffness, "edge": table.edge_coefficients(radii, **parameters)}
    outputs |= {f"kappa_{n:g}": value for n, value in zip(exponents, kappa, strict=True)}
    return {**parameters, "beta": radii}, outputs


def _query(table: Any, beta: str, given: list[str], moments: str) -> None:
    from rich.table import Table as Listing

    inputs, outputs = _values(table, beta, given, moments, fill=False)
    count = inputs["beta"].size
    most = 40  # rows of a screen
    if count > most:
        raise ValueError(f"{count} values are too many to print ({most}); `flatpunch atlas export` writes them as CSV.")
    listing = Listing(title=table.title, title_justify="left", caption=f"relative error below {table.bound:.0e}")
    for name in (*inputs, *outputs):
        listing.add_column(name, justify="right")
    for i in range(count):
        listing.add_row(*(f"{v[i]:.6g}" for v in inputs.values()), *(f"{v[i]:.11g}" for v in outputs.values()))
    Console().print(listing)


def _export(table: Any, path: Path, beta: str | None, given: list[str], moments: str, terms: int) -> None:
    import csv
    import io

    import numpy as np

    from flatpunch._support.whole_file import check_target, write_whole

    check_target("--csv", path, (".csv",))
    low, high = table.beta_range
    if beta is None:
        beta = f"{low}:{high}:41:log" if np.isfinite(high) else "0.001:100:41:log"
    inputs, outputs = _values(table, beta, given, moments, fill=True)
    names, rows = [*inputs, *outputs], np.stack([*inputs.values(), *outputs.values()], axis=1)
    if terms:
        found = _coefficients(table, inputs, terms)
        names, rows = [*names, *(f"c_{n}" for n in range(terms))], np.hstack([rows, found])
    text = io.StringIO()
    text.write(f"# {table.title}: rigid flat punch, F = 2 E* a d Kbar, beta = a/l\n")
    text.write(
        f"# relative error below {table.bound:.0e}; {table.attributes.get('created_by', 'flatpunch')}; CC-BY-4.0\n"
    )
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([f"{value:.12g}" for value in row] for row in rows)
    write_whole(path, text.getvalue().encode())
    say(f"Written: {path} ({rows.shape[0]} rows)")


def _coefficients(table: Any, inputs: dict[str, Any], terms: int) -> Any:
    """c_n of every combination, shape (rows, terms)."""
    import numpy as np

    if not table.panels:
        raise ValueError(f"--terms: the solutions of {table.name!r} are closed forms and have no coefficients.")
    names = [p.name for p in table.parameters]
    rows = np.zeros((inputs["beta"].size, terms))
    for i, beta in enumerate(inputs["beta"]):
        flat = table.at(**{name: float(inputs[name][i]) for name in names}).flat(np.array([beta]))[0, :terms]
        rows[i, : flat.size] = flat
    return rows


def _families(names: list[str]) -> list[tuple[Family, dict[str, str]]]:
    """Families by name or file, each with the provenance that its table records."""
    from flatpunch.atlas import FAMILIES
    from flatpunch.cli.atlas_family import read_family

    found: list[tuple[Family, dict[str, str]]] = []
    for name in names:
        if name in FAMILIES:
            found.append((FAMILIES[name], {}))
        elif name.endswith(".toml"):
            family, text = read_family(name)
            if family.name in FAMILIES:
                raise ValueError(f"{name}: name = {family.name!r} is that of a shipped family; choose another one.")
            found.append((family, {"family_file": text}))
        else:
            raise ValueError(
                f"{name!r} is no family: there are {', '.join(FAMILIES)}, and files of your own (name.toml)."
            )
    return found


def _build(
    names: list[str],
    output: Path,
    store: Path,
    check: int,
    workers: int | None,
    scheduler: str | None,
    step: Step,
) -> None:
    from dataclasses import replace

    from flatpunch import atlas
    from flatpunch._support.progress import listening
    from flatpunch._support.whole_file import made_folder

    families = _families(names)
    made_folder("--output", output)
    ways: dict[str, Any] = {"store": store, "workers": workers, "scheduler": scheduler}
    for family, more in families:
        with listening(_counting(step, f"{family.name}, {{}} of {{}} media")):
            table = atlas.build(family, **ways)
        with listening(_counting(step, f"{family.name}, {{}} of {{}} checked")):
            table = atlas.verified(table, atlas.verify(table, family, points=check, **ways))
        path = atlas.write_table(replace(table, attributes={**table.attributes, **more}), output / f"{family.name}.nc")
        say(f"Written: {path} ({path.stat().st_size / 1e3:.0f} kB), relative error below {table.bound:.0e}")


def _counting(step: Step, text: str) -> Callable[[int, int], None]:
    return lambda done, total: step(text.format(done, total), advance=0)


def _verify(name: str, points: int, seed: int, workers: int | None, scheduler: str | None, step: Step) -> bool:
    from flatpunch import atlas
    from flatpunch._support.progress import listening
    from flatpunch.cli.atlas_family import family_from

    table = _table(name)
    if not table.panels:
        raise ValueError(f"The solutions of {name!r} are closed forms; there is nothing to compare.")
    text = table.attributes.get("family_file")
    if text is None and table.name not in atlas.FAMILIES:
        raise ValueError(
            f"{name} does not record how its media are made, so that it cannot be compared with direct solutions."
        )
    family = atlas.FAMILIES[table.name] if text is None else family_from(str(text), Path(name))
    with listening(_counting(step, "{} of {} points")):
        found = atlas.verify(table, family, points=points, seed=seed, workers=workers, scheduler=scheduler)
    out = Console()
    for quantity, error in found.largest.items():
        out.print(f"{quantity:<10}largest relative error {error:.1e}", markup=False, highlight=False)
    kept: bool = max(found.largest[q] for q in ("Kbar", "kappa_1", "kappa_2")) <= table.bound
    out.print(f"The table {'keeps' if kept else 'DOES NOT KEEP'} its bound of {table.bound:.0e} at {points} points.")
    return kept
