"""Files of Nanosurf microscopes (.nid), through the package NSFopen of the maker (extra `nanosurf`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.paths import Plain
from flatpunch.fit.measured.curve import CurveError

_DEFLECTION, _HEIGHTS = "Deflection", ("Z-Axis Sensor", "Z-Axis")


def nanosurf_curves(path: Path, given: Mapping[str, float]) -> Iterator[tuple[dict[str, object], dict[str, object]]]:
    """Metadata and columns of each curve, heights growing away from the sample.

    Parameters
    ----------
    path : Path
        The file.
    given : mapping
        "spring constant" [N/m] and "sensitivity" [m/V], where they are given: needed for deflections that are no forces.

    Raises
    ------
    CurveError
        If NSFopen is not installed, the file has no curves, or a constant is missing.
    """
    try:
        from NSFopen.read import read
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs NSFopen: pip install 'flatpunch[nanosurf]'.") from None
    try:
        file = read(str(path), dataframe=False)
        ways = file.data.get("Spec", {})
        header = file.param["HeaderDump"]
        spring = file.param["Tip"].get("Prop0", {})
    # NSFopen indexes and unpacks damaged bytes unchecked: KeyError, IndexError, struct.error, ...
    except Exception:
        raise CurveError(
            f"{path.name}: NSFopen cannot read it. It is damaged, or no file of a Nanosurf microscope."
        ) from None
    unit = next(
        (h["Dim2Unit"] for h in header.values() if h.get("Dim2Name") == _DEFLECTION and "Spec" in h.get("Frame", "")),
        "",
    )
    there = ways.get("Forward", {})
    height = next((name for name in _HEIGHTS if name in there), None)
    if height is None or _DEFLECTION not in there:
        raise CurveError(
            f"{path.name}: no force curves: no channels of spectroscopy with {_DEFLECTION!r} and {_HEIGHTS[0]!r}."
        )
    factor, metadata = _factor(path, unit, spring.get("Value"), given)
    back = ways.get("Backward", {})
    for number in range(len(there[height])):
        parts = [way for way in (there, back) if number < len(way.get(_DEFLECTION, ()))]
        z, signal = ([np.asarray(way[name][number], dtype=float) for way in parts] for name in (height, _DEFLECTION))
        if len(z) > 1 and abs(z[1][-1] - z[0][-1]) < abs(z[1][0] - z[0][-1]):
            # stored in the order of the positions: the retract begins where the approach ends
            z[1], signal[1] = z[1][::-1], signal[1][::-1]
        yield (
            metadata,
            {
                "force": factor * np.concatenate(signal),
                # the position of the piezo grows towards the sample
                "height (measured)": -np.concatenate(z),
                "segment": np.repeat(np.arange(len(z)), [part.size for part in z]),
            },
        )


def _factor(path: Path, unit: str, spring: Any, given: Mapping[str, float]) -> tuple[float, Plain]:
    """Force over the channel of deflections, and the constants that it was made with."""
    k = spring if isinstance(spring, float) and spring > 0 else given.get("spring constant")
    sensitivity = given.get("sensitivity") if unit == "V" else None
    metadata = {"spring constant": k, "sensitivity": sensitivity}
    factor = {"N": 1.0, "m": k, "V": k and sensitivity and k * sensitivity}.get(unit)
    if k is None or factor is None:
        raise CurveError(
            f"{path.name}: its deflections are in {unit or 'no unit'}, with spring constant {k or 'unknown'}. Give what is "
            "missing: [curve] spring_constant = '0.05 N/m' and, for V, sensitivity = '70 nm/V' in the case file (Python: "
            "spring_constant=... [N/m], sensitivity=... [m/V])."
        )
    return factor, metadata
