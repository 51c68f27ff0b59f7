"""Files of Nanosurf microscopes (.nid), through the package NSFopen of the maker (extra `nanosurf`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flatpunch.fit.measured.columns import Constants, Table
from flatpunch.fit.measured.curve import CurveError

_DEFLECTION, _HEIGHTS = "Deflection", ("Z-Axis Sensor", "Z-Axis")


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
        ways = file.data.get("Spec", {})
        header = file.param["HeaderDump"]
        spring = file.param["Tip"].get("Prop0", {}).get("Value")
    # NSFopen indexes and unpacks damaged bytes unchecked: KeyError, IndexError, struct.error, ...
    except Exception:
        raise CurveError(
            f"{path.name}: NSFopen cannot read it. It is damaged, or no file of a Nanosurf microscope."
        ) from None
    there, back = (ways.get(way, {}) for way in ("Forward", "Backward"))
    height = next((name for name in _HEIGHTS if name in there), None)
    if height is None or _DEFLECTION not in there:
        raise CurveError(
            f"{path.name}: no force curves: no channels of spectroscopy with {_DEFLECTION!r} and {_HEIGHTS[0]!r}."
        )
    channels = [h for h in header.values() if h.get("Dim2Name") == _DEFLECTION and "Spec" in h.get("Frame", "")]
    unit = next((h["Dim2Unit"] for h in channels), None)
    constants = Constants(spring if isinstance(spring, float) and spring > 0 else None)
    tables = []
    for number in range(len(there[height])):
        parts = [way for way in (there, back) if number < len(way.get(_DEFLECTION, ()))]
        columns = [
            np.concatenate([np.asarray(part[n][number], float) for part in parts]) for n in (height, _DEFLECTION)
        ]
        tables.append(
            Table(
                f"{path.name}, curve {number}",
                (height, _DEFLECTION),
                ("m", unit),
                np.column_stack(columns),
                constants=constants,
                segment=np.repeat(np.arange(float(len(parts))), [len(part[height][number]) for part in parts]),
                ways=("forth", "back")[: len(parts)],
            )
        )
    return tables
