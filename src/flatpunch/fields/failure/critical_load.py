"""`critical_load`: the load, place and kind of the first failure under a growing contact.

Stress over strength is taken on grids that follow the contact, faces and rim included; its largest value is brought to one by
secants in the logarithm of the radius, and the place of the first event is then refined. Round contacts are exact
(`critical_round`), others are pressures on cells (`critical_cells`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliance import Kernel, compliance
from flatpunch.contact import FirstOrder, indent
from flatpunch.contact.limits import deepest
from flatpunch.contact.round.mean_profile import resolved_radius
from flatpunch.fields.failure.events import Event, Judged, first_event, margins
from flatpunch.fields.failure.on_cells import CellSearch
from flatpunch.fields.failure.round import RoundSearch
from flatpunch.fields.failure.strength import Strength, checked_strengths
from flatpunch.fields.fields import checked_friction, residual_stresses
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, HalfSpace, Medium, PowerLawHalfSpace, RigidBase, TwoBodies, underlying
from flatpunch.punch import UnresolvedLayer
from flatpunch.punch.matrix import largest_beta

__all__ = ["CriticalLoad", "Event", "critical_load"]

Strengths = Strength | Sequence[Strength | None]


@readable
@dataclass(frozen=True, slots=True)
class CriticalLoad:
    """The first failure under a growing contact.

    Attributes
    ----------
    force, depth, radius : float
        Load [N], depth and (mean) contact radius [m] at which it happens: zero if at the first touch already (sharp tips),
        infinite if nothing fails before the tip is in contact all over or as deep as layers on a rigid base are thick, or up to
        contacts a million times larger than those at which failure was to be expected.
    kind : str
        "yield", "tensile", "shear", "interface tension" or "interface shear".
    layer : int
        Layer, counted from the surface from 0; the base comes last. Of an interface, the layer above it.
    place : (float, float, float)
        x, y, z [m], with sliding along x; z < 0 in the upper of two bodies.
    margins : dict of str to float
        Strength over stress at that load for every criterion, "layers[0].yield" and so on; the smallest is 1. Of two bodies
        "upper.layers[0].yield" and "lower.layers[0].yield".
    body : {"lower", "upper"}
        Which of two bodies fails; a single one is the lower.
    error : float
        Estimated relative error of the stress at that place.
    notes : tuple of str
        Why the contact at that load is not valid, as of `indent`; empty if it is.

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
    body: str = "lower"
    error: float = 0.0
    notes: tuple[str, ...] = ()


@one_blas_thread()
def critical_load(
    medium: Body,
    indenter: Indenter,
    strengths: Strengths | Sequence[Strengths | None],
    *,
    friction: float = 0.0,
    residual_stress: Sequence[Any] | None = None,
) -> CriticalLoad:
    """Load at which the first layer or interface fails under an indenter.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace or TwoBodies
        The elastic body, or two of them.
    indenter : Indenter
        What is pressed in. Round tips are exact; the pressure under others comes from boundary elements and takes seconds.
    strengths : Strength or sequence of Strength or None
        For each layer from the surface down, then the base; layers without an entry are not checked. Of two bodies a pair of such
        sequences, of the upper and of the lower one, or None for one that is not checked.
    friction : float
        Coefficient of friction of a contact that slides along x.
    residual_stress : sequence of float, optional
        Biaxial stress of each layer (and the base) [Pa]; of two bodies a pair of such sequences or None.

    Returns
    -------
    CriticalLoad
        Load, depth, place, kind and all margins. Under round tips the stress is known to 1e-8 (graded surfaces 1e-4) and the load
        refined to about 1e-4; under others `error` estimates it, 0.1 to 2 % inside and more beside the rim.

    Raises
    ------
    ValueError, TypeError
        On bad input, where the residual stress alone exceeds a strength, and where nothing fails up to the largest contact that
        layers allow to solve.

    See Also
    --------
    Strength : What a layer bears.
    fields : The stresses.
    CriticalLoad : What it returns.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> first = fp.critical_load(film, fp.Sphere(50e-6), [fp.Strength(tensile=2e9), fp.Strength(yield_stress=1e9)])
    >>> print(f"{first.kind} at {first.force * 1e3:.1f} mN")
    yield at 11.8 mN

    Notes
    -----
    Yield and shear in the layer at the surface are reached at the first touch where the pressure is infinite: under the apex and
    edges of sharp tips. The edge of a flat end is refused there; give its strengths to the layers below.
    """
    compliance(medium)  # refuses what is no medium
    check_indenter(indenter)
    bodies = _judged(underlying(medium), strengths, residual_stress)
    friction = checked_friction(friction)
    for each in bodies:
        each.check()
        if isinstance(indenter, Cylinder) and each.strengths[0].of_bulk:
            raise ValueError(
                "indenter is a Cylinder, whose edge has an infinite stress at any load. Round the edge: Rounded(...), or give "
                "strengths to the layers below the surface only."
            )
    kernel = compliance(medium)
    kind = RoundSearch if indenter.round else CellSearch
    search = kind(bodies, kernel, indenter, friction, deepest(medium))
    try:
        size, worst, events = first_event(search)
    except UnresolvedLayer as error:
        raise UnresolvedLayer(f"no strength is reached before stresses can no longer be computed: {error}") from None
    named = isinstance(underlying(medium), TwoBodies)
    if size == np.inf and search.limits()[2] == resolved_radius(kernel):
        raise UnresolvedLayer(_undecided(search, kernel, worst))
    if not 0 < size < np.inf:
        return CriticalLoad(
            size, size, size, worst.kind, worst.layer, worst.place, margins(events, named=named), worst.body
        )
    force, depth, radius = search.contact(size)
    return CriticalLoad(
        force,
        depth,
        radius,
        worst.kind,
        worst.layer,
        worst.place,
        margins(events, named=named),
        worst.body,
        search.error(worst, size),
        _limits(medium, indenter, depth, radius),
    )


