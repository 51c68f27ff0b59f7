"""Series methods under tips that are not round: derivatives of their own curves.

The second and fourth order have no pressure of their own on the true contact, but their force, radius and stiffness are analytic
in all numbers of medium and tip and computed to rounding. Differences of order eight lose nothing then. Their distance to those
of order six is the error estimate; it is large beside kinks of the tip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch._support.paths import Plain
from flatpunch.contact.curve import FEW_ANGLES, Control, percent
from flatpunch.contact.indentation import indent
from flatpunch.contact.methods import FourthOrder, SecondOrder
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.media.paths import with_values
from flatpunch.sensitivities.parameters import Parameter, difference, difference_and_error
from flatpunch.sensitivities.round import Contact

if TYPE_CHECKING:
    import xarray as xr

Series = SecondOrder | FourthOrder

_STEP = 1e-2
"""Step over the number itself: truncation and rounding are then below 1e-11 of an analytic curve of order one."""


@dataclass(frozen=True, slots=True)
class SeriesContacts:
    """Contacts of a curve and their derivatives.

    Attributes
    ----------
    contacts : list of Contact
    force, stiffness, radius : ndarray, shape (n, parameters)
        Derivatives at fixed depth.
    valid : list of bool
        Of each contact, as of `indent`.
    notes : str
    """

    contacts: list[Contact]
    force: Array
    stiffness: Array
    radius: Array
    valid: list[bool]
    notes: str


def series_contacts(
    medium: Body, indenter: Indenter, control: Control, method: Series, wanted: list[Parameter]
) -> SeriesContacts:
    """Solve a curve and differentiate it at fixed depths."""
    given: Plain = {control.name: control.values}
    curve = indent(medium, indenter, method=method, angles=FEW_ANGLES, **given)
    depth = curve["depth"].values

    def at(medium_: Body, indenter_: Indenter, scale: float = 1.0) -> Array:
        found = indent(medium_, indenter_, depth=scale * depth, method=method, angles=FEW_ANGLES)
        return np.array([found[name].values for name in ("force", "stiffness", "radius")])

    force, stiffness, radius = (curve[name].values for name in ("force", "stiffness", "radius"))
    _, bend, growing = difference(lambda s: at(medium, indenter, s), 1.0, _STEP) / depth
    contacts = [
        Contact(*map(float, row[:4]), *((1 / row[5], row[4] / row[5]) if row[5] else (np.inf, 0.0)))
        for row in zip(radius, depth, force, stiffness, bend, growing, strict=True)
    ]
    slopes, errors = np.empty((2, len(wanted), 3, depth.size))
    for j, each in enumerate(wanted):

        def changed(value: float, name: str = each.path) -> Array:
            return at(*with_values(medium, indenter, {name: value}))

        slopes[j], errors[j] = difference_and_error(changed, each.value, _STEP * (abs(each.value) or 1.0))
    columns = slopes.transpose(1, 2, 0)
    notes = [*str(curve.attrs["notes"]).splitlines(), *_notes(curve, method, wanted, slopes[:, 0], errors[:, 0])]
    return SeriesContacts(
        contacts, columns[0], columns[1], columns[2], curve["valid"].values.tolist(), "\n".join(notes)
    )


def _notes(curve: xr.Dataset, method: Series, wanted: list[Parameter], slopes: Array, errors: Array) -> list[str]:
    """How good the derivatives of the force are."""
    own = percent(float(curve["force_error"].max()))
    notes = [
        f"Derivatives are those of the {method.name} curve, which expects its forces within {own}; those of the true contact "
        "differ by about as much."
    ]
    if wanted:
        unit = np.array([abs(each.value) or 1.0 for each in wanted])[:, None]
        share = (errors * unit).max() / max(float(np.abs(slopes * unit).max()), TINY)
        if share > 1e-6:
            notes.append(
                f"By differences, derivatives are known to {share:.1g} of the largest: a kink of the tip is near."
            )
    return notes
