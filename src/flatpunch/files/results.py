"""Result files: NetCDF for programs, CSV for people; either is read back to the identical dataset.

A file appears whole or not at all: it is written under a temporary name in the same folder and then renamed.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support import whole_file as _whole_file

_STAMP = "flatpunch_version"
_STRUCTURE = "# structure: "


class ResultError(ValueError):
    """A result file that cannot be read, or a result that cannot be written where it was asked for."""


def save(result: xr.Dataset, path: str | Path) -> Path:
    """Write a result.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    path : path
        Target; the ending chooses the format: ".nc" (NetCDF 4) or ".csv" (text, metadata as comments on top).

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ResultError
        If the ending is neither, or the file cannot be written. An older file of that name is then untouched.
    """
    path = Path(path)
    _format(path)
    with whole_file(path) as temporary:
        if path.suffix.lower() == ".nc":
            result.to_netcdf(temporary, engine="h5netcdf")
        else:
            temporary.write_text(to_csv(result), encoding="utf-8")
    return path


def load(path: str | Path) -> xr.Dataset:
    """Read a result back; the dataset is identical to the one that was saved, to the last bit.

    Parameters
    ----------
    path : path
        File written by `save`.

    Raises
    ------
    ResultError
        If the file is missing, damaged, or no result of this package.
    """
    path = Path(path)
    kind = _format(path)
    if not path.is_file():
        raise ResultError(f"{path}: no such file.")
    try:
        result = (
            xr.load_dataset(path, engine="h5netcdf") if kind == ".nc" else from_csv(path.read_text(encoding="utf-8"))
        )
    except ResultError as error:
        raise ResultError(f"{path}: {error}") from None
    except (OSError, ValueError, KeyError, UnicodeDecodeError) as error:
        raise ResultError(
            f"{path}: damaged, or no {'NetCDF' if kind == '.nc' else 'CSV'} file ({_first_line(error)})."
        ) from None
    if _STAMP not in result.attrs:
        raise ResultError(f"{path}: readable, but no flatpunch result (the attribute {_STAMP} is missing).")
    return result


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary file next to `path` that takes its place at the end; what goes wrong is told as a `ResultError`."""
    path = Path(path)
    try:
        with _whole_file.whole_file(path) as temporary:
            yield temporary
    except OSError as error:
        raise ResultError(
            f"{path}: cannot be written ({error.strerror or error}). Choose a folder that exists and is yours."
        ) from None


def _format(path: Path) -> str:
    kind = path.suffix.lower()
    if kind not in (".nc", ".csv"):
        raise ResultError(
            f"{path}: results are kept as .nc (NetCDF) or .csv; the ending {kind or 'is missing and'!r} is neither."
        )
    return kind


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def to_csv(result: xr.Dataset) -> str:
    """Return a dataset as CSV text: comments, one line of column names, one line a step.

    Variables over `step` are one column, variables over `step` and one more dimension are one column for each of its
    entries. Everything else (coordinates, attributes, types) stands in the line "structure", as JSON.
    """
    out = io.StringIO()
    for line in _preamble(result):
        out.write(line + "\n")
    columns = list(_columns(result))
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([name for name, _ in columns])
    # repr of a Python float is the shortest text that reads back to the same number
    writer.writerows(zip(*(map(repr, values.tolist()) for _, values in columns), strict=True))
    return out.getvalue()


def _preamble(result: xr.Dataset) -> Iterator[str]:
    yield f"# flatpunch result, version {result.attrs.get(_STAMP, 'unknown')}"
    for key in ("method", "control", "medium", "indenter"):
        if key in result.attrs:
            yield f"# {key}: {result.attrs[key]}"
    for note in str(result.attrs.get("notes", "")).splitlines():
        yield f"# note: {note}"
    for name, variable in result.data_vars.items():
        yield f"# {name} [{variable.attrs.get('units', '-')}]: {variable.attrs.get('long_name', name)}"
    yield _STRUCTURE + json.dumps(_structure(result), ensure_ascii=False)


def _structure(result: xr.Dataset) -> dict[str, Any]:
    def described(variable: Any) -> dict[str, Any]:
        return {"dims": list(variable.dims), "dtype": str(variable.dtype), "attrs": _plain(variable.attrs)}

    coords = {str(name): described(coord) for name, coord in result.coords.items()}
    for name, kept in coords.items():
        if name != "step":  # its values are the first column
            kept["values"] = result[name].values.tolist()
    variables = {str(name): described(variable) for name, variable in result.data_vars.items()}
    return {"steps": result.sizes["step"], "attrs": _plain(result.attrs), "coords": coords, "variables": variables}


def _plain(attrs: dict[Any, Any]) -> dict[str, Any]:
    return {
        str(key): value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
        for key, value in attrs.items()
    }


def _columns(result: xr.Dataset) -> Iterator[tuple[str, Any]]:
    steps = np.arange(result.sizes["step"]) if "step" not in result.coords else result["step"].values
    yield "step", steps
    for name, variable in result.data_vars.items():
        if not variable.dims or variable.dims[0] != "step" or variable.ndim > 2:
            raise ResultError(
                f"variable {name!r} over {variable.dims} has no place in a table of steps; save it as .nc instead."
            )
        unit = variable.attrs.get("units", "-")
        if variable.ndim == 1:
            yield f"{name} [{unit}]", variable.values
            continue
        other = str(variable.dims[1])
        labels = result[other].values.tolist() if other in result.coords else range(variable.shape[1])
        for i, label in enumerate(labels):
            yield f"{name} [{unit}] {other}={label!r}", variable.values[:, i]


def from_csv(text: str) -> xr.Dataset:
    """Return the dataset written by `to_csv`."""
    lines = text.splitlines()
    described = [line for line in lines if line.startswith(_STRUCTURE)]
    if not described:
        raise ResultError(f"no flatpunch result: the comment line {_STRUCTURE.strip()!r} is missing.")
    structure = json.loads(described[0].removeprefix(_STRUCTURE))
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise ResultError("damaged: the lines of the table have different lengths.")
    table = np.array(rows[1:], dtype=object).reshape(len(rows) - 1, len(rows[0]))
    position, variables = 1, {}
    for name, kept in structure["variables"].items():
        width = 1 if len(kept["dims"]) == 1 else len(structure["coords"][kept["dims"][1]]["values"])
        block = _parsed(table[:, position : position + width], kept["dtype"])
        variables[name] = (kept["dims"], block[:, 0] if len(kept["dims"]) == 1 else block, kept["attrs"])
        position += width
    coords = {
        name: (kept["dims"], np.array(kept.get("values", table[:, 0].tolist()), dtype=kept["dtype"]), kept["attrs"])
        for name, kept in structure["coords"].items()
    }
    result = xr.Dataset(variables, coords, structure["attrs"])
    if structure["steps"] != len(rows) - 1 or position != len(rows[0]):
        raise ResultError("damaged: the table is smaller or larger than its description.")
    return result


def _parsed(block: Any, dtype: str) -> Any:
    if dtype == "bool":
        return block == "True"
    return block.astype(dtype)
