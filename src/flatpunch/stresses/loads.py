"""Prescribed loads: a uniform disc and a pressure given on a grid, each at a place of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from flatpunch._support.checks import CELLS, LARGEST, Array, BadValue, numbers, point, positive, real
from flatpunch._support.readable import readable


@readable
@dataclass(frozen=True, slots=True)
class DiscLoad:
    """Uniform pressure, and traction along the surface, on a disc: a tyre, a plate under an actuator.

    Parameters
    ----------
    pressure : float
        Normal pressure [Pa], positive in compression.
    radius : float
        Radius of the disc [m], > 0.
    traction : float
        Shear traction on the disc [Pa], in the `direction` given to `fields`.
    center : (float, float)
        Centre of the disc on the surface [m].

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range; the message names it.

    See Also
    --------
    PatchLoad : Footprints of any shape.
    fields : Takes it.

    Examples
    --------
    >>> import flatpunch as fp
    >>> wheel = fp.DiscLoad(pressure=0.7e6, radius=0.1, center=(0.0, 0.17))
    """

    pressure: float
    radius: float
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pressure", real("DiscLoad.pressure", self.pressure, "Pa"))
        object.__setattr__(self, "radius", positive("DiscLoad.radius", self.radius, unit="m"))
        object.__setattr__(self, "traction", real("DiscLoad.traction", self.traction, "Pa"))
        object.__setattr__(self, "center", point("DiscLoad.center", self.center, "m"))


@readable
@dataclass(frozen=True, slots=True, eq=False)
class PatchLoad:
    """Pressure on a grid of square cells, constant in each: a measured footprint, a computed contact.

    Parameters
    ----------
    pressure : array, shape (ny, nx)
        Normal pressure of the cells [Pa], rows along y.
    spacing : float
        Side of a cell [m], > 0.
    traction : array of the same shape, or float
        Shear traction of the cells [Pa], in the `direction` given to `fields`.
    center : (float, float)
        Centre of the grid on the surface [m].

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range, or the shapes differ.

    See Also
    --------
    DiscLoad : A round footprint.
    fields : Takes it.

    Examples
    --------
    >>> body = fp.HalfSpace(young=3e9, poisson=0.4)
    >>> load = fp.PatchLoad(pressure=np.full((4, 8), 1e6), spacing=1e-3)  # 8 mm x 4 mm at 1 MPa
    >>> inside = fp.fields(body, load, x=0.0, y=0.0, z=[1e-3, 20e-3])
    >>> print((inside.stress.sel(component="zz").values.ravel() / 1e6).round(2))
    [-0.96 -0.04]
    """

    pressure: ArrayLike
    spacing: float
    traction: ArrayLike = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    cells: tuple[Array, Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        pressure = _cells("PatchLoad.pressure", self.pressure)
        traction = numbers("PatchLoad.traction", self.traction, "Pa")
        if traction.ndim == 0:
            traction = np.full(pressure.shape, real("PatchLoad.traction", traction, "Pa"))
        traction = _cells("PatchLoad.traction", traction)
        if traction.shape != pressure.shape:
            raise BadValue(
                "PatchLoad.traction",
                "",
                f"has shape {traction.shape}, pressure {pressure.shape}; give one traction for each cell, or one "
                "number for all.",
            )
        object.__setattr__(
            self, "spacing", positive("PatchLoad.spacing", self.spacing, "It is the side of a cell.", unit="m")
        )
        object.__setattr__(self, "center", point("PatchLoad.center", self.center, "m"))
        object.__setattr__(self, "cells", (pressure, traction))

    @property
    def recorded(self) -> dict[str, object]:
        """Size of the grid and total load, which is what a record of the calculation needs to know."""
        pressure, _ = self.cells
        return {
            "type": "PatchLoad",
            "cells": list(pressure.shape),
            "spacing": self.spacing,
            "center": list(self.center),
            "force": float(pressure.sum() * self.spacing**2),
        }


Load = DiscLoad | PatchLoad


def _cells(name: str, value: object) -> Array:
    cells = numbers(name, value, "Pa")
    if cells.ndim != 2 or cells.size == 0:
        raise BadValue(name, "", f"has shape {cells.shape}; it must be a two-dimensional array (ny, nx), rows along y.")
    if max(cells.shape) > CELLS:
        raise BadValue(
            name,
            "",
            f"has shape {cells.shape}; a patch has at most {CELLS} cells along a side. Average blocks of cells.",
        )
    bad = ~(np.abs(cells) <= LARGEST)
    if bad.any():
        i, j = np.argwhere(bad)[0]
        raise ValueError(
            f"{name}[{i}, {j}] = {cells[i, j]} must be finite, at most {LARGEST:g} Pa in size. Set cells without a measured "
            "value to zero."
        )
    cells.setflags(write=False)
    return cells
