"""What boundary elements are compared with over a loading path: a series, its round base, or nothing.

Ratios to the series hardly move where it holds. Under stiff films it has poles and its base radius jumps, while force and
outline themselves remain smooth in the depth: there the logarithms of the solutions are interpolated as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._validation import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import Control
from flatpunch.contact.expansion import PathPoint, PerturbedContact
from flatpunch.contact.perturbed import Expansion, Series, controlled
from flatpunch.indenters.profile import Indenter

SERIES, BASE, NOTHING = 0, 1, 2
"""Columns of `Theory.force`."""

_FAR = 2.0
"""Swing of w about which it is damped; sharp tips on soft bodies reach 0.8."""
_SAMPLES = 200


@dataclass(frozen=True, slots=True)
class Theory:
    """References at n depths.

    Attributes
    ----------
    force, growth : ndarray, shape (n, 3)
        ln F [N] and dln F/dln d of series, base and nothing.
    shape : ndarray, shape (n, 2 + angles)
        Logarithms of radius [m], root of area over pi [m] and a(phi) [m] of the series' damped outline.
    radius : ndarray, shape (n,)
        Base radius [m].
    """

    force: Array
    growth: Array
    shape: Array
    radius: Array


class TheoryAt:
    """References at depths, kept.

    Parameters
    ----------
    kernel, indenter, series
        Medium, indenter, and the series that stands beside their solutions.
    phi : ndarray, shape (angles,)
        Polar angles of the outlines [rad].
    """

    def __init__(self, kernel: Kernel, indenter: Indenter, series: Series, phi: Array) -> None:
        self.kernel, self.indenter, self.series, self.phi = kernel, indenter, series, phi
        self._kept: dict[float, tuple[Array, ...]] = {}

    def at(self, x: Array) -> Theory:
        """References at x = ln d, shape (n,)."""
        new = np.array([at for at in x if at not in self._kept])
        if new.size:
            contact = controlled(self.kernel, self.indenter, self.series, Control("depth", np.exp(new)))
            rows = (*forces(self.series, contact), shapes(self.series, contact, self.phi), contact.radius)
            self._kept.update(zip(new.tolist(), zip(*rows, strict=True), strict=True))
        kept = [self._kept[at] for at in x]
        return Theory(*(np.array(part) for part in zip(*kept, strict=True)))

    def turning(self, radius: Array) -> float:
        """Least base radius [m], up to the largest given, at which the depth of the round base turns back; else infinity.

        It may do so under stiff films: one depth has several contacts beyond.
        """
        path = np.geomspace(radius.min(), radius.max(), _SAMPLES)
        return float(path[self.series.descent(path).depth_slope <= 0].min(initial=np.inf))


def forces(series: Series, contact: PathPoint | PerturbedContact) -> tuple[Array, Array]:
    """`Theory.force` and `Theory.growth` of contacts of the series, not finite where there is no such force."""
    base = series.unperturbed(contact.radius)
    force = np.column_stack([contact.force, base.force, np.ones_like(base.force)])
    stiffness = np.column_stack([contact.stiffness, base.stiffness, np.zeros_like(base.force)])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(force), stiffness * contact.depth[:, None] / force


def shapes(series: Expansion, contact: PerturbedContact, phi: Array) -> Array:
    """`Theory.shape` of contacts of the series; radius and area are compared with the base radius."""
    radius = np.log(contact.radius)
    return np.column_stack([radius, radius, np.log(reference_outline(series, contact, phi))])


def reference_outline(expansion: Expansion, contact: PerturbedContact, phi: Array) -> Array:
    """What outlines are compared with, shape (n, p) [m]: smooth in the base radius even through the poles of w."""
    size = np.where(contact.size > 0, contact.size, 1.0)[:, None]
    with np.errstate(divide="ignore"):
        w = np.log(expansion.outline(contact, phi) / size)
    damped = np.where(contact.size[:, None] > 0, w, 0.0) / (1 + (contact.swing[:, None] / _FAR) ** 2)
    return np.asarray(contact.radius[:, None] * np.exp(damped))
