"""`critical_load`: the load, place and kind of the first failure under a growing contact.

Stress over strength is taken on grids that follow the contact, faces and rim included; its largest value is brought to one by
secants in the logarithm of the radius, and the place of the first event is then refined. Round contacts are exact
(`critical_round`), others are pressures on cells (`critical_cells`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import shown
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact import Exact, indent
from flatpunch.contact.curve import NOTABLE_FORCE, first_failure, percent
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.limits import deepest, high_pressure, steepness
from flatpunch.contact.round.mean_profile import resolved_radius
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, underlying
from flatpunch.punch import UnresolvedLayer
from flatpunch.punch.matrix import largest_beta
from flatpunch.stresses.failure.events import Event, Judged, criterion_name, first_event, margins
from flatpunch.stresses.failure.on_cells import CellSearch
from flatpunch.stresses.failure.round import RoundSearch
from flatpunch.stresses.failure.strength import Strength, checked_strengths
from flatpunch.stresses.failure.tips import pointed_table
from flatpunch.stresses.points import AXES, checked_friction, of_case

__all__ = ["CriticalLoad", "Event", "critical_load", "critical_loads"]

Strengths = Strength | Sequence[Strength | None]

_HIGH = 0.03
"""Mean pressure over the contact modulus above which a critical load has a note: metals yield at some thousandths, hard
ceramics at some hundredths."""


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
        Why the contact at that load is not valid or beyond small strains, as of `indent`, and an error above 1 %.

    See Also
    --------
    flatpunch.critical_load : Makes it.

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
        Load, depth, place, kind and all margins. Under round tips the load is refined to about 1e-4. `error` estimates that of
        the stress there: up to 1e-7 under round tips, 0.1 to 2 % under others, 1 to 10 % of tension at the rim of their contact
        and more at the ends of slender ones. Above 1 % a note gives it.

    Raises
    ------
    ValueError, TypeError
        On bad input, where the residual stress alone exceeds a strength, and where nothing fails up to the largest contact that
        layers allow to solve.

    See Also
    --------
    Strength : What a layer bears.
    fields : The stresses.
    stresses.CriticalLoad : What it returns.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> first = fp.critical_load(film, fp.Sphere(50e-6), [fp.Strength(tensile=2e9), fp.Strength(yield_stress=1e9)])
    >>> print(f"{first.kind} at {first.force * 1e3:.1f} mN")
    yield at 11.8 mN

    Notes
    -----
    Yield and shear in the layer at the surface are reached at the first touch where the pressure is infinite: under the apex and
    edges of sharp tips, and at the border of flat ends that are worn into a tip, round or not. So are they under the rim of a
    `Cylinder`, and under friction tension behind it. Incompressible material bears infinite pressure, but not its friction.
    """
    search, friction_of = search_of(medium, indenter, strengths, friction, residual_stress)
    return found_by(search, medium, friction_of)


