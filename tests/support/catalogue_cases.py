"""Cases of the honesty catalogue: tips x media x sizes, drawn once with a fixed seed.

The constants of the error estimates and of the fourth order's guard were read off the first `FITTED` cases, those of
`refined` off the first `DRAWN`, what its cells do to outlines with an eye on the first `UNSEEN`. Those after them are of other
tips, media and sizes, drawn later: they test what was read off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.indenters import Ellipsoid, Rounded, Superellipse, Truncated
from flatpunch.media import GradedLayer, LinearModulus, TwoBodies

PER_TIP = 9
SIZES = (0.02, 0.1, 0.3, 1.0, 2.0, 4.0, 10.0)
"""Contact radius of the mean profile over the thickness of the layer."""


@dataclass(frozen=True)
class FourierOutline:
    """psi(phi) = 1 + sum over m = 2 .. 7 of amplitudes of random phase, at most `amplitude` in all."""

    seed: int
    amplitude: float

    def __call__(self, phi: Any) -> Any:
        rng = np.random.default_rng(self.seed)
        orders = np.arange(2, 8)
        size, phase = rng.uniform(0, 1, orders.size) / orders, rng.uniform(0, 2 * np.pi, orders.size)
        size *= self.amplitude / size.sum()
        return 1 + np.cos(np.multiply.outer(phi, orders) + phase) @ size


def ellipse(eccentricity: float) -> fp.EllipticParaboloid:
    """Level lines of the given eccentricity, A = (1 - e^2) B."""
    return fp.EllipticParaboloid(1 - eccentricity**2, 1.0)


TIPS: dict[str, Callable[[], Any]] = {
    **{f"ellipse-{e}": lambda e=e: ellipse(e) for e in (0.3, 0.5, 0.7, 0.8, 0.9, 0.95)},
    **{f"pyramid-{n}": lambda n=n: fp.Pyramid(n, 0.35) for n in (3, 4, 5, 6, 8)},
    "superellipse-2.5": lambda: Superellipse(1.0, 0.8, 0.3, 2.5, 2.0),
    "superellipse-4": lambda: Superellipse(1.0, 1.0, 0.3, 4.0, 2.0),
    "superellipse-3-pointed": lambda: Superellipse(1.0, 0.7, 0.3, 3.0, 1.0),
    "rhombus": lambda: Superellipse(1.0, 0.7, 0.3, 1.0, 1.0),
    **{
        f"fourier-{seed}": lambda seed=seed, size=size, n=n: fp.PowerLaw(n, FourierOutline(seed, size))
        for seed, (size, n) in enumerate(
            [(0.05, 2), (0.1, 2), (0.15, 2), (0.2, 2), (0.1, 1), (0.2, 1), (0.2, 1.5), (0.2, 3)]
        )
    },
    "rounded-4": lambda: Rounded(fp.Pyramid(4, 0.35), 1.0, true_sphere=False),
    "rounded-3": lambda: Rounded(fp.Pyramid(3, 0.35), 1.0, true_sphere=False),
    "truncated-4": lambda: Truncated(fp.Pyramid(4, 0.35), 0.02),
    "ellipsoid": lambda: Ellipsoid(20.0, 15.0, 12.0),
}

FRESH_TIPS: dict[str, Callable[[], Any]] = {
    **{f"ellipse-{e}": lambda e=e: ellipse(e) for e in (0.6, 0.85, 0.93)},
    "pyramid-3": lambda: fp.Pyramid(3, 0.2),
    "pyramid-4": lambda: fp.Pyramid(4, 0.5),
    "pyramid-7": lambda: fp.Pyramid(7, 0.35),
    "superellipse-3": lambda: Superellipse(1.0, 0.9, 0.3, 3.0, 2.0),
    "rhombus-0.85": lambda: Superellipse(1.0, 0.85, 0.3, 1.0, 1.0),
    "elliptic-cone-0.8": lambda: Superellipse(1.0, 0.6, 0.3, 2.0, 1.0),
    **{
        f"fourier-{seed}": lambda seed=seed, n=n: fp.PowerLaw(n, FourierOutline(seed, 0.2))
        for seed, n in ((20, 2), (21, 1), (22, 1.5))
    },
    "rounded-4-blunt": lambda: Rounded(fp.Pyramid(4, 0.5), 1.5, true_sphere=False),
    "truncated-3": lambda: Truncated(fp.Pyramid(3, 0.35), 0.03),
    "spheroid-ellipsoid": lambda: Ellipsoid(15.0, 10.0, 10.0),
}
FRESH_PER_TIP = 7

_EXPONENTS = (1.0, 1.5, 2.0, 3.0)
ASPERITIES: dict[str, Callable[[], Any]] = {
    f"asperity-{seed}": lambda seed=seed: fp.PowerLaw(
        _EXPONENTS[seed % 4], FourierOutline(seed, 0.05 + 0.15 * (seed % 7) / 6)
    )
    for seed in range(100, 156)
}
"""Random rough outlines of 5 to 20 % amplitude."""


def _on(young: float, poisson: float = 0.3) -> Callable[[], Any]:
    return lambda: fp.Medium([fp.Layer(young, poisson, 1.0)], base=fp.HalfSpace(1.0, 0.3))


MEDIA: dict[str, Callable[[], Any]] = {
    "half-space": lambda: fp.HalfSpace(1.0, 0.3),
    "incompressible": lambda: fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()),
    "compressible": lambda: fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.RigidBase()),
    "sliding": lambda: fp.Medium([fp.Layer(1.0, 0.5, 1.0, bonded=False)], base=fp.RigidBase()),
    **{f"film-{ratio:g}": _on(ratio) for ratio in (0.01, 0.1, 0.5, 2.0, 4.0, 10.0, 30.0, 100.0)},
    "soft-stiff-soft": lambda: fp.Medium(
        [fp.Layer(1.0, 0.45, 1.0), fp.Layer(20.0, 0.25, 0.5), fp.Layer(0.5, 0.4, 2.0)], base=fp.HalfSpace(5.0, 0.3)
    ),
    "stiff-soft-stiff": lambda: fp.Medium(
        [fp.Layer(3.0, 0.25, 1.0), fp.Layer(0.5, 0.4, 1.0)], base=fp.HalfSpace(10.0, 0.3)
    ),
    "graded-stiffer": lambda: fp.Medium(
        [GradedLayer(LinearModulus(1.0, 3.0, 1.0), 0.3, 1.0)], base=fp.HalfSpace(3.0, 0.3)
    ),
    "graded-softer": lambda: fp.Medium(
        [GradedLayer(LinearModulus(3.0, 1.0, 1.0), 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)
    ),
    "two-bodies": lambda: TwoBodies(fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()), fp.HalfSpace(4.0, 0.3)),
}

FRESH_MEDIA: dict[str, Callable[[], Any]] = {
    **{f"film-{ratio:g}": _on(ratio) for ratio in (0.05, 3.0, 7.0, 20.0, 50.0)},
    **{
        f"power-law-{exponent:g}": lambda exponent=exponent: fp.PowerLawHalfSpace(1.0, 1.0, exponent, 0.3)
        for exponent in (0.2, 0.5, -0.3)
    },
    "nearly-incompressible": lambda: fp.Medium([fp.Layer(1.0, 0.49, 1.0)], base=fp.RigidBase()),
    "film-2-sliding": lambda: fp.Medium([fp.Layer(2.0, 0.4, 1.0, bonded=False)], base=fp.HalfSpace(1.0, 0.3)),
}


def drawn_tip(seed: int) -> Any:
    """A tip of any kind, its parameters drawn."""
    rng = np.random.default_rng([seed, 1])
    pyramid = fp.Pyramid(int(rng.integers(3, 9)), rng.uniform(0.1, 0.6))
    kinds = (
        lambda: pyramid,
        lambda: ellipse(rng.uniform(0.4, 0.95)),
        lambda: Superellipse(1.0, rng.uniform(0.7, 1.0), 0.3, rng.uniform(1.5, 5.0), rng.choice([1.0, 1.5, 2.0])),
        lambda: Rounded(pyramid, rng.uniform(0.3, 2.0), true_sphere=False),
        lambda: Truncated(pyramid, rng.uniform(0.005, 0.05)),
        lambda: fp.PowerLaw(rng.choice([1.0, 1.5, 2.0, 3.0]), FourierOutline(seed, rng.uniform(0.05, 0.2))),
    )
    return kinds[rng.choice(len(kinds), p=[0.3, 0.2, 0.15, 0.15, 0.1, 0.1])]()


def drawn_medium(seed: int) -> Any:
    """A medium of any kind, its parameters drawn: two of three have a film or two on a half-space."""
    rng = np.random.default_rng([seed, 2])
    ratio, poisson = 10 ** rng.uniform(-2, 2), rng.uniform(0.15, 0.5)
    body, rigid = fp.HalfSpace(1.0, 0.3), fp.RigidBase()
    kinds = (
        lambda: fp.Medium([fp.Layer(ratio, poisson, 1.0)], base=body),
        lambda: fp.Medium([fp.Layer(ratio, poisson, 0.7), fp.Layer(10 ** rng.uniform(-1, 1), 0.3, 1.0)], base=body),
        lambda: fp.Medium([fp.Layer(1.0, poisson, 1.0, bonded=bool(rng.integers(2)))], base=rigid),
        lambda: fp.Medium([GradedLayer(LinearModulus(10 ** rng.uniform(-0.8, 0.8), 1.0, 1.0), 0.3, 1.0)], base=body),
        lambda: fp.PowerLawHalfSpace(1.0, 1.0, rng.uniform(-0.3, 0.6), 0.3),
    )
    return kinds[rng.choice(len(kinds), p=[0.45, 0.2, 0.2, 0.1, 0.05])]()


DRAWN_SEEDS = (*range(700, 820), *range(1100, 1220))
DRAWN_TIPS: dict[str, Callable[[], Any]] = {f"drawn-{seed}": partial(drawn_tip, seed) for seed in DRAWN_SEEDS}
DRAWN_MEDIA: dict[str, Callable[[], Any]] = {f"drawn-{seed}": partial(drawn_medium, seed) for seed in DRAWN_SEEDS}

FITTED = PER_TIP * len(TIPS)
"""Number of the first case that the series' estimates were not read off."""
LATEST = FITTED + FRESH_PER_TIP * len(FRESH_TIPS)
"""Number of the first rough asperity."""
DRAWN = LATEST + len(ASPERITIES)
"""Number of the first case that nothing was read off, but the cells' part of the outlines of `refined`."""
UNSEEN = DRAWN + 120
"""Number of the first case that nothing at all was read off."""


