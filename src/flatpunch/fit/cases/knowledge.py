"""Tables of a fit's case file about what is known beforehand: [priors], [posterior] and [plan]."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field

from flatpunch._support.checks import shown
from flatpunch._support.paths import Plain
from flatpunch.files import units as si
from flatpunch.files.tables.fields import Count, Force, Length, Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.fit.cases.values import value_in_si
from flatpunch.fit.parameters.priors import LogNormal, Normal, Prior, Uniform

_DIMENSIONS: dict[str, si.Dimension | None] = {
    "contact": si.LENGTH,
    "baseline": si.FORCE,
    "tilt": si.STIFFNESS,
    "spring_constant": si.STIFFNESS,
    "sensitivity": None,
}
"""What numbers that are not of the case are measured in."""


def priors_of(given: Plain) -> dict[str, Prior]:
    """Priors as they stand in [priors]: { mean, std }, { median, relative } or { min, max } of each parameter."""
    return {name: _prior(name, table) for name, table in given.items()}


def _prior(name: str, table: Any) -> Prior:
    fields = set(table) if isinstance(table, Mapping) else set()
    if fields == {"mean", "std"}:
        mean = _value(name, "mean", table["mean"])
        percent = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", table["std"]) if isinstance(table["std"], str) else None
        return Normal(mean, float(percent[1]) / 100 * abs(mean) if percent else _value(name, "std", table["std"]))
    if fields == {"median", "relative"}:
        relative = table["relative"]
        if isinstance(relative, bool) or not isinstance(relative, (int, float)):
            raise ValueError(f"priors: {name}.relative = {shown(relative)} must be a plain number such as 0.1.")
        return LogNormal(_value(name, "median", table["median"]), float(relative))
    if fields == {"min", "max"}:
        return Uniform(_value(name, "min", table["min"]), _value(name, "max", table["max"]))
    raise ValueError(
        f'priors: {name} = {shown(table)} must be {{ mean = "1 um", std = "50 nm" }} (or std = "5 %"), '
        '{ median = "1 um", relative = 0.05 } or { min = ..., max = ... }.'
    )


def _value(name: str, field: str, given: object) -> float:
    if name not in _DIMENSIONS:
        return value_in_si(name, given)
    dimension = _DIMENSIONS[name]
    if dimension is not None:
        return si.named_si(f"priors: {name}.{field}", given, dimension)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise ValueError(f"priors: {name}.{field} = {shown(given)} must be a plain number.")
    return float(given)


class PosteriorTable(Table):
    """[posterior]: how many draws, and the seed of the random numbers."""

    draws: Count = 10_000
    seed: Count = 0

    def build(self, folder: Path) -> Plain:
        """Return arguments of `FitResult.posterior`."""
        return {"draws": self.draws, "seed": self.seed}


class PlanTable(Table):
    """[plan]: the curve that will be measured, for `flatpunch check`; several depths and tips make a table."""

    depth: Length | list[Length]
    indenters: dict[str, IndenterTable] = Field(default={})
    noise: Force
    points: Count = 1000
    before: Length | None = None
    spring_constant: str | None = None

    def build(self, folder: Path) -> Plain:
        """Return arguments of `planned`."""
        found: Plain = {"depth": self.depth, "noise": self.noise, "points": self.points, "before": self.before}
        if self.indenters:
            found["indenters"] = {name: table.built for name, table in self.indenters.items()}
        if self.spring_constant is not None:
            found["spring_constant"] = si.named_si("spring_constant", self.spring_constant, si.STIFFNESS)
        return found
