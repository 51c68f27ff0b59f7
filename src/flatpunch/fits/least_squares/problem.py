"""Least-squares problem of one or several curves.

The sum of squares is that of all curves, each over the variance of its own noise:

    chi^2 = sum_i |r_i(shared, own_i)|^2 / s_i^2,

with x = (shared parameters, own parameters of each curve, contact point and background of each curve). One curve is the case
n = 1, whose x is that of its own problem; s_1 is one there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices, real
from flatpunch._support.declared import Place
from flatpunch.fits.least_squares.minimum import Minimum
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.parameters.sample import OF, Scale
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import Unknowns


@dataclass(frozen=True, eq=False)
class Setup:
    """A least-squares problem.

    Attributes
    ----------
    part : Curve
        What is shown of the curve.
    used : ndarray of bool
        Which of its points are fitted.
    objective : Objective or HistoryObjective
        Residuals.
    lower, upper : ndarray
        Limits of all of x.
    start : callable
        () -> x to descend from.
    settings : Settings
        With the background that was chosen.
    coarse : Objective, optional
        The same problem on block means with the same minimum, at a fraction of the cost.
    other : Objective, optional
        The same problem over another background that the data allow; what it moves widens the intervals.
    again : callable, optional
        x at the minimum -> the problem with other points left out, or None if it is settled.
    notes : tuple of str
    reached : float, optional
        Deepest reading of the approach, fitted or not [m].
    tilted : bool
        Whether the readings before the contact show a tilt where the user has not asked for one.
    doubtful : bool
        Whether the user left the baseline open, and a constant describes these readings.
    """

    part: Curve
    used: Flags
    objective: Unknowns
    lower: Array
    upper: Array
    start: Callable[[], Array]
    settings: Settings
    notes: tuple[str, ...] = ()
    reached: float | None = None
    coarse: Unknowns | None = None
    other: Unknowns | None = None
    again: Callable[[Array], Setup | None] | None = None
    tilted: bool = False
    doubtful: bool = False


def enough(curve: Curve, objective: Unknowns) -> None:
    """Refuse more parameters than points."""
    count = len(objective.names)
    if objective.depth.size <= count:
        raise CurveError(f"{curve.name}: {objective.depth.size} points cannot determine {count} parameters.")


def with_nuisance(
    objective: Unknowns, limits: tuple[Array, Array], contact: tuple[float, float]
) -> tuple[Array, Array]:
    """Limits of the free parameters, of the contact point [m], and none for the background."""
    offset, unit = objective.units["contact"]
    bounds = {"contact": ((contact[0] - offset) / unit, (contact[1] - offset) / unit)}
    ends = [bounds.get(name, (-np.inf, np.inf)) for name in objective.nuisance]
    return np.append(limits[0], [low for low, _ in ends]), np.append(limits[1], [high for _, high in ends])


def contact_ends(settings: Settings, turned: float, low: float, high: float) -> tuple[float, float]:
    """Limits of the contact point on an axis whose sign is `turned` [m]: those of the user, or the given ones."""
    asked = settings.contact_limits(turned)
    return (low if asked[0] is None else asked[0]), (high if asked[1] is None else asked[1])


def cut(curve: Curve, settings: Settings, depth_sign: float = 1.0, force_sign: float = 1.0) -> Curve:
    """The curve before it first reaches `force_to` or `depth_to`, given on the user's own axes (signs of turned ones)."""
    end = curve.depth.size
    for name, column, sign in (("force_to", curve.force, force_sign), ("depth_to", curve.depth, depth_sign)):
        limit = getattr(settings, name)
        if limit is not None:
            beyond = column > sign * real(name, limit)
            if beyond.any():
                end = min(end, int(np.argmax(beyond)))
    return curve if end == curve.depth.size else curve.taken(slice(0, end))


