"""Tables written as files: NetCDF 4 (HDF5), readable by any program that reads HDF5.

One file for each family. Coefficients are whole numbers times a step, which the attribute `scale_factor` gives (the NetCDF
convention), each with its degrees; see the documentation for the twenty lines that evaluate them.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np

from flatpunch._support.whole_file import sealed, write_whole
from flatpunch.atlas import Table
from flatpunch.atlas.library import SCHEMA
from flatpunch.atlas.panel import SparseSeries

_TEXTS = {
    "Conventions": "CF-1.8",
    "institution": "The flatpunch developers",
    "license": "CC-BY-4.0",
    "references": "Forsbach, Willert: Lubricants 2023, equations 1, 2, 21; documentation of flatpunch, pages Atlas and Theory",
    "description": (
        "Rigid, frictionless cylindrical flat punch of radius a pressed by the depth d into an elastic medium whose own length "
        "is l (thickness of the layer). beta = a/l. E* is the plane-strain modulus E/(1 - nu^2) at the surface. Force "
        "F = 2 E* a d Kbar, pressure p(r) = (E* d/a) sum_n c_n p_n(r/a), p_n(x) = P_n^(0,-1/2)(1 - 2 x^2) / "
        "(binom(n - 1/2, n) sqrt(1 - x^2)), whose edge coefficient is (-1)^n; Kbar = pi c_0; "
        "kappa_m = (m + 1) pi sum_n c_n b_n, b_n = int_0^1 x^(m + 1) p_n(x) dx."
    ),
    "evaluation": (
        "With the entries of the panel that holds beta: output_n = sum of value * T_i(x) * T_j(y_1) * T_k(y_2) with T the "
        "Chebyshev polynomials, i = beta_degree, x = (2 ln beta - ln(beta_low beta_high))/ln(beta_high/beta_low), and y the "
        "parameters' coordinates scaled likewise to [-1, 1] between those of their ends: the value (scale linear), its logarithm "
        "(log), or -ln(shift + (high - value)/(high - low)) (upper). In the group flat output 0 is ln Kbar, output n is c_n/c_0."
    ),
    "responses": (
        "Where there: groups stiffening (k_m - (m - 1)/2, relative gain of a punch's edge intensity when its outline gets the "
        "harmonic m), edge_1 and edge_2 (S[A_m^-1 b[r^n]]/(pi e S0_m), edge intensity for the displacement r^n cos(m phi) over "
        "that on the half-space, n = 1, 2), outputs along panels/orders, the harmonics m. R_m, chi_m and eta_m follow "
        "(documentation, page Theory)."
    ),
}


def write_table(table: Table, path: str | Path) -> Path:
    """Write a table as "<name>.nc" by custom, whole or not at all; return the path."""
    path = Path(path)
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        _write(file, table)
    write_whole(path, sealed(buffer.getvalue()))
    return path


def _write(file: Any, table: Table) -> None:
    panels, (low, high) = table.panels, table.beta_range
    about = {"title": table.title, "flatpunch_atlas_schema": SCHEMA, "family": table.name}
    file.attrs.update({**about, **_TEXTS, **table.attributes})
    file.attrs.update({"beta_low": low, "beta_high": high, "relative_error_bound": table.bound})
    group = file.create_group("parameters")
    group.attrs["names"] = " ".join(p.name for p in table.parameters)
    for p in table.parameters:
        ends = {"low": p.low, "high": p.high}
        about = {"long_name": p.meaning, **ends, "scale": p.scale, "shift": p.shift, "units": p.unit}
        group.create_group(p.name).attrs.update(about)
    group = file.create_group("panels")
    group.dimensions = {"panel": len(panels), "order": max(1, *(panel.orders.size for panel in panels))}
    _variable(group, "beta_low", ("panel",), np.array([p.low for p in panels]), "low end of the panel")
    _variable(group, "beta_high", ("panel",), np.array([p.high for p in panels]), "high end of the panel")
    orders = np.zeros((len(panels), group.dimensions["order"].size), dtype=np.uint16)
    for row, panel in zip(orders, panels, strict=True):
        row[: panel.orders.size] = panel.orders
    meaning = "harmonics m of the outputs of the responses; 0 fills up"
    _variable(group, "orders", ("panel", "order"), orders, meaning)
    for kind in panels[0].series:
        _write_kind(file.create_group(kind), [p.series[kind] for p in panels], [p.name for p in table.parameters])


def _write_kind(group: Any, panels: list[SparseSeries], names: list[str]) -> None:
    """One kind of function on all panels."""
    values = np.concatenate([series.value for series in panels])
    group.dimensions = {"entry": values.size, "panel": len(panels)}
    # step of the stored coefficients over the smallest one kept
    step = float(np.abs(values).min(initial=np.inf)) / 4 if values.size else 1.0
    index = np.repeat(np.arange(len(panels)), [series.value.size for series in panels])
    columns: list[tuple[str, Any, str]] = [
        ("value", np.round(values / step).astype(np.int64), "coefficient"),
        ("panel_index", index.astype(np.uint8), "panel, counted from 0"),
        ("output", np.concatenate([s.output for s in panels]).astype(np.uint16), "function, counted from 0"),
        ("beta_degree", np.concatenate([s.beta_degree for s in panels]).astype(np.uint8), "degree over ln beta"),
    ]
    for i, name in enumerate(names):
        degree = np.concatenate([s.degrees[i] for s in panels]).astype(np.uint8)
        columns.append((f"degree_{name}", degree, f"degree over {name}"))
    for name, data, meaning in columns:
        packing = {"compression": "gzip", "compression_opts": 9, "shuffle": True, "chunks": (max(data.size, 1),)}
        _variable(group, name, ("entry",), data, meaning, **packing)
    group.variables["value"].attrs["scale_factor"] = step
    outputs = np.array([s.outputs for s in panels], dtype=np.uint16)
    _variable(group, "outputs", ("panel",), outputs, "number of functions on the panel")


def _variable(group: Any, name: str, dimensions: tuple[str, ...], data: Any, meaning: str, **packing: Any) -> None:
    group.create_variable(name, dimensions, data=data, **packing).attrs.update({"long_name": meaning, "units": "1"})
