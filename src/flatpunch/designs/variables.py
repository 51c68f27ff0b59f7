"""The numbers that a design varies, as a vector between bounds.

Numbers with a unit are varied by their logarithm. A name without its last index stands for all of a list: "layers[0].young" for
the nodes of a tabulated grading. "indenter.slopes" stands for the heights of a RadialProfile by the slopes between them, which
are > 0: so the profile ascends.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, BadValue, Flags, follows, shown, values
from flatpunch.indenters import RadialProfile
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.media.paths import with_values
from flatpunch.sensitivities.parameters import Parameter, parameters

_SLOPES = "indenter.slopes"


@dataclass(frozen=True, eq=False)
class Variables:
    """The vector u of a design.

    Attributes
    ----------
    names, units : tuple of str
        Of each entry.
    start, low, high : ndarray, shape (n,)
        Values in the case and bounds [SI].
    logarithmic : ndarray of bool, shape (n,)
        Whether u is the logarithm of the value.
    wanted : tuple of Parameter
        The parameters whose derivatives are needed.
    radii : ndarray or None
        Radii of a RadialProfile whose slopes are the last entries.
    listed : ndarray of bool, shape (n,)
        Whether an entry came with a whole list, some of which a contact may not reach.
    """

    medium: Body
    indenter: Indenter
    names: tuple[str, ...]
    units: tuple[str, ...]
    start: Array
    low: Array
    high: Array
    logarithmic: Flags
    wanted: tuple[Parameter, ...]
    radii: Array | None
    listed: Flags

    def internal(self, value: Array) -> Array:
        """u of values."""
        return np.where(self.logarithmic, np.log(np.where(self.logarithmic, value, 1.0)), value)

    def external(self, u: Array) -> Array:
        """Values of u, never beyond the bounds by rounding."""
        return np.clip(np.where(self.logarithmic, np.exp(np.where(self.logarithmic, u, 0.0)), u), self.low, self.high)

    def case(self, u: Array) -> tuple[Body, Indenter]:
        """Medium and tip at u."""
        value = self.external(u)
        if self.radii is None:
            return with_values(self.medium, self.indenter, dict(zip(self.names, value.tolist(), strict=True)))
        plain = value.size - (self.radii.size - 1)
        changes = dict(zip(self.names[:plain], value[:plain].tolist(), strict=True))
        heights = np.cumsum(value[plain:] * np.diff(self.radii))
        changes |= {f"indenter.f[{j}]": float(height) for j, height in enumerate(heights, 1)}
        return with_values(self.medium, self.indenter, changes)

    def by_u(self, derivatives: Array, u: Array) -> Array:
        """Derivatives by u of those by the wanted parameters, shape (..., parameters) -> (..., n)."""
        value = self.external(u)
        scale = np.where(self.logarithmic, value, 1.0)
        if self.radii is None:
            return np.asarray(derivatives * scale)
        plain = value.size - (self.radii.size - 1)
        # a slope lifts all heights beyond it
        tail = np.cumsum(derivatives[..., plain:][..., ::-1], axis=-1)[..., ::-1] * np.diff(self.radii)
        return np.asarray(np.concatenate([derivatives[..., :plain], tail], axis=-1) * scale)

    def renewed(self, medium: Body, indenter: Indenter) -> list[Parameter]:
        """The wanted parameters with the values and laws of a new case."""
        known = {each.path: each for each in parameters(medium, indenter)}
        return [known[each.path] for each in self.wanted]


def variables(medium: Body, indenter: Indenter, vary: Mapping[str, tuple[float, float]]) -> Variables:
    """Read what is varied; an error for names that are not there, and bounds that are none or do not hold the present value."""
    if not follows(vary, Mapping) or not vary:
        raise TypeError(
            f"vary = {shown(vary)} must name the numbers to vary with their bounds, e.g. {{'layers[0].thickness': (1e-7, 1e-5)}}."
        )
    known = {each.path: each for each in parameters(medium, indenter)}
    entries: list[tuple[Parameter, tuple[float, float]]] = []
    slopes: tuple[float, float] | None = None
    listed: list[bool] = []
    for name, bounds in vary.items():
        pair = _bounds(name, bounds)
        if name == _SLOPES:
            if not isinstance(indenter, RadialProfile):
                raise ValueError(f"vary: {shown(name)} goes with a RadialProfile, whose heights it varies.")
            slopes = pair
            continue
        chosen = _chosen(name, known)
        entries += [(each, pair) for each in chosen]
        listed += [name not in known] * len(chosen)
    if len({each.path for each, _ in entries}) < len(entries):
        raise ValueError("vary names a number twice: a list by its name, and one of its entries.")
    names = [each.path for each, _ in entries]
    units = [each.unit for each, _ in entries]
    start = [each.value for each, _ in entries]
    low, high = [pair[0] for _, pair in entries], [pair[1] for _, pair in entries]
    wanted = [each for each, _ in entries]
    radii = None
    if slopes is not None and isinstance(indenter, RadialProfile):
        radii = np.asarray(indenter.r, dtype=float)
        present = np.diff(np.asarray(indenter.f, dtype=float)) / np.diff(radii)
        names += [f"{_SLOPES}[{j}]" for j in range(present.size)]
        units += [""] * present.size
        start += present.tolist()
        low += [slopes[0]] * present.size
        high += [slopes[1]] * present.size
        listed += [True] * present.size
        wanted += [_height(known, indenter, j) for j in range(1, radii.size)]
    first, least, most = (np.array(each, dtype=float) for each in (start, low, high))
    _check_start(names, first, least, most)
    logarithmic = np.array([bool(unit) or name.startswith(_SLOPES) for name, unit in zip(names, units, strict=True)])
    _check_logarithms(names, least, logarithmic)
    for name, pair, several in zip(names, zip(low, high, strict=True), listed, strict=True):
        if not several:
            _check_possible(medium, indenter, name, pair)
    return Variables(
        medium,
        indenter,
        tuple(names),
        tuple(units),
        first,
        least,
        most,
        logarithmic,
        tuple(wanted),
        radii,
        np.array(listed),
    )


def unit_of(medium: Body, indenter: Indenter, name: str) -> str:
    """SI unit of a number, or of the entries of a list; empty without one."""
    if name == _SLOPES:
        return ""
    known = {each.path: each for each in parameters(medium, indenter)}
    return _chosen(name, known)[0].unit


def _height(known: Mapping[str, Parameter], indenter: RadialProfile, j: int) -> Parameter:
    name = f"indenter.f[{j}]"
    if name not in known:
        raise ValueError(
            f"vary: {_SLOPES!r} needs a profile that ascends everywhere; its height {j} is {indenter.f[j]:g} m."
        )
    return known[name]


def _bounds(name: object, bounds: object) -> tuple[float, float]:
    if not isinstance(name, str):
        raise TypeError(f"vary: {shown(name)} must be the name of a number, a text.")
    pair = values(f"vary[{name!r}]", bounds, minimum=-np.inf)
    if pair.size != 2 or not pair[0] < pair[1]:
        raise BadValue(f"vary[{shown(name)}]", shown(bounds), "must be two bounds, the smaller one first.")
    return float(pair[0]), float(pair[1])


def _chosen(name: str, known: Mapping[str, Parameter]) -> list[Parameter]:
    if name in known:
        return [known[name]]
    inside = [each for each in known.values() if each.path.startswith((f"{name}[", f"{name}.entries["))]
    if not inside:
        near = difflib.get_close_matches(name, known, n=1)
        advice = f"; did you mean {near[0]!r}?" if near else "."
        raise ValueError(
            f"vary: {shown(name)} is not a number of this medium or tip{advice} It has {shown(', '.join(known), 1000)}."
        )
    return inside


def _check_start(names: list[str], start: Array, low: Array, high: Array) -> None:
    outside = (start < low) | (start > high)
    if outside.any():
        i = int(np.argmax(outside))
        raise ValueError(
            f"vary: {names[i]} = {start[i]:.6g} starts outside its bounds {low[i]:.6g} to {high[i]:.6g}. Change the case or the "
            "bounds."
        )


def _check_possible(medium: Body, indenter: Indenter, name: str, bounds: tuple[float, float]) -> None:
    """Refuse bounds at which there is no such medium or tip."""
    for bound in bounds:
        try:
            with_values(medium, indenter, {name: bound})
        except ValueError as error:
            raise ValueError(f"vary: the bound {bound:g} of {name} is impossible: {error}") from None


def _check_logarithms(names: list[str], low: Array, logarithmic: Flags) -> None:
    wrong = logarithmic & (low <= 0)
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(f"vary: the lower bound {low[i]:g} of {names[i]} must be > 0.")
