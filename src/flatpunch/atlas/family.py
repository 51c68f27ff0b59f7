"""Families of media: what their parameters are, and the medium that belongs to their values.

A medium of a family has its own length 1 and any modulus: the flat punch on the unit disc depends on beta = a/l and the
parameters alone. How many parameters there are is a matter of elasticity, not of taste: per wavenumber the layer is in plane
strain, so that one bonded layer on a half-space knows its elastic constants through Dundurs' two parameters only (T2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from flatpunch._support.checks import ROUNDING, Array
from flatpunch._support.readable import readable
from flatpunch.atlas.parameter import Parameter
from flatpunch.compliance.layered import constants_of
from flatpunch.media import (
    AnyLayer,
    Base,
    Body,
    ExponentialModulus,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Material,
    Medium,
    RigidBase,
)
from flatpunch.media.laws import Law
from flatpunch.media.material import young_and_poisson

L = TypeVar("L", Layer, GradedLayer)
S = TypeVar("S", HalfSpace, RigidBase)

BETA_RANGE = (1e-3, 1e2)
"""Punch radius over the length of the medium, in all shipped families."""

_RATIO = "E1*/E2* of the plane-strain moduli of layer and base; Dundurs' alpha = (E1* - E2*)/(E1* + E2*)"


@readable
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
    identify : callable or None
        Medium -> values of the parameters, or None if it is of another kind; ranges are not checked.
    tolerance : float
        Tolerance of the interpolation, relative to Kbar.
    responses : bool
        Whether the second-order responses to non-round outlines are part of the table.
    beta : tuple of float
        Range of a/l.

    See Also
    --------
    flatpunch.atlas.Parameter : What its media differ in.
    flatpunch.atlas.table : The table of a shipped one.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> def soft_on_stiffer(ratio):
    ...     layer = fp.Layer(young=ratio, poisson=0.5, thickness=1.0)
    ...     return fp.Medium([layer], base=fp.HalfSpace(young=1.0, poisson=0.5))
    >>> ratio = atlas.Parameter("ratio", "E1/E2", 0.3, 3.0, "log")
    >>> family = atlas.Family("gel-on-gel", "Two incompressible gels", (ratio,), soft_on_stiffer, beta=(0.5, 2.0))
    >>> print(family.make(ratio=2.0).layers[0].young)
    2.0
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Body]
    identify: Callable[[Body], Mapping[str, float] | None] | None = None
    tolerance: float = 1e-11
    responses: bool = False
    beta: tuple[float, float] = BETA_RANGE

    def __post_init__(self) -> None:
        low, high = self.beta
        if not 0 < low < high:
            raise ValueError(f"beta = {self.beta!r}: the range of a/l must be ascending and begin above zero.")
        if len(self.parameters) > 2:
            names = ", ".join(p.name for p in self.parameters)
            raise ValueError(
                f"The family {self.name!r} has {len(self.parameters)} parameters ({names}); two beside beta can be tabulated. "
                "Scale moduli and lengths out, or run a parameter study instead."
            )

    def values(self, given: Mapping[str, float | Array]) -> tuple[Array, ...]:
        """Values of the parameters in their order, with a clear message for names that are missing or unknown."""
        names = [p.name for p in self.parameters]
        unknown, missing = sorted(set(given) - set(names)), [name for name in names if name not in given]
        if unknown or missing:
            what = f"does not know {', '.join(unknown)}" if unknown else f"needs {', '.join(missing)}"
            raise TypeError(
                f"The family {self.name!r} {what}: its parameters are {', '.join(names) or 'none'} (and beta)."
            )
        return tuple(p.check(given[p.name]) for p in self.parameters)


def bonded_layer(poisson: float) -> Medium:
    """Layer bonded to a rigid base."""
    return Medium([Layer(young=1.0, poisson=poisson, thickness=1.0)], base=RigidBase())


def sliding_layer() -> Medium:
    """Layer that slides on a rigid base; its Poisson ratio does not matter."""
    return Medium([Layer(young=1.0, poisson=0.0, thickness=1.0, bonded=False)], base=RigidBase())


def bonded_coating(modulus_ratio: float, dundurs_position: float) -> Medium:
    """Layer bonded to a half-space, one of those with given Dundurs parameters."""
    alpha = (modulus_ratio - 1) / (modulus_ratio + 1)
    # shear modulus ratio mu1/mu2 = 1 + s Q with Q = 4 (1 - nu1) and 4 (1 - nu2) = modulus_ratio Q/(1 + s Q)
    s = (alpha - dundurs_beta(alpha, dundurs_position)) * (1 + modulus_ratio) / 2
    # where the denominator is not positive every Q is admissible
    ends = [p / (modulus_ratio - s * p) if modulus_ratio > s * p else np.inf for p in (2.0, 4.0)]
    q = (max(2.0, min(ends)) + min(4.0, max(ends))) / 2
    shear = 1 + s * q
    film, base = (min(max(1 - value / 4, 0.0), 0.5) for value in (q, modulus_ratio * q / shear))
    return Medium(
        [Layer(young=2 * shear * (1 + film), poisson=film, thickness=1.0)],
        base=HalfSpace(young=2 * (1 + base), poisson=base),
    )


def dundurs_beta(alpha: float, position: float) -> float:
    """Dundurs' beta at a position between 0 and 1 in its admissible interval (alpha - 1)/4 ... (alpha + 1)/4."""
    return (alpha - 1) / 4 + position / 2


