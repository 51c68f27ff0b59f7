"""What fails where: bodies with their strengths, largest stresses over strength, and the search for the first event."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import Any, Protocol

import numpy as np
from scipy.ndimage import label, maximum_filter

from flatpunch._support.checks import ROUNDING, TINY, Array, BadValue
from flatpunch._support.readable import readable
from flatpunch.compliances.stack import interfaces
from flatpunch.media import Stack
from flatpunch.stresses.failure.strength import Strength
from flatpunch.stresses.points import residual_stresses

DEEPEST, _INTERVALS = 2.5, 12
"""Contact radii below the top of a layer down to which it is searched, and intervals of the grid over them."""

STEPS, FINER, ROUNDS = np.linspace(-1, 1, 5), 3.0, 3
"""Places along each direction, as shares of an interval, among which one is refined; the factor by which each round is finer;
least rounds."""

_WORTH = 0.2
"""Share by which a local maximum on the grid may be below the largest to be refined too."""

_FOUND, _SOLVED, _MISSED, SURE = 1e-3, 1e-7, 0.01, 1e-4
"""Deviations of stress over strength from one: found on the grid, found at the refined place, not found, exceeded elsewhere."""

BEYOND = 1e-6
"""Share by which a contact is larger than a kink of the tip that it has just passed."""

_STRIDE, _ROUNDS = np.log(10.0), 20
"""Largest change of the logarithm of the size in one step of the search; most halvings or doublings of it from the load of the
grid to that of the refined place."""


@readable
@dataclass(frozen=True, slots=True)
class Event:
    """The largest stress over strength of one kind in one layer: its value and its place (x, y, z) [m].

    `rim`: at the rim of a contact on cells, extrapolated from outside.
    """

    kind: str
    layer: int
    utilisation: float
    place: tuple[float, float, float]
    body: str = "lower"
    rim: bool = False

    @property
    def what(self) -> tuple[str, int, str]:
        """Kind, layer and body."""
        return self.kind, self.layer, self.body

    @property
    def of_face(self) -> bool:
        """Whether it is on the lower face of the layer."""
        return self.kind.startswith("interface")

    @property
    def polar(self) -> tuple[float, float, float]:
        """Radius [m], polar angle [rad] and depth [m] of its place."""
        x, y, z = self.place
        return float(np.hypot(x, y)), float(np.arctan2(y, x)), abs(z)


@dataclass(frozen=True, slots=True)
class Judged:
    """A body with its strengths and residual stresses, from the surface inwards.

    Attributes
    ----------
    body : HalfSpace, Medium or PowerLawHalfSpace
        The body.
    strengths : tuple of Strength
        Of each layer and the base.
    residual : ndarray, shape (layers + 1,)
        Biaxial stress [Pa].
    name : {"lower", "upper"}
        Which of two bodies; a single one is the lower.
    """

    body: Stack
    strengths: tuple[Strength, ...]
    residual: Array
    name: str = "lower"

    @classmethod
    def of(cls, body: Stack, strengths: tuple[Strength, ...], residual: Any, name: str = "lower") -> Judged:
        """A body with checked strengths; `residual` has the stresses as users give them."""
        own = residual_stresses(body, residual)
        return cls(body, strengths, np.zeros(len(strengths)) if own is None else own, name)

    @property
    def upper(self) -> bool:
        """Whether depth runs against z."""
        return self.name == "upper"

    @property
    def tops(self) -> Array:
        """Depth of the upper face of each layer and the base [m]."""
        return np.concatenate([[0.0], interfaces(self.body)])

    @property
    def watched(self) -> list[int]:
        """Layers that have strengths."""
        return [i for i, each in enumerate(self.strengths) if each.of_bulk or each.of_interface]

    @property
    def deepest(self) -> float:
        """Depth of the lowest face that is watched [m]: the lower one of a layer whose interface is, else the upper one."""
        tops = np.append(self.tops, 0.0)
        return max((float(tops[i + self.strengths[i].of_interface]) for i in self.watched), default=0.0)

    def only(self, what: tuple[str, int, str]) -> Judged:
        """The body with one strength alone, or none if that belongs to the other body."""
        kind, layer, body = what
        name = "yield_stress" if kind == "yield" else kind.replace(" ", "_")
        value = getattr(self.strengths[layer], name) if body == self.name else None
        chosen = Strength(**{name: value})
        return replace(self, strengths=tuple(chosen if i == layer else Strength() for i in range(len(self.strengths))))

    def check(self) -> None:
        """Refuse strengths of a rigid base, and residual stresses that fail the body without a contact."""
        last = self.tops.size - 1
        if self.body.base.rigid and self.strengths[last].of_bulk:
            raise ValueError(f"strengths[{last}] belongs to the rigid base, which has no stresses. Leave it out.")
        self.check_surface()
        for i, (strength, value) in enumerate(zip(self.strengths, self.residual, strict=True)):
            for kind, ratio in strength.utilisation(np.array([value, value, 0.0, 0.0, 0.0, 0.0])):
                if ratio >= 1:
                    raise BadValue(
                        f"residual_stress[{i}]",
                        f"{value:g}",
                        f"Pa alone exceeds the {kind} strength of that layer, without any load.",
                    )

    def check_surface(self) -> None:
        """Refuse bodies whose stresses along the surface are infinite under any load."""
        law = self.body.power_law
        if law and law.exponent < 0:
            raise ValueError(
                f"medium has a modulus that grows without bound towards the surface (exponent = {law.exponent:.6g}), so "
                "that the stresses along the surface are infinite under any load. Give its top a GradedLayer."
            )

    def interval(self, event: Event, radius: float) -> float:
        """Interval of depth [m] over which the place of an event is refined first: a little more than the grid's longest."""
        top, bottom = np.append(self.tops, np.inf)[event.layer : event.layer + 2]
        return 0.0 if event.of_face else 0.15 * min(float(bottom - top), DEEPEST * max(radius, float(top) / 2))

    def depths(self, i: int, radius: float) -> Array:
        """Depths of the grid in one layer under a contact of that radius [m]; its lower face is the last if it has one."""
        face = self.tops[i + 1 : i + 2]
        return np.unique(np.append(self._inside(i, radius), face)) if self.strengths[i].of_bulk else face

    def _inside(self, i: int, radius: float) -> Array:
        top, face = np.append(self.tops, np.inf)[i : i + 2]
        deep = min(float(face - top), DEEPEST * max(radius, float(top) / 2))
        # thin layers have fewer intervals, at least four
        count = int(np.clip(np.ceil(_INTERVALS * deep / (DEEPEST * radius)), 4, _INTERVALS))
        return np.asarray(top + (1 - np.cos(np.pi * np.arange(count + 1) / count)) / 2 * deep)

    def largest(self, i: int, stress: Array, place: Array) -> list[Event]:
        """Largest utilisation of each kind in a layer; stress (6, ..., nz) without the residual one, places (3, ..., nz)."""
        return self._events(i, stress, place, lambda ratio: [np.unravel_index(np.argmax(ratio), ratio.shape)])

    def maxima(self, i: int, stress: Array, place: Array, parts: Sequence[slice] = (slice(None),)) -> list[Event]:
        """Local maxima of each kind on a grid in a layer, those close to the largest, in each part of its second axis."""

        def peaks(ratio: Array) -> list[tuple[object, ...]]:
            least = ratio.max() - _WORTH * abs(ratio.max())
            found: list[tuple[object, ...]] = []
            for part in parts:
                here = ratio[:, part]
                high = (here == maximum_filter(here, size=3)) & (here >= least)
                # equal neighbours, as the zeros of a free part or the angles at the axis, are one place
                regions, count = label(high, np.ones((3,) * ratio.ndim))
                for n in range(1, count + 1):
                    x, y, z = np.unravel_index(int(np.argmax(regions == n)), here.shape)
                    found.append((x, y + (part.start or 0), z))
            return found

        return self._events(i, stress, place, peaks)

    def _events(
        self, i: int, stress: Array, place: Array, chosen: Callable[[Array], list[tuple[Any, ...]]]
    ) -> list[Event]:
        """Events at the places of a grid that are chosen by stress over strength; z holds depths, the lower face last."""
        stress = stress.copy()
        stress[:2] += self.residual[i]
        strength, sign = self.strengths[i], -1 if self.upper else 1
        ratios = list(strength.utilisation(stress))
        if place[2].flat[-1] == np.append(self.tops, np.inf)[i + 1]:
            ratios += strength.interface_utilisation(stress[..., -1:])
        found = []
        for kind, ratio in ratios:
            there = place[..., -ratio.shape[-1] :]
            for at in chosen(ratio):
                x, y, z = (float(axis[at]) for axis in there)
                found.append(Event(kind, i, float(ratio[at]), (x, y, sign * z), self.name))
        return found


