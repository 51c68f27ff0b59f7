"""Result files: NetCDF for programs, CSV for people; either is read back to the identical dataset.

A file appears whole or not at all: it is written under a temporary name in the same folder and then renamed.
"""

from __future__ import annotations

import csv
import hashlib
import io
import itertools
import json
import warnings
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatpunch._support.checks import shown
from flatpunch._support.endings import RESULTS, listed
from flatpunch._support.paths import Plain
from flatpunch._support.reading import RESULT, Unreadable, as_path, content, shown_path
from flatpunch._support.whole_file import BrokenSeal, NotWritten, sealed, unsealed, write_whole
from flatpunch.files.exports import arrays, gap_text, vtk_bytes

_STAMP = "flatpunch_version"
_STRUCTURE = "# structure: "
_DIGEST = "content_sha256"
_SHA = "# sha256 of all that follows: "
_HDF5 = b"\x89HDF\r\n\x1a\n"


class ResultError(ValueError):
    """A result file that cannot be read, or a result that cannot be written where it was asked for.

    See Also
    --------
    flatpunch.load, flatpunch.save : Raise it.

    Examples
    --------
    >>> try:
    ...     fp.load("missing.nc")
    ... except fp.files.ResultError as error:
    ...     print(error)
    missing.nc: not readable (No such file or directory).
    """


def save(result: xr.Dataset, path: str | Path, *, outlines: bool = False) -> Path:
    """Write a result.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent`, `fields`, `sensitivity` and so on returned.
    path : path
        Target; the ending chooses the format: ".nc" (NetCDF 4) or ".csv" (text, metadata as comments on top). For other programs,
        which `load` does not read back: ".vtu" (by meshio) or ".vts" (pyvista), for ParaView, of fields and of rough contacts
        with their fields. The latter also ".npz" (x, y, pressure, gap and displacement) and ".txt" (the gap as a matrix of
        heights, rows along y, which SurfaceTopography, Gwyddion and `read_topography` open), of the last step.
    outlines : bool
        Whether a CSV holds the contact outlines too, one column for each polar angle; NetCDF always does.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ResultError
        If the ending is none of these, or the file cannot be written. An older file of that name is then untouched.

    See Also
    --------
    load : Reads it back.

    Examples
    --------
    >>> curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6), depth=[1e-7, 2e-7])
    >>> fp.save(curve, "gel.nc").name
    'gel.nc'
    """
    path = as_path("path", path)
    kind = _format(path, _WRITERS)
    if not hasattr(result, "data_vars"):
        raise TypeError(f"result = {shown(result)} must be a data set, as indent returns it.")
    try:
        written = _WRITERS[kind](result, outlines)
    except (ValueError, OSError) as error:
        # OSError: libraries for VTK write to a folder for temporary files
        raise ResultError(f"{shown_path(path)}: {error}") from None
    return write(path, written)


def netcdf(result: xr.Dataset) -> bytes:
    """Return a dataset as the bytes of a NetCDF file, made in memory: HDF5 does not survive a full disk.

    Arrays of numbers carry the checksums of HDF5 (fletcher32), which other programs verify too.
    """
    stamped = result.assign_attrs({_DIGEST: digest(result)})
    # bytes of a chunk of HDF5 must be below 4 GB
    checked = {
        name: {"fletcher32": True, "chunksizes": variable.shape}
        for name, variable in result.variables.items()
        if variable.dtype.kind in "fiu" and variable.ndim and 0 < variable.nbytes < 2**31
    }
    return bytes(stamped.to_netcdf(engine="h5netcdf", encoding=checked))


def digest(result: xr.Dataset) -> str:
    """Return the SHA-256 of names, types and values of all variables."""
    sha = hashlib.sha256()
    for name in sorted(map(str, result.variables)):
        values = result[name].values
        sha.update(f"{name} {result[name].dims} {values.shape}".encode())
        # texts change their type on the way through a file
        content = "\0".join(map(str, values.ravel().tolist())).encode() if values.dtype.kind not in "fiub" else None
        sha.update(np.ascontiguousarray(values).tobytes() if content is None else content)
    return sha.hexdigest()


_WRITERS: dict[str, Callable[[xr.Dataset, bool], bytes]] = {
    ".nc": lambda result, outlines: sealed(netcdf(result)),
    ".csv": lambda result, outlines: to_csv(result, outlines=outlines).encode("utf-8"),
    ".vtu": lambda result, outlines: vtk_bytes(result, ".vtu"),
    ".vts": lambda result, outlines: vtk_bytes(result, ".vts"),
    ".npz": lambda result, outlines: arrays(result),
    ".txt": lambda result, outlines: gap_text(result),
}


