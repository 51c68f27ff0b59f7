"""Random curves as laboratories record them: offset, tilt, noise, contact position, layout of segments, size of the sample.

Every kind has a truth that all its curves share; the force of a case is solved once and interpolated (cubic, on a grid fine
enough for 1e-6), so that hundreds of curves cost little.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from flatpunch.contact import indent, pull_off
from flatpunch.contact.physics import Physics
from flatpunch.fits import Curve
from flatpunch.indenters import Paraboloid, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, PowerLawRelaxation, RigidBase, StandardLinearSolid


@dataclass(frozen=True)
class Kind:
    """What is measured: the truth, where a fit starts, and what it looks for."""

    truth: Any
    start: Any
    tip: Any
    deepest: float
    free: tuple[str, ...]
    spring: float | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Any] = field(default_factory=dict)


GEL, BEAD = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase()), Sphere(3e-6)
START = Medium([Layer(2e3, 0.5, 1e-6)], RigidBase())
FILM, FILM_START = (Medium([Layer(young, 0.35, 1e-6)], HalfSpace(2e9, 0.3)) for young in (8e9, 3e9))
YOUNG = ("layers[0].young",)

KINDS = {
    "bead on gel": Kind(GEL, START, BEAD, 0.4e-6, YOUNG),
    "pyramid on film": Kind(FILM, FILM_START, Pyramid(4, 0.35), 0.2e-6, YOUNG),
    "bead on half-space": Kind(HalfSpace(2e3, 0.5), HalfSpace(1e3, 0.5), Paraboloid(5e-6), 0.4e-6, ("base.young",)),
    "soft cantilever": Kind(GEL, START, BEAD, 0.4e-6, YOUNG, spring=0.02),
    "stiff cantilever": Kind(GEL, START, BEAD, 0.4e-6, YOUNG, spring=0.3),
    "modulus and thickness": Kind(GEL, START, BEAD, 0.6e-6, ("layers[0].young", "layers[0].thickness")),
    "sticking bead": Kind(
        GEL,
        START,
        BEAD,
        0.3e-6,
        ("layers[0].young", "work_of_adhesion"),
        more={"work_of_adhesion": 1e-4},
        settings={"work_of_adhesion": 3e-5},
    ),
    "sticking, cantilever": Kind(
        GEL,
        START,
        BEAD,
        0.3e-6,
        ("layers[0].young", "work_of_adhesion"),
        spring=0.05,
        more={"work_of_adhesion": 1e-4},
        settings={"work_of_adhesion": 3e-5},
    ),
    "relaxing solid": Kind(
        GEL,
        START,
        BEAD,
        0.3e-6,
        ("layers[0].young", "relaxation.equilibrium", "relaxation.time"),
        more={"relaxation": StandardLinearSolid(0.4, 0.5)},
        settings={"relaxation": StandardLinearSolid(0.6, 1.0)},
    ),
    "relaxing power law": Kind(
        GEL,
        START,
        BEAD,
        0.3e-6,
        ("layers[0].young", "relaxation.exponent"),
        more={"relaxation": PowerLawRelaxation(0.15, 1.0)},
        settings={"relaxation": PowerLawRelaxation(0.3, 1.0)},
    ),
}


def truth(kind: Kind) -> dict[str, float]:
    """True values of what is free."""
    from flatpunch.fits import Sample

    sample = Sample(kind.truth, kind.tip, Physics(**kind.more))
    return {name: sample.value(name) for name in kind.free}


def laboratory_curve(kind: Kind, rng: np.random.Generator, *, tilted: bool = True) -> Curve:
    """One curve of a kind."""
    if "relaxation" in kind.more:
        return _disturbed(kind, rng, *_history(kind, rng), tilted=tilted)
    if "work_of_adhesion" in kind.more:
        return _disturbed(kind, rng, *_cycle(kind, rng), tilted=tilted)
    return _disturbed(kind, rng, *_approach(kind, rng), tilted=tilted)


def _disturbed(
    kind: Kind, rng: np.random.Generator, way: Any, force: Any, time: Any, segment: Any, *, tilted: bool
) -> Curve:
    """Noise, offset and tilt of the force, an offset of the position; the tilt moves no tip."""
    rise = float(force.max())
    noise = rise * 10 ** rng.uniform(-2.6, -1.7) * rng.normal(size=force.size)
    offset = rise * rng.uniform(-3, 3)
    tilt = rise * rng.uniform(-0.3, 0.3) * (way - way.min()) / np.ptp(way) if tilted else 0.0
    shift = kind.deepest * rng.uniform(-5, 5)
    read = force + noise + offset + tilt
    more = {"time": time, "segment": segment if rng.random() < 0.5 else None}
    if kind.spring is None:
        return Curve(way + shift, read, **more)
    return Curve.from_piezo(way + shift, read, kind.spring, **more)


_SOLVED: dict[str, Any] = {}


def _force_over_way(kind: Kind) -> CubicSpline:
    """Force over the position of the cantilever's base (of the tip without one), zero before the contact."""
    key = repr((kind.truth, kind.tip, kind.deepest, kind.spring))
    if key not in _SOLVED:
        power = 1.5 if kind.tip.exponent is None else 1 + 1 / kind.tip.exponent
        depth = kind.deepest * np.linspace(0, 1.02, 1200)[1:] ** 2
        force = indent(kind.truth, kind.tip, depth=depth, angles=8)["force"].values
        way = depth if kind.spring is None else depth + force / kind.spring
        # what is interpolated is smooth down to the contact
        smooth = CubicSpline(way, force / way**power)
        last = float(np.interp(kind.deepest, depth, way))
        _SOLVED[key] = (smooth, power, last)
    return _SOLVED[key]


