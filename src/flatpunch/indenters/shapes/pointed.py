"""Pointed tips: cones, regular pyramids, and pyramids whose faces differ.

A pyramid is the highest of its faces, f = max_j k_j . x, each a plane of gradient k_j. The gradients are the corners
of a convex polygon about the origin, and that polygon is the shape: rounding the tip (`Rounded`) and tilting it
(`Tilted`) are operations on it. AFM tips have front, back and side angles; the Knoop diamond is rhombic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.checks import SIDES, Array
from flatpunch._support.declared import a_count, an_angle, checked, in_case_files
from flatpunch._support.readable import readable
from flatpunch.indenters._common import FULL_TURN, SAME, HalfOpeningAngle, Inclination
from flatpunch.indenters.profile import PowerLawShape, RoundShape


@in_case_files("indenter", None, "", "of_opening", wear="wears")
@readable
@dataclass(frozen=True, slots=True)
class Cone(PowerLawShape, RoundShape):
    """Cone, f = r tan(inclination).

    Parameters
    ----------
    inclination : float
        Angle between the surface and the cone's face [rad], between 0 and pi/2.

    See Also
    --------
    SpheroCone : With a round apex.
    Pyramid : With edges.

    Examples
    --------
    >>> print(fp.Cone(inclination=np.radians(20)))
    Cone
      inclination  20 deg
    """

    inclination: Inclination
    exponent = 1.0

    @classmethod
    @checked
    def of_opening(cls, half_opening_angle: HalfOpeningAngle) -> Cone:
        """Cone by the angle between its axis and its face.

        Parameters
        ----------
        half_opening_angle : float
            Angle [rad], between 0 and pi/2; the inclination is pi/2 less this.
        """
        return cls(math.pi / 2 - half_opening_angle)

    def angular(self, phi: Array) -> Array:
        """psi(phi) = tan(inclination), in the shape of phi [rad]."""
        return np.full(np.shape(phi), math.tan(self.inclination))


Sides = Annotated[
    int,
    a_count(
        "sides", 3, SIDES, remedy="A pyramid has 3 faces or more; the round limit is Cone(inclination).", example="4"
    ),
]


@in_case_files("indenter", None, "", "of_opening", wear="wears")
@readable
@dataclass(frozen=True, slots=True)
class Pyramid(PowerLawShape):
    """Regular pyramid, f = tan(inclination) max_j (x·n_j).

    The horizontal normals of the faces are n_j = (cos 2 pi j/N, sin 2 pi j/N): the first face looks along +x,
    the edges lie half-way between the normals.

    Parameters
    ----------
    sides : int
        Number of faces N, >= 3.
    inclination : float
        Angle between the surface and each face [rad], between 0 and pi/2.

    See Also
    --------
    FacetedPyramid : Faces of any inclination.
    Rounded, Truncated : Worn tips.
    Vickers, Berkovich, Knoop, CubeCorner : The standard ones.

    Examples
    --------
    >>> print(fp.Pyramid(sides=4, inclination=np.radians(55)))
    Pyramid
      sides        4
      inclination  55 deg
    """

    sides: Sides
    inclination: Inclination
    exponent = 1.0

    @classmethod
    @checked
    def of_opening(cls, sides: Sides, half_opening_angle: HalfOpeningAngle) -> Pyramid:
        """Pyramid by the angle between its axis and each face.

        Parameters
        ----------
        sides : int
            Number of faces, >= 3.
        half_opening_angle : float
            Angle [rad], between 0 and pi/2; the inclination is pi/2 less this.
        """
        return cls(sides, math.pi / 2 - half_opening_angle)

    @property
    def corners(self) -> tuple[float, ...]:
        """Directions of the edges, (2 j + 1) pi/N [rad]."""
        return tuple((2 * j + 1) * math.pi / self.sides for j in range(self.sides))

    def angular(self, phi: Array) -> Array:
        """psi(phi) = tan(inclination) cos(angle to the nearest face normal), in the shape of phi [rad]."""
        width = FULL_TURN / self.sides
        off = phi - width * np.round(np.asarray(phi) / width)
        return np.asarray(math.tan(self.inclination) * np.cos(off))


@readable
@dataclass(frozen=True, slots=True)
class FacetedPyramid(PowerLawShape):
    """Pyramid with faces of different inclination, f = max_j tan(inclination_j) (x·n_j).

    Parameters
    ----------
    directions : sequence of float
        Polar angles of the horizontal face normals n_j [rad]: the side to which each face looks.
    inclinations : sequence of float
        Angle between the surface and each face [rad], between 0 and pi/2.

    Raises
    ------
    ValueError
        If the faces do not enclose the apex, or one of them is hidden behind its neighbours.

    See Also
    --------
    Pyramid : The regular one.
    AfmPyramid : By front, back and side angles.

    Examples
    --------
    >>> tip = fp.FacetedPyramid(directions=(0.0, np.pi / 2, np.pi, 3 * np.pi / 2), inclinations=(0.3, 0.4, 0.3, 0.4))
    >>> len(tip.corners)
    4
    """

    directions: tuple[Annotated[float, an_angle("direction", least=-math.inf)], ...]
    inclinations: tuple[Inclination, ...]
    exponent = 1.0

    def _together_(self) -> None:
        directions, slants = [direction % FULL_TURN for direction in self.directions], self.inclinations
        if len(directions) != len(slants) or len(slants) < 3:
            raise ValueError(
                f"FacetedPyramid has {len(directions)} directions and {len(slants)} inclinations; it needs 3 faces or "
                "more, with one of each."
            )
        faces = sorted(zip(directions, slants, strict=True))
        object.__setattr__(self, "directions", tuple(d for d, _ in faces))
        object.__setattr__(self, "inclinations", tuple(a for _, a in faces))
        _check_faces(self.directions, face_gradients(self))

    @property
    def corners(self) -> tuple[float, ...]:
        """Directions of the edges between neighbouring faces [rad]."""
        return edge_directions(face_gradients(self))

    def angular(self, phi: Array) -> Array:
        """psi(phi) = max_j tan(inclination_j) cos(phi - direction_j), in the shape of phi [rad]."""
        phi = np.asarray(phi, dtype=float)
        faces = zip(self.directions, self.inclinations, strict=True)
        return np.asarray(np.max([math.tan(a) * np.cos(phi - d) for d, a in faces], axis=0))


def face_gradients(tip: Pyramid | FacetedPyramid) -> Array:
    """Gradients k_j of the faces, anticlockwise, shape (faces, 2)."""
    if isinstance(tip, Pyramid):
        angle = FULL_TURN * np.arange(tip.sides) / tip.sides
        steepness = np.full(tip.sides, math.tan(tip.inclination))
    else:
        angle, steepness = np.array(tip.directions), np.tan(tip.inclinations)
    return np.asarray(steepness[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))


def edge_directions(gradients: Array) -> tuple[float, ...]:
    """Polar angles of the edges, along which two faces are equally high: normals of the polygon's sides, ascending."""
    side = np.roll(gradients, -1, axis=0) - gradients
    angles = np.mod(np.arctan2(-side[:, 0], side[:, 1]), FULL_TURN)
    # rounding must not turn an edge along +x into one a turn further
    angles[FULL_TURN - angles < 1e-15 * FULL_TURN] = 0.0
    return tuple(sorted(map(float, angles)))