class Search(Protocol):
    """Contacts of growing size and their events."""

    def limits(self) -> tuple[float, float, float]:
        """Smallest size, where to start, and largest size [m]."""

    def singular(self, size: float) -> list[Event]:
        """Infinite stresses at a size."""

    def events(self, size: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on a grid."""

    def maxima(self, size: float) -> list[Event]:
        """Local maxima of every kind in every layer, on a grid."""

    def refined(self, events: Sequence[Event], size: float) -> list[Event]:
        """Return events with their places refined."""

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """Follow an event to the place to which it moves as the contact grows."""

    def turns(self, low: float, high: float) -> list[float]:
        """Sizes between which stresses may rise and fall again, ascending: where the slope of the tip turns, and between."""


def outwards(
    on_grid: Callable[[int], list[Event]], at_edge: Callable[[int, Event], bool], least: int = 1
) -> list[Event]:
    """Events on grids 0, 1, ..., each wider than the one before, as long as a stress is largest at the edge of the last one.

    Layers on springs and stiff layers bend over many thicknesses.
    """
    found: list[Event] = []
    largest: dict[tuple[str, int, str], float] = {}
    for n in count():
        here = on_grid(n)
        found += here
        rising = {
            each.what: each.utilisation
            for each in here
            if at_edge(n, each) and each.utilisation > (1 + _FOUND) * largest.get(each.what, 0.0)
        }
        if not rising and n + 1 >= least:
            break
        largest |= rising
    return found


def first_event(search: Search) -> tuple[float, Event, list[Event]]:
    """Size at which the first event happens, that event, and all events there; size zero or infinite without a crossing.

    Zero: the refined place is above its strength at the smallest size. Where the estimate jumps over one, the size is that of the
    jump, and the event's utilisation, which is not one then, is part of its error. It is infinite where a kink of the tip comes
    into contact first.
    """
    low, start, high = search.limits()
    if at_once := search.singular(low):
        return 0.0, at_once[0], at_once
    kink = next((size for size in search.turns(low, high) if search.singular(size)), None)
    top = high if kink is None else kink * (1 - 2 * BEYOND)
    found = _crossing(search, low, min(start, top), top)
    for size in search.turns(low, min(found[0], top)):
        if max(event.utilisation for event in search.events(size)) > 1 + _MISSED:
            return _crossing(search, low, size, size)
    if found[0] == np.inf and kink is not None:
        return kink, search.singular(kink)[0], search.events(kink)
    return found


def _crossing(search: Search, low: float, start: float, high: float) -> tuple[float, Event, list[Event]]:
    """A crossing between two sizes, found from `start` on."""
    size, events = _solved(search.events, start, low, high, _FOUND)
    worst = max(events, key=lambda event: event.utilisation)
    if _missed(worst) and worst.utilisation < 1 and size >= high * (1 - ROUNDING):
        # the grid may be below one where the refined place is not
        (worst,) = search.refined([worst], size)
        if worst.utilisation < 1:
            return np.inf, worst, events
    size, worst = _followed(search, worst, size, low, high)
    for _ in range(_ROUNDS):
        # the place may have moved, and another, which the grid under- or overestimates, may be worse there
        near = [worst, *(each for each in search.maxima(size) if 1 - _WORTH < each.utilisation < np.inf)]
        higher = [each for each in search.refined(near, size) if each.utilisation > 1 + SURE]
        if not higher or size <= low * (1 + ROUNDING):
            break
        size, worst = _followed(search, max(higher, key=lambda event: event.utilisation), size, low, high)
    if _missed(worst) and worst.utilisation > 1 and size <= low * (1 + ROUNDING):
        return 0.0, worst, [worst if each.what == worst.what else each for each in search.events(low)]
    if _missed(worst) and worst.utilisation < 1 and size >= high * (1 - ROUNDING):
        return np.inf, worst, search.events(high)
    return size, worst, [worst if each.what == worst.what else each for each in search.events(size)]


def _followed(search: Search, worst: Event, size: float, low: float, high: float) -> tuple[float, Event]:
    """Size at which one event happens, its place refined."""
    for _ in range(_ROUNDS):
        (worst,) = search.refined([worst], size)
        follow = partial(_alone, search.follower(worst, size))
        least, most = max(low, size / 2), min(high, size * 2)
        size, (worst,) = _solved(follow, size, least, most, _SOLVED)
        if not _missed(worst) or least * (1 + ROUNDING) < size < most * (1 - ROUNDING):
            break
    return size, worst


def _alone(follow: Callable[[float], Event], size: float) -> list[Event]:
    return [follow(size)]


def _missed(event: Event) -> bool:
    """Whether no size was found at which stress and strength are equal."""
    return abs(event.utilisation - 1) > _MISSED


def _solved(
    events: Callable[[float], list[Event]], start: float, low: float, high: float, tolerance: float
) -> tuple[float, list[Event]]:
    """Size at which the largest utilisation is one, by secants in the logarithms, inside a bracket once there is one."""
    x, floor, ceiling = np.log(start), np.log(max(low, TINY)), np.log(high)
    before: tuple[float, float] | None = None
    below, above = -np.inf, np.inf
    for _ in range(60):
        found = events(float(np.exp(x)))
        y = float(np.log(np.clip(max(e.utilisation for e in found), ROUNDING, 1 / ROUNDING)))
        if abs(y) < tolerance or (y > 0 and x <= floor) or (y < 0 and x >= ceiling):
            break
        below, above = (max(below, x), above) if y < 0 else (below, min(above, x))
        if above - below < 1e-9:
            break
        slope = 1.0 if before is None or x == before[0] else (y - before[1]) / (x - before[0])
        step = -y / slope if slope > 0.1 else -y
        before = x, y
        following = float(np.clip(x + np.clip(step, -_STRIDE, _STRIDE), floor, ceiling))
        if np.isfinite(above - below) and not below < following < above:
            following = (below + above) / 2
        x = following
    return float(np.exp(x)), found


def criterion_name(what: tuple[str, int, str], *, named: bool) -> str:
    """Name of a criterion; `named`: with the body, where there are two."""
    kind, layer, body = what
    return (f"{body}." if named else "") + f"layers[{layer}].{kind}"


def margins(events: Sequence[Event], *, named: bool) -> dict[str, float]:
    """Strength over stress by criterion; infinite under compression."""
    return {
        criterion_name(event.what, named=named): 1 / event.utilisation if event.utilisation > 0 else float("inf")
        for event in events
    }


def of_kind(kind: str, events: Sequence[Event]) -> Event:
    """The one event of a kind."""
    (found,) = [each for each in events if each.kind == kind]
    return found


def largest_of_each(events: Iterable[Event]) -> dict[tuple[str, int, str], Event]:
    """The largest of each kind in each layer."""
    best: dict[tuple[str, int, str], Event] = {}
    for each in events:
        if each.what not in best or each.utilisation > best[each.what].utilisation:
            best[each.what] = each
    return best


def body_of(bodies: Sequence[Judged], event: Event) -> Judged:
    """The body that an event is in."""
    return next(each for each in bodies if each.name == event.body)
