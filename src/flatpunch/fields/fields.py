"""`fields`: stress and displacement inside the bodies of a contact, or under prescribed loads."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array, Values, non_negative, real
from flatpunch._support.record import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.contact import MethodName
from flatpunch.contact.dataset import Column, dataset
from flatpunch.fields.bodies import Located, Side, located
from flatpunch.fields.invariants import principal, von_mises
from flatpunch.fields.loads import Load
from flatpunch.fields.sources import Source, contact_sources, prescribed_sources
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Medium, TwoBodies, underlying

if TYPE_CHECKING:
    import xarray as xr

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
AXES = ("x", "y", "z")


@one_blas_thread()
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
    method: MethodName | None = None,
    friction: float = 0.0,
    direction: float = 0.0,
    side: Side = "below",
    residual_stress: Sequence[float] | None = None,
    work_of_adhesion: float | None = None,
    **options: Any,
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
    method : str, optional
        Contact method, as for `indent`. Round contacts are exact with all methods but "bem"; for other tips the pressure
        comes from boundary elements unless a fast method is named, whose superposed pressure is then taken.
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
    **options
        Further settings of the method.

    Returns
    -------
    xarray.Dataset
        Over the broadcast points: stress(component: xx, yy, zz, yz, xz, xy) [Pa, tension positive], displacement(axis) [m],
        von_mises, principal(order, largest first), max_shear, hydrostatic [Pa], layer. Attributes say what was solved;
        `stress_error` is the estimated error over the largest pressure.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

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
    friction = non_negative("friction", friction, "Its direction is `direction`.")
    direction = real("direction", direction)
    parts = located(medium, points[2], side)
    residual = residual_stresses(medium, residual_stress)
    given = {"depth": depth, "force": force, "radius": radius}
    if loads := _loads(indenter):
        _nothing_to_solve(given, method, work_of_adhesion, options)
        sources = prescribed_sources(loads, friction)
        solved: dict[str, Any] = {}
    else:
        sources, solved = contact_sources(
            medium, indenter, given, method, friction, work_of_adhesion=work_of_adhesion, **options
        )
    stress, displacement, error = evaluate(sources, parts, points, direction)
    layer = np.empty(points.shape[1], dtype=int)
    for part in parts:
        layer[part.chosen] = part.layer
        if residual is not None:
            stress[:2, part.chosen] += residual[part.layer]
    if friction > 0 and any(_slides(part.body) for part in parts):
        solved["notes"] = "\n".join(filter(None, [solved.get("notes", ""), _SHIFT]))
    attributes = {
        "title": "Fields computed by flatpunch",
        **solved,
        "medium": json.dumps(record(underlying(medium))),
        "load": json.dumps(record(list(loads) if loads else indenter)),
        "friction": friction,
        "direction": direction,
        "side": side,
        "stress_error": error,
        "flatpunch_version": __version__,
        "conventions": "SI units; stress positive in tension; z into the material",
    }
    return _dataset(points, shape, stress, displacement, layer, attributes)


_SHIFT = (
    "A layer slides without friction on what is below it: under friction of the tip its displacement along the surface is known "
    "up to a rigid shift only."
)


def _slides(body: HalfSpace | Medium) -> bool:
    return isinstance(body, Medium) and not all(layer.bonded for layer in body.layers)


def evaluate(
    sources: Sequence[Source], parts: Sequence[Located], points: Array, direction: float
) -> tuple[Array, Array, float]:
    """Stress (6, n), displacement (3, n) and the estimated error over the largest pressure, summed over all loads."""
    stress, displacement = np.zeros((6, points.shape[1])), np.zeros((3, points.shape[1]))
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


def residual_stresses(medium: Any, given: Sequence[float] | None) -> Array | None:
    """Biaxial stress of each layer and the base, shape (layers + 1,)."""
    if given is None:
        return None
    body = underlying(medium)
    if isinstance(body, TwoBodies):
        raise ValueError("residual_stress goes with one body; of two bodies add it to xx and yy of the result.")
    layers = len(body.layers) if isinstance(body, Medium) else 0
    try:
        values = [real(f"residual_stress[{i}]", value) for i, value in enumerate(given)]
    except TypeError:
        raise TypeError(
            f"residual_stress = {given!r} must be a sequence of stresses in Pa, one for each layer."
        ) from None
    if len(values) not in (layers, layers + 1) or not values:
        raise ValueError(
            f"residual_stress has {len(values)} values for {layers} layers; give one for each layer from the surface down, and "
            "one more for the base if it has some."
        )
    return np.array(values + [0.0] * (layers + 1 - len(values)))


def _points(x: Any, y: Any, z: Any) -> tuple[Array, tuple[int, ...]]:
    arrays = []
    for name, value in (("x", x), ("y", y), ("z", z)):
        try:
            array = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise TypeError(f"{name} = {value!r} must be a number or an array of numbers in metres.") from None
        if not np.all(np.isfinite(array)):
            bad = array[~np.isfinite(array)].flat[0]
            raise ValueError(f"{name} has the value {bad}; points must be finite, in metres.")
        arrays.append(array)
    try:
        broad = np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ValueError(f"x, y and z have the shapes {shapes}, which do not broadcast together.") from None
    if broad[0].size == 0:
        raise ValueError("x, y and z have no points.")
    return np.array([array.ravel() for array in broad]), broad[0].shape


def _loads(indenter: Any) -> tuple[Any, ...]:
    """Prescribed loads, or none if it is an indenter."""
    from flatpunch.fields.loads import DiscLoad, PatchLoad

    if isinstance(indenter, (DiscLoad, PatchLoad)):
        return (indenter,)
    if not isinstance(indenter, (list, tuple)):
        return ()
    for i, load in enumerate(indenter):
        if not isinstance(load, (DiscLoad, PatchLoad)):
            raise TypeError(f"load[{i}] = {load!r} must be a DiscLoad or a PatchLoad; only these are added up.")
    if not indenter:
        raise ValueError("the sequence of loads is empty; give at least one DiscLoad or PatchLoad.")
    return tuple(indenter)


def _nothing_to_solve(given: dict[str, Any], method: Any, work: Any, options: dict[str, Any]) -> None:
    named = {**given, "method": method, "work_of_adhesion": work, **options}
    wrong = [name for name, value in named.items() if value is not None]
    if wrong:
        raise ValueError(
            f"{' and '.join(wrong)} belongs to an indenter; a prescribed load has its own pressure. Leave it out."
        )


def _dataset(
    points: Array, shape: tuple[int, ...], stress: Array, displacement: Array, layer: Any, attributes: dict[str, Any]
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
