"""Results as the bytes of a file that a browser saves."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from flatpunch._support.whole_file import sealed
from flatpunch.files.results import netcdf

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def file_bytes(
    kind: str, dataset: Callable[[], xr.Dataset], table: Callable[[], str], figure: Callable[[], Figure]
) -> bytes:
    """Return the file of a kind, "nc", "csv", "png" or "svg", of which only what it needs is made."""
    if kind == "nc":
        return sealed(netcdf(dataset()))
    if kind == "csv":
        return table().encode("utf-8")
    from flatpunch.plots.result import save_figure

    with tempfile.TemporaryDirectory() as folder:
        return save_figure(figure(), Path(folder) / f"picture.{kind}").read_bytes()
