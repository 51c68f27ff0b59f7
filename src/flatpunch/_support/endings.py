"""Endings of the files that results are written to, and what these hold: for `save`, the options of commands, and messages."""

from __future__ import annotations

from collections.abc import Mapping

RESULTS = {".nc": "NetCDF", ".csv": "table"}
"""What `load` reads back."""

FIELDS = {".vtu": "meshio", ".vts": "pyvista"}
"""Points for ParaView and other programs, by the library that writes them."""

MAPS = {".npz": "arrays of NumPy", ".txt": "the gap as heights, for SurfaceTopography and Gwyddion"}
"""Maps of rough contacts, besides `FIELDS`."""


def listed(endings: Mapping[str, str]) -> str:
    """Words for help and messages: ".nc (NetCDF) or .csv (table)"."""
    return " or ".join(f"{ending} ({meaning})" for ending, meaning in endings.items())