def sliding_coating(modulus_ratio: float) -> Medium:
    """Layer that slides on a half-space."""
    layer = Layer(young=modulus_ratio, poisson=0.0, thickness=1.0, bonded=False)
    return Medium([layer], base=HalfSpace(young=1.0, poisson=0.0))


def linear_coating(modulus_ratio: float, poisson: float) -> Medium:
    """Coating whose modulus falls or rises linearly to that of the half-space below."""
    return _graded_coating(LinearModulus(modulus_ratio, 1.0, 1.0), poisson)


def exponential_coating(modulus_ratio: float, poisson: float) -> Medium:
    """Coating whose modulus falls or rises exponentially to that of the half-space below."""
    return _graded_coating(ExponentialModulus(modulus_ratio, 1.0, 1.0), poisson)


def _graded_coating(law: Law, poisson: float) -> Medium:
    layer = GradedLayer(young=law, poisson=poisson, thickness=1.0)
    return Medium([layer], base=HalfSpace(young=1.0, poisson=poisson))


def find_bonded_layer(medium: Body) -> Mapping[str, float] | None:
    """Parameters of a layer bonded to a rigid base."""
    found = _only_isotropic(medium, rigid=True, bonded=True)
    return None if found is None else {"poisson": constants_of(found[0])[1]}


def find_sliding_layer(medium: Body) -> Mapping[str, float] | None:
    """Parameters, none, of a layer that slides on a rigid base."""
    return None if _only_isotropic(medium, rigid=True, bonded=False) is None else {}


def find_bonded_coating(medium: Body) -> Mapping[str, float] | None:
    """Parameters of a layer bonded to a half-space."""
    found = _only_isotropic(medium, rigid=False, bonded=True)
    if found is None:
        return None
    layer, base = found
    alpha, beta = dundurs(layer, base)
    return {
        "modulus_ratio": layer.surface_modulus / base.surface_modulus,
        "dundurs_position": 2 * beta - (alpha - 1) / 2,
    }


def find_sliding_coating(medium: Body) -> Mapping[str, float] | None:
    """Parameters of a layer that slides on a half-space."""
    found = _only_isotropic(medium, rigid=False, bonded=False)
    return None if found is None else {"modulus_ratio": found[0].surface_modulus / found[1].surface_modulus}


def find_linear_coating(medium: Body) -> Mapping[str, float] | None:
    """Parameters of a linear coating on a matching half-space."""
    return _find_graded(medium, LinearModulus)


def find_exponential_coating(medium: Body) -> Mapping[str, float] | None:
    """Parameters of an exponential coating on a matching half-space."""
    return _find_graded(medium, ExponentialModulus)


def _find_graded(medium: Body, law: type) -> Mapping[str, float] | None:
    found = _only_layer(medium, rigid=False, bonded=True)
    if found is None:
        return None
    layer, base = found
    if not isinstance(layer, GradedLayer) or layer.anisotropic or not isinstance(layer.young, law):
        return None
    young, poisson = young_and_poisson(base)
    top, bottom = layer.young_at(np.array([0.0, layer.thickness]))
    ends = layer.poisson_at(np.linspace(0.0, layer.thickness, 10))
    if not np.isclose(bottom, young, rtol=ROUNDING) or np.abs(ends - poisson).max() > ROUNDING:
        return None
    # a law may end below the layer; then the layer holds a part of it only, which is again a law of the same kind
    return {"modulus_ratio": float(top / bottom), "poisson": float(poisson)}


