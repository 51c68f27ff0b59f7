"""`critical_load`: the load, place and kind of the first failure under a growing round contact.

Stress over strength is taken on grids in the plane of sliding that follow the contact (radii in units of its own, depths of
each layer down to a few radii), faces and rim included; its largest value is brought to one by secants in the logarithm of
the radius, and the place of the first event is then refined.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliance import Kernel, compliance
from flatpunch.compliance.depth import interfaces
from flatpunch.contact.round.mean_profile import mean_profile, resolved_radius
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fields.bodies import Located
from flatpunch.fields.contact_load import contact_load
from flatpunch.fields.fields import checked_friction, residual_stresses
from flatpunch.fields.layered import REACH
from flatpunch.fields.round_load import round_fields
from flatpunch.fields.strength import Strength, checked_strengths
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Medium, RigidBase, underlying

_RADII = np.array([0.0, 0.2, 0.4, 0.6, 0.75, 0.86, 0.94, 1.0, 1.06, 1.16, 1.35, 1.7, 2.2, 3.0])
"""Radii of the grid over the contact radius; between them the largest value is refined."""

_DEPTHS = (1 - np.cos(np.pi * np.arange(11) / 10)) / 2
"""Depths of the grid over those of a layer, or over a few contact radii where it is thicker, faces included."""

_DEEPEST = 2.5
"""Contact radii below the top of a layer down to which it is searched."""

_FACTOR = 8.0
"""Largest change of the radius in one step of the search."""

_COARSE = 14.0
"""Where integrals over the layers' response end during the search: 1e-4. The load at the place found is exact."""

_ROUNDS = 6
"""Rounds of refinement of a place, each three times finer."""

_RANGE = 1e6
"""Ratio of radii over which the first event is searched, on either side of the start."""

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


@readable
@dataclass(frozen=True, slots=True)
class CriticalLoad:
    """The first failure under a growing contact.

    Attributes
    ----------
    force, depth, radius : float
        Load [N], depth and contact radius [m] at which it happens: zero if at the first touch already (sharp tips), infinite
        if up to no contact that the medium or the tip allows.
    kind : str
        "yield", "tensile", "shear", "interface tension" or "interface shear".
    layer : int
        Layer, counted from the surface from 0; the base comes last. Of an interface, the layer above it.
    place : (float, float, float)
        x, y, z [m], with sliding along x.
    margins : dict of str to float
        Strength over stress at that load for every criterion, "layers[0].yield" and so on; the smallest is 1.

    See Also
    --------
    critical_load : Makes it.

    Examples
    --------
    >>> film = fp.Layer(young=200e9, poisson=0.2, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.3))
    >>> found = fp.critical_load(film, fp.Sphere(radius=10e-6), strengths=[None, fp.Strength(yield_stress=1e9)])
    >>> print(f"{found.kind} of layer {found.layer} at {found.force * 1e3:.1f} mN")
    yield of layer 1 at 3.5 mN
    """

    force: float
    depth: float
    radius: float
    kind: str
    layer: int
    place: tuple[float, float, float]
    margins: dict[str, float]


@one_blas_thread()
def critical_load(
    medium: Body,
    indenter: Indenter,
    strengths: Strength | Sequence[Strength | None],
    *,
    friction: float = 0.0,
    residual_stress: Sequence[float] | None = None,
) -> CriticalLoad:
    """Load at which the first layer or interface fails under a round indenter.

    Parameters
    ----------
    medium : Medium or HalfSpace
        The elastic body.
    indenter : Indenter
        A round indenter.
    strengths : Strength or sequence of Strength or None
        For each layer from the surface down, then the base; layers without an entry are not checked.
    friction : float
        Coefficient of friction of a contact that slides along x.
    residual_stress : sequence of float, optional
        Biaxial stress of each layer (and the base) [Pa].

    Returns
    -------
    CriticalLoad
        Load, depth, place, kind and all margins. The stress is known to 1e-8; the place and the load are refined to about 1e-4.

    Raises
    ------
    ValueError, TypeError
        On bad input, and where the residual stress alone exceeds a strength.

    See Also
    --------
    Strength : What a layer bears.
    fields : The stresses.
    CriticalLoad : What it returns.

    Examples
    --------
    >>> import flatpunch as fp
    >>> steel = fp.HalfSpace(210e9, 0.3)
    >>> first = fp.critical_load(steel, fp.Sphere(1e-3), fp.Strength(yield_stress=500e6))
    >>> first.kind, round(first.place[2] / first.radius, 2)
    ('yield', 0.48)
    """
    body = underlying(medium)
    if not isinstance(body, (HalfSpace, Medium)):
        raise TypeError(
            f"medium = {type(body).__name__} has no critical load here; it must be one Medium or HalfSpace."
        )
    if not isinstance(indenter, Indenter) or isinstance(indenter, type) or not indenter.round:
        raise ValueError(
            "indenter must be round: the critical load of other tips is not computed. See `fields` for their stresses."
        )
    if isinstance(indenter, Cylinder):
        raise ValueError(
            "indenter is a Cylinder, whose edge has an infinite stress at any load. Round the edge: Rounded(...)."
        )
    found = checked_strengths(body, strengths)
    friction = checked_friction(friction)
    residual = residual_stresses(medium, residual_stress)
    kernel = compliance(medium)
    search = _Search(body, kernel, indenter, found, friction, np.zeros(len(found)) if residual is None else residual)
    search.refuse_residual()
    return search.first()