def write(path: Path, content: bytes) -> Path:
    """Write a file whole or not at all, and return its path; what goes wrong is a `ResultError`."""
    try:
        write_whole(path, content)
    except NotWritten as error:
        raise ResultError(str(error)) from None
    return path


def load(path: str | Path) -> xr.Dataset:
    """Read a result back; what was saved is identical to the last bit.

    Parameters
    ----------
    path : path
        File written by `save`.

    Raises
    ------
    ResultError
        If the file is missing, damaged, or no result of this package.

    See Also
    --------
    save : Writes it.

    Examples
    --------
    >>> curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6), depth=[1e-7, 2e-7])
    >>> fp.load(fp.save(curve, "gel.nc")).identical(curve)
    True
    """
    path = as_path("path", path)
    kind = _format(path, RESULTS)
    try:
        written = content(path, RESULT)
        found = from_netcdf(written) if kind == ".nc" else from_csv(written.decode("utf-8"))
    except Unreadable as error:
        raise ResultError(f"{shown_path(path)}: {error}.") from None
    except BrokenSeal as error:
        raise ResultError(
            f"{shown_path(path)}: damaged or changed after it was written: {error}. Solve it again."
        ) from None
    except ResultError as error:
        raise ResultError(f"{shown_path(path)}: {str(error).rstrip('.')}.") from None
    except Exception:  # damaged bytes make HDF5, h5py and xarray fail in any way
        name = "NetCDF" if kind == ".nc" else "CSV"
        raise ResultError(f"{shown_path(path)}: damaged, or no {name} file. Solve it again.") from None
    if _STAMP not in found.attrs:
        raise ResultError(f"{shown_path(path)}: readable, but no flatpunch result (the attribute {_STAMP} is missing).")
    return found


def from_netcdf(written: bytes) -> xr.Dataset:
    """Return the dataset written by `netcdf` and sealed; files of earlier versions have no seal."""
    whole, has_seal = unsealed(written)
    if not whole.startswith(_HDF5):
        raise ResultError("damaged, or no NetCDF file")
    with warnings.catch_warnings():
        # what a damaged file makes libraries say is no news for the reader of a message
        warnings.simplefilter("ignore")
        found = xr.load_dataset(io.BytesIO(whole), engine="h5netcdf")
    wanted = found.attrs.pop(_DIGEST, None)
    if wanted is not None and (not has_seal or digest(found) != wanted):
        raise BrokenSeal("its values are not those that were written")
    return found


def _format(path: Path, known: Container[str]) -> str:
    kind = path.suffix.lower()
    if kind not in known:
        raise ResultError(
            f"{shown_path(path)}: results are kept as {listed(RESULTS)}; the ending {shown(kind or 'is missing and')} is neither."
        )
    return kind


def to_csv(result: xr.Dataset, *, outlines: bool = True) -> str:
    """Return a dataset as CSV text: comments, one line of column names, a line for each step, point, parameter or layer.

    Variables over these are one column; those over further dimensions too, as outlines are, one column for each entry of these.
    Outlines may be left out. All else (coordinates, other variables, attributes, types) is in the line "structure", as JSON.
    """
    if not outlines and "step" in result.dims:
        result = result.drop_dims([name for name in result.dims if name not in _rows(result)])
    out = io.StringIO()
    for line in _preamble(result):
        out.write(" ".join(line.splitlines()) + "\n")
    columns = list(_columns(result))
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([name for name, _ in columns])
    # repr of a Python float is the shortest text that reads back to the same number
    writer.writerows(zip(*(map(_cell, values.tolist()) for _, values in columns), strict=True))
    table = out.getvalue()
    return f"{_SHA}{hashlib.sha256(table.encode()).hexdigest()}\n{table}"


def _cell(value: object) -> str:
    return value if isinstance(value, str) else repr(value)


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


def _structure(result: xr.Dataset) -> Plain:
    def described(variable: xr.DataArray) -> Plain:
        return {"dims": list(variable.dims), "dtype": str(variable.dtype), "attrs": _plain(variable.attrs)}

    rows = _rows(result)
    coords = {str(name): described(coord) for name, coord in result.coords.items()}
    for name, kept in coords.items():
        if (name,) != rows:  # its values are the first column
            kept["values"] = result[name].values.tolist()
    variables = {str(name): described(variable) for name, variable in result.data_vars.items()}
    for name, kept in variables.items():
        if not set(rows) <= set(kept["dims"]):
            kept["values"] = result[name].values.tolist()
    return {
        "rows": list(rows),
        "sizes": {str(name): size for name, size in result.sizes.items()},
        _DIGEST: True,
        "attrs": _plain(result.attrs),
        "coords": coords,
        "variables": variables,
    }


