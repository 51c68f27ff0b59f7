"""Which body and layer a point belongs to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, Indices, one_of
from flatpunch._support.prefixes import text
from flatpunch.compliances.stack import Side, layer_at
from flatpunch.media import Body, Stack, underlying

__all__ = ["Located", "Side", "layer_at", "located"]


@dataclass(frozen=True, slots=True)
class Located:
    """Points of one body.

    Attributes
    ----------
    body : Stack
    chosen : ndarray of int, shape (n,)
        Which of all points these are.
    depth : ndarray, shape (n,)
        Depth below the body's own surface [m].
    layer : ndarray of int, shape (n,)
        Layer from the surface inwards; the base comes after the last one.
    upper : bool
        Whether it is the upper of two bodies, whose depth runs against z.
    """

    body: Stack
    chosen: Indices
    depth: Array
    layer: Indices
    upper: bool = False


def located(medium: Body, z: Array, side: Side) -> list[Located]:
    """Sort points by body and layer; `side` decides at interfaces, and between two bodies at z = 0.

    Raises
    ------
    ValueError
        If a point is outside the bodies or inside a rigid one.
    """
    medium = underlying(medium)
    one_of("side", side, ("above", "below"), "It is the side of an interface on which points are taken.")
    if body := medium.single:
        _inside(body, z, z)
        return [Located(body, np.arange(z.size), z, layer_at(body, z, side))]
    in_upper = (z < 0) | ((z == 0) & (side == "above"))
    parts = []
    # seen from inside the upper body, above and below change places
    opposite: Side = "above" if side == "below" else "below"
    chosen_by_body = ((in_upper, -1, opposite), (~in_upper, 1, side))
    for (_, body), (mine, sign, own) in zip(medium.sides, chosen_by_body, strict=True):
        chosen = np.flatnonzero(mine)
        if chosen.size:
            depth = sign * z[chosen]
            _inside(body, depth, z[chosen])
            parts.append(Located(body, chosen, depth, layer_at(body, depth, own), sign < 0))
    return parts


def _inside(body: Stack, depth: Array, z: Array) -> None:
    law = body.power_law
    if law and law.exponent < 0 and (depth == 0).any():
        raise ValueError(
            f"z = 0 is the surface of a body whose modulus grows without bound towards it (exponent = {law.exponent:.6g}), so "
            "that the stresses along it are infinite. Give depths > 0."
        )
    if body.rigid:
        raise BadValue(
            "z",
            f"{text(float(z[0]), 'm')}",
            "is inside a rigid body, which has no stresses. Give points in the elastic body.",
        )
    if (depth < 0).any():
        i = int(np.argmax(depth < 0))
        raise BadValue(
            "z",
            f"{text(float(z[i]), 'm')}",
            "is above the surface. z points into the material, z = 0 is the surface; only of two bodies the "
            "upper one is at z < 0.",
        )
    if body.base.rigid:
        outside = depth > body.thickness * (1 + ROUNDING)
        if outside.any():
            i = int(np.argmax(outside))
            raise BadValue(
                "z",
                f"{text(float(z[i]), 'm')}",
                f"is inside the rigid base, which begins at {text(body.thickness, 'm')} and has no stresses. Give "
                "points in the layers.",
            )
