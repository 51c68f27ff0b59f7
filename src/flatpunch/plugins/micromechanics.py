"""Films in the tables of micromechanics 1.3: the modulus of a film apart from its substrate.

micromechanics finds stiffness, contact depth and area for each depth; here the film's modulus is fitted to the same table with
the exact contact of film and substrate. It needs no import of the host.
"""

from typing import Any

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch.fits import Curve, FilmResult, Tip, fit_film
from flatpunch.media import Body, HalfSpace

_MICRO, _MILLI, _GIGA = 1e-6, 1e-3, 1e9


def tip_of(indentation: Any) -> Tip:
    """Area function, epsilon and material of an `Indentation`, whose beta is 1."""

    def area(depth: Array) -> Array:
        # the host's function changes its argument
        return np.asarray(indentation.tip.areaFunction(np.array(depth, dtype=float) / _MICRO)) * _MICRO**2

    model = indentation.model
    epsilon = float(model["beta"]) * float(model["nonMetal"])
    diamond = HalfSpace(float(model["modulusTip"]) * _GIGA, float(model["nuTip"]))
    return Tip(area, beta=1.0, epsilon=epsilon, material=diamond)


def curve_of(indentation: Any) -> Curve:
    """Depth, force and stiffness [m, N, N/m] of an analysed `Indentation`, corrected as they are there."""
    if missing := [name for name in ("h", "p", "valid", "slope", "tip", "model") if not hasattr(indentation, name)]:
        raise TypeError(
            f"indentation = {shown(indentation)} has no `{missing[0]}`; it must be an Indentation of micromechanics."
        )
    valid = indentation.valid
    if not np.any(valid) or np.size(indentation.slope) != np.count_nonzero(valid):
        raise ValueError("indentation has no stiffness; call its `analyse()` first.")
    return Curve(
        depth=indentation.h[valid] * _MICRO,
        force=indentation.p[valid] * _MILLI,
        stiffness=indentation.slope * _MILLI / _MICRO,
        name=indentation.testName or "indentation",
    )


def film(indentation: Any, medium: Body, **options: Any) -> FilmResult:
    """Fit a film to an analysed indentation.

    Parameters
    ----------
    indentation : micromechanics.indentation.Indentation
        After `analyse()`: with stiffness, and its area function calibrated.
    medium : Medium
        Film and substrate: known values, and starting values.
    **options
        `free`, `depths`, `frame` and `compare` of `flatpunch.fits.fit_film`.

    Returns
    -------
    FilmResult
        `result["layers[0].young"]` is the film's modulus [Pa].
    """
    return fit_film(curve_of(indentation), medium, tip_of(indentation), **options)
