"""How much of the elastic energy of a round contact is in each layer.

Below any depth z the energy is the work of the tractions on what lies above it, half of stress times displacement there:

    W(z) = -pi int k P^2 (u_z s_zz + u_l s_lz) dk      per unit load wave, P the transform of the pressure,

so a layer holds W(top) - W(bottom). W(0), where the integral converges slowly, is the half-space of the surface in closed form,
(pi^2/E*) int g^2 dt, and a rest that decays like exp(-2kh). The sum over the layers is the work int F dd of the contact.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array, Values, values
from flatpunch._support.record import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliance import Kernel, compliance
from flatpunch.compliance.depth import interfaces, waves_at
from flatpunch.contact.dataset import Column, dataset
from flatpunch.fields.bodies import layer_at
from flatpunch.fields.contact_sources import contact_of, contact_sources
from flatpunch.fields.layered import wavenumbers
from flatpunch.fields.ring_sources import RingSources
from flatpunch.fields.sources import RoundSource
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Medium, RigidBase, underlying
from flatpunch.numerics.gauss import gauss

if TYPE_CHECKING:
    import xarray as xr

_REACH = 40.0
"""k times the depth at which integrals end."""

_SHALLOWEST = 1e-3
"""Depth over the contact radius above which the energy cannot be asked for: the integral would need too many wavenumbers."""


@one_blas_thread()
def energy_by_depth(
    medium: Body,
    indenter: Indenter,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    z: Values | None = None,
    work_of_adhesion: float | None = None,
) -> xr.Dataset:
    """Elastic energy of a round contact, by layer and below given depths.

    Parameters
    ----------
    medium : Medium or HalfSpace
        The elastic body; not graded at its surface.
    indenter : Indenter
        A round indenter.
    depth, force, radius : float
        Exactly one: depth [m], force [N] or contact radius [m].
    z : array, shape (n,), optional
        Depths below which the energy is wanted [m], > 0.
    work_of_adhesion : float, optional
        [J/m^2], as for `indent`; the elastic energy only is returned.

    Returns
    -------
    xarray.Dataset
        energy(layer) [J] and share(layer) [-], layers from the surface down and the base last; energy_below(z) [J] if depths
        are given; attribute `total` [J], the work of the contact where nothing adheres.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    fields : Stresses and displacements.
    sensitivity : From which depth a result comes.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    >>> found = fp.energy_by_depth(film, fp.Sphere(20e-6), depth=100e-9)
    >>> print(f"{float(found.share[0]):.2f} of the energy is in the film")
    0.90 of the energy is in the film
    """
    body = underlying(medium)
    if not isinstance(body, (HalfSpace, Medium)):
        raise TypeError(
            f"medium = {type(body).__name__} must be one Medium or HalfSpace to divide its energy by layer."
        )
    kernel = compliance(medium)
    if kernel.graded:
        raise ValueError("medium has a graded surface layer, for which the energy by depth is not computed.")
    given = {"depth": depth, "force": force, "radius": radius}
    below = values("z", z, strict=True, unit="m") if z is not None else np.zeros(0)
    if not getattr(indenter, "round", False):
        raise ValueError("indenter must be round: the energy by depth of other tips is not computed.")
    contact = contact_of(medium, indenter, given, None, work_of_adhesion)
    sources, solved = contact_sources(contact, 0.0)
    source = sources[0]
    faces = interfaces(body)
    if isinstance(source, RoundSource) and isinstance(source.load, RingSources):
        _check_depths(below, source.load.radius, body)
        total = _total(kernel, source.load)
        at = _below(body, source.load, faces)
        wanted = _below(body, source.load, below)
    else:
        total, at, wanted = 0.0, np.zeros(faces.size), np.zeros(below.size)
    if isinstance(body, Medium) and isinstance(body.base, RigidBase):
        at[-1] = 0.0
    energy = -np.diff(np.concatenate([[total], at, [0.0]]))
    columns: dict[str, Column] = {
        "energy": ("layer", energy, {"units": "J", "long_name": "elastic energy of the layer"}),
        "share": ("layer", energy / total if total else energy, {"long_name": "share of the elastic energy"}),
    }
    coordinates: dict[str, Any] = {
        "layer": (np.arange(energy.size), {"long_name": "layer from the surface inwards; the base comes last"})
    }
    if below.size:
        columns["energy_below"] = ("z", wanted, {"units": "J", "long_name": "elastic energy below the depth"})
        coordinates["z"] = (below, {"units": "m", "long_name": "depth"})
    attributes = {
        "title": "Elastic energy computed by flatpunch",
        **solved,
        "total": total,
        "medium": json.dumps(record(body)),
        "load": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
    }
    return dataset(columns, coordinates, attributes)


def _check_depths(z: Array, radius: float, body: HalfSpace | Medium) -> None:
    shallow = z < _SHALLOWEST * radius
    if shallow.any():
        i = int(np.argmax(shallow))
        raise ValueError(
            f"z[{i}] = {z[i]:.6g} m is less than {_SHALLOWEST:g} of the contact radius {radius:.6g} m, at which the energy below "
            "is that of the whole body. Give larger depths."
        )
    if isinstance(body, Medium) and isinstance(body.base, RigidBase) and (z > body.thickness).any():
        raise ValueError(f"z has depths inside the rigid base, which begins at {body.thickness:.6g} m.")


def _total(kernel: Kernel, load: RingSources) -> float:
    """Energy of the whole body [J]."""
    x, w = gauss(40)
    square = 0.0
    for low, high in zip(load.breaks[:-1], load.breaks[1:], strict=True):
        half = (high - low) / 2
        square += half * float(w @ load.value(low + half * (1 + x)) ** 2)
    total = np.pi**2 / kernel.modulus * square
    if not kernel.homogeneous:
        k, weight = wavenumbers(kernel.cutoff / kernel.length, 2 * load.radius, max(load.radius, kernel.length))
        rest = 2 * kernel.remainder(k * kernel.length) / (kernel.modulus * k)
        total += np.pi * float((weight * k * load.transform(k) ** 2) @ rest)
    return float(total)


def _below(body: HalfSpace | Medium, load: RingSources, z: Array) -> Array:
    """Energy below depths [J], shape of z."""
    result = np.zeros(z.size)
    layer = layer_at(body, z, "above")
    thickness = body.thickness if isinstance(body, Medium) else 0.0
    for i, depth in enumerate(z):
        k, weight = wavenumbers(_REACH / depth / 2, 2 * load.radius, max(load.radius, thickness))
        u_l, u_z, s_lz, s_zz, _, _ = waves_at(body, k, z[i : i + 1], layer[i : i + 1], shear=False).normal[..., 0]
        result[i] = -np.pi * float((weight * load.transform(k) ** 2) @ (u_z * s_zz + u_l * s_lz))
    return result
