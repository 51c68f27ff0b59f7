"""Heat or current through a contact of layered conductors: the flat punch with another kernel.

A disc at one temperature on a body of conductors obeys the integral equation of the flat punch, with C(k) = L/(lambda k), lambda
the conductivity of the surface. Flux and temperature are carried up a stack as on a transmission line, by the admittance Y = 1/C,

    Y -> lambda k (Y + lambda k t)/(lambda k + Y t),      t = tanh(k h),

so that with the modulus 2 lambda the stiffness of the punch is the conductance, 4 lambda a on a half-space. Two bodies add
their C.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import (
    ROUNDING,
    Array,
    BadValue,
    Flags,
    follows,
    instance,
    numbers,
    refused_overflow,
    shown,
    values,
)
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch.bem.grid import Grid
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.layered import SATURATION
from flatpunch.contact.dataset import dataset, outlines
from flatpunch.media import Body, underlying
from flatpunch.punch.family import check_resolution, punch_family
from flatpunch.rough.contact import TOLERANCE
from flatpunch.rough.solution import COUNTED, flat_stiffness, operator_of, perimeter

if TYPE_CHECKING:
    import xarray as xr

Conductivity = Sequence[float] | tuple[Sequence[float], Sequence[float]]
"""Of the layers from the surface down and of the base; of two bodies a pair of these."""

_CELLS = 192, 128, 96
"""Cells across an outline that is not round, the finest first; two coarser ones, as one may agree by chance."""


@one_blas_thread()
@refused_overflow()
def conductance(medium: Body, contact: float | Array | xr.Dataset, *, conductivity: Conductivity) -> xr.Dataset:
    """Heat or electric current through a contact, per difference of temperature or potential.

    The contact is at one temperature, nothing passes beside it, and the difference is that to far away.

    Parameters
    ----------
    medium : Medium, HalfSpace, TwoBodies, ...
        The body, whose thicknesses of layers are taken, or two of them, both of which conduct.
    contact : float, array of shape (n,), or xarray.Dataset
        Radii of round contacts [m], a result of `indent`, or one of `rough_contact` with its `fields`, for the same body.
    conductivity : sequence of float, or a pair of these for two bodies
        Of each layer from the surface down, and of the base [W/(m K)] or [S/m], > 0; that of a base may be infinite.

    Returns
    -------
    xarray.Dataset
        Along `step`: conductance [W/K] or [S], its estimated relative `error`, and of round and other contacts of tips the mean
        `radius` [m]. Of rough surfaces that repeat it is the flux of one period over the drop of temperature that the contact
        adds to that of a uniform flux.

        Contacts of `indent` that are not round follow from their stiffness on half-spaces (Barber 2003), elsewhere from boundary
        elements, some tenths of a second each; their error is what wider cells change, and what cells make of a disc. That of
        rough contacts is what cells twice as wide change and the scatter of counts of cells, NaN where their number is odd.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    flat_punch : The same contact in elasticity.
    rough_contact : Patches of a rough surface.

    Examples
    --------
    >>> coated = fp.Medium([fp.Layer(young=80e9, poisson=0.4, thickness=1e-6)], base=fp.HalfSpace(young=130e9, poisson=0.34))
    >>> flow = fp.conductance(coated, 0.5e-6, conductivity=[45e6, 58e6])
    >>> print(f"{1 / flow.conductance.values[0]:.4f} ohm")
    0.0107 ohm
    """
    import xarray as xr  # takes as long to load as all of the contact

    kernel = _kernel(_stacks(medium, conductivity))
    attributes = {
        "title": "Conductance computed by flatpunch",
        "medium": json.dumps(record(medium)),
        "conductivity": json.dumps(np.asarray(conductivity, dtype=object).tolist(), default=float),
    }
    columns: dict[str, Any] = {}
    if not isinstance(contact, xr.Dataset):
        columns["radius"] = values("contact", contact, unit="m")
        found, error = _of_discs(kernel, columns["radius"])
    else:
        if "topography" not in contact.attrs and not {"radius", "phi"} <= {*contact.variables}:
            raise TypeError("contact must be radii, or a result of indent or rough_contact; this dataset is another.")
        if contact.attrs.get("medium") != attributes["medium"]:
            raise ValueError("contact is a result for another body than medium. Give the body that it was solved for.")
        if "topography" in contact.attrs:
            found, error = _of_patches(kernel, contact)
        else:
            columns["radius"] = contact["radius"].values
            found, error = _of_outlines(kernel, compliance(medium, membrane=True), contact)
    columns |= {"conductance": found, "error": error}
    units = {"radius": ("m", "mean contact radius"), "conductance": ("W/K", "conductance; S of currents")}
    made = {}
    for name, column in columns.items():
        unit, words = units.get(name, ("1", "estimated relative error of the conductance"))
        made[name] = ("step", column, {"units": unit, "long_name": words})
    return dataset(made, {"step": (np.arange(found.size), {"long_name": "step"})}, attributes)


@dataclass(frozen=True, slots=True)
class _Conductors:
    """L of stacks of conductors that carry one flux: thicknesses [m] and conductivities of each, from the surface down."""

    stacks: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]

    @property
    def conductivity(self) -> float:
        """Conductivity of the surfaces in series."""
        return 1 / sum(1 / conductivities[0] for _, conductivities in self.stacks)

    @property
    def length(self) -> float:
        """Thickness of the thinnest surface layer [m]."""
        return min((thicknesses[0] for thicknesses, _ in self.stacks if thicknesses), default=float("inf"))

    def __call__(self, kappa: Array) -> Array:
        k, total = kappa / self.length, np.zeros_like(kappa)
        for thicknesses, conductivities in self.stacks:
            # notation: r = lambda_1 k/Y, which infinite conductivities leave finite
            r = np.ones_like(k)
            for h, own, below in zip(thicknesses[::-1], conductivities[-2::-1], conductivities[:0:-1], strict=True):
                t, z = np.tanh(k * h), r * (own / below)
                r = (z + t) / (1 + z * t)
            total += r * (self.conductivity / conductivities[0])
        return total


def _stacks(medium: Body, conductivity: Conductivity) -> _Conductors:
    instance("medium", medium, (Body,), "a body, such as HalfSpace or Medium")
    medium = underlying(medium)
    if medium.free:
        raise ValueError(
            "medium = FreeLayer(...) lifts off its base; what passes there is not known. Give a layer that is held."
        )
    given = conductivity if medium.pair else (conductivity,)
    if not follows(conductivity, Sequence, np.ndarray) or len(given) != len(medium.sides):
        wanted = (
            "a pair of lists, of the upper and of the lower body"
            if medium.pair
            else "a list, of the layers and the base"
        )
        raise TypeError(f"conductivity = {shown(conductivity)} must be {wanted}.")
    stacks = []
    for (name, stack), own in zip(medium.sides, given, strict=True):
        called = f"conductivity of the {name} body" if medium.pair else "conductivity"
        each = np.atleast_1d(numbers(called, own))
        if each.shape != (len(stack.layers) + 1,):
            raise BadValue(
                called, shown(own), f"must have {len(stack.layers) + 1} values: of each layer, and of the base."
            )
        values(called, each[:-1] if each[-1] == np.inf else each, strict=True, empty=True)
        stacks.append((tuple(layer.thickness for layer in stack.layers), tuple(each.tolist())))
    if all(own[0] == np.inf for _, own in stacks):
        raise BadValue(
            "conductivity", shown(conductivity), "leaves no resistance. Only a base below layers may be infinite."
        )
    return _Conductors(tuple(stacks))


@byte_cached
def _kernel(conductors: _Conductors) -> Kernel:
    modulus = 2 * conductors.conductivity
    if not np.isfinite(conductors.length):
        return Kernel(modulus, conductors.length, np.ones_like)
    finite = [each for _, own in conductors.stacks for each in own if np.isfinite(each)]
    thickest = max(sum(thicknesses) for thicknesses, _ in conductors.stacks)
    floor = 1e-3 * (conductors.length / thickest) * (min(finite) / max(finite))
    return Kernel(modulus, conductors.length, conductors, cutoff=SATURATION, floor=floor)


def _of_discs(kernel: Kernel, radius: Array) -> tuple[Array, Array]:
    """Stiffness, or conductance, of discs and its relative error, shape (n,)."""
    beta, family = radius / kernel.length, punch_family(kernel)
    if radius.size:
        check_resolution(kernel, float(beta.max()))
    error = np.full(radius.size, family.error(beta)[0] + ROUNDING)
    return 2 * np.pi * kernel.modulus * radius * family.flat(beta)[:, 0], error


def _of_outlines(kernel: Kernel, elastic: Kernel, contact: xr.Dataset) -> tuple[Array, Array]:
    radius, contour = contact["radius"].values, outlines(contact)
    found, error = _of_discs(kernel, radius)
    if (np.ptp(contour, axis=1) <= ROUNDING * radius).all():
        return found, error
    # what else changes dF/dd than the outline
    others = {"work_of_adhesion", "relaxation", "finite_strain"} & contact.attrs.keys()
    if kernel.homogeneous and elastic.homogeneous and not others:
        return contact["stiffness"].values * (kernel.modulus / elastic.modulus), error + contact["force_error"].values
    if not np.isfinite(contour).all():
        raise ValueError(
            "contact has no outline at some steps, as its contact is in several parts. Leave these steps out."
        )
    phi = contact["phi"].values
    for i in np.flatnonzero(radius > 0):
        own, discs = np.transpose([_with_disc(kernel, phi, contour[i], radius[i], n) for n in _CELLS])
        # cells err along the edge, of outline and disc alike
        ratios, rim = own / discs, contour[i] * np.exp(1j * phi)
        longer = np.abs(np.diff(rim, append=rim[0])).sum() / (2 * np.pi * radius[i])
        error[i] += np.ptp(ratios) / ratios[0] + longer * np.abs(discs / found[i] - 1).max()
        found[i] *= ratios[0]
    return found, error


def _with_disc(kernel: Kernel, phi: Array, outline: Array, radius: float, cells: int) -> Array:
    """Conductances of an outline and of a disc, both on cells."""
    spacing = 2 * float(outline.max()) / cells
    x = (np.arange(cells) - (cells - 1) / 2) * spacing
    rim = np.interp(np.arctan2(x[:, None], x) % (2 * np.pi), phi, outline, period=2 * np.pi)
    masks = np.hypot(x[:, None], x) <= np.stack([rim, np.full_like(rim, radius)])
    return _of_masks(kernel, masks, spacing, repeats=False)


def _of_patches(kernel: Kernel, contact: xr.Dataset) -> tuple[Array, Array]:
    """Of the cells in contact; the error from every second cell, those of cells twice as wide, and from the count of cells."""
    if "pressure" not in contact:
        raise ValueError(
            "contact has no maps of the cells that touch. Give the result of rough_contact(..., fields=True)."
        )
    rough = json.loads(contact.attrs["topography"])
    periodic, spacing, masks = tuple(rough["periodic"]), rough["spacing"], contact["pressure"].values > 0
    if len({*periodic}) > 1:
        raise ValueError(
            "contact repeats along one axis only: far away its temperature has no limit. Give one that repeats, or ends."
        )
    found = _of_masks(kernel, masks, spacing, repeats=periodic[0])
    if any(n % 2 for n in masks.shape[1:]):
        return found, np.full(found.size, np.nan)
    others = np.array([_of_masks(kernel, masks[:, i::2, i::2], 2 * spacing, repeats=periodic[0]) for i in (0, 1)])
    # equal where nothing touches, and where all does
    differences = np.where(others == found, 0.0, np.abs(others - found)).max(axis=0) / np.where(found > 0, found, 1.0)
    # a conductance grows like the area at most
    sides = np.array([perimeter(mask, periodic) for mask in masks])
    return found, np.hypot(differences, (COUNTED * sides) ** 0.5 / np.maximum(masks.sum(axis=(1, 2)), 1))


def _of_masks(kernel: Kernel, masks: Flags, spacing: float, *, repeats: bool) -> Array:
    _, ny, nx = masks.shape
    longest = float(kernel(2 * np.pi / (spacing * max(nx, ny)))[0])
    operator = operator_of(kernel, Grid(nx, ny, spacing), (repeats, repeats), longest).single()
    found = np.zeros(len(masks))
    for i, mask in enumerate(masks):
        stiffness, closing = flat_stiffness(operator, mask, TOLERANCE)
        found[i] = (
            np.inf if repeats and mask.all() else stiffness * kernel.modulus * spacing / (closing if repeats else 1.0)
        )
    return found
