"""`rough_contact`: a rough surface pressed into any body, periodic, ending, or periodic in one direction."""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.ceilings import OUTLINES
from flatpunch._support.checks import Array, Flags, Values, refused_overflow, shown, switch, values, whole
from flatpunch._support.prefixes import text
from flatpunch._support.record import record
from flatpunch._version import __version__
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import SINGLE_FLOOR, build_operator
from flatpunch.bem.operator.periodic import periodic_operator
from flatpunch.bem.resources import fitting_threads
from flatpunch.bem.solution import check_tolerance
from flatpunch.bem.solver.active_set import State, punch_stiffness
from flatpunch.bem.solver.levels import COARSEST
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.uniform import uniform_compliance
from flatpunch.contact.curve import few, first_failure
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.contact.limits import STEEPEST, deepest
from flatpunch.media import Body
from flatpunch.rough.measures import STAIRCASE, at_border, patch_sizes, perimeter
from flatpunch.rough.solver import Level, Solved, at_depth, at_force
from flatpunch.surfaces import Topography
from flatpunch.surfaces.heights import tilt_note

if TYPE_CHECKING:
    import xarray as xr

logger = logging.getLogger("flatpunch.rough")

TOLERANCE = 1e-7
"""Default gap error over the approach, and relative error of the force."""

LIMIT = 10_000
"""Default limit of iterations of a solution: films 30 000 times stiffer than their base and 2.5 cells thick took 8400."""

ControlName = Literal["pressure", "force", "depth"]
_UNITS = {"pressure": "Pa", "force": "N", "depth": "m"}

_COLUMNS = {
    "mean_pressure": ("Pa", "force over nominal area"),
    "force": ("N", "normal force of one period, or of the surface"),
    "depth": ("m", "depth of the highest peak below the undeformed surface"),
    "area": ("m^2", "area of the cells in contact"),
    "area_fraction": ("1", "share of the cells in contact"),
    "area_fraction_corrected": ("1", "share of the area in contact, less the staircase of the cells"),
    "mean_gap": ("m", "mean gap between the surfaces"),
    "stiffness": ("N/m", "dF/dd"),
    "gap_stiffness": ("N/m", "-dF/d(mean gap)"),
    "energy": ("J", "elastic energy"),
    "patches": ("1", "number of connected contact patches"),
    "largest_patch": ("m^2", "area of the largest patch"),
    "gap_error": ("1", "largest gap in contact over the approach"),
    "penetration": ("1", "largest penetration outside the contact over the approach"),
}

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
        area_fraction_corrected (less the staircase of the cells, Yastrebov et al. 2017), mean_gap [m], stiffness dF/dd [N/m],
        gap_stiffness -dF/d(mean gap) [N/m], energy [J] (elastic; without that of the mean pressure where this is infinite),
        patches (their number), largest_patch [m^2], gap_error, penetration and valid. With `fields` pressure [Pa], gap [m] and
        displacement [m], the latter relative to its mean where no depth exists.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work; for `depth` where no depth exists.

    See Also
    --------
    Topography, self_affine : The surface.
    indent : Tips.
    PatchLoad : Stresses inside under the pressure of one step.

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
    kernel, uniform = compliance(medium), uniform_compliance(medium)
    name, targets = _control(pressure=pressure, force=force, depth=depth)
    fields, limit = switch("fields", fields), whole("limit", limit, 1, "It is the largest number of iterations.")
    check_tolerance(tolerance, single=False)
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
    if fields and targets.size * topography.heights.size > OUTLINES:
        raise ValueError(
            f"fields of {targets.size} steps on {topography.heights.size} cells make more than {OUTLINES:.0e} numbers. Solve "
            "fewer steps at once."
        )
    if name == "pressure":
        targets = targets * topography.area
    with fitting_threads(topography.heights.size):
        case = _case(kernel, topography, uniform, by_depth=name == "depth")
        steps = case.solved(targets, tolerance, limit, fields=fields)
    return _dataset(medium, topography, name, steps, fields=fields)


def _control(**given: Values | None) -> tuple[ControlName, Array]:
    """Exactly one of pressure, force and depth, checked."""
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        raise ValueError(
            f"Give exactly one of pressure, force and depth; got {' and '.join(named) or 'none'}. The others are part of the "
            "result."
        )
    name = cast("ControlName", named[0])
    return name, few(name, values(name, given[name], unit=_UNITS[name]))


