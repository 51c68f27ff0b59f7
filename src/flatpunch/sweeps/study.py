"""`sweep`: a case file solved over a grid of values, as one data set, and the data set as a table."""

from __future__ import annotations

import copy
import itertools
import json
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatpunch._support.checks import NUMBERS, FlatpunchWarning, switch
from flatpunch._support.paths import Plain, put
from flatpunch._support.progress import Report
from flatpunch._version import __version__
from flatpunch.contact import default_choice, indent, method_of
from flatpunch.files import Case, CaseError
from flatpunch.files.analyses import first_failure
from flatpunch.files.cases import case_from, case_text, parsed
from flatpunch.files.results import write
from flatpunch.parallel import Outcome, Solved, content_key, cores, solve_points
from flatpunch.sweeps.axes import Axis, axes_of

if TYPE_CHECKING:
    import pandas as pd
    from distributed import Client

    from flatpunch.stresses import CriticalLoad

_SHOWN = 5
"""Problems that a message lists."""
_SLOW = ("bem", "refined")
KINDS = ("yield", "tensile", "shear", "interface tension", "interface shear")
"""Kinds of failure in the order of their numbers."""

Found = NDArray[np.generic]


def sweep(
    case: str | Path | Case,
    vary: Mapping[str, object] | None = None,
    *,
    contours: bool = False,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | Client | None = None,
    progress: bool | Report | None = None,
    retry_failed: bool = False,
    anew: bool = False,
) -> xr.Dataset:
    """Solve a case for all combinations of values of some of its parameters.

    Parameters
    ----------
    case : path or Case
        Case file, or what `read_case` returned.
    vary : mapping, optional
        Path into the case file -> its values: "0.2um:5um:40:log" (start, stop, count, and "log" or "lin"), "15deg, 20deg", or a
        sequence of texts with units or of numbers in SI units. Paths name tables and list entries, "layers.0.thickness". If
        left out, the table [vary] of the case file, with its paths in quotation marks.
    contours : bool
        Keep the outlines a(phi) too, which are large.
    store : path, optional
        Folder that keeps each finished point; a later call with the same folder solves only what is missing.
    workers : int, optional
        Processes. By default one for 32 points of a fast method, or for each point of a slow one, at most one for each core.
    scheduler : str or distributed.Client, optional
        Address of a Dask scheduler, whose cluster then does the work.
    progress : bool or callable, optional
        True shows a bar; a function is called with (points done, points in all).
    retry_failed, anew : bool
        Try again what failed in an earlier run; solve everything again.

    Returns
    -------
    xarray.Dataset
        What `indent` returns, over the varied parameters (coordinates named by their paths, in SI units) and `step`; NaN where
        a point failed. `status` is "solved" or "failed", `reason` says why, `method_used` and `notes` are those of
        each point. Where the case has strengths in [stress]: critical_force, critical_depth, critical_kind and
        critical_layer too, the same at all steps, and along `criterion` critical_margin, strength over stress at that load.

    Raises
    ------
    ValueError
        Before any work: for a path that is not in the file, a value without its unit, a combination that is no case.

    See Also
    --------
    read_case : The case.
    sweeps.table : The result as a table.
    parallel.solve_points : A function of your own over any points.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> study = fp.sweep(path, {"layers.0.thickness": "1mm:2mm:3:lin"}, workers=1)
    >>> print(dict(study.sizes)["layers.0.thickness"], set(study.status.values.ravel().tolist()))
    3 {'solved'}
    """
    contours = switch("contours", contours)
    if isinstance(case, Case) and case.source:
        path, text = case.source
    elif isinstance(case, (str, Path)):
        path, text = Path(case), case_text(case)
    else:
        raise TypeError(f"case = {type(case).__name__} must be the path of a case file, or what read_case returned.")
    data = parsed(text, path)
    in_file = data.pop("vary", None)
    axes = axes_of(data, in_file if vary is None else vary)
    cases = _cases(data, axes, path, contours=contours)
    # what is chosen for the last of the points is chosen for all
    slow = any(_slow(found) for found in (cases if "method" in data else cases[-1:]))
    # points of a fast method, up to 0.1 s each with a body of their own, that take as long as starting a process
    few = len(cases) if slow else 1 + len(cases) // 32
    solved = solve_points(
        partial(_solve, contours=contours),
        [replace(found, title="") for found in cases],  # which moves no numbers
        store=store,
        workers=workers if workers is not None else min(cores(), few),
        scheduler=scheduler,
        progress=progress,
        title="Sweep",
        group=lambda found: content_key(found.medium),  # points on the same body share its flat-punch solutions
        retry_failed=retry_failed,
        anew=anew,
    )
    result = _dataset(axes, solved)
    return result.assign_attrs(
        title=f"Parameter study: {cases[0].title or path.name}",
        case_file=path.name,
        case=text,
        vary=json.dumps({axis.path: list(axis.written) for axis in axes}, ensure_ascii=False),
        control=cases[0].control,
        flatpunch_version=__version__,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        conventions="SI units; pressure positive in compression; depth and gap as in the documentation",
    )


