"""Contact methods as frozen configurations: what `method=` of `indent` and `pressure` takes, besides their short names.

Each has `solve` (a whole curve) and `pressure` (one contact), both with the medium as its kernel and the points in polar
coordinates. The imports inside them keep the methods from being loaded before they are used.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, ClassVar, TypedDict
from warnings import warn

import numpy as np

from flatpunch._support.checks import CELLS, FEWEST, Array, FlatpunchWarning, positive, shown, whole
from flatpunch._support.progress import Report
from flatpunch._support.readable import readable
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import FORCE_ERROR, Control, Curve, PressureField, superposed
from flatpunch.indenters.profile import Indenter

if TYPE_CHECKING:
    from flatpunch.bem import Grid


@dataclass(frozen=True, slots=True)
class _Method(ABC):
    """What methods share: pressures by boundary elements, at the depth that the method finds for a mean radius."""

    name: ClassVar[str]

    @abstractmethod
    def solve(self, kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
        """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        return _cell_pressure(self, kernel, indenter, control, r, phi)


@dataclass(frozen=True, slots=True)
class _Series(_Method):
    """A method of the room `perturbation`, whose module has its name."""

    def solve(self, kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
        """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""
        module = import_module(f"flatpunch.contact.perturbation.{self.name.replace('-', '_')}")
        curve: Curve = module.solve(kernel, indenter, control, phi)
        return curve


@readable
@dataclass(frozen=True, slots=True)
class FirstOrder(_Series):
    """The method of Forsbach and Willert (2023): force and depth of the angular mean profile, outline to first order.

    Exact for round indenters.

    See Also
    --------
    SecondOrder, FourthOrder : More accurate, as fast.
    indent : Takes it as `method`.

    Examples
    --------
    >>> tip = fp.Pyramid(sides=4, inclination=0.3)
    >>> fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), tip, depth=1e-7, method=fp.FirstOrder()).attrs["method"]
    'first-order'
    """

    name: ClassVar[str] = "first-order"

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        from flatpunch.contact.perturbation import first_order

        if indenter.round:
            return _round_pressure(kernel, indenter, control, r)
        try:
            field = first_order.pressure(kernel, indenter, control, r, phi)
        except first_order.NoSuperposition as reason:
            warn(
                f"Pressures of boundary elements are returned at the same depth: there are none of the first order, as {reason}.",
                FlatpunchWarning,
                stacklevel=4,
            )
            return _cell_pressure(self, kernel, indenter, control, r, phi)
        return superposed(field, _cell_pressure(self, kernel, indenter, control, r, phi))


@readable
@dataclass(frozen=True, slots=True)
class SecondOrder(_Series):
    """Exact perturbation theory to second order of the asymmetry, for any shape; exact for round indenters.

    See Also
    --------
    FourthOrder : For power-law shapes.
    Refined : Series corrected by boundary elements.
    indent : Takes it as `method`.

    Examples
    --------
    >>> tip = fp.EllipticParaboloid(A=1e5, B=2e5)
    >>> curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), tip, depth=1e-7, method=fp.SecondOrder())
    >>> curve.attrs["method"]
    'second-order'
    """

    name: ClassVar[str] = "second-order"


@readable
@dataclass(frozen=True, slots=True)
class FourthOrder(_Series):
    """Perturbation theory to fourth order, for power-law shapes f = r^n psi(phi); exact for round indenters.

    See Also
    --------
    SecondOrder : For any shape.
    Refined : Series corrected by boundary elements.
    indent : Takes it as `method`.

    Examples
    --------
    >>> tip = fp.Pyramid(sides=4, inclination=0.3)
    >>> curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), tip, depth=1e-7, method=fp.FourthOrder())
    >>> curve.attrs["method"]
    'fourth-order'
    """

    name: ClassVar[str] = "fourth-order"

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        from flatpunch.contact.perturbation import fourth_order

        if not indenter.round:
            fourth_order.check(indenter)
        return _cell_pressure(self, kernel, indenter, control, r, phi)


@readable
@dataclass(frozen=True, slots=True)
class Refined(_Method):
    """Round contacts corrected by a few boundary element solutions along the curve; exact for round indenters.

    Parameters
    ----------
    rtol : float
        Relative error of the force that the interpolation between boundary element solutions may have, > 0. Below 5e-4
        the solutions of standard tips on one layer that come with the package are not used.
    cells : int, optional
        Cells per side of their grids, at least 8; 256 by default.
    cache : path, optional
        Folder in which the solutions are kept, so that a later session need not repeat them.

    Raises
    ------
    ValueError, TypeError
        For settings out of range.

    See Also
    --------
    FourthOrder : Without boundary elements.
    BoundaryElements : Boundary elements alone.
    indent : Takes it as `method`.

    Examples
    --------
    >>> fp.Refined(cells=128)
    Refined(rtol=0.0005, cells=128, cache=None)
    """

    name: ClassVar[str] = "refined"

    rtol: float = FORCE_ERROR
    cells: int | None = None
    cache: str | PathLike[str] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "rtol", positive("rtol", self.rtol))
        if self.cells is not None:
            object.__setattr__(
                self, "cells", whole("cells", self.cells, FEWEST, "It is the number of cells per side.", most=CELLS)
            )
        if self.cache is not None:
            if not isinstance(self.cache, (str, PathLike)):
                raise TypeError(
                    f"cache = {shown(self.cache)} must be a folder, as text or Path; None keeps nothing on disk."
                )
            object.__setattr__(self, "cache", str(self.cache))

    def solve(self, kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
        """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""
        from flatpunch.contact.refined import method
        from flatpunch.contact.round.mean_profile import check_size, mean_profile

        if control.name != "radius":
            check_size(kernel, mean_profile(indenter), control, indenter.reach)
        cache = None if self.cache is None else str(self.cache)
        return method.solve(kernel, indenter, control, phi, rtol=self.rtol, cells=self.cells, cache=cache)

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        return _cell_pressure(self, kernel, indenter, control, r, phi, self.cells)


