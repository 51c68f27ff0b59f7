"""`rough_contact`: a rough surface pressed into any body, periodic, ending, or periodic in one direction."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import (
    NUMBERS,
    ROUNDING,
    Array,
    BadValue,
    Flags,
    Values,
    positive,
    refused_overflow,
    shown,
    switch,
    values,
    whole,
)
from flatpunch._support.prefixes import text
from flatpunch._support.readable import record
from flatpunch._version import __version__
from flatpunch.bem.solution import check_tolerance
from flatpunch.bem.solver.levels import fitting_threads
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.response import uniform_compliance
from flatpunch.contact.curve import few, first_failure, percent
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.contact.limits import STEEPEST, deepest, high_pressure
from flatpunch.media import Body
from flatpunch.rough.solution import COLUMNS, Step, solved_with_errors
from flatpunch.surfaces import Topography
from flatpunch.surfaces.heights import tilt_note

if TYPE_CHECKING:
    import xarray as xr

TOLERANCE = 1e-7
"""Default gap error over the approach, and relative error of the force."""

LIMIT = 10_000
"""Default limit of iterations of a solution: films 30 000 times stiffer than their base and 2.5 cells thick took 8400."""

TOO_WIDE = 0.1
"""Error of the area over the area above which a note says that the cells are too wide."""

ControlName = Literal["pressure", "force", "depth"]
_UNITS = {"pressure": "Pa", "force": "N", "depth": "m"}

_FIELDS = (
    ("pressure", "Pa", "contact pressure"),
    ("gap", "m", "gap between the surfaces"),
    ("displacement", "m", "inward displacement of the body's surface"),
)


@refused_overflow()
def rough_contact(
    medium: Body,
    topography: Topography,
    *,
    pressure: Values | None = None,
    force: Values | None = None,
    depth: Values | None = None,
    hardness: float | None = None,
    fields: bool = False,
    tolerance: float = TOLERANCE,
    limit: int = LIMIT,
) -> xr.Dataset:
    """Press a rough surface into a body, without friction and adhesion.

    Where the surface repeats, wavenumbers are discrete and the compliance C(k) of the body is the operator; where it ends,
    nothing beyond its border touches.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    topography : Topography
        The rigid rough surface. Two rough surfaces: the sum of their heights.
    pressure, force, depth : float or array, shape (n,)
        Exactly one, >= 0: mean pressure [Pa] over the nominal area, normal force [N] on it (of one period), or depth [m] of
        the highest peak below the undeformed surface. A depth exists only where a mean pressure moves the surface by a finite
        amount: on rigid bases, and under surfaces that end in both directions. Half-spaces, with layers or without, sink
        without limit under a load that repeats; `depth` is NaN there, and `mean_gap` takes its place.
    hardness : float, optional
        Largest pressure that the softer body bears [Pa], > 0: cells that have it yield, and others take the rest of the load
        (Almqvist et al. 2007). Stiffnesses are then those of further loading. The mean pressure stays below it.
    fields : bool
        Whether to return pressure(step, y, x), gap and displacement as well.
    tolerance : float
        Largest gap in contact and penetration outside, relative to the approach (the decrease of the mean gap since first
        touch; of surfaces that end the depth), and largest relative error of the force.
    limit : int
        Largest number of iterations of one solution.

    Returns
    -------
    xarray.Dataset
        Along `step`: mean_pressure [Pa], force [N], depth [m], area [m^2], area_fraction (share of the cells in contact),
        area_fraction_corrected (less the staircase of the cells, Yastrebov et al. 2017), plastic_fraction (share of the cells
        at the hardness, where the gap is zero), mean_gap [m], stiffness dF/dd [N/m],
        gap_stiffness -dF/d(mean gap) [N/m], energy [J] (elastic; without that of the mean pressure where this is infinite),
        patches (their number), largest_patch [m^2], max_pressure [Pa], area_error [-] of area_fraction_corrected,
        mean_gap_error [m] and max_pressure_error [Pa] (what cells twice as wide change; NaN on less than 17 cells along a side;
        that of max_pressure is infinite, or up to the hardness, where the contact reaches a border, the edge of a punch),
        gap_error, penetration and valid. With `fields` pressure [Pa], gap [m] and
        displacement [m], the latter relative to its mean where no depth exists.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work; for `depth` where no depth exists.

    See Also
    --------
    Topography, self_affine : The surface.
    indent : Tips.
    rough_stresses : Stresses inside, where the surface repeats.
    PatchLoad : Stresses inside under the pressure of one step, where it ends.

    Examples
    --------
    >>> rough = fp.self_affine(128, 10e-9, rms_slope=0.1, roll_off=0.5e-6, cut_off=80e-9)
    >>> coating = fp.Medium([fp.Layer(young=200e9, poisson=0.25, thickness=0.2e-6)], base=fp.HalfSpace(young=100e9, poisson=0.3))
    >>> contact = fp.rough_contact(coating, rough, pressure=[0.2e9, 1e9])
    >>> print(contact.area_fraction_corrected.values.round(3))
    [0.022 0.105]
    """
    if not isinstance(topography, Topography):
        raise TypeError(
            f"topography = {shown(topography)} must be a Topography(heights, spacing), such as self_affine makes."
        )
    kernel, uniform = compliance(medium, membrane=True), uniform_compliance(medium)
    name, targets = _control(pressure=pressure, force=force, depth=depth)
    fields, limit = switch("fields", fields), whole("limit", limit, 1, "It is the largest number of iterations.")
    check_tolerance(tolerance, single=False)
    ceiling = float("inf") if hardness is None else positive("hardness", hardness, unit="Pa")
    ends = not any(topography.periodic)
    if name == "depth" and not (ends or np.isfinite(uniform)):
        raise ValueError(
            "depth cannot control a surface that repeats on an elastic base, which sinks without limit under a mean pressure "
            "(C(0) is infinite). Give pressure or force; the result has mean_gap."
        )
    full = float(topography.heights.max() - topography.heights.mean())
    if name == "depth" and all(topography.periodic) and uniform == 0 and targets.max() >= full:
        raise ValueError(
            f"depth = {text(float(targets.max()), 'm')} is out of reach: incompressible layers on a rigid base give way only "
            f"sideways, and the surface is flat at a depth of {text(full, 'm')}. Ask for less depth."
        )
    if fields and targets.size * topography.heights.size > NUMBERS:
        raise ValueError(
            f"fields of {targets.size} steps on {topography.heights.size} cells make more than {NUMBERS:.0e} numbers. Solve "
            "fewer steps at once."
        )
    if name == "pressure":
        targets = targets * topography.area
    if name != "depth" and targets.max() >= ceiling * topography.area:
        raise BadValue(
            "hardness",
            text(ceiling, "Pa"),
            f"must be above the mean pressure, {text(targets.max() / topography.area, 'Pa')}.",
        )
    with fitting_threads(topography.heights.size):
        steps = solved_with_errors(
            kernel,
            topography,
            uniform,
            targets,
            tolerance,
            limit,
            by_depth=name == "depth",
            fields=fields,
            hardness=ceiling,
        )
    return _dataset(medium, topography, kernel, name, steps, fields=fields)


def _control(**given: Values | None) -> tuple[ControlName, Array]:
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        raise ValueError(
            f"Give exactly one of pressure, force and depth; got {' and '.join(named) or 'none'}. The others are part of the "
            "result."
        )
    name = cast("ControlName", named[0])
    return name, few(name, values(name, given[name], unit=_UNITS[name]))


def _dataset(
    medium: Body, rough: Topography, kernel: Kernel, control: str, steps: list[Step], *, fields: bool
) -> xr.Dataset:
    data: dict[str, Column] = {
        name: ("step", np.array([step.numbers[name] for step in steps]), {"units": unit, "long_name": long_name})
        for name, (unit, long_name) in COLUMNS.items()
    }
    data["patches"] = ("step", data["patches"][1].astype(int), data["patches"][2])
    depth = np.asarray(data["depth"][1], dtype=float)
    through = np.nan_to_num(depth) >= deepest(medium)
    converged, border = (np.array([getattr(step, name) for step in steps]) for name in ("converged", "at_border"))
    data["valid"] = ("step", converged & ~through, {"long_name": "whether the step converged and the theory holds"})
    coordinates: dict[str, tuple[NDArray[np.generic], Attributes]] = {
        "step": (np.arange(len(steps)), {"long_name": "step of the curve"})
    }
    if fields:
        for i, (name, unit, long_name) in enumerate(_FIELDS):
            maps = np.stack([step.fields[i] for step in steps])
            data[name] = (("step", "y", "x"), maps, {"units": unit, "long_name": long_name})
        for axis, count in zip("yx", rough.shape, strict=True):
            centres = rough.spacing * (np.arange(count) - (count - 1) / 2)
            coordinates[axis] = (centres, {"units": "m", "long_name": f"cell centres along {axis}"})
    attributes = {
        "title": "Rough contact computed by flatpunch",
        "control": control,
        "medium": json.dumps(record(medium)),
        "topography": json.dumps(record(rough)),
        "flatpunch_version": __version__,
        "conventions": "SI units; pressure positive in compression; depth and gap as in the documentation",
        "notes": "\n".join(_notes(medium, rough, kernel, data, converged, border, through)),
    }
    return dataset(data, coordinates, attributes)


def _notes(
    medium: Body,
    rough: Topography,
    kernel: Kernel,
    data: dict[str, Column],
    converged: Flags,
    border: Flags,
    through: Flags,
) -> tuple[str, ...]:
    found = tilt_note(rough.heights, rough.spacing, rough.periodic)
    depth = np.asarray(data["depth"][1], dtype=float)
    if np.all(np.asarray(data["area_fraction"][1]) == 1):
        found += (
            f"The whole surface touches at every step. Its rms slope is {rough.rms_slope:.3g}; if that is too little, check "
            f"the units of heights and spacing ({text(rough.spacing, 'm')}).",
        )
    if np.isnan(depth).any():
        found += (
            "No depth exists: under a load that repeats an elastic base sinks without limit. mean_gap and gap_stiffness take its "
            "place.",
        )
    if rough.rms_slope > STEEPEST:
        found += (
            f"The rms slope of the surface is {rough.rms_slope:.3g}; the theory takes slopes as small. Check the units of "
            f"heights and spacing ({text(rough.spacing, 'm')}).",
        )
    pressure, area, error, peak = (
        np.asarray(data[name][1], dtype=float)
        for name in ("mean_pressure", "area_fraction_corrected", "area_error", "max_pressure")
    )
    wide = error > TOO_WIDE * area
    share = float((error[wide] / np.maximum(area[wide], ROUNDING)).max(initial=0.0))
    for bad, sentence in (
        (
            ~converged,
            "not converged within the limit of iterations; the numbers are what was reached. Give a larger limit.",
        ),
        (border, "the contact reaches the border of the surface, which acts as the edge of a punch there."),
        (
            through,
            f"the layers on their rigid base are only {text(deepest(medium), 'm')} thick; no surface gets there.",
        ),
        (
            wide,
            f"on cells twice as wide the area differs by up to {percent(share)} of itself: the cells do not resolve the shortest "
            "waves of the surface, or the smallest patches. Give heights at smaller spacing, or take these waves out.",
        ),
    ):
        found += first_failure(bad, pressure, sentence, ("mean pressure", "Pa"))
    # of waves as short as the cells have
    modulus = 2 * rough.spacing / (np.pi * float(kernel(np.pi / rough.spacing)[0]))
    return found + high_pressure(peak / modulus, pressure, 0.1, ("mean pressure", "Pa"), "largest")