@one_blas_thread()
def critical_loads(
    medium: Body,
    indenter: Indenter,
    strengths: Strengths | Sequence[Strengths | None],
    *,
    friction: float = 0.0,
    residual_stress: Sequence[Any] | None = None,
) -> xr.Dataset:
    """Load at which each strength is reached by itself, as if the others were not.

    Parameters
    ----------
    medium, indenter, strengths, friction, residual_stress
        As for `critical_load`, whose load is the smallest of these.

    Returns
    -------
    xarray.Dataset
        Along `criterion`, "layers[0].yield" and so on, of two bodies "upper.layers[0].yield": force [N], depth and radius [m],
        place (criterion, axis) [m] and error, the estimated relative error of the stress. Infinite, with a place that is NaN,
        where a strength is never reached; NaN where the search ended before, as `notes` of the criterion say. The attribute
        `first` is the criterion that is reached first.

    Raises
    ------
    ValueError, TypeError
        On bad input, and where the residual stress alone exceeds a strength.

    See Also
    --------
    critical_load : The first of them.
    peak_stresses : The stresses under one contact.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> strengths = [fp.Strength(yield_stress=6e9, tensile=2e9), fp.Strength(yield_stress=1e9)]
    >>> loads = fp.critical_loads(film, fp.Sphere(50e-6), strengths)
    >>> for name, force in zip(loads.criterion.values, loads.force.values):
    ...     print(f"{name}: {force * 1e3:.1f} mN")
    layers[0].yield: 128.2 mN
    layers[0].tensile: 329.8 mN
    layers[1].yield: 11.8 mN
    """
    search, named = search_of(medium, indenter, strengths, friction, residual_stress)
    rows = []
    for what in dict.fromkeys(event.what for event in search.maxima(search.limits()[1])):
        try:
            found = found_by(replace(search, bodies=tuple(each.only(what) for each in search.bodies)), medium, named)
        except UnresolvedLayer as error:
            nan = float("nan")
            found = CriticalLoad(nan, nan, nan, *what[:2], (nan, nan, nan), {}, what[2], nan, (str(error),))
        rows.append((criterion_name(what, named=named), found))
    forces = np.array([found.force for _, found in rows])
    columns: dict[str, Column] = {
        name: (
            ("criterion",),
            np.array([getattr(found, name) for _, found in rows]),
            {"units": unit, "long_name": text},
        )
        for name, unit, text in (
            ("force", "N", "load"),
            ("depth", "m", "depth"),
            ("radius", "m", "mean contact radius"),
        )
    }
    never = np.isinf(forces)[:, None]
    columns["place"] = (
        ("criterion", "axis"),
        np.where(never, np.nan, [found.place for _, found in rows]),
        {"units": "m", "long_name": "place"},
    )
    errors = np.array([found.error for _, found in rows])
    columns["error"] = (("criterion",), errors, {"long_name": "estimated relative error of the stress"})
    notes = np.array(["\n".join(found.notes) for _, found in rows], dtype=object)
    columns["notes"] = (("criterion",), notes, {"long_name": "limits of the theory at that load"})
    names = np.array([name for name, _ in rows], dtype=object)
    first = names[int(np.nanargmin(forces))] if np.isfinite(forces).any() else ""
    coordinates = {
        "criterion": (names, {"long_name": "criterion"}),
        "axis": (np.array(AXES), {"long_name": "direction"}),
    }
    attributes = {"title": "Critical loads computed by flatpunch", "first": str(first), "friction": search.friction}
    return dataset(columns, coordinates, {**attributes, **of_case(medium, indenter)})


def search_of(
    medium: Body, indenter: Indenter, strengths: Any, friction: float, residual_stress: Any
) -> tuple[RoundSearch | CellSearch, bool]:
    """Check the arguments; the search, and whether criteria are named with their body."""
    kernel = compliance(medium)  # refuses what is no medium
    check_indenter(indenter)
    bodies = _judged(underlying(medium), strengths, residual_stress)
    friction = checked_friction(friction)
    for each in bodies:
        each.check()
    kind = RoundSearch if indenter.round else CellSearch
    search = kind(bodies, kernel, indenter, friction, deepest(medium))
    return search, underlying(medium).pair


def found_by(search: Any, medium: Body, named: bool) -> CriticalLoad:
    try:
        size, worst, events = first_event(search)
    except UnresolvedLayer as error:
        raise UnresolvedLayer(f"no strength is reached before stresses can no longer be computed: {error}") from None
    if size == np.inf and search.limits()[2] == resolved_radius(search.kernel):
        raise UnresolvedLayer(_undecided(search, search.kernel, worst))
    kind, layer, body = worst.what
    nothing = pointed_table(search.indenter) if size == 0 else ()
    infinite = bool(np.isinf(worst.utilisation))
    if size == np.inf or (size == 0 and infinite):
        return CriticalLoad(
            size, size, size, kind, layer, worst.place, margins(events, named=named), body, notes=nothing
        )
    off = (
        0.0
        if infinite
        else max(search.error(worst, size or search.limits()[0]), abs(worst.utilisation - 1) if size else 0.0)
    )
    if size == 0 and worst.utilisation * (1 - off) > 1:
        every = margins(events, named=named)
        return CriticalLoad(size, size, size, kind, layer, worst.place, every, body, off, nothing)
    if size == 0 or off >= 1:
        raise UnresolvedLayer(_uncertain(worst, off, layered=any(each.tops.size > 1 for each in search.bodies)))
    force, depth, radius = search.contact(size)
    notes = limits_at(medium, search.indenter, force, depth, radius)
    notes += first_failure(
        np.array([off > NOTABLE_FORCE]),
        np.array([depth]),
        f"the stress at that place is expected to be off by up to {percent(off)}, and the load by several times as much.",
    )
    return CriticalLoad(force, depth, radius, kind, layer, worst.place, margins(events, named=named), body, off, notes)


