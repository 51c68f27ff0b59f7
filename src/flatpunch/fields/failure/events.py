"""What fails where: bodies with their strengths, largest stresses over strength, and the search for the first event."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.readable import readable
from flatpunch.compliance.depth import constants_at, interfaces
from flatpunch.fields.bodies import Solid
from flatpunch.fields.failure.strength import Strength
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Medium, PowerLawHalfSpace, RigidBase

DEEPEST = 2.5
"""Contact radii below the top of a layer down to which it is searched."""


_FOUND, _SOLVED = 1e-3, 1e-7
"""Deviations of stress over strength from one at which the load is found on the grid, and at the refined place."""


@readable
@dataclass(frozen=True, slots=True)
class Event:
    """The largest stress over strength of one kind in one layer: its value and its place (x, y, z) [m]."""

    kind: str
    layer: int
    utilisation: float
    place: tuple[float, float, float]
    body: str = "lower"

    @property
    def what(self) -> tuple[str, int, str]:
        """Kind, layer and body."""
        return self.kind, self.layer, self.body


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

    body: Solid
    strengths: tuple[Strength, ...]
    residual: Array
    name: str = "lower"

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

    def check(self) -> None:
        """Refuse strengths of a rigid base, and residual stresses that fail the body without a contact."""
        last = self.tops.size - 1
        if isinstance(self.body, Medium) and isinstance(self.body.base, RigidBase) and self.strengths[last].of_bulk:
            raise ValueError(f"strengths[{last}] belongs to the rigid base, which has no stresses. Leave it out.")
        if isinstance(self.body, PowerLawHalfSpace) and self.body.exponent < 0:
            raise ValueError(
                f"medium has a modulus that grows without bound towards the surface (exponent = {self.body.exponent:.6g}), so "
                "that the stresses along the surface are infinite under any load. Give its top a GradedLayer."
            )
        for i, (strength, value) in enumerate(zip(self.strengths, self.residual, strict=True)):
            for kind, ratio in strength.utilisation(np.array([value, value, 0.0, 0.0, 0.0, 0.0])):
                if ratio >= 1:
                    raise ValueError(
                        f"residual_stress[{i}] = {value:g} Pa alone exceeds the {kind} strength of that layer, without any load."
                    )

    def depths(self, i: int, radius: float) -> Array:
        """Depths of the grid in one layer under a contact of that radius [m]; its lower face is the last if it has one."""
        tops, strength = self.tops, self.strengths[i]
        face = tops[i + 1 : i + 2]
        if not strength.of_bulk:
            return face
        thickness = float(face[0] - tops[i]) if face.size else np.inf
        deep = min(thickness, DEEPEST * max(radius, float(tops[i]) / 2))
        # intervals of the grid over the depths that are searched below a thick body's surface; thin layers have fewer, at least
        # four
        count = int(np.clip(np.ceil(12 * deep / (DEEPEST * radius)), 4, 12))
        share = (1 - np.cos(np.pi * np.arange(count + 1) / count)) / 2
        return np.unique(np.append(tops[i] + share * deep, face))

    def largest(self, i: int, stress: Array, place: Array) -> list[Event]:
        """Largest utilisation of each kind in a layer; stress (6, n) without the residual one, places (3, n), depth for z."""
        stress = stress.copy()
        stress[:2] += self.residual[i]
        strength, sign = self.strengths[i], -1 if self.upper else 1
        ratios = [(kind, ratio, np.arange(place.shape[1])) for kind, ratio in strength.utilisation(stress)]
        face = np.flatnonzero(place[2] == np.append(self.tops, np.inf)[i + 1])
        if face.size:
            ratios += [(kind, ratio, face) for kind, ratio in strength.interface_utilisation(stress[:, face])]
        found = []
        for kind, ratio, where in ratios:
            worst = int(np.argmax(ratio))
            x, y, z = (float(each) for each in place[:, where[worst]])
            found.append(Event(kind, i, float(ratio[worst]), (x, y, sign * z), self.name))
        return found

    def singular(self, indenter: Indenter, radius: float) -> list[Event]:
        """Infinite stresses in the layer at the surface: under the apex of a sharp tip, its edges, and kinks inside the contact.

        There the pressure is infinite, and so are shear and von Mises stress unless the material is incompressible.
        """
        if isinstance(self.body, PowerLawHalfSpace) or not _sharp(indenter, radius):
            return []
        _, poisson = constants_at(self.body, np.zeros(1), np.zeros(1, dtype=int))
        if poisson[0] > 0.5 - 1e-12:
            return []
        strength = self.strengths[0]
        kinds = [("yield", strength.yield_stress), ("shear", strength.shear)]
        return [Event(kind, 0, np.inf, (0.0, 0.0, 0.0), self.name) for kind, value in kinds if value is not None]


def _sharp(indenter: Indenter, radius: float) -> bool:
    if indenter.corners or (indenter.exponent is not None and indenter.exponent <= 1):
        return True
    rings = np.array([ring for ring in indenter.rings if ring < radius * (1 - 1e-6)])
    if not rings.size or not indenter.round:
        return False
    inside, outside = (indenter.slope(rings * (1 + side), np.zeros(1)) for side in (-1e-9, 1e-9))
    # jump of the slope over the slope from which a ring of the tip is an edge
    return bool((np.abs(outside - inside) > 1e-6 * np.abs(outside)).any())


class Search(Protocol):
    """Contacts of growing size and their events."""

    def limits(self) -> tuple[float, float, float]:
        """Smallest size, where to start, and largest size [m]."""

    def events(self, size: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on a grid."""

    def refined(self, event: Event, size: float) -> Event:
        """The same event, its place refined."""

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """The same event at the place to which it moves as the contact grows."""


