"""Indenters of the hardness and nanoindentation standards, and the usual AFM tips, by their nominal angles.

Angles as the standards give them: between the axis and a face (Berkovich, cube corner), between opposite faces (Vickers),
between opposite edges (Knoop). Sources: ISO 6507-2 (Vickers), ISO 4545-2 (Knoop), ISO 14577-2 (Berkovich, modified Berkovich,
cube corner). The face inclination used here is measured from the surface, 90 degrees minus the angle to the axis:

| name | standard angle | inclination | A(h)/h^2 |
|---|---|---|---|
| Vickers | 136 deg between opposite faces | 22 deg | 24.504 |
| Berkovich | 65.03 deg axis to face (same surface area as Vickers) | 24.97 deg | 23.96 |
| Berkovich, modified | 65.27 deg axis to face (same projected area as Vickers) | 24.73 deg | 24.49 |
| CubeCorner | faces at right angles, 35.264 deg axis to face | 54.736 deg | 2.598 |
| Knoop | 172.5 and 130 deg between opposite edges | 25.21 deg | 65.44 |

The first face looks along +x; Knoop's long diagonal lies along x. Sharp tips are returned as the pyramids that they are.
"""

from __future__ import annotations

import math
from typing import Annotated, overload

from flatpunch._support.checks import BadValue
from flatpunch._support.declared import a_length, an_angle, checked, in_case_files
from flatpunch.indenters.shapes.pointed import Cone, FacetedPyramid, Pyramid
from flatpunch.indenters.worn.rounded import Rounded
from flatpunch.indenters.worn.truncated import Truncated

Tip = Pyramid | FacetedPyramid | Rounded | Truncated

TipRadius = Annotated[float, a_length("radius of the apex", above=-math.inf, least=0.0, remedy="0 is sharp.")]
HeightRemoved = Annotated[float, a_length("height removed", above=-math.inf, least=0.0, remedy="0 is sharp.")]


_FACE = "must lie in 0 < angle < pi/2: the half opening angle between axis and face in radians. Degrees go through math.radians."
Front = Annotated[float, an_angle("front", outside=_FACE, example="15 deg")]
Back = Annotated[float, an_angle("back", outside=_FACE, example="25 deg")]
Side = Annotated[float, an_angle("side", outside=_FACE, example="20 deg")]


@overload
def Vickers() -> Pyramid: ...
@overload
def Vickers(*, tip_radius: float) -> Rounded: ...
@overload
def Vickers(*, height_removed: float) -> Truncated: ...
@in_case_files("indenter", wear="wears")
@checked
def Vickers(*, tip_radius: TipRadius = 0.0, height_removed: HeightRemoved = 0.0) -> Tip:
    """Square diamond, 136 degrees between opposite faces: inclination 22 degrees.

    Parameters
    ----------
    tip_radius : float
        Radius of the sphere in which the tip ends [m], `Rounded(..., true_sphere=True)`. 0 is sharp.
    height_removed : float
        Height cut off flat above the apex [m]; see `Truncated`. 0 is sharp. Only one of the two.

    See Also
    --------
    Berkovich, Knoop, CubeCorner : Other standard pyramids.
    Pyramid : Inclination as given.

    Examples
    --------
    >>> fp.Vickers(height_removed=20e-9)
    Truncated(tip=Pyramid(sides=4, inclination=0.383972), height_removed=2e-08)
    """
    return _finished("Vickers", Pyramid(4, math.pi / 2 - math.radians(136 / 2)), tip_radius, height_removed)


@overload
def Berkovich(*, modified: bool = True) -> Pyramid: ...
@overload
def Berkovich(*, modified: bool = True, tip_radius: float) -> Rounded: ...
@overload
def Berkovich(*, modified: bool = True, height_removed: float) -> Truncated: ...
@in_case_files("indenter", wear="wears")
@checked
def Berkovich(*, modified: bool = True, tip_radius: TipRadius = 0.0, height_removed: HeightRemoved = 0.0) -> Tip:
    """Three-sided diamond: 65.27 degrees between axis and face (modified, today's), or the 65.03 degrees of the original.

    Parameters
    ----------
    modified : bool
        Projected area as Vickers, 24.5 h^2; otherwise surface area as Vickers.
    tip_radius, height_removed : float
        Rounding or flat [m], as for `Vickers`.

    See Also
    --------
    Rounded : Pyramids with a rounded tip.
    plot_tip : The picture.

    Examples
    --------
    >>> print(fp.Berkovich())
    Pyramid
      sides        3
      inclination  24.73 deg
    >>> fp.Berkovich(tip_radius=50e-9)
    Rounded(tip=Pyramid(sides=3, inclination=0.43162), radius=5e-08, true_sphere=True)
    """
    return _finished(
        "Berkovich",
        Pyramid(3, math.pi / 2 - math.radians(65.27 if modified else 65.03)),
        tip_radius,
        height_removed,
    )