def pyramid_of(gradients: Sequence[Sequence[float]] | Array) -> FacetedPyramid:
    """Pyramid with faces of given gradients, shape (faces, 2)."""
    k = np.asarray(gradients, dtype=float)
    return FacetedPyramid(tuple(np.arctan2(k[:, 1], k[:, 0])), tuple(np.arctan(np.hypot(k[:, 0], k[:, 1]))))


def _check_faces(directions: tuple[float, ...], gradients: Array) -> None:
    gaps = np.diff([*directions, directions[0] + FULL_TURN])
    if gaps.max() >= math.pi * (1 - SAME):
        i = int(np.argmax(gaps))
        raise ValueError(
            f"FacetedPyramid has no face between the directions {directions[i]:.4g} and "
            f"{directions[i] + gaps[i]:.4g} rad, half a "
            "turn or more: there the tip would not rise. Add a face."
        )
    before, after = np.roll(gradients, 1, axis=0), np.roll(gradients, -1, axis=0)
    turn = np.cross(np.pad(gradients - before, ((0, 0), (0, 1))), np.pad(after - gradients, ((0, 0), (0, 1))))[:, 2]
    hidden = turn <= SAME * np.max(np.sum(gradients**2, axis=1))
    if hidden.any():
        i = int(np.argmax(hidden))
        raise ValueError(
            f"FacetedPyramid face {i} (direction {directions[i]:.4g} rad) is hidden behind its neighbours: they "
            "are steep enough "
            "to leave nothing of it. Leave it out or raise its inclination."
        )