@dataclass(frozen=True, slots=True)
class _Step:
    """Numbers of a step by their names, whether it converged, and its fields: pressure [Pa], gap and displacement [m]."""

    numbers: dict[str, float]
    converged: bool
    at_border: bool
    fields: tuple[Array, ...] = ()


@dataclass(frozen=True, slots=True)
class _Case:
    """A surface on a body, with its operators.

    Attributes
    ----------
    topography, kernel : Topography, Kernel
        Surface and body.
    level : Level
        Its operators and gap at first touch.
    added, uniform : float
        C(0) that the operator has, and that of the body [m/Pa]; both zero where the surface ends in some direction.
    has_depth, by_depth : bool
        Whether a depth exists, and whether it is prescribed.
    """

    topography: Topography
    kernel: Kernel
    level: Level
    added: float
    uniform: float
    has_depth: bool
    by_depth: bool

    def solved(self, targets: Array, tolerance: float, limit: int, *, fields: bool) -> list[_Step]:
        """All steps, each from the one before where that is nearer than a fresh start."""
        steps, before = [], None
        for target in targets:
            if target == 0:
                steps.append(self._untouched(fields=fields))
                continue
            solved = self._solve(float(target), before, tolerance, limit)
            before = solved.state.pressure
            steps.append(self._measured(solved, tolerance, fields=fields))
        return steps

    def _solve(self, target: float, before: Array | None, tolerance: float, limit: int) -> Solved:
        if self.by_depth:
            return at_depth(self.level, target / self.topography.spacing, tolerance, limit, before)
        force = target / (self.kernel.modulus * self.topography.spacing**2)
        return at_force(self.level, force, tolerance, limit, before)

    def _measured(self, solved: Solved, tolerance: float, *, fields: bool) -> _Step:
        """What a result says of a contact."""
        state, rough, spacing = solved.state, self.topography, self.topography.spacing
        unit = self.kernel.modulus * spacing**2
        cells, mean_pressure = rough.heights.size, state.force * unit / rough.area
        # displacement and depth with the body's own compliance of the mean pressure, or with none where that is infinite
        moved = (self.uniform if self.has_depth else 0.0) - self.added
        rise = moved * mean_pressure
        displacement = np.asarray(state.displacement) * spacing + rise
        depth = state.depth * spacing + rise
        gap = displacement + self.level.height * spacing - depth
        sizes = patch_sizes(state.contact, rough.periodic)
        share = np.count_nonzero(state.contact) / cells
        sides = perimeter(state.contact, rough.periodic)
        stiffness, gap_stiffness = self._stiffness(state.contact, moved, tolerance)
        numbers = {
            "mean_pressure": mean_pressure,
            "force": state.force * unit,
            "depth": depth if self.has_depth else np.nan,
            "area": share * rough.area,
            "area_fraction": share,
            "area_fraction_corrected": share - STAIRCASE * sides / cells,
            "mean_gap": float(gap.mean()),
            "stiffness": stiffness if self.has_depth else np.nan,
            "gap_stiffness": gap_stiffness,
            "energy": self._energy(state, mean_pressure),
            "patches": sizes.size,
            "largest_patch": float(sizes.max(initial=0)) * spacing**2,
            "gap_error": state.gap_error,
            "penetration": state.penetration,
        }
        maps = (np.asarray(state.pressure) * self.kernel.modulus, gap, displacement) if fields else ()
        return _Step(numbers, solved.converged, at_border(state.contact, rough.periodic), maps)

    def _energy(self, state: State, mean_pressure: float) -> float:
        """Elastic energy [J]; where both axes repeat, the part of the mean pressure in closed form, as it may be much larger."""
        unit = self.kernel.modulus * self.topography.spacing**3
        if not all(self.topography.periodic):
            return float(np.vdot(state.pressure, state.displacement)) / 2 * unit
        uniform = self.uniform if self.has_depth else 0.0
        pressure, moved = (part - part.mean() for part in (state.pressure, np.asarray(state.displacement)))
        waves = np.vdot(pressure, moved) / 2 * unit
        return float(waves) + uniform * mean_pressure**2 * self.topography.area / 2

    def _stiffness(self, contact: Flags, moved: float, tolerance: float) -> tuple[float, float]:
        """dF/dd and -dF/d(mean gap) [N/m], from the flat punch under the contact."""
        # the error of the stiffness is the square of that of the displacement under the punch
        punch, stiffness, _, _ = punch_stiffness(self.level.inner, contact, max(SINGLE_FLOOR, tolerance**0.5))
        if stiffness == 0:
            return 0.0, 0.0
        full = bool(contact.all())
        if full and all(self.topography.periodic):
            # flat already: the mean pressure alone moves it
            return (self.topography.area / self.uniform if self.uniform > 0 else np.inf), np.inf
        unit = self.kernel.modulus * self.topography.spacing
        closing = 1 - float(self.level.inner.apply(punch).mean())
        by_depth = 1 / (stiffness * unit) + moved / self.topography.area
        return (1 / by_depth if by_depth > 0 else np.inf), (np.inf if full else stiffness * unit / closing)

    def _untouched(self, *, fields: bool) -> _Step:
        """Surfaces that touch at one point, without load."""
        numbers = dict.fromkeys(_COLUMNS, 0.0)
        gap = self.level.height * self.topography.spacing
        numbers |= {"mean_gap": float(gap.mean())}
        if not self.has_depth:
            numbers |= {"depth": np.nan, "stiffness": np.nan}
        return _Step(numbers, True, False, (np.zeros_like(gap), gap, np.zeros_like(gap)) if fields else ())


