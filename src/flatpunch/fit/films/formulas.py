"""What published formulas make of the stiffness of a film: the same points, the same tip, another equivalent modulus."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.films.oliver_pharr import OliverPharr, Tip
from flatpunch.fit.half_space import published
from flatpunch.fit.least_squares.minimum import minimise
from flatpunch.media import HalfSpace, Layer, Medium

_STEP = 1e-5
"""Step of central differences over logarithms of moduli."""
Law = Callable[[OliverPharr, float, float], Array]


def _poisson(fitted: Medium) -> float:
    """Poisson ratio of an isotropic film."""
    (film,) = fitted.layers
    assert isinstance(film, Layer)
    return film.poisson


def _laws(fitted: Medium) -> dict[str, tuple[Law, bool]]:
    """Equivalent plane-strain moduli by published formulas over (points, film modulus, alpha), and whether alpha is fitted."""
    base = fitted.base
    assert isinstance(base, HalfSpace)
    t, nu, substrate = fitted.length, _poisson(fitted), base.surface_modulus
    return {
        "Gao": (lambda p, e, _: published.gao(p.radius / t, e, substrate, nu), False),
        "Perriot-Barthel": (lambda p, e, _: published.perriot_barthel(p.radius / t, e, substrate), False),
        "Bec": (lambda p, e, _: published.bec(p.radius, e, substrate, t), False),
        "King": (lambda p, e, alpha: published.king(p.radius / t, e, substrate, alpha), True),
        "Saha-Nix": (
            lambda p, e, alpha: published.king(
                p.radius / np.maximum(t - p.contact_depth, 1e-3 * t), e, substrate, alpha
            ),
            True,
        ),
    }


def by_formulas(points: OliverPharr, tip: Tip, fitted: Medium) -> dict[str, tuple[float, float]]:
    """Film modulus [Pa] and rms relative misfit of the stiffness by each formula; King's with its exponent fitted as well.

    The search begins at the modulus of `fitted`. The modulus is nan where the points do not determine it: film and substrate
    that hardly differ fit with any modulus if the exponent makes the film vanish.
    """
    nu = _poisson(fitted)
    results = {}
    for name, (law, alpha_free) in _laws(fitted).items():

        def residual(x: Array, law: Law = law) -> Array:
            modulus = np.maximum(law(points, float(np.exp(x[0])), float(np.exp(x[-1]))), 1.0)
            reduced = 1 / (1 / modulus + 1 / tip.material.surface_modulus)
            return np.asarray(np.log(2 * tip.beta * points.radius * reduced / points.stiffness))

        start = np.array([np.log(fitted.surface_modulus), *([0.0] if alpha_free else [])])
        found = minimise(differentiated(residual), start, start - 5, start + 5)
        young = float("nan") if found.at_bound.any() else float(np.exp(found.x[0])) * (1 - nu**2)
        results[name] = (young, float(np.sqrt(np.mean(found.residual**2))))
    return results


def differentiated(residual: Callable[[Array], Array]) -> Callable[[Array], tuple[Array, Array]]:
    """Residuals with derivatives by central differences."""

    def evaluate(x: Array) -> tuple[Array, Array]:
        steps = _STEP * np.eye(x.size)
        return residual(x), np.array([(residual(x + s) - residual(x - s)) / (2 * _STEP) for s in steps])

    return evaluate
