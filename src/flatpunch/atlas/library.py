"""The shipped tables, and media that find theirs by themselves."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Literal

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Indices, shown
from flatpunch._support.kinds import one_of
from flatpunch._support.paths import Plain
from flatpunch._support.reading import is_file
from flatpunch.atlas.closed import PowerLawTable
from flatpunch.atlas.family import FAMILIES
from flatpunch.atlas.solution import Solution
from flatpunch.atlas.storage import read_table
from flatpunch.atlas.table import Table
from flatpunch.compliance import compliance
from flatpunch.media import Body, TabulatedMedium
from flatpunch.punch.matrix import solve_round, sufficient_terms

Outside = Literal["solve", "refuse"]


def folder() -> Path:
    """Where the shipped tables are."""
    return Path(str(resources.files("flatpunch.atlas") / "data"))


def families() -> tuple[str, ...]:
    """Names of the shipped tables.

    See Also
    --------
    flatpunch.atlas.table : One of them.
    flatpunch.atlas.FAMILIES : How they are made.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> print(*atlas.families())
    bonded-coating bonded-layer exponential-coating linear-coating sliding-coating sliding-layer
    """
    return tuple(sorted(name for name in FAMILIES if (folder() / f"{name}.nc").is_file()))


def find_table(name: str | Path) -> Any:
    """A shipped table by its name, or one of your own by its file.

    Parameters
    ----------
    name : str or path
        One of `families()`, or a file of your own, name.nc.

    Returns
    -------
    Table
        (or `PowerLawTable`, in closed form, under "power-law").

    Raises
    ------
    ValueError, OSError
        If there is no such table.

    See Also
    --------
    flatpunch.atlas.families : The names.
    flatpunch.atlas.tabulated : As a medium.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> layer = atlas.table("bonded-layer")
    >>> print(layer.stiffness_and_moments(np.array([0.5, 1.0]), poisson=0.3)[0].round(4))
    [1.624  2.4835]
    """
    if name == PowerLawTable.name:
        return PowerLawTable()
    if isinstance(name, str) and name in families():
        return _read(folder() / f"{name}.nc")
    if Path(name).suffix:
        return _read(Path(name))
    raise ValueError(f"{shown(name)} is no table: there are {', '.join(families())}, and files of your own (name.nc).")


def tabulated(
    medium: Body, *, outside: Outside = "solve", table: Table | None = None, **parameters: float
) -> TabulatedMedium:
    """A medium that takes its flat punches from the atlas, for use as any other medium.

    Parameters
    ----------
    medium : Medium
        One layer, homogeneous or graded (LinearModulus, ExponentialModulus), on a base: the table is found by what it is.
    outside : "solve" or "refuse"
        What to do where a contact is smaller or larger than the table holds: solve it directly, as without a table, or raise.
    table : Table, optional
        The table to use: a family of your own, or a shipped family built anew.
    **parameters : float
        Values of its parameters for this medium, where the table is your own.

    Returns
    -------
    TabulatedMedium
        Goes into `flatpunch.indent`, `flatpunch.flat_punch` and all others.

    Raises
    ------
    ValueError
        If no table holds this medium, or the one given belongs to another medium.

    See Also
    --------
    flatpunch.atlas.table : The numbers.
    flatpunch.flat_punch : Solved directly.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> curve = fp.indent(atlas.tabulated(gel), fp.Sphere(radius=5e-6), depth=100e-9)
    >>> print(f"{float(curve.force[0]) * 1e9:.3f} nN")
    1.040 nN
    """
    one_of("outside", outside, ("solve", "refuse"))
    if table is not None and table.name not in FAMILIES:
        solution = table.at(**parameters)
        _check_same(medium, solution)
        return TabulatedMedium(medium, MediumSolution(solution, outside))
    if parameters:
        raise TypeError(
            f"{', '.join(parameters)}: parameters go with a table of your own; here they follow from the medium."
        )
    for name, family in FAMILIES.items():
        values = None if family.identify is None else family.identify(medium)
        if values is None or (table.name != name if table is not None else name not in families()):
            continue
        try:
            solution = (table or find_table(name)).at(**values)
        except ValueError as error:
            raise ValueError(f"The medium belongs to {name!r}, but {error}") from error
        return TabulatedMedium(medium, MediumSolution(solution, outside))
    raise ValueError(
        f"No table holds this {type(medium).__name__}: the atlas knows one layer on a base, {', '.join(families())}. Without "
        "flatpunch.atlas.tabulated it is solved directly."
    )


def _check_same(medium: Body, solution: Solution) -> None:
    """Refuse a table of another medium: one punch is solved directly."""
    kernel = compliance(medium)
    beta = np.array([np.sqrt(np.prod(solution.beta_range))])
    direct = np.pi * solve_round(kernel, beta, sufficient_terms(kernel, float(beta[0]))).flat[0, 0]
    found = float(solution.normalized_stiffness(beta)[0])
    if not abs(found / direct - 1) < max(1e-6, 10 * solution.error):
        raise ValueError(
            f"The table {solution.family!r} with {dict(solution.parameters)} belongs to another medium: at beta = {beta[0]:.3g} "
            f"it says Kbar = {found:.6g}, the medium {direct:.6g}. Check the values of the parameters."
        )


@dataclass(frozen=True, slots=True)
class MediumSolution:
    """A solution with what to do outside its range; see `flatpunch.media.PunchSolution`."""

    solution: Solution
    outside: Outside

    @property
    def error(self) -> float:
        """Bound of the relative error."""
        return self.solution.error

    def covers(self, beta: Array) -> bool:
        """Whether all radii are in the table; a medium that refuses others raises."""
        inside = self.solution.covers(beta)
        if not inside and self.outside == "refuse":
            low, high = self.solution.beta_range
            lowest, highest = float(np.min(beta, initial=np.inf)), float(np.max(beta, initial=0.0))
            raise ValueError(
                f"Contact radii of {lowest:.3g} ... {highest:.3g} lengths of the medium are asked for; the table "
                f"{self.solution.family!r} holds {low:g} ... {high:g}. outside='solve' solves the others directly."
            )
        return inside

    def summary(self, beta: Array) -> str:
        """Which table it was, and how many of these radii it does not hold."""
        low, high = self.solution.beta_range
        outside = int(np.count_nonzero((beta > 0) & ((beta < low) | (beta > high))))
        others = f"; {outside} of {beta.size} contacts are outside it and were solved directly" if outside else ""
        return (
            f"table {self.solution.family!r}, relative error below {self.error:.0e}, a/l = {low:g} ... {high:g}{others}"
        )

    def flat(self, beta: Array) -> Array:
        """Coefficients of the flat punch."""
        return self.solution.flat(beta)

    def round(self, beta: Array) -> tuple[Array, Array, Array]:
        """Flat punch, edge and slope functionals."""
        return self.solution.round(beta)

    def responds_to(self, exponent: float) -> bool:
        """Whether `edges` has r^exponent psi(phi)."""
        return self.solution.responds_to(exponent)

    def edges(self, beta: Array, orders: Indices, exponent: float) -> tuple[Array, Array]:
        """Responses to harmonics of outlines."""
        return self.solution.edges(beta, orders, exponent)


@byte_cached
def _read_once(path: Path, changed: float) -> Table:
    return read_table(path)


def _read(path: Path) -> Table:
    return _read_once(path, path.stat().st_mtime if is_file(path) else 0.0)


def describe(found: Table) -> Plain:
    """What a table is, for listings."""
    low, high = found.beta_range
    entries = sum(series.value.size for panel in found.panels for series in panel.series.values())
    return {
        "name": found.name,
        "title": found.title,
        "parameters": {p.name: (p.low, p.high) for p in found.parameters},
        "beta": (low, high),
        "bound": found.bound,
        "coefficients": entries,
        "responses": bool(found.panels and found.panels[0].orders.size),
        **found.attributes,
    }
