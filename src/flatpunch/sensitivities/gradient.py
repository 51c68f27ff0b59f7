"""All derivatives of one contact by all numbers of its medium and tip, and how they combine at given depth, force or radius.

Series methods under tips that are not round have no pressure of their own on the true contact, but their force, radius and
stiffness are analytic in all numbers of medium and tip and computed to rounding. Differences of order eight lose nothing then.
Their distance to those of order six is the error estimate; it is large beside kinks of the tip.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch._support.paths import Plain
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import FEW_ANGLES, Control, percent
from flatpunch.contact.default import Method
from flatpunch.contact.indentation import indent
from flatpunch.contact.methods import BoundaryElements, FirstOrder, FourthOrder, SecondOrder
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.indenters.profile import Indenter, RoundShape
from flatpunch.media import Body, underlying
from flatpunch.media.paths import with_values
from flatpunch.sensitivities import cells
from flatpunch.sensitivities import round as discs
from flatpunch.sensitivities.parameters import Parameter, difference, difference_and_error
from flatpunch.sensitivities.round import Contact, Spectrum, by_medium

if TYPE_CHECKING:
    import xarray as xr


Series = SecondOrder | FourthOrder

_STEP = 1e-2
"""Step over the number itself: truncation and rounding are then below 1e-11 of an analytic curve of order one."""


@dataclass(frozen=True, slots=True)
class Gradient:
    """Derivatives of one contact by parameters, per unit of each; shape (n,), NaN where a method does not know them.

    Attributes
    ----------
    contact : Contact
        The contact.
    force, stiffness, radius : ndarray
        dF, dK and da at fixed depth.
    spectrum : callable or None
        largest k times the contact radius, None for as far as layers act -> weights over the wavenumber; None for power-law
        half-spaces and series methods.
    notes : str
        Limits of the contact's own solution.
    valid : bool
        Whether the contact is one of the theory, as of `indent`.
    """

    contact: discs.Contact
    force: Array
    stiffness: Array
    radius: Array
    spectrum: Callable[[float | None], Spectrum] | None
    notes: str = ""
    valid: bool = True

    @property
    def depth(self) -> Array:
        """Change of the depth at fixed force."""
        return np.asarray(-self.force / self.contact.stiffness)

    @property
    def stiffness_at_force(self) -> Array:
        """Change of the stiffness at fixed force."""
        return np.asarray(self.stiffness + self.contact.stiffening / self.contact.growth * self.depth)

    @property
    def radius_at_force(self) -> Array:
        """Change of the contact radius at fixed force."""
        return np.asarray(self.radius + self.depth / self.contact.growth)


def gradients(
    medium: Body, indenter: Indenter, control: Control, method: Method, wanted: list[Parameter]
) -> list[Gradient]:
    """Derivatives at each prescribed depth, force or radius, all > 0."""
    medium = underlying(medium)
    kernel = compliance(medium)
    if isinstance(method, BoundaryElements):
        return [
            _on_cells(medium, kernel, indenter, Control(control.name, value[None]), method, wanted)
            for value in control.values
        ]
    if isinstance(method, (SecondOrder, FourthOrder)) and not indenter.round:
        return _of_series(medium, indenter, control, method, wanted)
    given: Plain = {control.name: control.values}
    curve = indent(medium, indenter, method=FirstOrder(), angles=1, **given)
    notes = curve.attrs["notes"]
    tip = indenter if indenter.round else _MeanTip(indenter)
    steps = zip(curve["radius"].values.tolist(), curve["depth"].values.tolist(), strict=True)
    contacts = [discs.contact_at(kernel, tip, radius, depth) for radius, depth in steps]
    by_shape = discs.by_tip(kernel, indenter, contacts, [each for each in wanted if each.body < 0])
    return [
        replace(_of_disc(medium, kernel, tip, contact, shape, wanted), notes=notes, valid=valid)
        for contact, shape, valid in zip(contacts, by_shape, curve["valid"].values.tolist(), strict=True)
    ]


def _of_series(
    medium: Body, indenter: Indenter, control: Control, method: Series, wanted: list[Parameter]
) -> list[Gradient]:
    """Solve a curve and differentiate it at fixed depths."""
    given: Plain = {control.name: control.values}
    curve = indent(medium, indenter, method=method, angles=FEW_ANGLES, **given)
    depth = curve["depth"].values

    def at(medium_: Body, indenter_: Indenter, scale: float = 1.0) -> Array:
        found = indent(medium_, indenter_, depth=scale * depth, method=method, angles=FEW_ANGLES)
        return np.array([found[name].values for name in ("force", "stiffness", "radius")])

    force, stiffness, radius = (curve[name].values for name in ("force", "stiffness", "radius"))
    _, bend, growing = difference(lambda s: at(medium, indenter, s), 1.0, _STEP) / depth
    contacts = [
        Contact(*map(float, row[:4]), *((1 / row[5], row[4] / row[5]) if row[5] else (np.inf, 0.0)))
        for row in zip(radius, depth, force, stiffness, bend, growing, strict=True)
    ]
    slopes, errors = np.empty((2, len(wanted), 3, depth.size))
    for j, each in enumerate(wanted):

        def changed(value: float, name: str = each.path) -> Array:
            return at(*with_values(medium, indenter, {name: value}))

        slopes[j], errors[j] = difference_and_error(changed, each.value, _STEP * (abs(each.value) or 1.0))
    notes = [*str(curve.attrs["notes"]).splitlines(), *_notes(curve, method, wanted, slopes[:, 0], errors[:, 0])]
    by_step = zip(contacts, slopes.transpose(2, 1, 0), curve["valid"].values.tolist(), strict=True)
    return [
        Gradient(contact, by_force, by_stiffness, by_radius, None, "\n".join(notes), valid)
        for contact, (by_force, by_stiffness, by_radius), valid in by_step
    ]


def _notes(curve: xr.Dataset, method: Series, wanted: list[Parameter], slopes: Array, errors: Array) -> list[str]:
    own = percent(float(curve["force_error"].max()))
    notes = [
        f"Derivatives are those of the {method.name} curve, which expects its forces within {own}; those of the true contact "
        "differ by about as much."
    ]
    if wanted:
        unit = np.array([abs(each.value) or 1.0 for each in wanted])[:, None]
        share = (errors * unit).max() / max(float(np.abs(slopes * unit).max()), TINY)
        if share > 1e-6:
            notes.append(
                f"By differences, derivatives are known to {share:.1g} of the largest: a kink of the tip is near."
            )
    return notes


def _of_disc(
    medium: Body,
    kernel: Kernel,
    tip: Indenter,
    contact: discs.Contact,
    by_shape: Array,
    wanted: list[Parameter],
) -> Gradient:
    of_tip = np.array([each.body < 0 for each in wanted], dtype=bool)
    rest = [each for each in wanted if each.body >= 0]
    spectrum: Callable[[float | None], Spectrum] | None = None
    if has_power_law(medium):
        by_constants = _by_power_law(medium, tip, contact, rest)
    else:
        spectrum = partial(discs.spectrum_of, kernel, tip, contact)
        by_constants = by_medium(medium, kernel, spectrum(None), rest) if rest else np.empty((3, 0))
    found = np.empty((3, len(wanted)))
    found[:, ~of_tip], found[:, of_tip] = by_constants, by_shape
    force, stiffness, depth = found
    if tip.flat:
        # the contact is the end face, whatever the body
        radius = np.array([float(each.body < 0) for each in wanted])
    else:
        radius = -depth / contact.growth
        stiffness = stiffness + contact.stiffening * radius
    return Gradient(contact, force, stiffness, radius, spectrum)


def _on_cells(
    medium: Body,
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    method: BoundaryElements,
    wanted: list[Parameter],
) -> Gradient:
    if has_power_law(medium):
        raise ValueError(
            "medium is a power-law half-space, whose derivatives are known under round tips only. Describe its grading by a "
            "GradedLayer with a modulus > 0 at the surface."
        )
    found = cells.cell_contact(kernel, indenter, control, method)
    solution = found.solution
    rest = [each for each in wanted if each.body >= 0]
    spectrum = partial(cells.spectrum_of_cells, kernel, found)
    of_tip = np.array([each.body < 0 for each in wanted], dtype=bool)
    force = np.empty(len(wanted))
    if rest:
        force[~of_tip] = by_medium(medium, kernel, spectrum(None), rest)[0]
    force[of_tip] = cells.force_by_tip(kernel, indenter, found, method, [each for each in wanted if each.body < 0])
    unknown = np.full(len(wanted), np.nan)
    # contacts of several parts have no outline: the radius of a disc of their area
    radius = solution.radius if np.isfinite(solution.radius) else float(np.sqrt(solution.area / np.pi))
    contact = discs.Contact(radius, solution.depth, solution.force, found.stiffness, np.nan, np.nan)
    return Gradient(contact, force, unknown, unknown, spectrum, "\n".join(solution.notes), solution.converged)


def has_power_law(medium: Body) -> bool:
    """Whether a body is a power-law half-space, which the wave solution does not divide by depth."""
    return medium.power_law is not None


def _by_power_law(medium: Body, tip: Indenter, contact: discs.Contact, wanted: list[Parameter]) -> Array:
    """Derivatives of F at fixed depth, K and d at fixed radius, of closed forms."""
    found = np.empty((3, len(wanted)))
    for column, parameter in enumerate(wanted):

        def solved(value: float, name: str = parameter.path) -> Array:
            changed, _ = with_values(medium, tip, {name: value})
            at = discs.contact_at(compliance(changed), tip, contact.radius, contact.depth)
            return np.array([at.force, at.stiffness, at.depth])

        force, stiffness, depth = difference(solved, parameter.value, parameter.step)
        found[:, column] = force - contact.stiffness * depth, stiffness, depth
    return found


@dataclass(frozen=True, slots=True)
class _MeanTip(RoundShape):
    """The round tip of the mean profile, whose contact the first order takes."""

    tip: Indenter

    @property
    def exponent(self) -> float | None:
        return self.tip.exponent

    @property
    def reach(self) -> float:
        return self.tip.reach

    @property
    def rings(self) -> tuple[float, ...]:
        return self.tip.rings

    @property
    def tabulated(self) -> bool:
        return not isinstance(mean_profile(self.tip), PowerProfile)

    def height(self, r: Array, phi: Array) -> Array:
        return np.asarray(mean_profile(self.tip).height(np.asarray(r)) + np.zeros_like(phi))

    def slope(self, r: Array, phi: Array) -> Array:
        return np.asarray(mean_profile(self.tip).slope(np.asarray(r)) + np.zeros_like(phi))