@dataclass(frozen=True, slots=True)
class _Search:
    """Everything that stays the same while the contact grows."""

    body: HalfSpace | Medium
    kernel: Kernel
    indenter: Indenter
    strengths: tuple[Strength, ...]
    friction: float
    residual: Array

    def refuse_residual(self) -> None:
        """Refuse residual stresses that fail the body without a contact."""
        for i, (strength, value) in enumerate(zip(self.strengths, self.residual, strict=True)):
            stress = np.array([value, value, 0.0, 0.0, 0.0, 0.0])
            for kind, ratio in strength.utilisation(stress):
                if ratio >= 1:
                    raise ValueError(
                        f"residual_stress[{i}] = {value:g} Pa alone exceeds the {kind} strength of that layer, without any load."
                    )

    def first(self) -> CriticalLoad:
        """Find the first event."""
        low, high = self._limits()
        start = float(np.clip(self._start(), low, high))
        limits = max(low, start / _RANGE), min(high, start * _RANGE)
        radius, events = self._solved(self.events, start, *limits, _FOUND)
        worst = max(events, key=lambda event: event.utilisation)
        if abs(worst.utilisation - 1) > 0.01:
            # not reached between the limits: from the first touch on, or never
            load = 0.0 if worst.utilisation > 1 else np.inf
            return CriticalLoad(load, load, load, worst.kind, worst.layer, worst.place, _margins(events))
        worst, at = self.refined(worst, radius), radius
        # at its place the stress is stationary: the load follows from that place alone
        radius, (worst,) = self._solved(lambda a: [self.followed(worst, a / at, a)], at, at / 2, at * 2, _SOLVED)
        contact = round_contact(self.kernel, mean_profile(self.indenter), np.array([radius]))
        events = [worst if (e.kind, e.layer) == (worst.kind, worst.layer) else e for e in self.events(radius)]
        return CriticalLoad(
            float(contact.force[0]),
            float(contact.depth[0]),
            radius,
            worst.kind,
            worst.layer,
            worst.place,
            _margins(events),
        )

    def _limits(self) -> tuple[float, float]:
        reach = self.indenter.reach * 0.98
        return 0.0, float(min(reach, resolved_radius(self.kernel)))

    def _start(self) -> float:
        """Radius at which the mean pressure on the half-space of the surface is about the smallest strength."""
        values = [v for s in self.strengths for v in (s.yield_stress, s.tensile, s.shear) if v is not None]
        values += [v for s in self.strengths for v in (s.interface_tension, s.interface_shear) if v is not None]
        half_space = compliance(HalfSpace(self.kernel.modulus, 0.0))
        profile = mean_profile(self.indenter)
        radius = np.geomspace(1e-12, min(1e3, self.indenter.reach * 0.98), 200)
        contact = round_contact(half_space, profile, radius)
        mean = contact.force / (np.pi * radius**2)
        return float(radius[min(int(np.searchsorted(mean, min(values))), radius.size - 1)])

    def _solved(
        self, events: Callable[[float], list[Event]], start: float, low: float, high: float, tolerance: float
    ) -> tuple[float, list[Event]]:
        """Radius at which the largest utilisation is one, by secants in the logarithms inside a bracket."""

        def level(a: float) -> tuple[float, list[Event]]:
            found = events(a)
            return float(np.log(max(max(e.utilisation for e in found), 1e-12))), found

        x, floor, ceiling = np.log(start), np.log(max(low, 1e-300)), np.log(high)
        below: tuple[float, float] | None = None
        above: tuple[float, float] | None = None
        for _ in range(60):
            y, found = level(float(np.exp(x)))
            if abs(y) < tolerance or (y > 0 and x <= floor) or (y < 0 and x >= ceiling):
                break
            if y < 0:
                below = (x, y)
            else:
                above = (x, y)
            if below is None or above is None:
                x = float(np.clip(x - np.clip(y, -np.log(_FACTOR), np.log(_FACTOR)), floor, ceiling))
                continue
            (x0, y0), (x1, y1) = below, above
            if abs(x1 - x0) < 1e-9:
                break
            share = np.clip(-y0 / (y1 - y0), 0.02, 0.98)
            x = float(x0 + share * (x1 - x0))
        return float(np.exp(x)), found

    def events(self, radius: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on the grid."""
        load = contact_load(self.kernel, self.indenter, radius, 0.0, edge=False)
        tops = np.concatenate([[0.0], interfaces(self.body)])
        along = self._radii(radius)
        found = []
        for i, strength in enumerate(self.strengths):
            thickness = float(tops[i + 1] - tops[i]) if i + 1 < tops.size else np.inf
            if not (strength.of_bulk or strength.of_interface):
                continue
            if i == tops.size - 1 and isinstance(self.body, Medium) and isinstance(self.body.base, RigidBase):
                raise ValueError(f"strengths[{i}] belongs to the rigid base, which has no stresses. Leave it out.")
            depth = tops[i + 1 : i + 2]
            if strength.of_bulk:
                deep = min(thickness, _DEEPEST * max(radius, float(tops[i]) / 2))
                depth = np.unique(np.append(tops[i] + _DEPTHS * deep, depth))
            found += self._largest(load, i, along, depth)
        return found

    def _radii(self, radius: float) -> Array:
        """Places along the plane of sliding: in units of the radius, and out to where stiff films bend."""
        far = self._bending()
        outer = np.geomspace(3 * radius, 3 * radius + 4 * far, 6)[1:] if far > 0 else np.zeros(0)
        right = np.concatenate([_RADII * radius, outer])
        return np.concatenate([-right[:0:-1], right]) if self.friction else right

    def _bending(self) -> float:
        """Distance over which the layers bend on what is below [m]: the thickness times the cube root of the contrast."""
        if not isinstance(self.body, Medium) or not self.body.layers:
            return 0.0
        moduli = [layer.surface_modulus for layer in self.body.layers]
        if isinstance(self.body.base, HalfSpace):
            moduli.append(self.body.base.surface_modulus)
        return float(self.body.thickness * ((max(moduli) / min(moduli)) ** (1 / 3) - 1))

    def _largest(self, load: Any, i: int, x: Array, z: Array, reach: float = _COARSE) -> list[Event]:
        """Largest utilisation of each kind in a layer on the product of x and z."""
        across, down = (each.ravel() for each in np.meshgrid(x, z))
        stress = self._stress(load, i, across, down, reach)
        tops = np.append(interfaces(self.body), np.inf)
        ratios = [(kind, ratio, np.arange(down.size)) for kind, ratio in self.strengths[i].utilisation(stress)]
        face = np.flatnonzero(down == tops[i])
        if face.size:
            on_face = self.strengths[i].interface_utilisation(stress[:, face])
            ratios += [(kind, ratio, face) for kind, ratio in on_face]
        found = []
        for kind, ratio, where in ratios:
            worst = int(np.argmax(ratio))
            at = where[worst]
            found.append(Event(kind, i, float(ratio[worst]), (float(across[at]), 0.0, float(down[at]))))
        return found

    def _stress(self, load: Any, i: int, x: Array, z: Array, reach: float) -> Array:
        at = Located(self.body, np.arange(x.size), z, np.full(x.size, i))
        stress, _ = round_fields(load, at, x, np.zeros_like(x), traction=self.friction, reach=reach)
        stress[:2] += self.residual[i]
        return stress

    def refined(self, event: Event, radius: float) -> Event:
        """The same event, its place refined on ever finer grids of five by five."""
        load = contact_load(self.kernel, self.indenter, radius, 0.0, edge=False)
        tops = np.concatenate([[0.0], interfaces(self.body), [np.inf]])
        i, face = event.layer, event.kind.startswith("interface")
        x, _, z = event.place
        wide = max(0.2 * radius, 0.3 * abs(x))
        deep = 0.0 if face else 0.15 * min(float(tops[i + 1] - tops[i]), _DEEPEST * max(radius, float(tops[i]) / 2))
        best = event
        for _ in range(_ROUNDS):
            xs = x + wide * np.linspace(-1, 1, 5)
            zs = np.unique(np.clip(z + deep * np.linspace(-1, 1, 5), tops[i], tops[i + 1]))
            xs = xs if self.friction else np.unique(np.abs(xs))
            (found,) = [e for e in self._largest(load, i, xs, zs) if e.kind == event.kind]
            best = max(best, found, key=lambda each: each.utilisation)
            x, _, z = best.place
            wide, deep = wide / 3, deep / 3
        return best

    def followed(self, event: Event, growth: float, radius: float) -> Event:
        """The same event at the place that it has moved to in a contact that is larger by a factor."""
        load = contact_load(self.kernel, self.indenter, radius, 0.0, edge=False)
        top = float(np.concatenate([[0.0], interfaces(self.body)])[event.layer])
        free = not isinstance(self.body, Medium) or not self.body.layers
        x, z = event.place[0] * growth, event.place[2] * growth if free else event.place[2]
        place = np.array([x]), np.array([max(z, top)])
        (found,) = [e for e in self._largest(load, event.layer, *place, REACH) if e.kind == event.kind]
        return found


def _margins(events: Sequence[Event]) -> dict[str, float]:
    """Strength over stress by criterion; infinite under compression."""
    return {
        f"layers[{event.layer}].{event.kind}": 1 / event.utilisation if event.utilisation > 0 else float("inf")
        for event in events
    }
