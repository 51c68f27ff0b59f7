"""Make tables of the atlas, and check them.

In the folder `scripts`:

    python -m atlas_tables build sliding-layer --output tables
    python -m atlas_tables build gel.toml
    python -m atlas_tables verify bonded-layer --points 50
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from atlas_tables.build import Ways
from atlas_tables.build import build as build_table
from atlas_tables.families import FAMILIES, Family
from atlas_tables.family_file import family_from, read_family
from atlas_tables.verify import verified
from atlas_tables.verify import verify as verify_table
from atlas_tables.writing import write_table
from flatpunch import atlas
from flatpunch._support.progress import listening
from flatpunch._support.whole_file import made_folder
from flatpunch.cli.terminal import Step, friendly, progress, say

Workers = Annotated[int | None, typer.Option(help="Processes.", show_default="one for each core")]
Scheduler = Annotated[
    str | None, typer.Option(help="Dask scheduler whose cluster does the work: tcp://host:8786.", show_default=False)
]

HERE = Path(__file__).parent

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Make tables of the atlas, and check them.",
)


@app.command()
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
    store = points or output / "atlas-points"
    kept = f"Solved media are in {store}; the same command goes on from there."
    with friendly(kept, program=HERE), progress("Atlas", 1) as step:
        step("reading")
        _build(families, output, store, check, workers, scheduler, step)


@app.command()
def verify(
    family: Annotated[
        str, typer.Argument(metavar="FAMILY", help="Name of a shipped table, or a file name.nc.", show_default=False)
    ],
    points: Annotated[int, typer.Option(help="How many random points.", min=1)] = 200,
    seed: Annotated[int, typer.Option(help="Makes them repeatable; another one, other points.")] = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Compare a table with direct solutions at random points; status 1 if it does not keep its bound."""
    with friendly(program=HERE), progress("Atlas", 1) as step:
        step("reading")
        kept = _verify(family, points, seed, workers, scheduler, step)
    if not kept:
        raise typer.Exit(1)


def _families(names: list[str]) -> list[tuple[Family, dict[str, str]]]:
    """Families by name or file, each with the provenance that its table records."""
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
    families = _families(names)
    made_folder("--output", output)
    ways: Ways = {"store": store, "workers": workers, "scheduler": scheduler}
    for family, more in families:
        with listening(_counting(step, f"{family.name}, {{}} of {{}} media")):
            table = build_table(family, **ways)
        with listening(_counting(step, f"{family.name}, {{}} of {{}} checked")):
            table = verified(table, verify_table(table, family, points=check, **ways))
        path = write_table(replace(table, attributes={**table.attributes, **more}), output / f"{family.name}.nc")
        say(f"Written: {path} ({path.stat().st_size / 1e3:.0f} kB), relative error below {table.bound:.0e}")


def _counting(step: Step, text: str) -> Callable[[int, int], None]:
    return lambda done, total: step(text.format(done, total), advance=0)


def _verify(name: str, points: int, seed: int, workers: int | None, scheduler: str | None, step: Step) -> bool:
    table = atlas.table(name)
    text = table.attributes.get("family_file")
    if text is None and table.name not in FAMILIES:
        raise ValueError(
            f"{name} does not record how its media are made, so that it cannot be compared with direct solutions."
        )
    family = FAMILIES[table.name] if text is None else family_from(str(text), Path(name))
    with listening(_counting(step, "{} of {} points")):
        found = verify_table(table, family, points=points, seed=seed, workers=workers, scheduler=scheduler)
    out = Console()
    for quantity, error in found.largest.items():
        out.print(f"{quantity:<10}largest relative error {error:.1e}", markup=False, highlight=False)
    kept: bool = max(found.largest[q] for q in ("Kbar", "kappa_1", "kappa_2")) <= table.bound
    out.print(f"The table {'keeps' if kept else 'DOES NOT KEEP'} its bound of {table.bound:.0e} at {points} points.")
    return kept


if __name__ == "__main__":
    app()
