"""Which method solves a contact: the one that was named, or the default, chosen by estimated error and cost; their names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from flatpunch._support.checks import Array, BadValue, Values, shown
from flatpunch._support.readable import readable
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import NOTABLE_FORCE, NOTABLE_OUTLINE, Control, Curve, control_from, percent
from flatpunch.contact.methods import (
    BoundaryElements,
    Exact,
    FirstOrder,
    FourthOrder,
    Refined,
    SecondOrder,
    exactly_solved,
)
from flatpunch.contact.round.mean_profile import mean_contact, shortest_length
from flatpunch.indenters.profile import Indenter, check_rising
from flatpunch.media import Body, underlying

Method = Exact | FirstOrder | SecondOrder | FourthOrder | Refined | BoundaryElements

MethodName = Literal["exact", "first-order", "second-order", "fourth-order", "refined", "bem"]
"""Short names of the methods with their default settings."""

METHODS: dict[str, type[Method]] = {
    kind.name: kind for kind in (Exact, FirstOrder, SecondOrder, FourthOrder, Refined, BoundaryElements)
}
"""Short names of the methods, with the classes whose defaults they mean."""

FORCE_LIMIT = NOTABLE_FORCE / 2
"""Estimated relative error of the force above which a series is not taken by default: half of what a result has a note about."""

WIDE = 20.0
"""Contact radius over the shortest length of the medium above which the harmonics of a series cost seconds and more."""

EXACT = "exact (round tip)"
"""Reason of round contacts, which all methods but boundary elements solve exactly."""


@readable
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

    See Also
    --------
    flatpunch.contact.default_choice : Makes it.

    Examples
    --------
    >>> from flatpunch.contact import default_choice
    >>> film = fp.Layer(young=200e9, poisson=0.2, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.2))
    >>> choice = default_choice(fp.Berkovich(), film, depth=300e-9)
    >>> print(choice.method.name, choice.quick)
    refined False
    """

    method: Method
    reason: str
    quick: bool
    curve: Curve | None = None


LIFTS_OFF = Choice(Exact(), "the layer lifts off", quick=True)
"""How contacts on a `FreeLayer` are solved; none of the methods for a held body does."""

ELLIPSE = "exact (elliptic paraboloid)"
"""Reason of elliptic paraboloids on half-spaces and power-law half-spaces."""


def series_of(indenter: Indenter) -> Exact | SecondOrder | FourthOrder | BoundaryElements:
    """The fast method that is closest for a shape, whatever the medium; boundary elements where none applies."""
    if not indenter.rising:
        return BoundaryElements()
    if indenter.round:
        return Exact()
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

    Round tips, and elliptic paraboloids on half-spaces and power-law half-spaces, are solved by "exact". Pyramids of 3, 4 and 6
    sides and ellipses on one layer on a rigid base take "refined" with corrections that come with the package. Other power laws
    take "fourth-order" if its own estimate is at most 0.5 % in force and 5 % in outline at all steps and the contact is at most
    20 times wider than the thinnest layer, and else "refined", as do all other shapes. Without a medium it is the best of the
    fast methods for the shape.

    See Also
    --------
    flatpunch.contact.default_choice : With the reason.
    flatpunch.indent : Takes it by itself.

    Examples
    --------
    >>> from flatpunch.contact import default_method
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> print(*(default_method(tip, gel, depth=200e-9) for tip in (fp.Sphere(radius=5e-6), fp.Vickers())))
    exact refined
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
    """The method that `indent` chooses by itself, with the reason; see `default_method`.

    See Also
    --------
    flatpunch.contact.default_method : The name alone.
    flatpunch.indent : Takes it by itself.

    Examples
    --------
    >>> from flatpunch.contact import default_choice
    >>> choice = default_choice(fp.Sphere(radius=5e-6), fp.HalfSpace(young=5e3, poisson=0.5), depth=200e-9)
    >>> print(choice.method.name, choice.reason)
    exact exact (round tip)
    """
    control = control_from(depth=depth, force=force, radius=radius)
    if underlying(medium).free:
        return LIFTS_OFF
    return choose(compliance(medium, membrane=True), indenter, control, np.zeros(1))


