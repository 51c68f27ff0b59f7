"""Tables as files: NetCDF 4 (HDF5), readable by any program that reads HDF5.

One file for each family. Coefficients are whole numbers times a step, which the attribute `scale_factor` gives (the NetCDF
convention), each with its degrees; see the documentation for the twenty lines that evaluate them.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, cast

import h5netcdf
import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.reading import Unreadable, content, is_file, is_folder, shown_path
from flatpunch._support.whole_file import BrokenSeal, sealed, unsealed, write_whole
from flatpunch.atlas.parameter import Parameter, Scale
from flatpunch.atlas.series import SparseSeries
from flatpunch.atlas.table import Panel, Table

LARGEST = 1_000_000_000
"""Largest file of a table that is read [bytes]."""

SCHEMA = 1
"""Version of the layout; files of a later one are refused."""

LICENCE = "CC-BY-4.0"


_TEXTS = {
    "Conventions": "CF-1.8",
    "institution": "The flatpunch developers",
    "license": LICENCE,
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


class AtlasFileError(ValueError):
    """A file that is no table of the atlas, or of a later layout.

    See Also
    --------
    flatpunch.atlas.read_table : Raises it.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> print(issubclass(atlas.AtlasFileError, ValueError))
    True
    """


def write_table(table: Table, path: str | Path) -> Path:
    """Write a table, whole or not at all.

    Parameters
    ----------
    table : Table
        What is written.
    path : path
        File, by custom "<name>.nc".

    Returns
    -------
    Path
        The file written.

    See Also
    --------
    flatpunch.atlas.read_table : Reads it.
    flatpunch.atlas.table : By name or file.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> print(atlas.write_table(atlas.table("sliding-layer"), "my-layer.nc"))
    my-layer.nc
    """
    path = Path(path)
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        _write(file, table)
    write_whole(path, sealed(buffer.getvalue()))
    return path


def _write(file: Any, table: Table) -> None:
    low, high = table.beta_range
    file.attrs.update(
        {"title": table.title, "flatpunch_atlas_schema": SCHEMA, "family": table.name, **_TEXTS, **table.attributes}
    )
    file.attrs.update({"beta_low": low, "beta_high": high, "relative_error_bound": table.bound})
    group = file.create_group("parameters")
    group.attrs["names"] = " ".join(p.name for p in table.parameters)
    for parameter in table.parameters:
        group.create_group(parameter.name).attrs.update(
            {
                "long_name": parameter.meaning,
                "low": parameter.low,
                "high": parameter.high,
                "scale": parameter.scale,
                "shift": parameter.shift,
                "units": parameter.unit,
            }
        )
    group = file.create_group("panels")
    group.dimensions = {"panel": len(table.panels), "order": max(1, *(panel.orders.size for panel in table.panels))}
    ends = [("beta_low", [p.low for p in table.panels]), ("beta_high", [p.high for p in table.panels])]
    for name, data in ends:
        variable = group.create_variable(name, ("panel",), data=np.array(data))
        variable.attrs.update({"long_name": f"{name.split('_')[1]} end of the panel", "units": "1"})
    orders = np.zeros((len(table.panels), group.dimensions["order"].size), dtype=np.uint16)
    for row, panel in zip(orders, table.panels, strict=True):
        row[: panel.orders.size] = panel.orders
    variable = group.create_variable("orders", ("panel", "order"), data=orders)
    variable.attrs.update({"long_name": "harmonics m of the outputs of the responses; 0 fills up", "units": "1"})
    for kind in table.panels[0].series:
        series = [panel.series[kind] for panel in table.panels]
        _write_kind(file.create_group(kind), series, [p.name for p in table.parameters])


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
        variable = group.create_variable(name, ("entry",), data=data, **packing)
        variable.attrs.update({"long_name": meaning, "units": "1"})
    group.variables["value"].attrs["scale_factor"] = step
    outputs = group.create_variable("outputs", ("panel",), data=np.array([s.outputs for s in panels], dtype=np.uint16))
    outputs.attrs.update({"long_name": "number of functions on the panel", "units": "1"})


def read_table(path: str | Path) -> Table:
    """Read a table.

    Parameters
    ----------
    path : path
        A file written by `write_table`.

    Returns
    -------
    Table

    Raises
    ------
    AtlasFileError, OSError
        If it is no such file.

    See Also
    --------
    flatpunch.atlas.write_table : Writes it.
    flatpunch.atlas.table : By name or file.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> path = atlas.write_table(atlas.table("sliding-layer"), "my-layer.nc")
    >>> print(atlas.read_table(path).name)
    sliding-layer
    """
    path = Path(path)
    if not is_file(path) and not is_folder(path):
        raise FileNotFoundError(
            f"{shown_path(path)}: there is no such file. scripts/atlas_tables of the repository makes tables."
        )
    try:
        body, has_seal = unsealed(content(path, LARGEST))
        if not has_seal:
            # HDF5 may return other numbers for damaged bytes, or never return
            raise BrokenSeal(
                "it has no line of its checksum at the end; scripts/atlas_tables of the repository makes it again"
            )
        with h5netcdf.File(io.BytesIO(body), "r") as file:
            return _read(file, path)
    except AtlasFileError:
        raise
    except (Unreadable, BrokenSeal) as error:
        raise AtlasFileError(f"{shown_path(path)} is no table of the atlas: {error}.") from None
    except Exception:  # damaged bytes make HDF5 fail in any way
        raise AtlasFileError(f"{shown_path(path)} is no table of the atlas: damaged, or of another kind.") from None


def _read(file: Any, path: Path) -> Table:
    schema = file.attrs.get("flatpunch_atlas_schema")
    if schema is None or int(schema) > SCHEMA:
        known = "it does not say which layout it has" if schema is None else f"its layout is version {schema}"
        raise AtlasFileError(
            f"{path}: {known}; this version reads tables up to {SCHEMA}. A newer flatpunch may read it."
        )
    group = file["parameters"]
    parameters = tuple(_parameter(group, name) for name in str(group.attrs["names"]).split())
    low, high = (file["panels"].variables[name][:] for name in ("beta_low", "beta_high"))
    kinds = [name for name in file.groups if name not in ("panels", "parameters")]
    series = {kind: _read_kind(file[kind], [p.name for p in parameters]) for kind in kinds}
    orders = np.asarray(file["panels"].variables["orders"][:], dtype=int)
    panels = tuple(
        Panel(float(low[i]), float(high[i]), {kind: series[kind][i] for kind in kinds}, orders[i][orders[i] > 0])
        for i in range(low.size)
    )
    skipped = {*_TEXTS, "title", "family", "beta_low", "beta_high", "relative_error_bound", "flatpunch_atlas_schema"}
    attributes = {
        name: np.asarray(value).tolist()
        for name, value in file.attrs.items()
        if name not in skipped and not name.startswith("_")
    }
    bound = float(file.attrs["relative_error_bound"])
    return Table(str(file.attrs["family"]), str(file.attrs["title"]), parameters, panels, bound, attributes)


def _parameter(group: Any, name: str) -> Parameter:
    a = group[name].attrs
    return Parameter(
        name,
        str(a["long_name"]),
        float(a["low"]),
        float(a["high"]),
        cast("Scale", str(a["scale"])),  # which Parameter checks
        float(a["shift"]),
        str(a["units"]),
    )


def _read_kind(group: Any, names: list[str]) -> list[SparseSeries]:
    def column(name: str) -> Indices:
        return np.asarray(group.variables[name][:], dtype=np.int64)

    # NumPy scalars of one element, as the file gives attributes
    step = float(np.ravel(group.variables["value"].attrs["scale_factor"])[0])
    value: Array = np.asarray(column("value") * step, dtype=float)
    panel = column("panel_index")
    output, beta_degree = column("output"), column("beta_degree")
    degrees = [column(f"degree_{name}") for name in names]
    found = []
    for i, outputs in enumerate(column("outputs").tolist()):
        part = slice(*np.searchsorted(panel, [i, i + 1]))
        found.append(
            SparseSeries(outputs, value[part], output[part], beta_degree[part], tuple(d[part] for d in degrees))
        )
    return found