def limits_at(medium: Body, indenter: Indenter, force: float, depth: float, radius: float) -> tuple[str, ...]:
    """Where the contact at that load is beyond the theory, or beyond what solids bear."""
    at = np.array([depth])
    mean = np.array([force / (np.pi * radius**2)])
    # two thirds of F/d is the stiffness of a cone, that of other tips is less: the contact modulus S/(2a) is at most F/(a d)
    notes = high_pressure(mean * radius * at / force, at, _HIGH)
    if not indenter.round:
        return notes + steepness(indenter, np.array([radius]), at)
    given: dict[str, Any] = {"depth": depth} if indenter.flat else {"radius": radius}
    curve = indent(medium, indenter, method=Exact(), angles=1, **given)
    own = tuple(line for line in str(curve.attrs["notes"]).splitlines() if "mean pressure" not in line)
    return own + notes


def _undecided(search: RoundSearch | CellSearch, kernel: Kernel, worst: Event) -> str:
    """Message: the largest load of the search, at which nothing fails, and why the search ends there."""
    high = search.limits()[2]
    kind, layer, body = worst.what
    share = max(worst.utilisation, 0.0)
    return (
        f"strengths are not reached up to a load of {text(search.contact(high)[0], 'N')} (the nearest is {kind} of layer "
        f"{layer + 1} of the {body} body, at {share:.2g} of its strength), and the search ends there: the contact radius is "
        f"{text(high, 'm')}, {largest_beta(kernel):g} times the shortest length of the layers, the largest contact that is "
        "solved. Leave out the thinnest layer, or check the units of strengths and thicknesses."
    )


def _uncertain(worst: Event, off: float, *, layered: bool) -> str:
    """Message: the first event is no better known than its error."""
    kind, layer, body = worst.what
    thin = "layers that are thin against the contact" if layered else "the smallest contacts of this tip"
    return (
        f"{kind} of layer {layer + 1} of the {body} body is reached first, but its stress is known to {100 * off:.2g} % only: "
        f"the cells of the pressure do not resolve {thin}. Leave out that layer's strengths"
        f"{', or the thinnest layer' if layered else ''}; `critical_loads` gives the loads of the other strengths."
    )


def _judged(medium: Body, strengths: Any, residual: Any) -> tuple[Judged, ...]:
    """Bodies with their checked strengths; of two bodies only those that have strengths."""
    if alone := medium.single:
        return (Judged.of(alone, checked_strengths(alone, strengths), residual),)
    if not medium.pair:
        raise TypeError(
            f"medium = {type(medium).__name__} must be a Medium, a HalfSpace, a PowerLawHalfSpace or TwoBodies."
        )
    bodies = []
    pairs = [_pair("strengths", strengths), _pair("residual_stress", (None, None) if residual is None else residual)]
    for (name, body), own, stresses in zip(medium.sides, *pairs, strict=True):
        if own is None:
            continue
        if body.rigid:
            raise ValueError(
                f"strengths of the {name} body belong to a rigid body, which has no stresses. Give None for it."
            )
        bodies.append(Judged.of(body, checked_strengths(body, own), stresses, name))
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
