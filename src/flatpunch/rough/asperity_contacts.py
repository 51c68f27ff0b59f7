"""Asperities that feel each other: each sinks into what its neighbours have pressed down.

By reciprocity the depth of asperity i is reduced by the displacement that asperity j makes, averaged with the pressure of the
flat punch under contact i,

    w_ij = (1/2 pi) int k C(k) J0(k r_ij) P*_i P_j dk / K_i

exact for round contacts to first order. The transforms P are taken to fourth order in k, so that only the Green's function G(r)
of the surface, its Laplacian and the second and fourth moments of the pressures are needed:

    w_ij = F_j [G + (s_i + m_j) lap G/4 + (s4_i + 4 s_i m_j + m4_j) lap lap G/64]

with mean r^2 and r^4 of punch (s) and contact (m). The contact is the sum of punches over its history, hence F m_j = int K s dd.
To second order the surface that neighbours have pressed down has a gradient t_i: a paraboloid of radius R touches by R t_i uphill
of its apex, where it is deeper by R t_i^2/2, and acts on the others from there. For other tips R is the contact radius over the
slope at the rim. Newton's method solves for all depths at once. The error of each result is measured from what this leaves out
(`Group.errors`).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from flatpunch._support.checks import NUMBERS, Array, Flags, Values, numbers, refused_overflow, shown, values
from flatpunch._support.readable import record
from flatpunch._version import __version__
from flatpunch.compliances import compliance
from flatpunch.contact.curve import control_from, first_failure, percent
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.indentation import indent
from flatpunch.indenters.profile import Indenter, check_indenter, check_rising
from flatpunch.media import Body
from flatpunch.rough.asperity_group import Group, Pressed
from flatpunch.rough.asperity_laws import Interactions, Law

if TYPE_CHECKING:
    import xarray as xr

MOST = 5000
"""Most asperities: their interactions take 1.6 GB, and 20 s of one core at each step."""

_NOTED = 0.01
"""Relative error of the force above which a note says so."""


@refused_overflow()
def asperities(
    medium: Body,
    tips: Indenter | Sequence[Indenter],
    positions: ArrayLike,
    heights: Values = 0.0,
    *,
    depth: Values | None = None,
    force: Values | None = None,
) -> xr.Dataset:
    """Press many asperities of one rigid body into a medium, each sinking into what the others press down.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body.
    tips : Indenter or sequence of them
        Shape of each asperity, or one for all: round tips are exact, others are solved by the default method of `indent` and act
        on their neighbours as round ones of their mean radius.
    positions : array, shape (n, 2)
        Places (x, y) of their apexes [m]; at most 5000.
    heights : float or array, shape (n,)
        Heights of the apexes over a common plane [m], peaks positive.
    depth, force : float or array, shape (steps,)
        One of them: depth of the highest apex below the undeformed surface [m], or the total force [N].

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force (total) [N], force_error (relative, of the force at this depth), stiffness dF/dd [N/m],
        contacts (number of asperities that touch), gap (the smallest between two contacts [m], negative where they overlap) and
        valid (False there). Along `step` and `asperity`: asperity_force [N], asperity_force_error (relative), radius [m] and
        asperity_depth [m], of the apex below the surface that the others have pressed down.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    rough_contact : Boundary elements, for contacts that merge.
    surfaces.Summits : Places, heights and curvatures of the summits of a surface.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=20e-6)], base=fp.RigidBase())
    >>> beads = [(0.0, 0.0), (15e-6, 0.0), (0.0, 15e-6)]
    >>> three = fp.asperities(gel, fp.Sphere(radius=10e-6), beads, depth=1e-6)
    >>> one = fp.indent(gel, fp.Sphere(radius=10e-6), depth=1e-6)
    >>> print((three.asperity_force.values[0] / float(one.force[0])).round(3))
    [0.996 1.014 1.014]
    """
    places = numbers("positions", positions, "m")
    if places.ndim != 2 or places.shape[1:] != (2,) or not places.size or not np.isfinite(places).all():
        raise ValueError(
            f"positions has shape {places.shape}; it must be finite places (n, 2) in metres, x and y of each asperity."
        )
    n = len(places)
    tops = values("heights", heights, minimum=-np.inf, unit="m", smallest=0.0)
    if tops.size not in (1, n):
        raise ValueError(f"heights has {tops.size} values for {n} positions; give one for each, or one for all.")
    if not isinstance(tips, (Indenter, list, tuple)):
        raise TypeError(f"tips = {shown(tips)} must be an indenter such as Sphere(radius=...), or a list of them.")
    given = n * [tips] if isinstance(tips, Indenter) else list(tips)
    if len(given) != n:
        raise ValueError(f"tips has {len(given)} entries for {n} positions; give one for each, or one for all.")
    for tip in given:
        check_indenter(tip)
        check_rising(tip)
    if n > MOST:
        raise ValueError(
            f"positions has {n} asperities; at most {MOST} are solved at once. Take the highest ones, or rough_contact."
        )
    control = control_from(depth=depth, force=force, radius=None)
    if control.values.size * n > NUMBERS:
        raise ValueError(
            f"{control.values.size} steps of {n} asperities make more than {NUMBERS:.0e} numbers. Solve fewer at once."
        )
    nearest, neighbour = (
        KDTree(places).query(places, k=2) if n > 1 else (np.full((1, 2), np.inf), np.zeros((1, 2), dtype=int))
    )
    if n > 1 and nearest[:, 1].min() == 0:
        i = int(np.argmin(nearest[:, 1]))
        i, j = sorted((i, int(next(k for k in neighbour[i] if k != i))))
        raise ValueError(f"positions[{i}] and positions[{j}] are equal; two asperities cannot be at one place.")
    shapes = list(dict.fromkeys(given))
    between = Interactions.of(compliance(medium), places, float(nearest[:, 1].min()))
    by_depth, largest = control.name == "depth", float(control.values.max())
    deepest = [
        (largest if by_depth else float(indent(medium, tip, force=largest / n)["depth"][0])) or 1e-9 for tip in shapes
    ]
    laws = [Law.of(medium, tip, each) for tip, each in zip(shapes, deepest, strict=True)]
    kind = np.array([shapes.index(tip) for tip in given])
    lower = np.broadcast_to(tops.max() - tops, (n,))
    group = Group(laws, kind, np.array([tip.round for tip in shapes]), lower, between)
    steps: list[Pressed] = []
    for target in control.values:
        group, pressed = group.solve(float(target), by_depth=by_depth)
        steps.append(pressed)
    return _dataset(medium, shapes, group, steps, control.name)


def _gap(places: Array, radius: Array) -> float:
    """Smallest gap between two contacts [m]; infinite for less than two."""
    touching = np.flatnonzero(radius > 0)
    at, a, smallest = places[touching], radius[touching], np.inf
    for i in range(1, touching.size):
        smallest = min(smallest, float((np.hypot(*(at[:i] - at[i]).T) - a[:i]).min()) - a[i])
    return smallest


def _dataset(
    medium: Body,
    shapes: list[Indenter],
    group: Group,
    steps: list[Pressed],
    control: str,
) -> xr.Dataset:
    force, radius, stiffness = (
        np.array([getattr(step.at, name) for step in steps]) for name in ("force", "radius", "stiffness")
    )
    depth = np.array([step.depth for step in steps])
    gap = np.array([_gap(group.between.places, row) for row in radius])
    own, missing = np.moveaxis(np.array([group.errors(step) for step in steps]), 1, 0)
    total = force.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        each_error = np.where(force > 0, stiffness * missing / force, 0.0)
        # neighbours take up part of the error of one depth, and never add to it
        error = np.where(total > 0, (stiffness * own).sum(axis=1) / total, 0.0)
    converged: Flags = np.array([step.converged for step in steps])
    merged = gap < 0
    both = ("step", "asperity")
    data: dict[str, Column] = {
        "depth": ("step", depth, {"units": "m", "long_name": "depth of the highest apex below the undeformed surface"}),
        "force": ("step", total, {"units": "N", "long_name": "total normal force"}),
        "force_error": ("step", error, {"units": "1", "long_name": "relative error of the total force at the depth"}),
        "stiffness": ("step", np.array([step.stiffness for step in steps]), {"units": "N/m", "long_name": "dF/dd"}),
        "contacts": ("step", (force > 0).sum(axis=1), {"units": "1", "long_name": "asperities in contact"}),
        "gap": ("step", gap, {"units": "m", "long_name": "smallest gap between two contacts"}),
        "valid": ("step", converged & ~merged, {"long_name": "whether no two contacts overlap"}),
        "asperity_force": (both, force, {"units": "N", "long_name": "normal force of each asperity"}),
        "asperity_force_error": (
            both,
            each_error,
            {"units": "1", "long_name": "relative error of the force of each asperity"},
        ),
        "radius": (both, radius, {"units": "m", "long_name": "mean contact radius of each asperity"}),
        "asperity_depth": (
            both,
            np.array([step.depths for step in steps]),
            {"units": "m", "long_name": "depth of the apex below the surface that the others have pressed down"},
        ),
    }
    notes = first_failure(merged, depth, "contacts overlap: neighbours have merged. rough_contact solves the surface.")
    notes += first_failure(
        (error > _NOTED) & ~merged,
        depth,
        f"contacts are so close that the error of the force is up to {percent(float(error[~merged].max(initial=0.0)))}.",
    )
    notes += first_failure(~converged, depth, "Newton's method did not converge.")
    coordinates = {
        "step": (np.arange(depth.size), {"long_name": "step of the curve"}),
        "asperity": (np.arange(group.lower.size), {"long_name": "asperity, in the order given"}),
    }
    attributes = {
        "title": "Asperities computed by flatpunch",
        "control": control,
        "medium": json.dumps(record(medium)),
        "tips": json.dumps([record(tip) for tip in shapes]),
        "flatpunch_version": __version__,
        "notes": "\n".join(notes),
    }
    return dataset(data, coordinates, attributes)
