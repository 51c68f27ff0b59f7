"""How much of the elastic energy of a contact is in each layer.

Below any depth z the energy is the work of the tractions on what lies above it, half of stress times displacement there:

    W(z) = -pi int k P^2 (u_z s_zz + u_l s_lz) dk      per unit load wave, P the transform of the pressure,

so a layer holds W(top) - W(bottom). Of a round contact W(0), where the integral converges slowly, is the half-space of the
surface in closed form, (pi^2/E*) int g^2 dt, and a rest that decays like exp(-2kh). Of a pressure on cells P^2 is the mean of
|P|^2 over the directions of the wave, and W(0) the work of the pressure on the surface that follows the tip,
(1/2) int p (d - f) dA. The sum over the layers is the work int F dd of the contact.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import Array, BadValue, Values, values
from flatpunch._support.prefixes import text
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.stack import attenuation, interfaces
from flatpunch.contact.curve import Control
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.contact.exact import punch_stiffness
from flatpunch.contact.round.carried import FARTHEST
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Stack, underlying
from flatpunch.numerics.gauss import gauss
from flatpunch.stresses.axisymmetric.contact_load import contact_load
from flatpunch.stresses.axisymmetric.panels import REACH
from flatpunch.stresses.axisymmetric.ring_sources import RingSources
from flatpunch.stresses.axisymmetric.round_load import wavenumbers
from flatpunch.stresses.bodies import layer_at
from flatpunch.stresses.cells import Cells
from flatpunch.stresses.sources import CellSource, Nothing, RoundSource, Source, contact_of, contact_sources

if TYPE_CHECKING:
    import xarray as xr


_DIRECTIONS = 48
"""Directions of waves over half a turn under a pressure on cells."""

_LARGEST_ROUND, _LARGEST_ON_CELLS = 2e7, 4e8
"""Wavenumbers times panels of a round pressure, and times cells: two or three seconds each."""


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
    """Elastic energy of a contact, by layer and below given depths.

    Parameters
    ----------
    medium : Medium, HalfSpace or PowerLawHalfSpace
        The elastic body.
    indenter : Indenter
        Round tips are exact. The pressure under others comes from boundary elements: some tenths of a per cent of the energy.
    depth, force, radius : float
        Exactly one: depth [m], force [N] or contact radius [m].
    z : array, shape (n,), optional
        Depths below which the energy is wanted [m], > 0: a thousandth of the contact radius at least, or a cell.
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
    medium = underlying(medium)
    body = medium.single
    if not body:
        kind = type(medium).__name__
        raise TypeError(
            f"medium = {kind} must be one Medium, HalfSpace or PowerLawHalfSpace to divide its energy by layer."
        )
    kernel = compliance(medium)
    given = {"depth": depth, "force": force, "radius": radius}
    below = values("z", z, strict=True, unit="m") if z is not None else np.zeros(0)
    contact = contact_of(medium, indenter, given, None, work_of_adhesion)
    sources, solved = contact_sources(contact, 0.0)
    source = sources[0]
    faces = interfaces(body)
    if isinstance(source, Nothing):
        total, at, wanted = 0.0, np.zeros(faces.size), np.zeros(below.size)
    else:
        load, total = _load(kernel, indenter, source, solved["depth"])
        _check_depths(below, load, body)
        at, wanted = (_below(body, load, depths) for depths in (faces, below))
    if body.base.rigid:
        at[-1] = 0.0
    energy = -np.diff(np.concatenate([[total], at, [0.0]]))
    columns: dict[str, Column] = {
        "energy": ("layer", energy, {"units": "J", "long_name": "elastic energy of the layer"}),
        "share": ("layer", energy / total if total else energy, {"long_name": "share of the elastic energy"}),
    }
    coordinates: dict[str, tuple[NDArray[np.generic], Attributes]] = {
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


@dataclass(frozen=True, slots=True)
class _Load:
    """A load by its radius and the smallest depth that is resolved below it [m], and `square`, which gives the mean of |P|^2.

    The mean is over the directions of a wave, shape of the wavenumbers.
    """

    radius: float
    shallowest: float
    square: Callable[[Array], Array]


def _round(load: RingSources) -> _Load:
    def square(k: Array) -> Array:
        _check_cost(k, len(load.series), _LARGEST_ROUND, load.radius)
        return load.transform(k) ** 2

    # depth over the contact radius above which the energy cannot be asked for: the integral would need too many wavenumbers
    return _Load(load.radius, 1e-3 * load.radius, square)


def _on_cells(cells: Cells) -> _Load:
    h, radius = cells.spacing, float(np.hypot(*cells.pressure.shape)) * cells.spacing / 2

    def square(k: Array) -> Array:
        """From P = (1/2 pi) sum p h^2 sinc sinc exp(-i k.x)."""
        _check_cost(k, cells.pressure.size, _LARGEST_ON_CELLS, radius)
        total = np.zeros_like(k)
        for angle in np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS:
            along = [k * factor for factor in (np.cos(angle), np.sin(angle))]
            waves = [np.exp(-1j * np.outer(q, each)) for q, each in zip(along, (cells.x, cells.y), strict=True)]
            found = np.einsum("ky,ky->k", waves[1], waves[0] @ cells.pressure.T)
            shape = np.sinc(along[0] * h / (2 * np.pi)) * np.sinc(along[1] * h / (2 * np.pi))
            total += np.abs(found * shape * h * h / (2 * np.pi)) ** 2
        return total / _DIRECTIONS

    return _Load(radius, h, square)


def _check_cost(k: Array, parts: int, most: float, radius: float) -> None:
    """Refuse loads that are so wide, compared with the depths of interest, that their transform would take minutes."""
    if k.size * parts > most:
        raise ValueError(
            f"the contact, with a radius of {text(radius, 'm')}, is too wide for the energy in layers this thin: the waves that "
            f"resolve both take {k.size * parts / most:.2g} times the largest effort. Ask for a smaller contact or for larger "
            "depths z, or join thin layers."
        )


def _load(kernel: Kernel, indenter: Indenter, source: Source, depth: float) -> tuple[_Load, float]:
    """The load, and the energy of the whole body [J]."""
    if isinstance(source, RoundSource):
        assert isinstance(source.load, RingSources)
        load = source.load
        total = _of_edge(kernel, indenter, load.radius, depth) if kernel.exponent else _total(kernel, load)
        return _round(load), total
    assert isinstance(source, CellSource)
    cells = source.cells.cropped
    x, y = np.meshgrid(cells.x, cells.y)
    loaded = cells.pressure != 0
    follows = depth - indenter.height(np.hypot(x, y)[loaded], np.arctan2(y, x)[loaded])
    return _on_cells(cells), float((cells.pressure[loaded] * follows).sum() * cells.spacing**2 / 2)


def _check_depths(z: Array, load: _Load, body: Stack) -> None:
    shallow = z < load.shallowest
    if shallow.any():
        i = int(np.argmax(shallow))
        raise BadValue(
            f"z[{i}]",
            f"{text(float(z[i]), 'm')}",
            f"is less than {text(float(load.shallowest), 'm')}, the smallest depth that is resolved under this "
            "contact; the energy below it is almost that of the whole body. Give larger depths.",
        )
    if body.base.rigid and (z > body.thickness).any():
        raise ValueError(f"z has depths inside the rigid base, which begins at {text(body.thickness, 'm')}.")


def _total(kernel: Kernel, load: RingSources) -> float:
    square_of = _round(load).square
    if kernel.exponent:
        k, weight = wavenumbers(FARTHEST / load.radius, 2 * load.radius, load.radius)
        return float(np.pi * (weight * k * square_of(k)) @ kernel(k))
    x, w = gauss()
    square = 0.0
    for low, high in zip(load.breaks[:-1], load.breaks[1:], strict=True):
        half = (high - low) / 2
        square += half * float(w @ load.value(low + half * (1 + x)) ** 2)
    total = np.pi**2 / kernel.modulus * square
    if not kernel.homogeneous:
        last = FARTHEST / load.radius if kernel.graded else kernel.cutoff / kernel.length
        k, weight = wavenumbers(last, 2 * load.radius, max(load.radius, kernel.length))
        rest = 2 * kernel.remainder(k * kernel.length) / (kernel.modulus * k)
        total += np.pi * float((weight * k * square_of(k)) @ rest)
    return float(total)


def _of_edge(kernel: Kernel, indenter: Indenter, radius: float, depth: float) -> float:
    """Energy of a power-law half-space [J], whose pressure may be infinite at the edge: waves of any length count then.

    What comes after the contact without such an edge, of the same radius, is the work on a flat punch.
    """
    if indenter.flat:
        return float(punch_stiffness(kernel, np.array([radius]))[0]) * depth**2 / 2
    plain = mean_contact(kernel, indenter, Control("radius", np.array([radius])))[1]
    first, force, stiffness = (float(each[0]) for each in (plain.depth, plain.force, plain.stiffness))
    whole = _total(kernel, contact_load(kernel, indenter, radius, first, edge=False))
    return whole + force * (depth - first) + stiffness * (depth - first) ** 2 / 2


def _below(body: Stack, load: _Load, z: Array) -> Array:
    """Energy below depths [J], shape of z."""
    result = np.zeros(z.size)
    layer = layer_at(body, z, "above")
    for i in range(z.size):
        reached = float(attenuation(body, z[i : i + 1])[0])
        # of the squares of waves
        k, weight = wavenumbers(REACH / reached / 2, 2 * load.radius, max(load.radius, body.thickness))
        if law := body.power_law:
            waves = power_law_waves(law, k, z[i : i + 1])
        else:
            waves = waves_at(body, k, z[i : i + 1], layer[i : i + 1], shear=False)
        u_l, u_z, s_lz, s_zz, _, _ = waves.normal[..., 0]
        result[i] = -np.pi * float((weight * load.square(k)) @ (u_z * s_zz + u_l * s_lz))
    return result