def _limits(medium: Any, indenter: Indenter, depth: float, radius: float) -> tuple[str, ...]:
    """Why a round contact is not valid: a film that bends away, a layer that is pressed through."""
    if not indenter.round:
        return ()
    given = {"depth": depth} if isinstance(indenter, Cylinder) else {"radius": radius}
    curve = indent(medium, indenter, method=FirstOrder(), angles=1, **given)
    return () if curve["valid"].values[0] else tuple(str(curve.attrs["notes"]).splitlines())


def _undecided(search: RoundSearch | CellSearch, kernel: Kernel, worst: Event) -> str:
    """Message: the largest load of the search, at which nothing fails, and why the search ends there."""
    high = search.limits()[2]
    kind, layer, body = worst.what
    share = max(worst.utilisation, 0.0)
    return (
        f"strengths are not reached up to a load of {text(search.contact(high)[0], 'N')} (the nearest is {kind} of layer {layer} "
        f"of the {body} body, at {share:.2g} of its strength), and the search ends there: the contact radius is "
        f"{text(high, 'm')}, {largest_beta(kernel):g} times the shortest length of the layers, the largest contact that is "
        "solved. Leave out the thinnest layer, or check the units of strengths and thicknesses."
    )


def _judged(medium: Any, strengths: Any, residual: Any) -> tuple[Judged, ...]:
    """Bodies with their checked strengths; of two bodies only those that have strengths."""
    if isinstance(medium, (HalfSpace, Medium, PowerLawHalfSpace)):
        found = checked_strengths(medium, strengths)
        stresses = residual_stresses(medium, residual)
        return (Judged(medium, found, np.zeros(len(found)) if stresses is None else stresses),)
    if not isinstance(medium, TwoBodies):
        raise TypeError(
            f"medium = {type(medium).__name__} must be a Medium, a HalfSpace, a PowerLawHalfSpace or TwoBodies."
        )
    bodies = []
    pairs = [_pair("strengths", strengths), _pair("residual_stress", (None, None) if residual is None else residual)]
    for name, body, own, stresses in zip(("upper", "lower"), (medium.upper, medium.lower), *pairs, strict=True):
        if own is None:
            continue
        if isinstance(body, RigidBase):
            raise ValueError(
                f"strengths of the {name} body belong to a rigid body, which has no stresses. Give None for it."
            )
        (judged,) = _judged(body, own, stresses)
        bodies.append(Judged(judged.body, judged.strengths, judged.residual, name))
    if not bodies:
        raise ValueError("strengths is None for both bodies, so nothing is checked. Give those of one of them.")
    return tuple(bodies)


def _pair(name: str, given: Any) -> tuple[Any, Any]:
    if not isinstance(given, (list, tuple)) or len(given) != 2:
        raise TypeError(
            f"{name} = {shown(given)} must be a pair for two bodies: what belongs to the upper and what to the lower one, "
            "or None for either."
        )
    return given[0], given[1]
