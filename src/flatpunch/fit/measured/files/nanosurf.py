"""Files of Nanosurf microscopes (.nid), through the package NSFopen of the maker (extra `nanosurf`)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from flatpunch.fit.measured.columns import Constants, Table
from flatpunch.fit.measured.curve import CurveError


def nanosurf_tables(path: Path) -> list[Table]:
    """Curves of a file.

    Raises
    ------
    CurveError
        If NSFopen is not installed, or the file has no curves.
    """
    try:
        from NSFopen.read import read
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs NSFopen: pip install 'flatpunch[nanosurf]'.") from None
    try:
        file = read(str(path), dataframe=False)
        ways, header = file.data.get("Spec", {}), file.param["HeaderDump"].values()
        spring = file.param["Tip"].get("Prop0", {}).get("Value")
        units = {h["Dim2Name"]: h["Dim2Unit"] for h in header if "Spec" in h.get("Frame", "")}
    # NSFopen indexes and unpacks damaged bytes unchecked: KeyError, IndexError, struct.error, ...
    except Exception:
        raise CurveError(
            f"{path.name}: NSFopen cannot read it. It is damaged, or no file of a Nanosurf microscope."
        ) from None
    parts = [(way, ways[name]) for way, name in (("forth", "Forward"), ("back", "Backward")) if name in ways]
    names = tuple(name for name in units if parts and all(name in part for _, part in parts))
    if not names:
        raise CurveError(f"{path.name}: no force curves: no channels of spectroscopy.")
    constants = Constants(spring if isinstance(spring, float) and spring > 0 else None)
    tables = []
    for number in range(len(parts[0][1][names[0]])):
        there = [(way, [part[name][number] for name in names]) for way, part in parts if number < len(part[names[0]])]
        rows = [np.column_stack([np.asarray(column, dtype=float) for column in columns]) for _, columns in there]
        segment = np.repeat(np.arange(float(len(rows))), [len(part) for part in rows])
        table = Table(f"{path.name}, curve {number}", names, tuple(units[name] for name in names), np.concatenate(rows))
        tables.append(replace(table, constants=constants, segment=segment, ways=tuple(way for way, _ in there)))
    return tables