def _slow(case: Case) -> bool:
    """Whether a point takes boundary element solutions; where the choice is left to `indent`, whether it would."""
    if case.method is None and case.time is None:
        return not default_choice(case.indenter, case.medium, **{case.control: case.values}).quick
    return case.method is not None and method_of(case.method).name in _SLOW


def _cases(data: Plain, axes: Sequence[Axis], path: Path, *, contours: bool) -> list[Case]:
    """All combinations, the last parameter running fastest; refused together where some are no cases."""
    cases, problems = [], []
    for at in itertools.product(*(range(len(axis.values)) for axis in axes)):
        changed = copy.deepcopy(data)
        for axis, i in zip(axes, at, strict=True):
            put(changed, axis.path, axis.written[i])
        try:
            cases.append(case_from(changed, path))
        except CaseError as error:
            where = ", ".join(f"{axis.path} = {axis.text(i)}" for axis, i in zip(axes, at, strict=True))
            problems.append(f"With {where}:\n    {error}")
    if problems:
        more = f"\n... and {len(problems) - _SHOWN} more" if len(problems) > _SHOWN else ""
        count = f"{len(problems)} of {len(problems) + len(cases)}"
        raise CaseError(f"{count} combinations describe no case.\n" + "\n".join(problems[:_SHOWN]) + more)
    size = sum(found.values.size * (found.angles if contours else 1) for found in cases)
    if size > NUMBERS:
        raise ValueError(
            f"vary makes {len(cases)} points of {cases[0].values.size} steps{' with outlines' if contours else ''}, {size:.3g} "
            f"values of each quantity; {NUMBERS:.0e} are the most. Take fewer points or steps."
        )
    steps = sorted({found.values.size for found in cases})
    if len(steps) > 1:
        raise ValueError(
            f"vary changes the number of steps, from {steps[0]} to {steps[-1]}: such results have no common grid. Keep the "
            "number of points of [control] or [history]."
        )
    return cases


