"""A parameter study as one table, a line for each point and step: what spreadsheets and statistics programs read."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from flatpunch.files.results import write
from flatpunch.sweeps.failure import KINDS

if TYPE_CHECKING:
    import pandas as pd


def table(study: xr.Dataset) -> pd.DataFrame:
    """Return a study as a table.

    Parameters
    ----------
    study : xarray.Dataset
        What `sweep` returned.

    Returns
    -------
    pandas.DataFrame
        A line for each point and step: the varied values, the step, what was computed there, and `status` and `reason` of the
        point. SI units, named in brackets. Outlines and notes of the method stay in the dataset.

    See Also
    --------
    flatpunch.sweep : Makes the study.
    flatpunch.sweeps.save_table : As a file.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> study = fp.sweep(path, {"layers.0.thickness": "1mm, 2mm"}, workers=1)
    >>> from flatpunch.sweeps import table
    >>> print(*table(study).columns[:4], sep=", ")
    layers.0.thickness [m], step, depth [m], force [N]
    """
    # where every point failed there are no steps
    over = [*study["status"].dims, *(["step"] if "step" in study.dims else [])]
    kept = [name for name, variable in study.data_vars.items() if set(variable.dims) <= set(over) and name != "notes"]
    frame = study[kept].to_dataframe(dim_order=over).reset_index()
    if "critical_kind" in frame:
        frame["critical_kind"] = [KINDS[int(kind)] if math.isfinite(kind) else "" for kind in frame["critical_kind"]]
    columns = [*over, *kept]
    return frame[columns].rename(columns={name: _heading(study, str(name)) for name in columns})


def save_table(study: xr.Dataset, path: str | Path) -> Path:
    """Write the table of a study as CSV.

    Parameters
    ----------
    study : xarray.Dataset
        What `sweep` returned.
    path : path
        Where to; what stands there is replaced when the new table is whole.

    Returns
    -------
    Path
        The table's place.

    Raises
    ------
    ResultError
        Where the folder is missing or may not be written to.

    See Also
    --------
    flatpunch.sweeps.table : The table itself.
    flatpunch.save : The study with outlines and notes.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> study = fp.sweep(path, {"layers.0.thickness": "1mm, 2mm"}, workers=1)
    >>> from flatpunch.sweeps import save_table
    >>> print(save_table(study, "study.csv"))
    study.csv
    """
    return write(Path(path), table(study).to_csv(index=False, lineterminator="\n").encode())


def _heading(study: xr.Dataset, name: str) -> str:
    unit = study[name].attrs.get("units", "") if name in study.variables else ""
    return f"{name} [{unit}]" if unit and unit != "1" else name
