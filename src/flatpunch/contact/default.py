"""Which method solves a contact: the one that was named, or the default, chosen by estimated error and cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Values
from flatpunch.compliance import Kernel, compliance
from flatpunch.contact.curve import Control, Curve, control_from, percent
from flatpunch.contact.methods import BoundaryElements, FirstOrder, FourthOrder, Method, Refined, SecondOrder
from flatpunch.contact.round.mean_profile import mean_contact, shortest_length
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

FORCE_LIMIT = 0.005
"""Estimated relative error of the force above which a series is not taken by default."""

OUTLINE_LIMIT = 0.05
"""Estimated error of the outline over the mean radius above which a series is not taken by default."""

WIDE = 20.0
"""Contact radius over the shortest length of the medium above which the harmonics of a series cost seconds and more."""

EXACT = "exact (round tip)"
"""Reason of round contacts, which all methods but boundary elements solve exactly."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A method and why it was chosen.

    Attributes
    ----------
    method : Method
        The method.
    reason : str
        Why, as the end of a sentence.
    quick : bool
        Whether a curve takes milliseconds, and no boundary element solutions.
    curve : Curve, optional
        The solution, where the choice took one.
    """

    method: Method
    reason: str
    quick: bool
    curve: Curve | None = None


def series_of(indenter: Indenter) -> FirstOrder | SecondOrder | FourthOrder:
    """The fast method that is closest for a shape, whatever the medium."""
    if indenter.round:
        return FirstOrder()
    return SecondOrder() if indenter.exponent is None else FourthOrder()


def default_method(
    indenter: Indenter,
    medium: Body | None = None,
    *,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
) -> str:
    """Short name of the method that `indent` chooses by itself; arguments as for `indent`.

    Round tips are solved exactly by "first-order", the shortest way. Pyramids of 3, 4 and 6 sides and ellipses on one layer on a
    rigid base take "refined" with corrections that come with the package. Other power laws take "fourth-order" if its own
    estimate is at most 0.5 % in force and 5 % in outline at all steps and the contact is at most 20 times wider than the thinnest
    layer, and else "refined", as do all other shapes. Without a
    medium it is the best of the fast methods for the shape.
    """
    if medium is None:
        return series_of(indenter).name
    return default_choice(indenter, medium, depth=depth, force=force, radius=radius).method.name


def default_choice(
    indenter: Indenter,
    medium: Body,
    *,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
) -> Choice:
    """The method that `indent` chooses by itself, with the reason; see `default_method`."""
    control = control_from(depth=depth, force=force, radius=radius)
    return choose(compliance(medium), indenter, control, np.zeros(1))


def choose(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Choice:
    """Choose the method for some steps.

    Round tips are exact. Tips whose corrections come with the package take these. Of other power laws the series costs
    milliseconds up to contacts `WIDE` layers wide: it is solved and taken if its own estimate is within `FORCE_LIMIT` and
    `OUTLINE_LIMIT` at all steps. The series of wider contacts and of all other shapes takes as long as the boundary element
    solutions of the refined method, which are closer.
    """
    series = series_of(indenter)
    if indenter.round:
        return Choice(series, EXACT, quick=True)
    if _covered(kernel, indenter, control):
        return Choice(Refined(), "its corrections for this tip on one layer come with the package", quick=True)
    if indenter.exponent is None:
        return Choice(
            Refined(), "the series of a shape that is no power law takes as long and is less accurate", quick=False
        )
    width = float(mean_contact(kernel, indenter, control)[1].radius.max()) / shortest_length(kernel)
    if width > WIDE:
        reason = f"contacts {width:.2g} times wider than the thinnest layer cost a series more than boundary elements"
        return Choice(Refined(), reason, quick=False)
    curve = series.solve(kernel, indenter, control, phi)
    force, outline = (float(np.max(curve.extra[name][1])) for name in ("force_error", "contour_error"))
    expected = f"the {series.name} series may be off by {percent(force)} in force and {percent(outline)} in outline"
    if force <= FORCE_LIMIT and outline <= OUTLINE_LIMIT and curve.valid.all():
        return Choice(series, expected, quick=True, curve=curve)
    if not curve.valid.all():
        expected = f"the {series.name} series does not hold at all steps"
    return Choice(Refined(), expected, quick=False)


def asked_for(method: Method, indenter: Indenter) -> Choice:
    """The choice of a named method."""
    exact = indenter.round and not isinstance(method, BoundaryElements)
    return Choice(method, EXACT if exact else "asked for", quick=not isinstance(method, (Refined, BoundaryElements)))


def adhesive_method(method: Method | None, indenter: Indenter) -> Method:
    """Return the method by which adhesive contacts are solved, second order if none is named, or refuse it."""
    if method is None:
        return SecondOrder()
    if isinstance(method, BoundaryElements):
        raise ValueError("work_of_adhesion goes with the fast methods, not with method='bem'.")
    if not isinstance(method, SecondOrder) and not indenter.round:
        raise ValueError(
            f"method = {method.name!r} does not know adhesion of non-round tips; it is solved to second order: choose "
            "method='second-order'."
        )
    return method


def _covered(kernel: Kernel, indenter: Indenter, control: Control) -> bool:
    """Whether the corrections that come with the package reach all steps."""
    from flatpunch.contact.refined.method import covered

    return covered(kernel, indenter, control)