def first_event(search: Search) -> tuple[float, Event, list[Event]]:
    """Size at which the first event happens, that event, and all events there; size zero or infinite without a crossing."""
    low, start, high = search.limits()
    size, events = _solved(search.events, start, low, high, _FOUND)
    worst = max(events, key=lambda event: event.utilisation)
    if abs(worst.utilisation - 1) > 0.01:
        # not reached between the limits: from the first touch on, or never
        return (0.0 if worst.utilisation > 1 else np.inf), worst, events
    worst = search.refined(worst, size)
    follow = search.follower(worst, size)
    size, (worst,) = _solved(lambda s: [follow(s)], size, max(low, size / 2), min(high, size * 2), _SOLVED)
    return size, worst, [worst if each.what == worst.what else each for each in search.events(size)]


def _solved(
    events: Callable[[float], list[Event]], start: float, low: float, high: float, tolerance: float
) -> tuple[float, list[Event]]:
    """Size at which the largest utilisation is one, by secants in the logarithms, inside a bracket once there is one."""
    x, floor, ceiling = np.log(start), np.log(max(low, 1e-300)), np.log(high)
    before: tuple[float, float] | None = None
    below, above = -np.inf, np.inf
    for _ in range(60):
        found = events(float(np.exp(x)))
        y = float(np.log(np.clip(max(e.utilisation for e in found), 1e-12, 1e12)))
        if abs(y) < tolerance or (y > 0 and x <= floor) or (y < 0 and x >= ceiling):
            break
        below, above = (max(below, x), above) if y < 0 else (below, min(above, x))
        if above - below < 1e-9:
            break
        slope = 1.0 if before is None or x == before[0] else (y - before[1]) / (x - before[0])
        step = -y / slope if slope > 0.1 else -y
        before = x, y
        # largest change of the contact in one step of the search
        following = float(np.clip(x + np.clip(step, -np.log(8.0), np.log(8.0)), floor, ceiling))
        if np.isfinite(above - below) and not below < following < above:
            following = (below + above) / 2
        x = following
    return float(np.exp(x)), found


def margins(events: Sequence[Event], *, named: bool) -> dict[str, float]:
    """Strength over stress by criterion; infinite under compression. `named`: with the body, where there are two."""
    return {
        (f"{event.body}." if named else "") + f"layers[{event.layer}].{event.kind}": (
            1 / event.utilisation if event.utilisation > 0 else float("inf")
        )
        for event in events
    }


def expected_utilisation(bodies: Sequence[Judged], radius: Array, pressure: Array) -> Array:
    """Rough largest stress over strength under mean pressures [Pa] on discs of given radii [m]: where a search may start."""
    found = np.zeros_like(radius)
    for each in bodies:
        faces = np.append(each.tops[1:], np.inf)
        for strength, top, face in zip(each.strengths, each.tops, faces, strict=True):
            # notation: shares of the mean pressure, falling off with depth as on the axis of a half-space
            for value, share, depth in (
                (strength.yield_stress, 0.6, top),
                (strength.shear, 0.3, top),
                (strength.tensile, 0.2, 0.0),
                (strength.interface_tension, 0.1, face),
                (strength.interface_shear, 0.3, face),
            ):
                if value is not None:
                    found = np.maximum(found, share * pressure / (1 + (depth / radius) ** 2) / value)
    return found
