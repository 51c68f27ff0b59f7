"""Partial slip of a case with a table [slip]: `flatpunch.partial_slip` at its last step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import BadValue
from flatpunch._support.paths import Plain
from flatpunch.contact import indent, partial_slip
from flatpunch.files.cases import Case

if TYPE_CHECKING:
    import xarray as xr


def slipping(case: Case) -> xr.Dataset:
    """Pull the tip of a case along the surface, under the normal force of its last step.

    Where [slip] prescribes nothing along the surface, from full stick until the whole contact slides.
    """
    if case.slip is None:
        raise ValueError('the case has no table [slip]; write one with the coefficient of friction, "friction = 0.3".')
    last: Plain = {case.control: float(case.values[-1])}
    given = case.slip
    if len(given) == 1:
        radius = indent(case.medium, case.indenter, method="exact", angles=1, **last)["radius"].values
        given = {**given, "stick_radius": radius * np.linspace(1, 0, 41)}
    try:
        return partial_slip(case.medium, case.indenter, **last, **given)
    except BadValue as error:
        place = "slip." if error.field.partition("[")[0] in given else ""
        raise BadValue(f"{place}{error.field}", error.value, error.text) from None