def _loaded(kind: Kind, way: Any) -> Any:
    smooth, power, _ = _force_over_way(kind)
    touching = way > 0
    force = np.zeros(way.size)
    force[touching] = smooth(way[touching]) * way[touching] ** power
    return force


def _approach(kind: Kind, rng: np.random.Generator) -> tuple[Any, Any, Any, Any]:
    """Approach alone, or with a pause, a retract, or both; unequal numbers of points."""
    last = _force_over_way(kind)[2]
    up = np.linspace(-rng.uniform(0.3, 2.0) * last, last, int(rng.integers(400, 2000)))
    pause = np.full(int(rng.integers(20, 300)), last)
    back = np.linspace(last, up[0], int(rng.integers(300, 1500)))
    parts = ([up], [up, back], [up, pause, back], [up, pause])[int(rng.integers(4))]
    forces = [_loaded(kind, part) * (1.0 if i == 0 else 0.95) for i, part in enumerate(parts)]
    segment = np.repeat(np.arange(len(parts)), [part.size for part in parts])
    return np.concatenate(parts), np.concatenate(forces), None, segment


def _cycle(kind: Kind, rng: np.random.Generator) -> tuple[Any, Any, Any, Any]:
    """Jump into contact at depth 0, stick until the cantilever (or the last depth) lets go."""
    key = repr((kind.truth, kind.tip, kind.deepest, kind.spring, kind.more))
    if key not in _SOLVED:
        lost = pull_off(kind.truth, kind.tip, **kind.more).depth_minimum.depth
        depth = np.linspace(lost * (1 - 1e-6), kind.deepest, 3000)
        force = indent(kind.truth, kind.tip, depth=depth, angles=8, **kind.more)["force"].values
        way = depth if kind.spring is None else depth + force / kind.spring
        _SOLVED[key] = (way, force)
    way, force = _SOLVED[key]
    snap = int(np.argmin(way))
    far = way[snap] - rng.uniform(0.6, 1.5) * (way[-1] - way[snap])
    up, back = (np.linspace(far, way[-1], int(rng.integers(250, 800))) for _ in range(2))
    pressed, stuck = (
        np.where(w >= edge, np.interp(w, way[snap:], force[snap:]), 0.0) for w, edge in ((up, 0.0), (back, way[snap]))
    )
    segment = np.repeat([0, 1], [up.size, back.size])
    return np.concatenate([up, back[::-1]]), np.concatenate([pressed, stuck[::-1]]), None, segment


def _history(kind: Kind, rng: np.random.Generator) -> tuple[Any, Any, Any, Any]:
    """Ramp, hold and retract of random speeds."""
    start = -rng.uniform(0.4, 1.0)
    ramp, hold, back = rng.uniform(0.2, 0.6), rng.uniform(1.5, 4.0), rng.uniform(0.3, 1.0)
    corners = np.cumsum([0, ramp * -start, ramp, hold, back])
    time = np.linspace(0, corners[-1], int(rng.integers(400, 900)))
    depth = np.interp(time, corners, kind.deepest * np.array([start, 0, 1, 1, start]))
    force = indent(kind.truth, kind.tip, time=time, depth=depth, angles=8, **kind.more)["force"].values
    segment = np.searchsorted(corners[2:4], time, side="right")
    return depth, force, time, segment
