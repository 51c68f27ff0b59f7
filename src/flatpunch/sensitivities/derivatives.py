"""`sensitivity`: how strongly each number of a medium and a tip, and each depth, determines a contact.

Depth sensitivity is how much of a force comes from which depth (T15.6). d ln F/d ln E(z) per length is the energy density that
the contact pressure and the flat punch's have in common, in planes of constant depth, over F; its integral over the whole body
is one. Shallow depths need large wavenumbers; groups share them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array, Indices, refused_overflow, values
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import compliance
from flatpunch.compliances.stack import attenuation, interfaces
from flatpunch.contact.curve import Control, control_from
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.default import Method, MethodName, method_of
from flatpunch.contact.methods import BoundaryElements, Exact, FirstOrder, FourthOrder, SecondOrder
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, underlying
from flatpunch.sensitivities.gradient import Gradient, gradients, has_power_law
from flatpunch.sensitivities.parameters import Parameter, parameters
from flatpunch.sensitivities.round import energy_shares
from flatpunch.stresses.bodies import Located, located

if TYPE_CHECKING:
    import xarray as xr


_SHALLOWEST, _FIRST = 0.01, 0.03
"""Depths over the contact radius: the smallest that is computed, and the first where none are given."""


@dataclass(frozen=True, slots=True)
class DepthSensitivity:
    """Depths [m], the layer of each, and d ln F/d ln E(z) per length [1/m], shape (contacts, depths)."""

    z: Array
    layer: Indices
    values: Array


def depth_sensitivity(medium: Body, found: list[Gradient], wanted: Array | None) -> DepthSensitivity:
    """Depth sensitivity of contacts at given depths, z < 0 being in the upper of two bodies, or at some in each layer."""
    widest = max(each.contact.radius for each in found)
    if wanted is None:
        places = list(_chosen(medium, min(each.contact.radius for each in found), widest))
    else:
        _check_shallow(wanted, widest)
        places = located(medium, wanted, "below")
    z = np.concatenate([-at.depth if at.upper else at.depth for at in places])
    layer = np.concatenate([at.layer for at in places])
    rows = [np.concatenate([_of_contact(each, at) for at in places]) for each in found]
    order = np.lexsort((layer, z))
    return DepthSensitivity(z[order], layer[order], np.array(rows)[:, order])


def _of_contact(gradient: Gradient, at: Located) -> Array:
    assert gradient.spectrum is not None
    found = np.empty(at.depth.size)
    order = np.argsort(at.depth)
    while order.size:
        nearest = at.depth[order[0]]
        reached = float(attenuation(at.body, at.depth[order[:1]])[0])
        # ratio of depths that share their wavenumbers
        group = order[at.depth[order] <= 3.0 * nearest]
        # wavenumber times the depth at which the energy of a wave has fallen to exp(-36)
        spectrum = gradient.spectrum(18.0 * gradient.contact.radius / reached)
        found[group] = energy_shares(at.body, spectrum, at.depth[group], at.layer[group]) / gradient.contact.force
        order = order[group.size :]
    return found


def _check_shallow(z: Array, radius: float) -> None:
    shallow = np.abs(z) < _SHALLOWEST * radius
    if shallow.any():
        i = int(np.argmax(shallow))
        raise ValueError(
            f"z[{i}] = {text(float(z[i]), 'm')} is less than {_SHALLOWEST:g} of the contact radius "
            f"{text(float(radius), 'm')}. There the depth "
            "sensitivity would need too many wavenumbers; it changes little from that depth to the surface. Give larger depths."
        )


def _chosen(medium: Body, narrowest: float, widest: float) -> Iterator[Located]:
    """Depths in each layer, both faces included, of each body."""
    for name, body in medium.sides:
        if body.rigid:
            continue
        faces = interfaces(body)
        ends = [float(face) for face in faces]
        if not body.base.rigid:
            # contact radii down to which depths are chosen where none are given
            ends.append(max(10.0 * widest, 2 * (ends[-1] if ends else 0.0)))
        first = min(_FIRST * narrowest, ends[0] / 2)
        first = max(first, _SHALLOWEST * widest)
        # depths between interfaces that are chosen in all
        count = 2 + 48 // len(ends)
        depths, layers = [], []
        for i, (start, end) in enumerate(zip([0.0, *ends[:-1]], ends, strict=True)):
            if end > first:
                depths.append(np.geomspace(max(start, first), end, count))
                layers.append(np.full(count, i))
        depth = np.concatenate(depths)
        yield Located(body, np.arange(depth.size), depth, np.concatenate(layers), name == "upper")


_QUANTITIES = {
    "force": ("force", "relative change of the force at fixed depth"),
    "depth": ("depth", "relative change of the depth at fixed force"),
    "stiffness": ("stiffness", "relative change of the stiffness at fixed depth"),
    "radius": ("radius", "relative change of the contact radius at fixed depth"),
    "stiffness_at_force": ("stiffness", "relative change of the stiffness at fixed force"),
    "radius_at_force": ("radius", "relative change of the contact radius at fixed force"),
}
"""Variable of the result, an attribute of gradients -> quantity of the contact, and meaning."""


@one_blas_thread()
@refused_overflow()
def sensitivity(
    medium: Body,
    indenter: Indenter,
    *,
    depth: float | Array | None = None,
    force: float | Array | None = None,
    radius: float | Array | None = None,
    method: Method | MethodName | None = None,
    z: Array | None = None,
) -> xr.Dataset:
    """Relative change of a contact per relative change of each number of medium and tip, and of the modulus at each depth.

    Parameters
    ----------
    medium : Medium, HalfSpace, TwoBodies or PowerLawHalfSpace
        The elastic body, or two of them.
    indenter : Indenter
        The rigid indenter.
    depth, force, radius : float or array, shape (n,)
        Exactly one: indentation depth [m], force [N], or contact radius [m], > 0. An array adds the dimension `step`.
    method : str or method, optional
        "exact" for round tips, whatever is asked for. `BoundaryElements(...)`, "bem", is the default for tips that are not round;
        "first-order" takes the mean profile of these. "second-order" and "fourth-order" are differentiated as curves, with the
        depth sensitivity of the mean profile. "refined" is refused there: between its solutions it is interpolated to some 1e-4,
        which differences would multiply.
    z : array, shape (m,), optional
        Depths for the depth sensitivity [m], at least 0.01 contact radii; negative ones are in the upper of two bodies.
        By default some in each layer, both faces included.

    Returns
    -------
    xarray.Dataset
        Along `parameter`, the attribute path of each number such as "layers[0].young": `force`, d ln F/d ln theta at fixed depth;
        `depth`, d ln d/d ln theta at fixed force; `stiffness` and `radius` at fixed depth, `stiffness_at_force` and
        `radius_at_force` (NaN with boundary elements); `value` [SI] and `unit` of theta.
        Along `z`: `depth_sensitivity`, d ln F/d ln E(z) per length at fixed depth [1/m], whose integral over the whole body is
        1; not for power-law half-spaces.
        The contact itself: contact_depth [m], contact_force [N], contact_radius [m], contact_stiffness [N/m].

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    plot_sensitivity : The picture.
    fit : Which values the data determine.
    design : Values for a wanted contact.

    Notes
    -----
    The contact area is the one that makes the force largest, so its motion drops out of the derivative (Barber 1974): the
    pressure of the contact and that of the flat punch on it give all derivatives at once, (T15.1). Relative to the largest
    derivative they are accurate to 1e-8 on homogeneous surfaces and 1e-6 on graded ones; on 256 x 256 cells to 1e-4 (numbers
    that stretch slender tips 4e-4, those of tips with a flat end that the contact hardly exceeds some per cent).

    Examples
    --------
    >>> import flatpunch as fp
    >>> film = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    >>> found = fp.sensitivity(film, fp.Sphere(20e-6), depth=100e-9)
    >>> round(float(found.force.sel(parameter="layers[0].young")), 3)
    0.883
    """
    check_indenter(indenter)
    control = control_from(depth=depth, force=force, radius=radius)
    _check_positive(control)
    chosen = derivable(method, indenter)
    if isinstance(chosen, BoundaryElements) and control.name == "radius":
        raise ValueError("radius cannot control method='bem': the contact is found from the depth or the force.")
    wanted = parameters(underlying(medium), indenter)
    compliance(medium)
    depths = None if z is None else values("z", z, minimum=-np.inf, unit="m", smallest=0.0)
    if depths is not None:
        _check_inside(medium, depths)
    found = gradients(medium, indenter, control, chosen, wanted)
    scalar = np.ndim(next(each for each in (depth, force, radius) if each is not None)) == 0
    body = underlying(medium)
    shares = None if has_power_law(body) else depth_sensitivity(body, _with_spectra(body, indenter, found), depths)
    return _dataset(medium, indenter, control, chosen, wanted, found, shares, scalar=scalar)


def _with_spectra(medium: Body, indenter: Indenter, found: list[Gradient]) -> list[Gradient]:
    """Contacts whose pressures are known: themselves, or those of the mean profile on circles of the same radii."""
    if all(each.spectrum is not None for each in found):
        return found
    radii = np.array([each.contact.radius for each in found])
    return gradients(medium, indenter, Control("radius", radii), FirstOrder(), [])


def derivable(method: Method | MethodName | None, indenter: Indenter) -> Method:
    """The method whose derivatives are taken; ValueError if it has none under such tips."""
    if method is None:
        return Exact() if indenter.round else BoundaryElements()
    chosen = method_of(method)
    if isinstance(chosen, BoundaryElements):
        return chosen
    if indenter.round:
        return Exact()
    if isinstance(chosen, (FirstOrder, SecondOrder, FourthOrder)):
        return chosen
    raise ValueError(
        f"method = {chosen.name!r} has no derivatives under tips that are not round: between its solutions it is interpolated to "
        "some 1e-4, which differences would multiply. Choose 'bem', the series 'second-order' or 'fourth-order', or "
        "'first-order' for those of the mean profile."
    )


def _check_positive(control: Control) -> None:
    if (control.values <= 0).any():
        i = int(np.argmax(control.values <= 0))
        raise ValueError(
            f"{control.name}[{i}] = {control.values[i]:g} must be > 0: without a contact there is nothing to be sensitive to."
        )


def _check_inside(medium: Body, z: Array) -> None:
    if has_power_law(medium):
        raise ValueError(
            "z goes with layers and homogeneous bodies: the depth sensitivity of a power-law half-space is not computed."
        )
    located(medium, z, "below")


def _dataset(
    medium: Body,
    indenter: Indenter,
    control: Control,
    method: Method,
    wanted: list[Parameter],
    found: list[Gradient],
    shares: DepthSensitivity | None,
    *,
    scalar: bool,
) -> xr.Dataset:
    theta = np.array([each.value for each in wanted])
    columns: dict[str, Column] = {}
    coordinates: Plain = {
        "parameter": (
            np.array([each.path for each in wanted], dtype=object),
            {"long_name": "number of the medium or the tip"},
        )
    }
    step: tuple[str, ...] = () if scalar else ("step",)
    if not scalar:
        coordinates["step"] = (np.arange(len(found)), {"long_name": "step of the curve"})

    def put(name: str, dims: tuple[str, ...], rows: Array, attributes: dict[str, str]) -> None:
        columns[name] = ((*step, *dims), rows[0] if scalar else rows, attributes)

    for name, (quantity, meaning) in _QUANTITIES.items():
        rows = np.array([getattr(each, name) * theta / getattr(each.contact, quantity) for each in found])
        put(name, ("parameter",), rows, {"units": "1", "long_name": f"{meaning} per relative change of the parameter"})
    for name, unit in (("depth", "m"), ("force", "N"), ("radius", "m"), ("stiffness", "N/m")):
        row = np.array([getattr(each.contact, name) for each in found])
        put(f"contact_{name}", (), row, {"units": unit, "long_name": f"{name} of the contact"})
    columns["value"] = ("parameter", theta, {"long_name": "value of the parameter, SI"})
    columns["unit"] = (
        "parameter",
        np.array([each.unit or "1" for each in wanted], dtype=object),
        {"long_name": "its unit"},
    )
    if shares is not None:
        coordinates["z"] = (shares.z, {"units": "m", "long_name": "depth"})
        columns["layer"] = ("z", shares.layer, {"long_name": "layer from the surface inwards; the base comes last"})
        meaning = "relative change of the force at fixed depth per relative change of the modulus there and length"
        put("depth_sensitivity", ("z",), shares.values, {"units": "1/m", "long_name": meaning})
    result = dataset(
        columns,
        coordinates,
        {
            "title": "Sensitivities computed by flatpunch",
            "method": method.name,
            "control": control.name,
            "medium": json.dumps(record(medium)),
            "indenter": json.dumps(record(indenter)),
            "flatpunch_version": __version__,
            "notes": "\n".join(dict.fromkeys(each.notes for each in found if each.notes)),
        },
    )
    return result.set_coords([name for name in ("value", "unit", "layer") if name in columns])