@overload
def CubeCorner() -> Pyramid: ...
@overload
def CubeCorner(*, tip_radius: float) -> Rounded: ...
@overload
def CubeCorner(*, height_removed: float) -> Truncated: ...
@in_case_files("indenter", wear="wears")
@checked
def CubeCorner(*, tip_radius: TipRadius = 0.0, height_removed: HeightRemoved = 0.0) -> Tip:
    """Corner of a cube, three faces at right angles: tan(inclination) = sqrt(2), far from the small slopes of the theory.

    Parameters
    ----------
    tip_radius, height_removed : float
        Rounding or flat [m], as for `Vickers`.

    See Also
    --------
    Berkovich, Vickers, Knoop : Other standard pyramids.
    Pyramid : Inclination as given.

    Examples
    --------
    >>> print(fp.CubeCorner())
    Pyramid
      sides        3
      inclination  54.74 deg
    """
    return _finished("CubeCorner", Pyramid(3, math.atan(math.sqrt(2))), tip_radius, height_removed)


@overload
def Knoop() -> FacetedPyramid: ...
@overload
def Knoop(*, tip_radius: float) -> Rounded: ...
@overload
def Knoop(*, height_removed: float) -> Truncated: ...
@in_case_files("indenter", wear="wears")
@checked
def Knoop(*, tip_radius: TipRadius = 0.0, height_removed: HeightRemoved = 0.0) -> Tip:
    """Rhombic diamond, edges at 172.5 degrees (long diagonal, along x) and 130 degrees (short diagonal, along y).

    ``f = |x| cot(86.25 deg) + |y| cot(65 deg)``: level lines are rhombi 7.11 times as long as wide.

    Parameters
    ----------
    tip_radius, height_removed : float
        Rounding or flat [m], as for `Vickers`.

    See Also
    --------
    Berkovich, Vickers, CubeCorner : Other standard pyramids.
    FacetedPyramid : Faces of any inclination.

    Examples
    --------
    >>> len(fp.Knoop().corners)
    4
    """
    along_x, along_y = 1 / math.tan(math.radians(172.5 / 2)), 1 / math.tan(math.radians(130 / 2))
    direction, face = math.atan2(along_y, along_x), math.atan(math.hypot(along_x, along_y))
    directions = (direction, math.pi - direction, math.pi + direction, 2 * math.pi - direction)
    return _finished("Knoop", FacetedPyramid(directions, (face,) * 4), tip_radius, height_removed)


@overload
def AfmPyramid(front: float, back: float, side: float) -> FacetedPyramid: ...
@overload
def AfmPyramid(front: float, back: float, side: float, *, tip_radius: float) -> Rounded: ...
@overload
def AfmPyramid(front: float, back: float, side: float, *, height_removed: float) -> Truncated: ...
@in_case_files("indenter", wear="wears")
@checked
def AfmPyramid(
    front: Front, back: Back, side: Side, *, tip_radius: TipRadius = 0.0, height_removed: HeightRemoved = 0.0
) -> Tip:
    """Four-sided AFM tip by the half opening angles of its data sheet.

    Parameters
    ----------
    front, back, side : float
        Angles between the axis and the faces [rad], 0 to pi/2: the front looks along +x, the back along -x, the two sides
        along +y and -y.
    tip_radius, height_removed : float
        Rounding or flat [m], as for `Vickers`.

    See Also
    --------
    FacetedPyramid : Faces as many as given.
    Tilted : On a tilted cantilever.

    Examples
    --------
    >>> fp.AfmPyramid(np.radians(15), np.radians(25), np.radians(17.5), tip_radius=10e-9).radius
    1e-08
    """
    faces = tuple(math.pi / 2 - angle for angle in (front, side, back, side))
    pyramid = FacetedPyramid((0.0, math.pi / 2, math.pi, 3 * math.pi / 2), faces)
    return _finished("AfmPyramid", pyramid, tip_radius, height_removed)


def SpheroCone(inclination: float, radius: float) -> Rounded:
    """Cone that ends in a sphere, tangent to it: spherical up to r = R sin(inclination), straight beyond.

    Parameters
    ----------
    inclination : float
        Angle between the surface and the cone's face [rad].
    radius : float
        Radius R of the sphere [m].

    See Also
    --------
    Cone : The sharp one.
    Rounded : Round the apex of any pointed tip.

    Examples
    --------
    >>> fp.SpheroCone(inclination=np.radians(20), radius=1e-6).round
    True
    """
    return Rounded(Cone(inclination), radius, true_sphere=True)


def _finished(name: str, sharp: Pyramid | FacetedPyramid, tip_radius: float, height_removed: float) -> Tip:
    if tip_radius and height_removed:
        raise BadValue(
            name,
            "",
            ": give tip_radius or height_removed, not both. A tip first rounded and then worn flat is "
            "Truncated(Rounded(...), height_removed).",
        )
    if tip_radius:
        return Rounded(sharp, tip_radius, true_sphere=True)
    return Truncated(sharp, height_removed) if height_removed else sharp
