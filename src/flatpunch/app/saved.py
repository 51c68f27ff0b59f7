"""Results as the bytes of a file that a browser saves."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from flatpunch._support.sealed import sealed
from flatpunch.files.results import netcdf

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def netcdf_bytes(result: xr.Dataset) -> bytes:
    """Return a dataset as a NetCDF file."""
    return sealed(netcdf(result))


def picture_bytes(drawn: Figure, kind: str) -> bytes:
    """Return a figure as a file of that kind, "png" or "svg"."""
    from flatpunch.plots.result import save_figure

    with tempfile.TemporaryDirectory() as folder:
        return save_figure(drawn, Path(folder) / f"picture.{kind}").read_bytes()