def choose(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Choice:
    """Choose the method for some steps.

    Round tips are exact, and elliptic paraboloids on half-spaces. Tips that do not rise from one apex take boundary elements.
    Tips whose corrections come with the package take these. Of other power laws the series costs milliseconds up to contacts
    `WIDE` layers wide: it is solved and taken if its own estimate is within `FORCE_LIMIT` and `NOTABLE_OUTLINE` at all steps. The
    series of wider contacts and of all other shapes takes as long as the boundary element solutions of the refined method, which
    are closer. Under a membrane on the surface boundary elements alone hold.
    """
    series = series_of(indenter)
    if kernel.limit < 1:
        return Choice(BoundaryElements(), "under a membrane on the surface there are no flat punches", quick=False)
    if control.name == "depth" and control.values.max(initial=0.0) > indenter.elsewhere:
        return Choice(BoundaryElements(), "parts of the map far from its apex are lower than the depth", quick=False)
    if isinstance(series, BoundaryElements):
        return Choice(series, "the tip does not rise from one apex in every direction", quick=False)
    if indenter.round:
        return Choice(series, EXACT, quick=True)
    if exactly_solved(kernel, indenter):
        return Choice(Exact(), ELLIPSE, quick=True)
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
    if force <= FORCE_LIMIT and outline <= NOTABLE_OUTLINE and curve.valid.all():
        return Choice(series, expected, quick=True, curve=curve)
    if not curve.valid.all():
        expected = f"the {series.name} series does not hold at all steps"
    return Choice(Refined(), expected, quick=False)


def asked_for(method: Method, indenter: Indenter) -> Choice:
    """The choice of a named method."""
    if indenter.round and not isinstance(method, BoundaryElements):
        return Choice(Exact(), EXACT, quick=True)
    return Choice(method, "asked for", quick=not isinstance(method, (Refined, BoundaryElements)))


def adhesive_method(method: Method | None, indenter: Indenter) -> Method:
    """Return the method by which adhesive contacts are solved, second order if none is named, or refuse it."""
    if method is None:
        return SecondOrder()
    if isinstance(method, BoundaryElements):
        raise ValueError("work_of_adhesion goes with the fast methods, not with method='bem'.")
    if not isinstance(method, SecondOrder) and not indenter.round:
        raise BadValue(
            "method",
            repr(method.name),
            "does not know adhesion of non-round tips; it is solved to second order: choose method='second-order'.",
        )
    return method


def _covered(kernel: Kernel, indenter: Indenter, control: Control) -> bool:
    from flatpunch.contact.refined.method import covered

    return covered(kernel, indenter, control)


def method_of(method: object) -> Method:
    """Return a method by its short name, or as it is; ValueError for unknown names, TypeError for a class."""
    if isinstance(method, Method):
        return method
    if isinstance(method, type) and method in METHODS.values():
        raise TypeError(f"method = {method.__name__} is a class; write {method.__name__}(), with its settings if any.")
    if not isinstance(method, str) or method not in METHODS:
        classes = ", ".join(f"fp.{known.__name__}(...)" for known in METHODS.values())
        raise BadValue(
            "method",
            shown(method),
            f"is unknown; choose one of {', '.join(map(repr, METHODS))}, or {classes} with settings.",
        )
    return METHODS[method]()


def check_membrane(medium: Body, kernel: Kernel, method: Method) -> None:
    """Refuse bending stiffness on the surface, and under tension there the methods that are made of flat punches."""
    for body in underlying(medium).elastic:
        if body.membrane and body.membrane.bending:
            raise BadValue(
                "Membrane.bending",
                repr(body.membrane.bending),
                "on the surface concentrates the force of a contact on its rim, which cells do not resolve. Leave it out, or put "
                "the membrane below a layer that is thin against the contact.",
            )
    if kernel.limit < 1 and method.name != "bem":
        raise BadValue(
            "method",
            repr(method.name),
            "is made of flat punches, whose rim has a line force under a membrane on the surface, as a Cylinder has itself. Take "
            "method='bem' and a tip without a flat end, or put the membrane below a layer that is thin against the contact.",
        )


def solver_of(method: Method, indenter: Indenter) -> Method:
    """The solver of an indenter under a method: cylinders with a flat end are solved exactly by all.

    Only boundary elements solve tips that do not rise from one apex.
    """
    if not isinstance(method, BoundaryElements):
        check_rising(indenter)
    return Exact() if indenter.flat else method
