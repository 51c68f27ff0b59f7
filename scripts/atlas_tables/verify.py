"""How well a table reproduces direct solutions: random radii and parameters, solved both ways."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np

from atlas_tables.build import Ways
from atlas_tables.families import Family
from atlas_tables.solving import solve_directly
from flatpunch._support.checks import Array
from flatpunch.atlas import Table
from flatpunch.parallel import solve_points

POINTS = 2000
"""Random points for the bound that is written to a file."""


QUANTITIES = ("Kbar", "kappa_1", "kappa_2", "edge")


@dataclass(frozen=True)
class Verification:
    """Relative errors of a table at random points.

    Attributes
    ----------
    beta : ndarray, shape (n,)
        Radii over the medium's length.
    parameters : mapping
        Name -> values, shape (n,).
    errors : mapping
        "Kbar", "kappa_1", "kappa_2" and "edge" (the edge coefficient) -> relative errors, shape (n,).
    """

    beta: Array
    parameters: dict[str, Array]
    errors: dict[str, Array]

    @property
    def largest(self) -> dict[str, float]:
        """Largest relative error of each quantity."""
        return {name: float(np.abs(error).max()) for name, error in self.errors.items()}

    @property
    def bound(self) -> float:
        """What holds for Kbar and the moments: twice the largest error found, with one digit."""
        # bound over the largest error found, so that other random points keep to it
        worst = 2.0 * max(self.largest[name] for name in QUANTITIES[:3])
        size = 10.0 ** np.floor(np.log10(max(worst, 1e-15)))
        return float(f"{np.ceil(worst / size) * size:.0e}")


def verify(table: Table, family: Family, *, points: int = POINTS, seed: int = 0, **ways: Unpack[Ways]) -> Verification:
    """Compare a table with direct solutions at random points, which `seed` makes repeatable.

    Radii are uniform in ln beta; half of the parameter values are uniform in the value (its logarithm, for logarithmic scales),
    half in the coordinate of the table, which visits the ends more.
    """
    rng = np.random.default_rng(seed)
    low, high = np.log(table.beta_range)
    beta = np.exp(rng.uniform(low, high, points))
    parameters = {}
    for p in table.parameters:
        spread = p.at(rng.uniform(-1, 1, points))
        plain = rng.uniform(p.low, p.high, points) if p.scale != "log" else spread
        parameters[p.name] = np.where(rng.random(points) < 0.5, spread, plain)
    media = [
        {"medium": family.make(**{name: float(v[i]) for name, v in parameters.items()}), "beta": float(beta[i])}
        for i in range(points)
    ]
    solved = solve_points(solve_directly, media, title=f"Checking {table.name}", **ways)
    if solved.failed:
        i, reason = next(iter(solved.failed.items()))
        raise RuntimeError(
            f"{len(solved.failed)} points of {table.name!r} could not be solved; {media[int(str(i))]}: {reason}"
        )
    exact = np.array([[float((solved[i].numbers or {})[name]) for name in QUANTITIES] for i in range(points)]).T
    found = (*table.stiffness_and_moments(beta, (1, 2), **parameters), table.edge_coefficients(beta, **parameters))
    errors = {name: f / e - 1 for name, f, e in zip(QUANTITIES, found, exact, strict=True)}
    return Verification(beta, parameters, errors)


def verified(table: Table, verification: Verification) -> Table:
    """Table that carries its measured bound, and how it was measured."""
    measured = {f"verified_error_{name}": value for name, value in verification.largest.items()}
    attributes = {**table.attributes, "verified_points": verification.beta.size, **measured}
    return replace(table, bound=verification.bound, attributes=attributes)