@dataclass(frozen=True, eq=False)
class Problem:
    """Residuals of all curves over their noise, as a function of x.

    Attributes
    ----------
    setups : tuple of Setup
        One for each curve.
    names : tuple of str
        Of all entries of x; those of one curve of several end in " @ " and its name.
    free : tuple of str
        Parameters of the sample, shared and own, which come first among the names.
    places : tuple of ndarray of int
        Where in x the entries of each curve's own x are.
    start : ndarray
        Internal values of x where the search began.
    noise : ndarray, shape (curves,)
        Standard deviation by which the residuals of each are divided, over its force range.
    """

    setups: tuple[Setup, ...]
    names: tuple[str, ...]
    free: tuple[str, ...]
    places: tuple[Indices, ...]
    start: Array
    noise: Array
    bounds: tuple[Array, Array] = field(init=False)

    def __post_init__(self) -> None:
        lower, upper = np.empty(len(self.names)), np.empty(len(self.names))
        for setup, place in zip(reversed(self.setups), reversed(self.places), strict=True):
            # of shared parameters those of the first curve
            lower[place], upper[place] = setup.lower, setup.upper
        object.__setattr__(self, "bounds", (lower, upper))

    @classmethod
    def of(cls, setups: Sequence[Setup], starts: Sequence[Array], shared: int) -> Problem:
        """The problem of curves that share their first parameters, from the x of each; shared ones begin at the median."""
        if len(setups) == 1:
            (setup,), (x,) = setups, starts
            names, free = setup.objective.names, setup.objective.model.free
            return cls((setup,), names, free, (np.arange(x.size),), x, np.ones(1))
        count = len(setups[0].objective.model.free)
        names_: list[str] = list(setups[0].objective.names[:shared])
        places: list[list[int]] = [list(range(shared)) for _ in setups]
        for some in (slice(shared, count), slice(count, None)):
            for setup, place in zip(setups, places, strict=True):
                mine = setup.objective.names[some]
                place += range(len(names_), len(names_) + len(mine))
                names_ += [f"{name}{OF}{setup.part.name}" for name in mine]
            if some.stop == count:
                free = tuple(names_)
        start = np.empty(len(names_))
        for x, place in zip(starts, places, strict=True):
            start[place] = x
        start[:shared] = np.median([x[:shared] for x in starts], axis=0)
        indices = tuple(np.array(place) for place in places)
        return cls(tuple(setups), tuple(names_), free, indices, start, np.ones(len(setups)))

    @property
    def parts(self) -> tuple[Any, ...]:
        """The problem of each curve, an `Unknowns` of its kind."""
        return tuple(setup.objective for setup in self.setups)

    @property
    def tabulated(self) -> bool:
        """Whether an evaluation costs no solution of a contact."""
        return all(part.model.tabulated for part in self.parts)

    @property
    def coarse(self) -> Problem:
        """The problem on block means of the curves, as far as there are any."""
        setups = [setup if setup.coarse is None else replace(setup, objective=setup.coarse) for setup in self.setups]
        return replace(self, setups=tuple(setups))

    @cached_property
    def numbers(self) -> dict[str, Place]:
        """Records of all entries of x, by name; the paths of those of one curve of several have its name as well."""
        found = [(place, part.numbers) for part, place in zip(self.parts, self.places, strict=True)]
        known = {j: each for place, own in found for j, each in zip(place, own.values(), strict=True)}
        return {name: known[j]._replace(path=name) for j, name in enumerate(self.names)}

    @cached_property
    def scales(self) -> dict[str, Scale]:
        """How all entries of x follow from their internal values, by name."""
        found = [(place, part.scales()) for part, place in zip(self.parts, self.places, strict=True)]
        known = {j: each for place, own in found for j, each in zip(place, own.values(), strict=True)}
        return {name: known[j] for j, name in enumerate(self.names)}

    def external(self, j: int, x: Array) -> Array:
        """Internal values x of parameter j in SI, infinite ones included."""
        return np.asarray(self.scales[self.names[j]].external(np.asarray(x)))

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n)."""
        if len(self.setups) == 1:
            found_: tuple[Array, Array] = self.parts[0].evaluate(x)
            return found_
        found = [part.evaluate(x[places]) for part, places in zip(self.parts, self.places, strict=True)]
        residual = np.concatenate([r / s for (r, _), s in zip(found, self.noise, strict=True)])
        jacobian = np.zeros((x.size, residual.size))
        begin = 0
        for (r, j), places, s in zip(found, self.places, self.noise, strict=True):
            jacobian[places, begin : begin + r.size] = j / s
            begin += r.size
        return residual, jacobian

    def at(self, found: Minimum) -> Minimum:
        """The minimum with residuals and normal matrix of this problem."""
        residual, jacobian = self.evaluate(found.x)
        return replace(found, residual=residual, normal=jacobian @ jacobian.T)