class Accuracy(TypedDict):
    """Settings of boundary elements that curves and pressures share."""

    grid: Grid | int | None
    tolerance: float | None
    limit: int
    single: bool


@readable
@dataclass(frozen=True, slots=True)
class BoundaryElements(_Method):
    """Boundary elements on a grid: the rigorous reference for every medium and indenter.

    Parameters
    ----------
    grid : flatpunch.bem.Grid or int, optional
        One grid for all steps, or cells per side (256) of a grid fitted to each contact.
    tolerance : float, optional
        Largest gap error in contact and penetration outside it, relative to the depth: 1e-6, or 1e-5 in single precision.
    limit : int
        Largest number of iterations on one grid; a step that needs more is marked in `valid` and `notes`.
    fields : bool
        Whether `indent` returns pressure(step, y, x), displacement and contact; they then share one grid, that of the largest
        contact.
    single : bool
        Single precision: half the memory.
    progress : bool or callable, optional
        True shows a bar; a function is called with (steps done, steps in all).

    Raises
    ------
    ValueError, TypeError
        For settings out of range.

    See Also
    --------
    Refined : Whole curves in a fraction of the time.
    bem.solve : The solver itself.
    indent : Takes it as `method`.

    Examples
    --------
    >>> fp.BoundaryElements(grid=128).limit
    1000
    """

    name: ClassVar[str] = "bem"

    grid: Grid | int | None = None
    tolerance: float | None = None
    limit: int = 1000
    fields: bool = False
    single: bool = False
    progress: bool | Report | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        from flatpunch.bem.grid import Grid
        from flatpunch.bem.solution import check_tolerance

        if self.grid is not None and not isinstance(self.grid, Grid):
            cells = whole("grid", self.grid, FEWEST, "It is the number of cells per side, or a Grid.")
            object.__setattr__(self, "grid", cells)
        if self.tolerance is not None:
            check_tolerance(self.tolerance, self.single)
        limit = whole("limit", self.limit, 1, "It is the largest number of iterations on one grid.")
        object.__setattr__(self, "limit", limit)

    def solve(self, kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
        """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""
        from flatpunch.contact.boundary_elements import method

        return method.solve(
            kernel, indenter, control, phi, fields=self.fields, progress=self.progress, **self._accuracy
        )

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        from flatpunch.contact.boundary_elements import method

        return method.pressure(kernel, indenter, control, r, phi, **self._accuracy)

    @property
    def _accuracy(self) -> Accuracy:
        return {"grid": self.grid, "tolerance": self.tolerance, "limit": self.limit, "single": self.single}


@readable
@dataclass(frozen=True, slots=True)
class Exact(_Method):
    """Closed solutions: round tips and flat ends on every medium, elliptic paraboloids on half-spaces and power-law half-spaces.

    See Also
    --------
    indent : Takes it as `method`, and by itself where it applies.

    Examples
    --------
    >>> fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), fp.EllipticParaboloid(1e5, 9e8), depth=1e-7).attrs["method"]
    'exact'
    """

    name: ClassVar[str] = "exact"

    def solve(self, kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
        """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""
        from flatpunch.contact import exact
        from flatpunch.contact.perturbation import first_order

        if indenter.flat:
            return exact.solve_flat_end(kernel, indenter, control, phi)
        if indenter.round:
            return first_order.solve(kernel, indenter, control, phi)
        self._check(kernel, indenter)
        return exact.solve_ellipse(kernel, indenter, control, phi)

    def pressure(self, kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
        """Return the pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
        from flatpunch.contact import exact

        if indenter.flat:
            return PressureField(*exact.flat_end_pressure(kernel, indenter, control, r))
        if indenter.round:
            return _round_pressure(kernel, indenter, control, r)
        self._check(kernel, indenter)
        return exact.ellipse_pressure(kernel, indenter, control, r, phi)

    def _check(self, kernel: Kernel, indenter: Indenter) -> None:
        if not exactly_solved(kernel, indenter):
            raise ValueError(
                f"method = 'exact' has no solution for {type(indenter).__name__} on this body: there is one for round tips, and "
                "for elliptic paraboloids on half-spaces and power-law half-spaces. Choose 'refined' or 'bem'."
            )


def exactly_solved(kernel: Kernel, indenter: Indenter) -> bool:
    """Whether `Exact` solves the contact."""
    from flatpunch.contact import exact

    return indenter.round or exact.has_ellipse(kernel, indenter)


def _cell_pressure(
    method: _Method,
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    r: Array,
    phi: Array,
    cells: int | None = None,
) -> PressureField:
    """Pressure by boundary elements; a mean radius has the depth of `method`, whose error is the difference to half the cells."""
    if indenter.round:
        return _round_pressure(kernel, indenter, control, r)
    ways: list[tuple[Control, int | None]] = [(control, cells)]
    if control.name == "radius":
        from flatpunch.bem.curves import DEFAULT_CELLS

        half = max((cells or DEFAULT_CELLS) // 2, FEWEST)
        # an accuracy for which the solutions that come with the package are not used
        independent = Refined(rtol=FORCE_ERROR / 2, cells=half)
        depths = (way.solve(kernel, indenter, control, np.zeros(1)).depth for way in (method, independent))
        ways = [(Control("depth", depth), n) for depth, n in zip(depths, (cells, half), strict=True)]
    found, *other = (BoundaryElements(grid=n).pressure(kernel, indenter, at, r, phi) for at, n in ways)
    return PressureField(found.pressure, found.error + sum(np.abs(found.pressure - each.pressure) for each in other))


def _round_pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array) -> PressureField:
    from flatpunch.contact.perturbation import first_order

    field, error = first_order.round_pressure(kernel, indenter, control, r)
    if (field < 0).any():
        warn(
            "The pressure of this round contact is negative in part, so the contact is no disc: the values are formal. Solve it "
            "with method='bem'.",
            FlatpunchWarning,
            stacklevel=5,
        )
    return PressureField(field, error)