def _solve(case: Case, *, contours: bool) -> Plain:
    """One point: the arrays of the result, and how they are to be understood."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FlatpunchWarning)
        result = indent(case.medium, case.indenter, **case.arguments)
        first, ended = first_failure(case)
        if case.stress is not None and case.stress.judged:
            result = result.assign(critical_variables(first, result.sizes["step"]))
            if first is not None:
                names = sorted(first.margins)
                margins = ("criterion", [first.margins[name] for name in names], {"long_name": "strength over stress"})
                result = result.assign(critical_margin=margins).assign_coords(criterion=names)
    kept = result if contours else result.drop_dims("phi")
    notes = dict.fromkeys([*str(result.attrs.get("notes", "")).splitlines(), *(str(w.message) for w in caught), ended])
    structure = {
        kind: {str(name): [list(found[name].dims), dict(found[name].attrs)] for name in found}
        for kind, found in (("coords", kept.coords), ("data", kept.data_vars))
    }
    arrays = {str(name): kept[name].values for name in kept.variables}
    return {
        **arrays,
        "_method": result.attrs["method"],
        "_structure": json.dumps(structure),
        "_notes": "\n".join(line for line in notes if line),
    }


def _dataset(axes: Sequence[Axis], solved: Solved) -> xr.Dataset:
    shape, dims = tuple(len(axis.values) for axis in axes), tuple(axis.path for axis in axes)
    outcomes = list(solved.values())
    coords: Plain = {}
    for axis in axes:
        kind = object if isinstance(axis.values[0], str) else None
        about = {"long_name": f"{axis.path} of the case file"} | ({"units": axis.unit} if axis.unit else {})
        coords[axis.path] = (axis.path, np.array(axis.values, dtype=kind), about)
    data: Plain = {}
    for name, own, attrs, values in _variables(outcomes, coords):
        empty = (False, bool) if all(value.dtype == bool for value in values.values()) else (np.nan, float)
        filled = np.full((len(outcomes), *next(iter(values.values())).shape), *empty)
        for i, value in values.items():
            filled[i] = value
        data[name] = ((*dims, *own), filled.reshape(*shape, *filled.shape[1:]), attrs)
    texts = {
        "status": (["solved" if outcome.ok else "failed" for outcome in outcomes], "whether the point was solved"),
        "reason": ([outcome.reason for outcome in outcomes], "why the point failed"),
        "method_used": ([str((o.numbers or {}).get("_method", "")) for o in outcomes], "contact method"),
        "notes": ([str((o.numbers or {}).get("_notes", "")) for o in outcomes], "limits of the method at this point"),
    }
    for name, (lines, long_name) in texts.items():
        data[name] = (dims, np.array(lines, dtype=object).reshape(shape), {"long_name": long_name})
    return xr.Dataset(data, coords)


def _variables(outcomes: Sequence[Outcome], coords: Plain) -> Iterator[tuple[str, list[str], Plain, dict[int, Found]]]:
    """Name, dimensions, attributes and values by point of what has one shape; what never varies goes to `coords`."""
    described: dict[str, tuple[list[str], Plain]] = {}
    values: dict[str, dict[int, Found]] = {}
    for i, outcome in enumerate(outcomes):
        if outcome.numbers is None:
            continue
        structure = json.loads(str(outcome.numbers["_structure"]))
        for name, (own, attrs) in structure["coords"].items():
            coords.setdefault(name, (own, outcome.numbers[name], attrs))
        for name, (own, attrs) in structure["data"].items():
            described.setdefault(name, (own, attrs))
            values.setdefault(name, {})[i] = np.asarray(outcome.numbers[name])
    for name, (own, attrs) in described.items():
        if len({value.shape for value in values[name].values()}) == 1:
            yield name, own, attrs, values[name]


def critical_variables(found: CriticalLoad | None, steps: int) -> Plain:
    """Critical load of a case as variables along the steps (all of which are alike); not numbers where it was not found."""
    kinds = ", ".join(f"{i} {name}" for i, name in enumerate(KINDS))
    about = {
        "force": ("N", "load at the first failure"),
        "depth": ("m", "depth at the first failure"),
        "radius": ("m", "contact radius at the first failure"),
        "kind": ("", f"kind of the first failure: {kinds}"),
        "layer": ("", "layer of the first failure, from the surface; the base comes last"),
    }

    def value(name: str) -> float:
        if found is None:
            return float("nan")
        return float(KINDS.index(found.kind) if name == "kind" else getattr(found, name))

    return {
        f"critical_{name}": (
            "step",
            np.full(steps, value(name)),
            {"units": unit, "long_name": text} if unit else {"long_name": text},
        )
        for name, (unit, text) in about.items()
    }


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