def _case(kernel: Kernel, topography: Topography, uniform: float, *, by_depth: bool) -> _Case:
    (ny, nx), spacing, periodic = topography.shape, topography.spacing, topography.periodic
    # at given force any finite C(0) gives the same pressure: that of the longest wave keeps the numbers of a size
    longest = float(kernel(2 * np.pi / max(topography.size))[0])
    added = uniform if by_depth and np.isfinite(uniform) else longest
    logger.info("%d x %d cells of %.4g m: at most %.0f MB", nx, ny, spacing, required(topography) / 1e6)
    if not all(periodic):
        added, uniform = 0.0, 0.0 if not any(periodic) or np.isfinite(uniform) else np.inf
    height = (topography.heights.max() - topography.heights) / spacing
    level = _level(kernel, Grid(nx, ny, spacing), height, periodic, added if all(periodic) else float(uniform == 0))
    return _Case(topography, kernel, level, added, uniform, bool(np.isfinite(uniform)), by_depth)


def _level(kernel: Kernel, grid: Grid, height: Array, periodic: tuple[bool, bool], uniform: float) -> Level:
    """Operators on a grid, and on ever wider cells as long as there are many of them; `uniform` as of `periodic_operator`."""
    operator = periodic_operator(kernel, grid, periodic, uniform) if any(periodic) else build_operator(kernel, grid)
    coarser = None
    if grid.nx % 2 == grid.ny % 2 == 0 and min(grid.shape) >= 2 * COARSEST:
        (ny, nx) = (n // 2 for n in grid.shape)
        wider = height.reshape(ny, 2, nx, 2).mean(axis=(1, 3)) / 2
        coarser = _level(kernel, Grid(nx, ny, 2 * grid.spacing), wider, periodic, uniform)
    return Level(operator, operator.single(), height, coarser)


def required(topography: Topography) -> int:
    """Upper bound of the memory of a solution [bytes]; a test measures it."""
    # bytes per cell where no, one or both axes are doubled
    return topography.heights.size * (240, 190, 170)[sum(topography.periodic)]


def _dataset(medium: Body, rough: Topography, control: str, steps: list[_Step], *, fields: bool) -> xr.Dataset:
    data: dict[str, Column] = {
        name: ("step", np.array([step.numbers[name] for step in steps]), {"units": unit, "long_name": long_name})
        for name, (unit, long_name) in _COLUMNS.items()
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
        "notes": "\n".join(_notes(medium, rough, data, converged, border, through)),
    }
    return dataset(data, coordinates, attributes)


def _notes(
    medium: Body, rough: Topography, data: dict[str, Column], converged: Flags, border: Flags, through: Flags
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
    ):
        found += first_failure(bad, depth, sentence)
    return found
