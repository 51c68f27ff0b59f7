"""Numbers as the plain data that a browser takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.app.form import case_text
from flatpunch.app.problems import CALLED
from flatpunch.files import Case
from flatpunch.files.cases import case_from, parsed


def plain(values: object) -> object:
    """Return an array as nested lists of floats, None where there is no finite number; floats keep every digit."""
    array = np.asarray(values)
    if array.dtype.kind == "f":
        listed = array.tolist()
        return listed if np.isfinite(array).all() else _without_infinities(listed)
    return array.tolist()


def short(values: Array) -> object:
    """Return an array with five significant digits, for drawings."""
    array = np.asarray(values, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 10.0 ** (4 - np.floor(np.log10(np.abs(array))))
        rounded = np.where(np.isfinite(scale), np.round(array * scale) / scale, array)
    return plain(rounded)


def case_of(fields: Mapping[str, str], tab: str = "press") -> Case:
    """Return the case of a form."""
    return case_from(parsed(case_text(fields, tab), CALLED), CALLED)


def _without_infinities(value: Any) -> Any:
    if isinstance(value, list):
        return [_without_infinities(entry) for entry in value]
    return value if math.isfinite(value) else None
