"""Families of media that can be tabulated: what their parameters are, and the medium that belongs to their values.

A medium of a family has its own length 1 and any modulus: the flat punch on the unit disc depends on beta = a/l and the
parameters alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flatpunch._support.checks import one_of
from flatpunch.atlas.panel import Parameter
from flatpunch.media import (
    Body,
    ExponentialModulus,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Medium,
    RigidBase,
)
from flatpunch.media.laws import Law

BETA_RANGE = (1e-3, 1e2)
"""Punch radius over the length of the medium, in all shipped families."""


@dataclass(frozen=True)
class Family:
    """Media that differ in a few numbers.

    Parameters
    ----------
    name : str
        As in file names and on the command line.
    title : str
        One line.
    parameters : tuple of Parameter
        None, one or two beside beta.
    make : callable
        Values of the parameters by name -> medium with own length 1 m. A function of a module.
    tolerance : float
        Tolerance of the interpolation, relative to Kbar.
    responses : bool
        Whether the second-order responses to non-round outlines are part of the table.
    beta : tuple of float
        Range of a/l.
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Body]
    tolerance: float = 1e-11
    responses: bool = False
    beta: tuple[float, float] = BETA_RANGE

    def __post_init__(self) -> None:
        low, high = self.beta
        if not 0 < low < high:
            raise ValueError(f"beta = {self.beta!r}: the range of a/l must be ascending and above zero.")
        if len(self.parameters) > 2:
            names = ", ".join(p.name for p in self.parameters)
            raise ValueError(
                f"The family {self.name!r} has {len(self.parameters)} parameters ({names}); two beside beta can be tabulated. "
                "Scale moduli and lengths out, or run a parameter study instead."
            )
        for parameter in self.parameters:
            _check(parameter)


def _check(p: Parameter) -> None:
    one_of(f"{p.name}.scale", p.scale, ("linear", "log", "upper"))
    if not -np.inf < p.low < p.high < np.inf:
        raise ValueError(f"{p.name}: the range {p.low!r} ... {p.high!r} must be finite and ascending.")
    if p.scale == "log" and p.low <= 0:
        raise ValueError(f"{p.name}: a logarithmic range begins above zero, not at {p.low!r}.")
    if p.scale == "upper" and not p.shift > 0:
        raise ValueError(f"{p.name}: the scale 'upper' needs a shift > 0.")


def bonded_coating(modulus_ratio: float, dundurs_position: float) -> Medium:
    """Layer bonded to a half-space, one of those with given Dundurs parameters."""
    alpha = (modulus_ratio - 1) / (modulus_ratio + 1)
    # shear modulus ratio mu1/mu2 = 1 + s Q with Q = 4 (1 - nu1) and 4 (1 - nu2) = modulus_ratio Q/(1 + s Q)
    s = (alpha - ((alpha - 1) / 4 + dundurs_position / 2)) * (1 + modulus_ratio) / 2
    # where the denominator is not positive every Q is admissible
    ends = [p / (modulus_ratio - s * p) if modulus_ratio > s * p else np.inf for p in (2.0, 4.0)]
    q = (max(2.0, min(ends)) + min(4.0, max(ends))) / 2
    shear = 1 + s * q
    film, base = (min(max(1 - value / 4, 0.0), 0.5) for value in (q, modulus_ratio * q / shear))
    return layer_on(HalfSpace(2 * (1 + base), base), 2 * shear * (1 + film), film)


def layer_on(base: HalfSpace | RigidBase, young: float = 1.0, poisson: float = 0.0, *, bonded: bool = True) -> Medium:
    """Homogeneous layer of thickness 1; where it slides its Poisson ratio does not matter."""
    return Medium([Layer(young, poisson, 1.0, bonded)], base=base)


def graded_coating(law: Callable[[float, float, float], Law], modulus_ratio: float, poisson: float) -> Medium:
    """Coating whose modulus falls or rises by a law to that of the half-space below."""
    layer = GradedLayer(young=law(modulus_ratio, 1.0, 1.0), poisson=poisson, thickness=1.0)
    return Medium([layer], base=HalfSpace(young=1.0, poisson=poisson))


_DUNDURS = Parameter(
    "dundurs_position",
    "(4 beta_D + 1 - alpha)/2: where Dundurs' beta lies between its limits (alpha - 1)/4 and (alpha + 1)/4",
    0.0,
    1.0,
    "upper",
    1e-2,
)
_RATIO = "E1*/E2* of the plane-strain moduli of layer and base"
_GRADED_RATIO = "Young's modulus at the surface over that of the base"
_POISSON = Parameter("poisson", "Poisson ratio nu of layer and base, constant over the depth", 0.0, 0.5, "upper", 0.03)

_COATED = 2e-9
"""Tail of the series of coatings: their parameters take more terms than those of layers."""

FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        Family(
            "bonded-layer",
            "Homogeneous layer bonded to a rigid base",
            (Parameter("poisson", "Poisson ratio nu of the layer", 0.0, 0.5, "upper", 1e-4),),
            lambda poisson: layer_on(RigidBase(), poisson=poisson),
            responses=True,
        ),
        Family(
            "sliding-layer",
            "Homogeneous layer that slides without friction on a rigid base",
            (),
            lambda: layer_on(RigidBase(), bonded=False),
            responses=True,
        ),
        Family(
            "bonded-coating",
            "Homogeneous layer bonded to a half-space",
            (
                Parameter("modulus_ratio", f"{_RATIO}; Dundurs' alpha = (E1* - E2*)/(E1* + E2*)", 1e-3, 1e3, "log"),
                _DUNDURS,
            ),
            bonded_coating,
            tolerance=_COATED,
        ),
        Family(
            "sliding-coating",
            "Homogeneous layer that slides without friction on a half-space",
            (Parameter("modulus_ratio", _RATIO, 1e-3, 1e3, "log"),),
            lambda modulus_ratio: layer_on(HalfSpace(1.0, 0.0), modulus_ratio, bonded=False),
            responses=True,
        ),
        Family(
            "linear-coating",
            "Coating with linearly varying modulus on the half-space that it ends in",
            (Parameter("modulus_ratio", _GRADED_RATIO, 0.1, 10.0, "log"), _POISSON),
            partial(graded_coating, LinearModulus),
            tolerance=_COATED,
        ),
        Family(
            "exponential-coating",
            "Coating with exponentially varying modulus on the half-space that it ends in",
            (Parameter("modulus_ratio", _GRADED_RATIO, 1e-2, 1e2, "log"), _POISSON),
            partial(graded_coating, ExponentialModulus),
            tolerance=_COATED,
        ),
    )
}
"""The shipped families; `flatpunch.atlas.library.identify` recognises their media."""