def dundurs(film: Material, base: Material) -> tuple[float, float]:
    """Dundurs' parameters (alpha, beta) of two bonded materials [-].

    alpha = (E1* - E2*)/(E1* + E2*), beta = (1/2)(mu1 (1 - 2 nu2) - mu2 (1 - 2 nu1))/(mu1 (1 - nu2) + mu2 (1 - nu1)), with 1 the
    film (Dundurs 1969).

    See Also
    --------
    flatpunch.atlas.tabulated : Coatings by these parameters.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> film = fp.Layer(young=200e9, poisson=0.2, thickness=1e-6)
    >>> alpha, beta = atlas.dundurs(film, fp.HalfSpace(young=70e9, poisson=0.3))
    >>> print(f"{alpha:.3f} {beta:.3f}")
    0.461 0.108
    """
    (mu1, nu1), (mu2, nu2) = constants_of(film), constants_of(base)
    below = mu1 * (1 - nu2) + mu2 * (1 - nu1)
    alpha = (film.surface_modulus - base.surface_modulus) / (film.surface_modulus + base.surface_modulus)
    return alpha, (mu1 * (1 - 2 * nu2) - mu2 * (1 - 2 * nu1)) / (2 * below)


def _only_layer(medium: Body, *, rigid: bool, bonded: bool) -> tuple[AnyLayer, Base] | None:
    """Layer and base of a medium with this one layer on a rigid base or an isotropic half-space, or None."""
    stack = medium.single
    if not stack or len(stack.layers) != 1 or not (stack.base.rigid if rigid else stack.base.isotropic):
        return None
    layer = stack.layers[0]
    return (layer, stack.base) if layer.bonded == bonded else None


def _only_isotropic(medium: Body, *, rigid: bool, bonded: bool) -> tuple[AnyLayer, Base] | None:
    """The same of one isotropic layer that does not vary."""
    found = _only_layer(medium, rigid=rigid, bonded=bonded)
    return found if found and found[0].isotropic else None


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
            bonded_layer,
            find_bonded_layer,
            responses=True,
        ),
        Family(
            "sliding-layer",
            "Homogeneous layer that slides without friction on a rigid base",
            (),
            sliding_layer,
            find_sliding_layer,
            responses=True,
        ),
        Family(
            "bonded-coating",
            "Homogeneous layer bonded to a half-space",
            (
                Parameter("modulus_ratio", _RATIO, 1e-3, 1e3, "log"),
                Parameter(
                    "dundurs_position",
                    "(4 beta_D + 1 - alpha)/2: where Dundurs' beta lies between its limits (alpha - 1)/4 and (alpha + 1)/4",
                    0.0,
                    1.0,
                    "upper",
                    1e-2,
                ),
            ),
            bonded_coating,
            find_bonded_coating,
            tolerance=_COATED,
        ),
        Family(
            "sliding-coating",
            "Homogeneous layer that slides without friction on a half-space",
            (Parameter("modulus_ratio", "E1*/E2* of the plane-strain moduli of layer and base", 1e-3, 1e3, "log"),),
            sliding_coating,
            find_sliding_coating,
            responses=True,
        ),
        Family(
            "linear-coating",
            "Coating with linearly varying modulus on the half-space that it ends in",
            (
                Parameter("modulus_ratio", "Young's modulus at the surface over that of the base", 0.1, 10.0, "log"),
                _POISSON,
            ),
            linear_coating,
            find_linear_coating,
            tolerance=_COATED,
        ),
        Family(
            "exponential-coating",
            "Coating with exponentially varying modulus on the half-space that it ends in",
            (
                Parameter("modulus_ratio", "Young's modulus at the surface over that of the base", 1e-2, 1e2, "log"),
                _POISSON,
            ),
            exponential_coating,
            find_exponential_coating,
            tolerance=_COATED,
        ),
    )
}
"""The shipped families; power-law half-spaces need no table, see `flatpunch.atlas.closed`."""
