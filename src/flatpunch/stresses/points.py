"""`fields`: stress and displacement inside the bodies of a contact, or under prescribed loads; invariants of stress."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import (
    INSIDE,
    LARGEST,
    Array,
    BadValue,
    Indices,
    Values,
    numbers,
    real,
    refused_overflow,
    shown,
    values,
)
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import compliance
from flatpunch.contact import Method, MethodName
from flatpunch.contact.dataset import Column, dataset
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, Stack, underlying
from flatpunch.stresses.bodies import Located, Side, located
from flatpunch.stresses.loads import Load
from flatpunch.stresses.sources import Source, contact_of, contact_sources, prescribed_sources

if TYPE_CHECKING:
    import xarray as xr

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
AXES = ("x", "y", "z")


MOST_FRICTION = 100.0
"""Largest coefficient of friction that is taken: larger ones are a mistake of units, and their squares overflow."""


@one_blas_thread()
@refused_overflow()
def fields(
    medium: Body,
    indenter: Indenter | Load | Sequence[Load],
    x: Values,
    y: Values,
    z: Values,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    method: MethodName | Method | None = None,
    friction: float = 0.0,
    direction: float = 0.0,
    side: Side = "below",
    residual_stress: Sequence[float] | None = None,
    work_of_adhesion: float | None = None,
) -> xr.Dataset:
    """Stress and displacement at points inside the body, in every layer and at the surface.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them: then z > 0 is in the lower one and z < 0 in the upper one.
    indenter : Indenter, DiscLoad, PatchLoad, or a sequence of loads
        What is pressed in, as for `indent`, or prescribed loads, which add up.
    x, y, z : float or array
        Points [m], broadcast together: z >= 0 into the material, x = y = 0 below the first touch.
    depth, force, radius : float
        Exactly one with an indenter, none with prescribed loads.
    method : str or method, optional
        Contact method, as for `indent`. Round contacts are exact with all methods but "bem". Under other tips the pressure
        comes from boundary elements, as for `pressure`; only "first-order" superposes the pressures of stretched flat punches.
    friction : float
        Coefficient of friction of a sliding contact: traction = friction times pressure, in the given direction. The pressure
        is taken as that without friction (Goodman's assumption), exact for an incompressible body under a rigid tip.
    direction : float
        Polar angle of the traction that acts on the lower body [rad]: 0 is along x.
    side : {"below", "above"}
        The side of an interface on which points at its depth are taken.
    residual_stress : sequence of float, optional
        Biaxial stress [Pa] in each layer from the surface down, and in the base if given as well; added to xx and yy.
    work_of_adhesion : float, optional
        [J/m^2], as for `indent`: JKR contact.

    Returns
    -------
    xarray.Dataset
        Over the broadcast points: stress(component: xx, yy, zz, yz, xz, xy) [Pa, tension positive; NaN at a rim where it is
        infinite], displacement(axis) [m], von_mises, principal(order, largest first), max_shear, hydrostatic [Pa],
        layer. Attributes say what was solved; `stress_error` is the error over the size of the pressure, from a
        second calculation by other rules.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    plot_fields : The picture.
    critical_load : The first failure.
    energy_by_depth : Where the energy is stored.

    Examples
    --------
    >>> import flatpunch as fp
    >>> film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> below = fp.fields(film, fp.Sphere(50e-6), x=0.0, y=0.0, z=[1e-6, 3e-6], force=0.5)
    >>> [round(float(value) / 1e9, 2) for value in below.von_mises]
    [7.62, 7.74]

    Notes
    -----
    Fields per wavenumber by one sweep up and one down through the layers; the part of the surface's half-space in closed form
    (Love 1929; Eason, Noble and Sneddon 1955; complex ring sources).
    """
    points, shape = _points(x, y, z)
    friction = checked_friction(friction)
    direction = real("direction", direction, "rad")
    compliance(medium)  # refuses what is no medium
    parts = located(medium, points[2], side)
    residual = residual_stresses(medium, residual_stress)
    given = {"depth": depth, "force": force, "radius": radius}
    if loads := _loads(indenter):
        _nothing_to_solve(given, method, work_of_adhesion)
        sources = prescribed_sources(loads, friction)
        solved: Plain = {}
    else:
        contact = contact_of(medium, check_indenter(indenter), given, method, work_of_adhesion)
        sources, solved = contact_sources(contact, friction)
    stress, displacement, error = evaluate(sources, parts, points, direction)
    layer = np.empty(points.shape[1], dtype=int)
    for part in parts:
        layer[part.chosen] = part.layer
        if residual is not None:
            stress[:2, part.chosen] += residual[part.layer]
    said = [solved.get("notes", ""), _at_singular_points(points, stress)]
    if friction > 0 and any(_slides(part.body) for part in parts):
        said.append(_SHIFT)
    if any(said):
        solved["notes"] = "\n".join(filter(None, said))
    attributes = {
        "title": "Fields computed by flatpunch",
        **solved,
        "friction": friction,
        "direction": direction,
        "side": side,
        "stress_error": error,
        **of_case(medium, list(loads) if loads else indenter),
    }
    return _dataset(points, shape, stress, displacement, layer, attributes)


def of_case(medium: Body, load: object) -> dict[str, str]:
    """Attributes that every result inside the body has."""
    return {
        "medium": json.dumps(record(underlying(medium))),
        "load": json.dumps(record(load)),
        "flatpunch_version": __version__,
        "conventions": "SI units; stress positive in tension; z into the material",
    }


_SHIFT = (
    "A layer slides without friction on what is below it: under friction of the tip its displacement along the surface is known "
    "up to a rigid shift only."
)


def _at_singular_points(points: Array, stress: Array) -> str:
    """Note on points without a stress; empty where all have one."""
    none = np.isnan(stress).any(axis=0)
    if not none.any():
        return ""
    x, y, _ = points[:, int(np.argmax(none))]
    return (
        f"{int(none.sum())} of {none.size} points have no stress, the first at x = {text(float(x), 'm')}, y = "
        f"{text(float(y), 'm')}: there it is infinite, at the rim of a load."
    )


def _slides(body: Stack) -> bool:
    return not all(layer.face for layer in body.layers)


def evaluate(
    sources: Sequence[Source], parts: Sequence[Located], points: Array, direction: float
) -> tuple[Array, Array, float]:
    """Stress (6, n), displacement (3, n) and the estimated error over the largest pressure, summed over all loads."""
    stress, displacement = np.zeros((len(COMPONENTS), points.shape[1])), np.zeros((len(AXES), points.shape[1]))
    error = 0.0
    for part in parts:
        x, y = points[0, part.chosen], points[1, part.chosen]
        for source in sources:
            s, u, e = source.fields(part, x, y, direction)
            if part.upper:
                # seen from inside the upper body the traction is the reaction, and z runs the other way
                s[3:5] *= -1
                u[2] *= -1
            stress[:, part.chosen] += s
            displacement[:, part.chosen] += u
            error = max(error, e)
    return stress, displacement, error


def checked_friction(friction: object) -> float:
    """Return a coefficient of friction, 0 <= friction <= 100."""
    value = real("friction", friction, "1")
    if not 0 <= value <= MOST_FRICTION:
        raise BadValue(
            "friction",
            f"{value:.6g}",
            f"must lie between 0 and {MOST_FRICTION:g}. It is the traction over the pressure, along `direction`.",
        )
    return value


def residual_stresses(medium: Body, given: Sequence[float] | None) -> Array | None:
    """Biaxial stress of each layer and the base, shape (layers + 1,)."""
    if given is None:
        return None
    body = underlying(medium).single
    if not body or body.power_law:
        raise ValueError(
            "residual_stress goes with one Medium or HalfSpace; of other bodies add it to xx and yy of the result."
        )
    layers = len(body.layers)
    stresses = values("residual_stress", given, minimum=-np.inf, unit="Pa", smallest=0.0)
    if stresses.size not in (layers, layers + 1):
        raise ValueError(
            f"residual_stress has {stresses.size} values for {layers} layers; give one for each layer from the surface down, and "
            "one more for the base if it has some."
        )
    return np.append(stresses, np.zeros(layers + 1 - stresses.size))


def _points(x: Values, y: Values, z: Values) -> tuple[Array, tuple[int, ...]]:
    arrays = []
    for name, value in (("x", x), ("y", y), ("z", z)):
        array = numbers(name, value, "m")
        bad = ~(np.abs(array) <= LARGEST)
        if bad.any():
            raise BadValue(
                name,
                "",
                f"has the value {array[bad].flat[0]}; points must be finite, in metres, and at most {LARGEST:g} m "
                "away.",
            )
        arrays.append(array)
    shapes = [array.shape for array in arrays]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(
            f"x, y and z have the shapes {', '.join(map(str, shapes))}, which do not broadcast together; "
            "x[:, None] with z makes a plane, np.meshgrid too."
        ) from None
    count = math.prod(shape)
    if not 0 < count <= INSIDE:
        raise ValueError(f"x, y and z make {count} points; give 1 to {INSIDE} in one call.")
    return np.array([np.broadcast_to(array, shape).ravel() for array in arrays]), shape


def _loads(indenter: object) -> tuple[Load, ...]:
    """Prescribed loads, or none if it is an indenter."""
    from flatpunch.stresses.loads import DiscLoad, PatchLoad

    if isinstance(indenter, (DiscLoad, PatchLoad)):
        return (indenter,)
    if not isinstance(indenter, (list, tuple)):
        return ()
    for i, load in enumerate(indenter):
        if not isinstance(load, (DiscLoad, PatchLoad)):
            raise TypeError(
                f"indenter[{i}] = {shown(load)} must be a DiscLoad or a PatchLoad; only these are added up."
            )
    if not indenter:
        raise ValueError("the sequence of loads is empty; give at least one DiscLoad or PatchLoad.")
    return tuple(indenter)


def _nothing_to_solve(given: Plain, method: object, work: object) -> None:
    named = {**given, "method": method, "work_of_adhesion": work}
    wrong = [name for name, value in named.items() if value is not None]
    if wrong:
        raise ValueError(
            f"{' and '.join(wrong)} belongs to an indenter; a prescribed load has its own pressure. Leave it out."
        )


def von_mises(stress: Array) -> Array:
    """Von Mises stress of (xx, yy, zz, yz, xz, xy), shape (6, ...)."""
    xx, yy, zz, yz, xz, xy = stress
    return np.asarray(np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2)))


def principal(stress: Array) -> Array:
    """Principal stresses, largest first, shape (3, ...): the cubic of the deviator by its angle."""
    mean = (stress[0] + stress[1] + stress[2]) / 3
    a, b, c = stress[0] - mean, stress[1] - mean, stress[2] - mean
    yz, xz, xy = stress[3:]
    size = von_mises(stress)
    third = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        angle = np.arccos(np.clip(np.where(size > 0, 13.5 * third / size**3, 0.0), -1, 1)) / 3
    turns = angle + 2 * np.pi / 3 * np.arange(3).reshape(-1, *([1] * size.ndim))
    # cos falls from the first to the second turn and is in between for the third
    values = mean + 2 / 3 * size * np.cos(turns)
    return np.asarray(values[[0, 2, 1]])


def _dataset(
    points: Array,
    shape: tuple[int, ...],
    stress: Array,
    displacement: Array,
    layer: Indices,
    attributes: dict[str, object],
) -> xr.Dataset:
    dims = ("point",) if len(shape) == 1 else tuple(f"axis_{i}" for i in range(len(shape)))
    main = principal(stress)

    def laid(values: Any) -> Any:
        return values.reshape((*values.shape[:-1], *shape))

    columns: dict[str, Column] = {
        name: (dims, laid(points[i]), {"units": "m", "long_name": f"coordinate {name}"}) for i, name in enumerate(AXES)
    }
    columns |= {
        "stress": (("component", *dims), laid(stress), {"units": "Pa", "long_name": "stress, positive in tension"}),
        "displacement": (("axis", *dims), laid(displacement), {"units": "m", "long_name": "displacement"}),
        "von_mises": (dims, laid(von_mises(stress)), {"units": "Pa", "long_name": "von Mises stress"}),
        "principal": (("order", *dims), laid(main), {"units": "Pa", "long_name": "principal stresses, largest first"}),
        "max_shear": (dims, laid((main[0] - main[2]) / 2), {"units": "Pa", "long_name": "largest shear stress"}),
        "hydrostatic": (dims, laid(stress[:3].mean(axis=0)), {"units": "Pa", "long_name": "mean normal stress"}),
        "layer": (dims, laid(layer), {"long_name": "layer from the surface inwards; the base comes last"}),
    }
    coordinates = {
        "component": (np.array(COMPONENTS), {"long_name": "component of stress"}),
        "axis": (np.array(AXES), {"long_name": "direction"}),
        "order": (np.arange(1, 4), {"long_name": "order of principal stresses"}),
    }
    return dataset(columns, coordinates, attributes)
