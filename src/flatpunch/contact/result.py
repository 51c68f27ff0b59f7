"""Results of contacts: polar angles of their outlines, and a curve as a dataset with the record of what was solved."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import ANGLES, NUMBERS, Array, BadValue, whole
from flatpunch._support.readable import record
from flatpunch._version import __version__
from flatpunch.contact.curve import Control, Curve, uncertain
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.default import Choice
from flatpunch.contact.limits import judged
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.media.stack import TabulatedMedium

if TYPE_CHECKING:
    import xarray as xr

_VARIABLES = {
    "depth": ("m", "indentation depth"),
    "force": ("N", "normal force"),
    "radius": ("m", "mean contact radius a0"),
    "area": ("m^2", "contact area"),
    "stiffness": ("N/m", "contact stiffness dF/dd"),
}


def _why(choice: Choice) -> tuple[str, ...]:
    """A note where the default is not the fast method."""
    if choice.quick or choice.reason == "asked for":
        return ()
    return (f"Method {choice.method.name!r} was chosen, as {choice.reason}.",)


def outline_angles(angles: int, control: Control) -> Array:
    """Polar angles of the outlines, evenly spaced from 0, checked."""
    count = whole("angles", angles, 1, "It is the number of polar angles of the outline.", most=ANGLES)
    check_outlines(count, control.values.size)
    return np.asarray(np.arange(count) * (2 * np.pi / count))


def check_outlines(angles: int, steps: int) -> None:
    """Refuse results whose outlines fill the memory."""
    if angles * steps > NUMBERS:
        raise BadValue(
            "angles",
            str(angles),
            f"times {steps} steps make {angles * steps:.3g} points of outlines; {NUMBERS:.0e} are the most. Take "
            "fewer angles, or solve the steps in parts.",
        )


def result_of(
    curve: Curve, phi: Array, medium: Body, indenter: Indenter, control: Control, choice: Choice
) -> xr.Dataset:
    """A solved curve as a dataset, judged, with what was solved in its attributes."""
    curve = judged(curve, medium, indenter)
    data: dict[str, Column] = {
        name: ("step", getattr(curve, name), {"units": unit, "long_name": long_name})
        for name, (unit, long_name) in _VARIABLES.items()
    }
    touching = curve.radius > 0
    if np.isfinite(curve.contour[touching]).any() or not touching.any():
        data["contour"] = (("step", "phi"), curve.contour, {"units": "m", "long_name": "contact outline a(phi)"})
    data["valid"] = ("step", curve.valid, {"long_name": "whether the theory holds at this step"})
    for name, (dims, array, unit, long_name) in curve.extra.items():
        data[name] = (dims, array, {"units": unit, "long_name": long_name})
    coordinates = {
        "step": (np.arange(curve.depth.size), {"long_name": "step of the curve"}),
        "phi": (phi, {"units": "rad", "long_name": "polar angle"}),
    }
    attributes = {
        "title": "Indentation computed by flatpunch",
        "method": choice.method.name,
        "method_settings": json.dumps(
            {k: v for k, v in record(choice.method).items() if k not in ("type", "progress")}
        ),
        "method_reason": choice.reason,
        "control": control.name,
        "medium": json.dumps(record(medium)),
        "indenter": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
        "conventions": "SI units; pressure positive in compression; depth and gap as in the documentation",
        "notes": "\n".join((*_why(choice), *curve.notes, *uncertain(curve))),
    }
    if isinstance(medium, TabulatedMedium):
        attributes["flat_punches"] = medium.solution.summary(curve.radius / medium.length)
    return dataset(data, coordinates, attributes)