@dataclass(frozen=True)
class Case:
    """One contact of the catalogue."""

    number: int
    tip: str
    medium: str
    size: float

    def build(self) -> tuple[Any, Any]:
        """Medium and indenter."""
        return _medium(self.medium), _tip(self.tip, self.number >= FITTED)

    def depth(self) -> float:
        """Depth [m] at which the mean profile has the radius `size`."""
        medium, tip = self.build()
        control = Control("radius", np.array([self.size]))
        return float(mean_contact(compliance(medium), tip, control)[1].depth[0])


@lru_cache
def _medium(name: str) -> Any:
    return (MEDIA | FRESH_MEDIA | DRAWN_MEDIA)[name]()


@lru_cache
def _tip(name: str, fresh: bool) -> Any:
    return (FRESH_TIPS | ASPERITIES | DRAWN_TIPS if fresh else TIPS)[name]()


def cases() -> list[Case]:
    """The whole catalogue: every tip on nine media, each medium and size as often as any other, and three lots of fresh cases."""
    rng = np.random.default_rng(20230511)
    media, sizes = list(MEDIA), list(SIZES)
    total = FITTED
    names = np.concatenate([rng.permutation(media) for _ in range(total // len(media) + 1)])
    radii = np.concatenate([rng.permutation(sizes) for _ in range(total // len(sizes) + 1)])
    tips = [tip for tip in TIPS for _ in range(PER_TIP)]
    first = [Case(i, tip, str(names[i]), float(radii[i])) for i, tip in enumerate(tips)]
    return first + _fresh(FITTED) + _rough(LATEST) + _drawn(DRAWN)


def _fresh(first: int) -> list[Case]:
    """Other tips on other media, sizes anywhere between 0.03 and 8."""
    rng = np.random.default_rng(20261121)
    media = list(FRESH_MEDIA)
    total = FRESH_PER_TIP * len(FRESH_TIPS)
    names = np.concatenate([rng.permutation(media) for _ in range(total // len(media) + 1)])
    radii = np.round(np.exp(rng.uniform(np.log(0.03), np.log(8.0), total)), 3)
    tips = [tip for tip in FRESH_TIPS for _ in range(FRESH_PER_TIP)]
    return [Case(first + i, tip, str(names[i]), float(radii[i])) for i, tip in enumerate(tips)]


def _rough(first: int) -> list[Case]:
    """Random rough asperities, one each, on all media in turn, sizes anywhere between 0.02 and 10."""
    rng = np.random.default_rng(20261122)
    media = list(MEDIA | FRESH_MEDIA)
    names = np.concatenate([rng.permutation(media) for _ in range(len(ASPERITIES) // len(media) + 1)])
    radii = np.round(np.exp(rng.uniform(np.log(0.02), np.log(10.0), len(ASPERITIES))), 3)
    return [Case(first + i, tip, str(names[i]), float(radii[i])) for i, tip in enumerate(ASPERITIES)]


def _drawn(first: int) -> list[Case]:
    """Tips and media of which all is drawn, sizes anywhere between 0.02 and 10."""
    radii = np.round(np.exp(np.random.default_rng(20261123).uniform(np.log(0.02), np.log(10.0), len(DRAWN_SEEDS))), 3)
    return [Case(first + i, name, name, float(radii[i])) for i, name in enumerate(DRAWN_TIPS)]