def _rows(result: xr.Dataset) -> tuple[str, ...]:
    """Dimensions whose combinations are the lines of a table: parameters of a study and steps, or those of most variables."""
    counts = Counter(tuple(map(str, variable.dims)) for variable in result.data_vars.values())
    if "step" in result.dims:
        return min((dims for dims in counts if "step" in dims), key=len, default=("step",))
    return max(counts, key=lambda dims: (counts[dims], -len(dims)), default=())


def _plain(attrs: Mapping[object, object]) -> Plain:
    return {
        str(key): value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
        for key, value in attrs.items()
    }


def _columns(result: xr.Dataset) -> Iterator[tuple[str, NDArray[np.generic]]]:
    rows = _rows(result)
    count = int(np.prod([result.sizes[name] for name in rows]))
    one = rows[0] if len(rows) == 1 and rows[0] in result.coords else None
    yield (one or "row"), (np.arange(count) if one is None else result[one].values)
    if one is None:
        places = np.indices([result.sizes[name] for name in rows]).reshape(len(rows), count)
        yield from (
            (name, result[name].values[at]) for name, at in zip(rows, places, strict=True) if name in result.coords
        )
    for name, variable in result.data_vars.items():
        if not set(rows) <= set(variable.dims):
            continue
        unit = variable.attrs.get("units", "-")
        others = [str(dim) for dim in variable.dims if dim not in rows]
        values = variable.transpose(*rows, *others).values.reshape(count, -1)
        labels = [result[dim].values.tolist() if dim in result.coords else range(result.sizes[dim]) for dim in others]
        for column, label in zip(values.T, itertools.product(*labels), strict=True):
            named = "".join(f" {dim}={each!r}" for dim, each in zip(others, label, strict=True))
            yield f"{name} [{unit}]{named}", column


def from_csv(text: str) -> xr.Dataset:
    """Return the dataset written by `to_csv`."""
    first, _, rest = text.partition("\n")
    if first.startswith(_SHA) and first.removeprefix(_SHA) != hashlib.sha256(rest.encode()).hexdigest():
        raise BrokenSeal("its text is not what was written")
    lines = text.splitlines()
    described = [line for line in lines if line.startswith(_STRUCTURE)]
    if not described:
        raise ResultError(f"no flatpunch result: the comment line {_STRUCTURE.strip()!r} is missing.")
    structure = json.loads(described[0].removeprefix(_STRUCTURE))
    if structure.get(_DIGEST) and not first.startswith(_SHA):
        raise BrokenSeal("its first line is missing or damaged")
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise ResultError("damaged: the lines of the table have different lengths.")
    table = np.array(rows[1:], dtype=object).reshape(len(rows) - 1, len(rows[0]))
    # files of earlier versions have steps alone
    lines_of = tuple(structure.get("rows", ["step"]))
    sizes = structure.get("sizes") or {"step": structure["steps"]}
    sizes |= {name: len(kept["values"]) for name, kept in structure["coords"].items() if "values" in kept}
    position, variables = len({"row", *structure["coords"]} & set(rows[0])), {}
    for name, kept in structure["variables"].items():
        if "values" in kept:
            variables[name] = (kept["dims"], np.array(kept["values"], dtype=kept["dtype"]), kept["attrs"])
            continue
        others = [dim for dim in kept["dims"] if dim not in lines_of]
        shape = [sizes[dim] for dim in (*lines_of, *others)]
        width = int(np.prod([sizes[dim] for dim in others]))
        block = _parsed(table[:, position : position + width], kept["dtype"]).reshape(shape)
        laid = xr.Variable((*lines_of, *others), block).transpose(*kept["dims"])
        variables[name] = (kept["dims"], laid.values, kept["attrs"])
        position += width
    coords = {
        name: (kept["dims"], _parsed(np.array(kept.get("values", table[:, 0].tolist())), kept["dtype"]), kept["attrs"])
        for name, kept in structure["coords"].items()
    }
    result = xr.Dataset(variables, coords, structure["attrs"])
    if int(np.prod([sizes[name] for name in lines_of])) != len(rows) - 1 or position != len(rows[0]):
        raise ResultError("damaged: the table is smaller or larger than its description.")
    return result


def _parsed(block: NDArray[np.generic], dtype: str) -> NDArray[np.generic]:
    if dtype == "bool":
        return np.asarray(block == "True")
    return block.astype(dtype)
