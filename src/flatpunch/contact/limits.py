"""Limits of contact theory, as notes of a result: steep faces, ends of shapes, layers pressed through, pressures beyond strength.

A tip cannot go through a layer into a base that does not give way. What a layer is compressed by is the depth less the share
of what lies below it, which is at most F/(E*_below a): the displacement of a half-space under the load on the contact radius
a (0.5 F/(E* a) under a flat punch, 0.75 under a sphere, 1 under a cone).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array, BadValue, Flags
from flatpunch._support.prefixes import text
from flatpunch.contact.curve import Curve, first_failure
from flatpunch.contact.finite_strain.correction import overestimate
from flatpunch.indenters import AreaFunction
from flatpunch.indenters._common import SCATTERED
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, underlying

STEEPEST = np.tan(np.radians(30.0))
"""Mean inclination at the rim of a tip, and rms slope of a rough surface, above which a result has a note about small slopes."""


def steepness(indenter: Indenter, radius: Array, depth: Array) -> tuple[str, ...]:
    """Whether faces are too steep for a theory of small slopes, at contact radii of shape (n,)."""
    r = np.minimum(np.where(np.isfinite(radius), radius, 0.0), indenter.reach)
    live = r > 0
    directions = SCATTERED[::10]
    # slopes of power laws grow with the radius
    if indenter.exponent is not None and np.mean(indenter.slope(r.max(), directions)) <= STEEPEST:
        return ()
    slope = np.zeros_like(r)
    if live.any():
        slope[live] = np.mean(indenter.slope(r[live][:, None], directions), axis=1)
    return steep_faces(slope, depth)


def steep_faces(slope: Array, depth: Array) -> tuple[str, ...]:
    """Sentence about steps whose mean slope at the rim, or in a contact without an outline, is too large; shape (n,)."""
    steep = slope > STEEPEST
    if not steep.any():
        return ()
    angle = np.degrees(np.arctan(slope[steep].max()))
    return first_failure(
        steep,
        depth,
        f"faces at the rim are inclined by up to {angle:.0f} degrees on average, strains are about {20 * slope[steep].max():.0f} "
        "%. The theory takes slopes and strains as small (surface and pressure move along z); above about 35 degrees that costs "
        "some per cent, at 60 ten and more.",
    )


def cut_off(indenter: Indenter, contour: Array, phi: Array, depth: Array) -> tuple[str, ...]:
    """Whether outlines a(phi), shape (n, p), end where the shape of the indenter does, and not by themselves."""
    if indenter.reach == np.inf or indenter.flat or not indenter.rising:
        return ()
    with np.errstate(invalid="ignore"):
        # share of the reach above which a contact counts as ending there: outlines are off by a hundredth
        at_end = np.any(contour > 0.98 * indenter.reach_along(phi), axis=1)
    return first_failure(
        np.asarray(at_end),
        depth,
        f"the contact reaches the end of the indenter's shape ({text(indenter.reach, 'm')} from the first touch) and is cut off "
        "there as by the edge of a punch. Ask for less depth, or describe the tip farther out.",
    )


def judged(curve: Curve, medium: Body, indenter: Indenter) -> Curve:
    """Return the curve with steps marked that are beyond the theory, and sentences that say why.

    `valid` is False where a number is not finite, the estimated error is as large as the force, a layer would be pressed
    through, another part of the tip than the one that was solved may touch, or no contact has the radius.
    """
    finite = np.all([np.isfinite(getattr(curve, name)) for name in ("depth", "force", "radius", "area")], axis=0)
    broken = curve.valid & ~finite
    notes = curve.notes + first_failure(
        broken,
        curve.depth,
        "the numbers are not finite: the sizes of this case overflow, or the force of a sudden step is infinite.",
    )
    known = _known(curve)
    inside = (curve.radius > 0) & (curve.depth == 0) & (curve.force == 0) & (not indenter.flat)
    if inside.any():
        largest = text(float(curve.radius[inside].max()), "m")
        notes += (
            f"At radii up to {largest}: the flat end of the tip is larger, and in contact as a whole under any load.",
        )
    valid = curve.valid & finite & known & ~inside
    # a force that is not known says nothing about the layers
    pressing = curve.force if curve.pressing is None else curve.pressing
    through = np.where(known, compression(medium, curve.depth, pressing, curve.radius), 0.0)
    notes += first_failure(
        through >= 1,
        curve.depth,
        "the tip would be pressed through a layer into what lies below, which does not give way. It cannot get there: ask for "
        "less depth, or check the thickness.",
    )
    corrected = "strain_factor" in curve.extra
    if not corrected:
        notes += _large_strains(curve, medium, indenter, through)
    notes += indenter.notes
    apart = curve.depth > indenter.elsewhere
    if "patches" not in curve.extra:
        valid = valid & ~apart
        notes += first_failure(
            apart,
            curve.depth,
            "other parts of the map, beyond the circle in which it rises from its apex, are lower than the depth and may touch "
            "as well. They are not counted here; method='bem' solves the whole map.",
        )
    if isinstance(indenter, AreaFunction):
        notes += (
            "The tip is taken as a body of revolution with the sections of its area function. At equal depth the force of a "
            "sharp three-sided pyramid is 7.8 % higher, of a four-sided one 2.7 %; where the tip is blunt it is less.",
        )
    if not corrected:
        notes += _yield(curve)
    return replace(curve, valid=valid & (through < 1), notes=notes)


def _large_strains(curve: Curve, medium: Body, indenter: Indenter, through: Array) -> tuple[str, ...]:
    """Whether layers are compressed or faces inclined by too much for linear theory, with the error where the table has it."""
    # compression of a layer over its thickness above which a note says that strains are no longer small
    thin = (through >= 1 / 3) & (through < 1)
    # boundary elements, which solve tips that do not rise, have a slope from cells
    steep = steepness(indenter, curve.radius, curve.depth) if indenter.rising and not indenter.flat else ()
    if not (steep or thin.any()):
        return ()
    # adhesion and relaxation do not go with the correction
    linear = not {"retraction", "contact_depth"} & curve.extra.keys()
    number = overestimate(medium, indenter, curve.depth, corrects=linear)
    what = "a layer is compressed by more than a third of its thickness. Strains are no longer small there"
    if number is None:
        what += (
            ", and what they change is not tabulated for this case: under spheres at half of the thickness, bonded neo-Hookean "
            "layers take from 6 % less force than linear theory (thick and incompressible) to 23 % more (thin, nu = 0.4)"
        )
    notes = (*first_failure(thin, curve.depth, f"{what}."), *steep)
    if number is None:
        return notes
    text, beyond = number
    return (*(notes if beyond else ()), f"Strains are no longer small: {text}")


def _known(curve: Curve) -> Flags:
    """Where the estimated error of the force is less than the force, or none is given; shape (n,)."""
    if "force_error" not in curve.extra:
        return np.ones_like(curve.valid)
    error = np.asarray(curve.extra["force_error"][1], dtype=float)
    # infinite: a method that has no estimate, and says so
    return np.asarray((error < 1) | ~np.isfinite(error))


def compression(medium: Body, depth: Array, force: Array, radius: Array) -> Array:
    """Least compression of the layers over their thickness at contacts of shape (n,), the largest of all stacks from the surface.

    Zero without layers, and where nothing is known of what lies below.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.where(radius > 0, np.maximum(force, 0.0) / radius, 0.0)
    largest = np.zeros_like(depth)
    for thickness, softness in _stacks(medium):
        with np.errstate(invalid="ignore"):
            share = (depth - softness * spread) / thickness
        largest = np.fmax(largest, np.where(np.isfinite(share), share, 0.0))
    return largest


