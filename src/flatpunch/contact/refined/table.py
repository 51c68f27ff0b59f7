"""Corrections of standard tips on one layer on a rigid base, from a table that comes with the package.

On such a layer the ratio of boundary elements to second order depends on beta and the Poisson ratio alone (on beta alone if
the layer slides): slopes scale out. The table holds it for pyramids of 3, 4 and 6 sides and for ellipses, at nodes of ln beta,
of q = sqrt(1 - 2 nu) and of s^2, s = |A - B|/(A + B); between the nodes of q and s^2 it is a polynomial. It is made by
`scripts/make_corrections.py`, and holds its own nodes.

A method sees the medium's response only, so the layer is recognised by that.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files

import numpy as np
from scipy.interpolate import CubicSpline

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import FORCE_ERROR
from flatpunch.contact.perturbation.perturbed_contact import PerturbedContact
from flatpunch.contact.perturbation.power_law_series import PowerExpansion, power_expansion
from flatpunch.contact.refined.interpolation import Interpolation, RoundReference
from flatpunch.contact.refined.sample import Sample
from flatpunch.indenters import EllipticParaboloid, Pyramid
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Layer, Medium, RigidBase
from flatpunch.numerics.chebyshev import lagrange

ANGLES = 360
"""Polar angles of the outline of a sample; half as many leave 0.1 % at the corners of pyramids."""


_WAVES = np.array([0.02, 0.2, 0.7, 1.5, 4.0])
"""Wavenumbers kappa at which a layer is recognised by its response; the third also gives q."""


@dataclass(frozen=True, slots=True)
class TableRows:
    """A second-order series, nodes ln a, shape (n,), and rows of logarithms of ratios to it there, shape (n, 3 + ANGLES)."""

    series: PowerExpansion
    nodes: Array
    rows: Array


def sector(tip: str) -> int:
    """Polar angles of one symmetric sector, out of `ANGLES`: from a face to an edge, or from one axis to the other."""
    return ANGLES // 4 + 1 if tip == "ellipse" else ANGLES // (2 * int(tip)) + 1


def layer(root: float | None, thickness: float = 1.0) -> Medium:
    """Bonded layer of the given q on a rigid base, or the sliding one (None)."""
    if root is None:
        return Medium([Layer(1.0, 0.0, thickness, bonded=False)], base=RigidBase())
    return Medium([Layer(1.0, (1 - root**2) / 2, thickness)], base=RigidBase())


def tabulated_rows(kernel: Kernel, indenter: Indenter) -> TableRows | None:
    """Corrections of an indenter on a medium if the table has them."""
    tip = _tip(indenter)
    if tip is None or kernel.homogeneous:
        return None
    media = _medium_weights(kernel)
    if media is None:
        return None
    rows = np.tensordot(media, _table()[tip[0]], axes=1)
    if tip[0] == "ellipse":
        rows = np.tensordot(tip[1], rows, axes=1)
    series = power_expansion(kernel, indenter, "second", terms=False)
    return TableRows(series, np.log(_table()["betas"] * kernel.length), _full_turn(rows, tip[0], tip[2]))


@byte_cached
def tabulated(kernel: Kernel, indenter: Indenter) -> Interpolation | None:
    """Contacts of an indenter on a medium from the table, if it has them, close enough for the interpolation between them."""
    table = tabulated_rows(kernel, indenter)
    if table is None:
        return None
    # samples per gap of the table; half as many add 1e-5 to the error of the force
    x = np.linspace(table.nodes[0], table.nodes[-1], 4 * (table.nodes.size - 1) + 1)
    # smaller contacts, down to a thousandth of that radius, are to the series as on the half-space; to the round contact they are
    # not, by up to 0.5 % at the first node
    x = np.concatenate([np.arange(x[0] - np.log(1e3), x[0] - 1e-9, x[1] - x[0]), x])
    contact, spline = table.series.evaluate(np.exp(x)), CubicSpline(table.nodes, table.rows)
    inside = np.maximum(x, table.nodes[0])
    values, slope = spline(inside), np.where(x < table.nodes[0], 0.0, spline(inside, 1)[:, 0])
    force = values[:, 0] + np.log(contact.force / kernel.modulus)
    growth = (contact.stiffness / contact.force + slope / contact.depth_slope) * contact.depth
    phi = np.asarray(np.arange(ANGLES) * (2 * np.pi / ANGLES))
    outline = np.log(reference_outline(table.series, contact, phi)) + values[:, 3:]
    shapes = np.column_stack([x + values[:, 1], x + values[:, 2] / 2, outline])
    # largest error of the outline over the mean radius against fresh boundary elements (tests/refined)
    samples = tuple(
        Sample(float(f), float(g), shape, FORCE_ERROR, 5e-3) for f, g, shape in zip(force, growth, shapes, strict=True)
    )
    return Interpolation(RoundReference(kernel, indenter), np.log(contact.depth), samples, np.zeros((x.size - 1, 2)))


def reference_outline(series: PowerExpansion, contact: PerturbedContact, phi: Array) -> Array:
    """What outlines are compared with, shape (n, p) [m]: smooth in the base radius even through the poles of w."""
    size = np.where(contact.size > 0, contact.size, 1.0)[:, None]
    with np.errstate(divide="ignore"):
        w = np.log(series.outline(contact, phi) / size)
    # swing of w about which outlines are damped; sharp tips on soft bodies reach 0.8
    damped = np.where(contact.size[:, None] > 0, w, 0.0) / (1 + (contact.swing[:, None] / 2.0) ** 2)
    return np.asarray(contact.radius[:, None] * np.exp(damped))


def _tip(indenter: Indenter) -> tuple[str, Array, bool] | None:
    """Name in the table, weights of the ellipses, and whether the outline is turned by 90 degrees."""
    if isinstance(indenter, Pyramid) and str(indenter.sides) in _table():
        return str(indenter.sides), np.ones(1), False
    if isinstance(indenter, EllipticParaboloid):
        square = ((indenter.A - indenter.B) / (indenter.A + indenter.B)) ** 2
        squares = _table()["squares"]
        if square <= squares[-1]:
            # at zero there is nothing to correct
            return "ellipse", lagrange(np.append(0.0, squares), square)[1:], indenter.A > indenter.B
    return None


@byte_cached
def _medium_weights(kernel: Kernel) -> Array | None:
    """Weights of the layers of the table, the sliding one last; None for any other medium."""
    # responses are interpolated to 2e-12
    same, found = 1e-9, kernel.response(_WAVES)
    sliding = compliance(layer(None)).response(_WAVES)
    if np.all(np.abs(found / sliding - 1) < same):
        return np.append(np.zeros(_table()["roots"].size), 1.0)
    root = _root_of(float(found[2]))
    if root is None:
        return None
    bonded = compliance(layer(root)).response(_WAVES)
    # the root is known to half the digits of the response beside q = 0
    if not np.all(np.abs(found / bonded - 1) < 100 * same):
        return None
    return np.append(lagrange(_table()["roots"], root), 0.0)


def _root_of(wanted: float) -> float | None:
    """q of the bonded layer whose response at `_WAVES[2]` is the wanted one; None outside 0 <= nu <= 1/2."""

    def response(root: float) -> float:
        return float(compliance(layer(root)).response(_WAVES[2:3])[0])

    same = 1e-9
    if abs(response(0.0) / wanted - 1) < same:
        return 0.0
    if not response(0.0) < wanted <= response(1.0) * (1 + same):
        return None
    from scipy.optimize import elementwise

    root = elementwise.find_root(lambda q: np.vectorize(response)(q) - wanted, (0.0, 1.0))
    return float(root.x) if root.success else 1.0


def _full_turn(rows: Array, tip: str, turned: bool) -> Array:
    """Rows with the outline over a whole turn from those of one sector."""
    period = 2 * (sector(tip) - 1)
    index = np.arange(ANGLES) % period
    index = np.minimum(index, period - index)
    if turned:
        index = np.roll(index, ANGLES // 4)
    return np.hstack([rows[:, :3], rows[:, 3 + index]])


@byte_cached
def _table() -> dict[str, Array]:
    """Rows by tip, (layers, [ellipses,] betas, 3 + sector), and the nodes: `betas`, `roots` (q), `squares` (s^2)."""
    with (files("flatpunch.contact.refined") / "data" / "corrections.npz").open("rb") as file, np.load(file) as arrays:
        return {name: arrays[name].astype(float) for name in arrays.files}
