"""`rough_stresses`: stresses inside layered bodies under rough contacts that repeat along both axes.

A pressure that repeats is a sum of waves, and each makes fields at depth by the sweep of `compliances.depth`, so that a plane of
constant depth costs one Fourier transform for each stress. The mean pressure is uniaxial strain, s_xx = s_yy = -C13/C33 p, the
mean traction a uniform shear. Pressures of cells are values at their centres, joined by the waves that the grid has.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from flatpunch._support.checks import (
    NUMBERS,
    ROUNDING,
    Array,
    BadValue,
    Indices,
    Values,
    real,
    refused_overflow,
    shown,
    switch,
    values,
    whole,
)
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import compliance
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.stack import interfaces, layer_at, plane_at
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.media import Body, Stack, underlying
from flatpunch.stresses.axisymmetric.round_load import waves_between
from flatpunch.stresses.bodies import located
from flatpunch.stresses.failure.events import Event, Judged
from flatpunch.stresses.failure.strength import Strength, checked_strengths
from flatpunch.stresses.peaks import BULK, INTERFACE, columns_of, unit_strengths
from flatpunch.stresses.points import COMPONENTS, checked_friction, of_case

if TYPE_CHECKING:
    import xarray as xr

_TWICE = 2.0
"""Safety factor on both parts of an error: beside rims at the surface the cells were off by up to 1.86 times what squares of
twice the side change."""


@one_blas_thread()
@refused_overflow()
def rough_stresses(
    medium: Body,
    contact: xr.Dataset,
    depths: Values,
    *,
    step: int = -1,
    friction: float = 0.0,
    direction: float = 0.0,
    strengths: Strength | Sequence[Strength | None] | None = None,
    fields: bool = False,
) -> xr.Dataset:
    """Stresses inside the body under a rough contact that repeats along both axes, and what fails first.

    Parameters
    ----------
    medium : Medium, HalfSpace or PowerLawHalfSpace
        The body of the contact; of two bodies the lower one, or the upper one, on which friction acts the other way.
    contact : xarray.Dataset
        Result of `rough_contact(..., fields=True)`.
    depths : float or array, shape (n,)
        Depths of planes [m], >= 0; 0 is the surface. Both sides of every interface are added.
    step : int
        Step of the contact, counted from its end if negative.
    friction, direction : float
        Coefficient of friction, and polar angle of the traction on the body [rad], as for `fields`.
    strengths : Strength or list of Strength, optional
        Of each layer and its lower face, from the surface down, then of the base.
    fields : bool
        Whether to return stress(component, plane, y, x) as well.

    Returns
    -------
    xarray.Dataset
        As of `peak_stresses`: along `layer`, the base last, von_mises, tension (largest principal stress) and shear (largest
        shear stress) [Pa]; along `interface`, below the layer of that number, interface_tension and interface_shear [Pa]; and
        their places, such as von_mises_place(layer, axis) [m]. Errors, such as von_mises_error(layer) [Pa], are twice what
        squares of twice the side in place of the values of the cells change on the plane, and in layers twice the larger
        difference to the next planes: NaN where the planes of a layer do not enclose its largest value or are fewer than three.
        The error of the contact itself is not in them. Along `plane`, from the surface down, depth [m] and
        plane_layer. With `strengths` along `criterion`, "layers[0].yield" and so on, factor: strength over stress, by which all
        stresses may grow while the contact stays as it is; the attribute `first` names the smallest. Contacts grow with the
        load: only at full contact is it the factor of the load. With `fields` stress [Pa].

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work; on surfaces that end, for which `PatchLoad` is the way.

    See Also
    --------
    rough_contact : The contact.
    peak_stresses : Under tips.
    PatchLoad : Under surfaces that end.

    Examples
    --------
    >>> rough = fp.self_affine(128, 20e-9, rms_slope=0.1, roll_off=1e-6, cut_off=160e-9)
    >>> coating = fp.Medium([fp.Layer(young=200e9, poisson=0.25, thickness=0.5e-6)], base=fp.HalfSpace(young=100e9, poisson=0.3))
    >>> contact = fp.rough_contact(coating, rough, pressure=1e9, fields=True)
    >>> inside = fp.rough_stresses(coating, contact, np.linspace(0, 1e-6, 21), friction=0.1)
    >>> print([f"{value / 1e9:.1f} GPa" for value in inside.von_mises.values])
    ['18.1 GPa', '1.7 GPa']
    """
    friction, direction = checked_friction(friction), real("direction", direction, "rad")
    body, fields = _body(medium, friction), switch("fields", fields)
    pressure, spacing = _pressure(contact, step)
    z, layer = _planes(body, values("depths", depths, unit="m"))
    strong = () if strengths is None else checked_strengths(body, strengths)
    if fields and len(COMPONENTS) * z.size * pressure.size > NUMBERS:
        raise ValueError(
            f"fields of {z.size} planes of {pressure.size} cells make more than {NUMBERS:.0e} numbers. Ask for fewer depths."
        )
    load = _Load.of(pressure, spacing, friction, direction)
    (judged,) = unit_strengths(body, None)
    if strong:
        replace(judged, strengths=strong).check()
    found: dict[tuple[str, int, str], list[tuple[Event, float]]] = {}
    maps = np.empty((len(COMPONENTS), z.size if fields else 0, *pressure.shape))
    for i, plane in enumerate(zip(z.tolist(), layer.tolist(), strict=True)):
        stress, wide = load.stresses(body, *plane)
        for event, error in _largest_of(judged, *plane, stress, wide, contact):
            found.setdefault(event.what, []).append((event, error))
        if fields:
            maps[:, i] = stress
    columns, coordinates, factors = _summary(judged, found, strong)
    columns["depth"] = "plane", z, {"units": "m", "long_name": "depth of the plane"}
    columns["plane_layer"] = "plane", layer, {"long_name": "layer of the plane"}
    if fields:
        columns["stress"] = ("component", "plane", "y", "x"), maps, {"units": "Pa", "long_name": "stress"}
        coordinates |= {name: (contact[name].values, contact[name].attrs) for name in ("y", "x")}
        coordinates["component"] = np.array(COMPONENTS), {"long_name": "component of stress"}
    attributes = {
        "title": "Stresses under a rough contact computed by flatpunch",
        "first": min((name for name in factors if factors[name] < np.inf), key=lambda name: factors[name], default=""),
        "friction": friction,
        "direction": direction,
        **of_case(medium, json.loads(contact.attrs["topography"])),
    }
    return dataset(columns, coordinates, attributes)


def _body(medium: Body, friction: float) -> Stack:
    compliance(medium)  # refuses what has none
    body = underlying(medium).single
    if not body:
        raise TypeError(
            "medium is TwoBodies; give the lower or the upper one: both have the pressure, and friction acts on the upper one in "
            "the opposite direction."
        )
    if friction and not all(each.face for each in body.layers):
        raise BadValue(
            "friction",
            f"{friction:.6g}",
            "needs layers that stick: the mean traction of a surface that repeats moves a layer that slides without end. Give "
            "friction = 0, or an Interface with a stiffness along it.",
        )
    return body


def _pressure(contact: xr.Dataset, step: int) -> tuple[Array, float]:
    """Pressure of a step [Pa] and side of a cell [m]."""
    if not {"pressure", "x", "y"} <= set(getattr(contact, "variables", ())) or "topography" not in contact.attrs:
        raise TypeError(f"contact = {shown(contact)} must be a result of rough_contact(..., fields=True).")
    rough, count = json.loads(contact.attrs["topography"]), contact.sizes["step"]
    if not all(rough["periodic"]):
        raise ValueError(
            "contact has a surface that ends along an axis, whose pressure is no sum of waves. Give "
            "fields(medium, PatchLoad(contact.pressure.values[0], spacing), x, y, z) instead."
        )
    step = whole("step", step, -count, f"The contact has {count} steps.", most=count - 1)
    return np.asarray(contact["pressure"].values[step], dtype=float), float(rough["spacing"])


def _planes(body: Stack, depths: Array) -> tuple[Array, Indices]:
    """Depths and layers of all planes, from the surface down: those given, and both sides of every interface."""
    located(body, depths, "below")
    faces = interfaces(body)
    inside = depths[~np.isclose(depths[:, None], faces, rtol=ROUNDING, atol=0.0).any(axis=1)]
    z = np.concatenate([inside, faces, faces])
    layer = np.concatenate([layer_at(body, z[: -faces.size or None], "below"), layer_at(body, faces, "above")])
    pairs = np.unique(np.stack([layer, z]), axis=1)
    return pairs[1], pairs[0].astype(int)


def _largest_of(
    judged: Judged, depth: float, layer: int, stress: Array, wide: Array, contact: xr.Dataset
) -> Iterator[tuple[Event, float]]:
    """Largest stresses of a plane inside its layer, and on its lower face if it is there, with their errors of the cells [Pa]."""
    own, faces = judged.strengths[layer], interfaces(judged.body)
    kinds = [own.utilisation]
    if own.of_interface and depth == faces[layer]:
        kinds.append(own.interface_utilisation)
    for of_kind in kinds:
        for (kind, fine), (_, coarse) in zip(of_kind(stress), of_kind(wide), strict=True):
            row, column = np.unravel_index(np.argmax(fine), fine.shape)
            place = float(contact["x"][column]), float(contact["y"][row]), depth
            error = _TWICE * float(np.abs(fine[::2, ::2] - coarse).max())
            yield Event(kind, layer, float(fine[row, column]), place), error


def _error(planes: Sequence[tuple[Event, float]], body: Stack) -> float:
    """That of the cells, and twice the larger difference of the largest value of a layer to the next two planes."""
    z, largest = (np.array(each) for each in zip(*((p.place[2], p.utilisation) for p, _ in planes), strict=True))
    i = int(np.argmax(largest))
    event, error = planes[i]
    if event.of_face:
        return error
    # stresses along a power-law surface begin with an infinite slope, so that its plane encloses none
    beside = body.power_law and z[max(i - 1, 0)] == 0
    if z.size < 3 or beside or (i in {0, z.size - 1} and z[i] not in {0.0, *interfaces(body)}):
        return float("nan")
    # three planes, also at a face: two may have equal values on both sides of a larger one
    first = min(max(i - 1, 0), z.size - 3)
    return error + _TWICE * float(np.abs(largest[first : first + 3] - largest[i]).max())


def _summary(
    judged: Judged, found: Mapping[tuple[str, int, str], Sequence[tuple[Event, float]]], strengths: Sequence[Strength]
) -> tuple[dict[str, Column], dict[str, tuple[NDArray[np.generic], Attributes]], dict[str, float]]:
    """Columns and coordinates of the largest stresses with their errors, and strength over stress by criterion."""
    best = {what: max(planes, key=lambda one: one[0].utilisation)[0] for what, planes in found.items()}
    columns, coordinates = columns_of((judged,), best, 0.0)
    for kind, name in (BULK | INTERFACE).items():
        dim = "layer" if kind in BULK else "interface"
        errors = np.array([_error(found[kind, i, "lower"], judged.body) for i in coordinates[dim][0]])
        columns[f"{name}_error"] = dim, errors, {"units": "Pa", "long_name": f"error of {name}"}
    factors = {}
    for (kind, layer, _), event in best.items() if strengths else ():
        limit = getattr(strengths[layer], "yield_stress" if kind == "yield" else kind.replace(" ", "_"))
        if limit is not None:
            factors[f"layers[{layer}].{kind}"] = limit / event.utilisation if event.utilisation > 0 else float("inf")
    if factors:
        columns["factor"] = "criterion", np.array([*factors.values()]), {"long_name": "strength over stress"}
        coordinates["criterion"] = np.array([*factors]), {"long_name": "criterion"}
    return columns, coordinates, factors


@dataclass(frozen=True, slots=True)
class _Load:
    """A pressure and its friction as waves.

    Attributes
    ----------
    waves : ndarray of complex, shape (ny + 1, nx // 2 + 1) or (ny, ...)
        The pressure [Pa]. Of an even number of rows the shortest wave along y is both of its directions, half each, the second
        one last.
    wide : ndarray, shape (ny, nx // 2 + 1)
        Factors that put squares of twice the side in place of the values.
    k, which : ndarray
        Different wavenumbers [1/m], ascending, and which of them each wave has.
    turn : ndarray of complex, the same shape
        Direction of each wave, exp(i angle).
    shape, friction, direction
        Of the cells, and of the traction.
    """

    waves: NDArray[np.complex128]
    wide: Array
    k: Array
    which: Indices
    turn: NDArray[np.complex128]
    shape: tuple[int, int]
    friction: float
    direction: float

    @classmethod
    def of(cls, pressure: Array, spacing: float, friction: float, direction: float) -> _Load:
        """Of cells."""
        ny, nx = pressure.shape
        waves, rows, columns = scipy.fft.rfft2(pressure), np.fft.fftfreq(ny, 1 / ny).astype(int), np.arange(nx // 2 + 1)
        if ny % 2 == 0:
            waves[ny // 2] /= 2
            waves, rows = np.concatenate([waves, waves[ny // 2, None]]), np.append(rows, ny // 2)
        # whole numbers, of which many are equal
        squares, which = np.unique((rows[:, None] * nx) ** 2 + (columns * ny) ** 2, return_inverse=True)
        along, across = 2 * columns / nx, 2 * rows[:, None] / ny
        k = 2 * np.pi / (nx * ny * spacing) * np.sqrt(squares)
        turn, wide = np.exp(1j * np.arctan2(across, along)), np.sinc(along) * np.sinc(across[:ny])
        return cls(waves, wide, k, which.reshape(waves.shape), turn, (ny, nx), friction, direction)

    def stresses(self, body: Stack, depth: float, layer: int) -> tuple[Array, Array]:
        """Stress on a plane, shape (6, ny, nx), and that of squares of twice the side on every second row and column."""
        z, own, law = np.array([depth]), np.array([layer]), body.power_law
        if law:
            waves, ratio = power_law_waves(law, self.k[1:], z), law.poisson / (1 - law.poisson)
        else:
            waves = waves_between(body, self.k[1:], z, own, shear=self.friction > 0)
            ratio = float(plane_at(body, z, own).coupling[0])
        # the uniform load is the first wavenumber
        found = [
            np.concatenate([np.array(first)[:, None], each[-len(first) :, :, 0]], axis=1)[:, self.which]
            for first, each in (
                ([0.0, -1.0, -ratio, 0.0], waves.normal),
                ([1.0, 0.0, 0.0, 0.0], waves.shear),
                ([1.0, 0.0], waves.transverse),
            )
            if each.size
        ]
        (ny, nx), half = self.shape, self.shape[0] // 2
        stress, wide = np.empty((len(COMPONENTS), ny, nx)), []
        for i, each in enumerate(self._components(*found)):
            spectrum = self.waves * each
            if len(spectrum) > ny:
                spectrum[half] += spectrum[ny]
            spectrum = spectrum[:ny]
            stress[i] = scipy.fft.irfft2(spectrum, s=(ny, nx))
            spectrum *= self.wide
            if ny % 2 == 0:
                # every second row is the mean of both halves of the waves
                wide.append(scipy.fft.irfft2((spectrum[:half] + spectrum[half:]) / 2, s=(half, nx))[:, ::2])
            else:
                wide.append(scipy.fft.irfft2(spectrum, s=(ny, nx))[::2, ::2])
        return stress, np.stack(wide)

    def _components(self, normal: Array, shear: Array | None = None, transverse: Array | None = None) -> Iterator[Any]:
        """The six stresses of each wave over its pressure, from s_lz, s_zz and so on as of `Waves`."""
        lx, ly = self.turn.real, self.turn.imag
        lz, zz, mean, apart = normal
        lz, tz, cross = -1j * lz, 0.0, 0.0
        if shear is not None and transverse is not None:
            # notation: l along the wave, t across it; tractions have the phase of the pressure, as in `kernels.interior`
            along = self.friction * (lx * np.cos(self.direction) + ly * np.sin(self.direction))
            across = self.friction * (lx * np.sin(self.direction) - ly * np.cos(self.direction))
            lz = lz - along * shear[0]
            zz, mean, apart = (a - 1j * along * b for a, b in zip((zz, mean, apart), shear[1:], strict=True))
            tz, cross = -across * transverse[0], -1j * across * transverse[1]
        cosine, sine = lx**2 - ly**2, 2 * lx * ly
        along_x = apart * cosine - cross * sine
        yield mean + along_x
        yield mean - along_x
        yield zz
        yield lz * ly + tz * lx
        yield lz * lx - tz * ly
        yield apart * sine + cross * cosine