def deepest(medium: Body) -> float:
    """Depth [m] that no tip can reach: the thickness of layers on rigid bases, infinite for all other bodies."""
    depths = [thickness for thickness, softness in _stacks(medium) if softness == 0]
    return max(depths, default=float("inf"))


def check_deepest(medium: Body, depth: float) -> None:
    """Refuse a depth [m] that no tip can reach."""
    if depth >= deepest(medium):
        raise BadValue(
            "depth",
            text(depth, "m"),
            f"is more than the {text(deepest(medium), 'm')} of the layers on their rigid base: no tip gets there. "
            "Ask for less depth.",
        )


def _stacks(medium: Body) -> Iterator[tuple[float, float]]:
    """Thickness of all layers above each interface [m], and 1/E* of the softest body below it [1/Pa]."""
    body = underlying(medium)
    if body.pair:
        thickness = sum(each.thickness for each in body.elastic)
        if thickness > 0:
            yield thickness, sum(each.base.softest for each in body.elastic)
        return
    thickness = 0.0
    ((_, stack),) = body.sides
    for i, layer in enumerate(stack.layers):
        thickness += layer.thickness
        yield thickness, max(part.softest for part in stack.parts[i + 1 :])


def _yield(curve: Curve) -> tuple[str, ...]:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        share = curve.force / curve.area * 2 * curve.radius / curve.stiffness
    # the ideal strength
    return high_pressure(np.where(curve.valid, share, 0.0), curve.depth, 0.1)


def high_pressure(
    share: Array, along: Array, limit: float, called: tuple[str, str] = ("depth", "m"), kind: str = "mean"
) -> tuple[str, ...]:
    """Sentence about steps whose pressure over the contact modulus S/(2a) exceeds a limit, above which hard solids yield."""
    high = np.isfinite(share) & (share > limit)
    if not high.any():
        return ()
    return first_failure(
        high,
        along,
        f"the {kind} pressure is up to {share[high].max():.2g} of the contact modulus. Solids that yield have done so before; in "
        "gels and rubbers strains are no longer small.",
        called,
    )
