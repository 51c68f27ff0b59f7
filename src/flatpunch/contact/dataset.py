"""Results as xarray datasets, of arrays as they are.

To convert anything, xarray checks whether it belongs to pint or dask and loads both for that: a third of a second of the
first call, for nothing. Arrays and indices that need no conversion are taken without.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

Attributes = Mapping[str, str]
Column = tuple[str | tuple[str, ...], NDArray[np.generic], Attributes]
"""Dimensions, values and attributes."""


def outlines(result: xr.Dataset) -> NDArray[np.float64]:
    """Outlines a(phi) of a result [m], shape (steps, phi); NaN where a contact has none, as one in several parts."""
    if "contour" in result:
        return np.asarray(result["contour"].values)
    return np.full((result.sizes["step"], result.sizes["phi"]), np.nan)


def dataset(
    columns: Mapping[str, Column],
    coordinates: Mapping[str, tuple[NDArray[np.generic], Attributes]],
    attributes: Mapping[str, object],
) -> xr.Dataset:
    """Dataset of columns over coordinates, each of which has values and attributes."""
    import pandas as pd
    import xarray as xr  # takes as long to load as all of the contact

    data = {
        name: xr.Variable(dims, np.asarray(array), dict(attrs), fastpath=True)
        for name, (dims, array, attrs) in columns.items()
    }
    indices = {name: (name, pd.Index(array), dict(attrs)) for name, (array, attrs) in coordinates.items()}
    return xr.Dataset(data, indices, dict(attributes))
