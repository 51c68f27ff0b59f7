"""Curves of known modulus with one fault each: four geometries, with and without a cantilever, either sign of depth and force.

Every fault has its place and size by chance, from the first to the last reading. The force of a geometry is solved once and
interpolated, good to 1e-4.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.signal import lfilter

from flatpunch.contact import indent
from flatpunch.fits import Curve
from flatpunch.indenters import Cone, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

YOUNG, START = 3e3, 1e3
DEEP = 5e-7
"""Depth of the deepest reading [m]."""


def layer(young: float) -> Medium:
    """A layer of 1.5 um on glass."""
    return Medium([Layer(young, 0.5, 1.5e-6)], RigidBase())


def bulk(young: float) -> HalfSpace:
    """A half-space."""
    return HalfSpace(young, 0.5)


GEOMETRIES = {
    "sphere": (bulk, Sphere(4e-6), "base.young"),
    "sphere on a layer": (layer, Sphere(4e-6), "layers[0].young"),
    "cone": (bulk, Cone(0.4), "base.young"),
    "cone on a layer": (layer, Cone(0.4), "layers[0].young"),
}


@cache
def _solved(name: str) -> tuple[Any, Any]:
    medium, tip, _ = GEOMETRIES[name]
    depth = np.geomspace(1e-5, 1.3, 150) * DEEP
    return np.log(depth), np.log(indent(medium(YOUNG), tip, depth=depth, angles=8).force.values)


def load(name: str, depth: Any) -> Any:
    """Force of a geometry at depths, zero before the contact [N]."""
    depth = np.asarray(depth, dtype=float)
    return np.where(depth > 0, np.exp(np.interp(np.log(np.maximum(depth, 1e-5 * DEEP)), *_solved(name))), 0.0)


@dataclass
class Record:
    """A record while it is made: base and force over DEEP's force, readings of the approach in contact from `touch` on."""

    rng: np.random.Generator
    base: Any
    force: Any
    touch: int
    shape: Callable[[Any], Any]
    """Force over base positions, of a contact at 0."""
    step: float = 0.0
    """Of a converter, over which what is measured is rounded."""

    def inside(self, low: float, high: float) -> int:
        """A reading of the approach between two shares of the way in contact."""
        return self.touch + int(self.rng.uniform(low, high) * (self.base.size - self.touch))

    def append(self, base: Any, force: Any) -> None:
        """Go on with further readings."""
        self.base, self.force = np.append(self.base, base), np.append(self.force, force)

    def retract(self) -> None:
        """Go back with a hysteresis, as the sample gives back less than was put in."""
        back = np.linspace(self.base[-1], self.base[0], int(0.8 * self.base.size))
        self.append(back, self.force[-1] * (self.shape(back) / self.shape(back[:1])) ** 1.2)


def _drop(r: Record, low: float = 0.3) -> None:
    at, size = r.inside(low, 0.97), 10 ** r.rng.uniform(-1.7, -0.3)
    r.force[at:] = np.maximum(r.force[at:] - size * r.force[at], 0)


def _drops(r: Record) -> None:
    _drop(r, 0.3)
    _drop(r, 0.7)


def _breakthrough(r: Record) -> None:
    at = r.inside(0.4, 0.8)
    r.force[at:] = r.shape(r.base[at:] - r.base[at])


def _saturation(r: Record) -> None:
    r.force = np.minimum(r.force, r.rng.uniform(0.3, 0.95) * r.force.max())


def _yield(r: Record) -> None:
    at = r.inside(0.4, 0.8)
    r.force[at:] = r.force[at] + r.rng.uniform(0.2, 0.7) * (r.force[at:] - r.force[at])


def _held_load(r: Record) -> None:
    gone = 1 - np.exp(-np.linspace(0, 3, r.inside(0.1, 0.9) - r.touch))
    r.append(r.base[-1] + r.rng.uniform(0.02, 0.15) * r.base[-1] * gone, np.full(gone.size, r.force[-1]))


def _withdrawn_load(r: Record) -> None:
    along = np.linspace(0, 1, r.inside(0.1, 0.9) - r.touch)
    r.append(r.base[-1] * (1 + 0.05 * along), r.force[-1] * (1 - r.rng.uniform(0.1, 0.6) * along))


def _held_position(r: Record) -> None:
    gone = 1 - np.exp(-np.linspace(0, 3, r.inside(0.1, 0.9) - r.touch))
    r.append(np.full(gone.size, r.base[-1]), r.force[-1] * (1 - r.rng.uniform(0.05, 0.4) * gone))
    r.retract()


def _burst(r: Record) -> None:
    count = int(r.rng.integers(3, 12))
    at = int(r.rng.integers(0, r.force.size - count))
    r.force[at : at + count] += r.rng.choice([-1, 1]) * r.rng.uniform(0.2, 2) + 0.1 * r.rng.normal(size=count)


def _single(r: Record) -> None:
    for at in {int(r.rng.integers(r.force.size)), int(r.rng.choice([0, r.force.size - 1]))}:
        r.force[at] += r.rng.choice([-1, 1]) * r.rng.uniform(0.2, 5)


def _bad_end(r: Record) -> None:
    r.retract()
    r.force[-1] -= r.rng.uniform(1, 3)
    r.base[-1] += r.rng.choice([-1, 1]) * r.rng.uniform(0.2, 2) * np.ptp(r.base)


def _back_first(r: Record) -> None:
    back = r.base[0] - r.rng.uniform(0.005, 0.1) * np.ptp(r.base) * np.sin(np.linspace(0, np.pi, 40))
    r.base, r.force, r.touch = np.append(back, r.base), np.append(np.zeros(40), r.force), r.touch + 40


def _tilt(r: Record) -> None:
    r.force = r.force + r.rng.uniform(-1, 1) * (r.base - r.base[0]) / np.ptp(r.base)


def _steps(r: Record) -> None:
    r.step = r.rng.uniform(0.01, 0.08)


def _slow_noise(r: Record) -> None:
    memory = r.rng.uniform(0.7, 0.95)
    white = r.rng.normal(size=r.force.size + 200)
    r.force = r.force + 0.01 * lfilter([np.sqrt(1 - memory**2)], [1, -memory], white)[200:]


def _nothing(_: Record) -> None:
    """A sound curve."""


FAULTS: dict[str, Callable[[Record], None]] = {
    "none": _nothing,
    "drop": _drop,
    "drops": _drops,
    "breakthrough": _breakthrough,
    "saturation": _saturation,
    "yield": _yield,
    "held load": _held_load,
    "withdrawn load": _withdrawn_load,
    "held position": _held_position,
    "burst": _burst,
    "single readings": _single,
    "bad end": _bad_end,
    "goes back first": _back_first,
    "tilt": _tilt,
    "steps of a converter": _steps,
    "slow noise": _slow_noise,
    "few readings": _nothing,
    "short baseline": _nothing,
    "long approach": _nothing,
}


def faulty(fault: str, seed: int) -> tuple[Curve, Any, Any, str]:
    """A curve with a fault, the sample where a fit starts, its tip and the name of the modulus."""
    rng = np.random.default_rng([list(FAULTS).index(fault), seed])
    name = list(GEOMETRIES)[seed % 4]
    medium, tip, free = GEOMETRIES[name]
    top = float(load(name, DEEP))
    # soft cantilevers bend as far as the tip goes in
    spring = top / DEEP * rng.uniform(0.3, 3) * 10 ** rng.uniform(0, 1) if seed // 4 % 2 else None
    fine = np.append(0.0, np.geomspace(1e-4, 1.25, 2000)) * DEEP
    reach = fine if spring is None else fine + load(name, fine) / spring

    def shape(base: Any) -> Any:
        return np.where(base > 0, load(name, np.interp(base, reach, fine)) / top, 0.0)

    last = float(np.interp(DEEP, fine, reach))
    before, count = rng.uniform(0.5, 3), int(rng.integers(200, 1500))
    if fault == "few readings":
        count = int(rng.integers(25, 60))
    elif fault == "short baseline":
        before = rng.uniform(0.03, 0.15)
    elif fault == "long approach":
        before, count = rng.uniform(20, 60), 3000
    base = last * np.linspace(-before, 1, count)
    record = Record(rng, base, shape(base), int(np.argmax(base > 0)), shape)
    FAULTS[fault](record)
    force = record.force + 10 ** rng.uniform(-2.7, -1.7) * rng.normal(size=record.force.size)
    force = top * (_rounded(force, record.step) + rng.uniform(-2, 2) * rng.integers(2))
    position = record.base + rng.uniform(-1e-6, 1e-6)
    signs = rng.choice([-1.0, 1.0], 2)
    curve = Curve(position, force) if spring is None else Curve.from_piezo(position, force, spring)
    return curve.turned(*signs), medium(START), tip, free


def _rounded(force: Any, step: float) -> Any:
    return np.round(force / step) * step if step else force


def waving(seed: int) -> tuple[Curve, Any, Any, str]:
    """A sphere or a cone on a half-space; the force without contact waves by 2 to 20 % of the rise."""
    rng = np.random.default_rng([99, seed])
    name = ("sphere", "cone")[seed % 2]
    medium, tip, free = GEOMETRIES[name]
    before = rng.uniform(2, 6)
    depth = DEEP * np.linspace(-before, 1, int(rng.integers(400, 1500)))
    top = float(load(name, DEEP))
    period, share = rng.uniform(0.4, 2) * before * DEEP, (0.02, 0.05, 0.1, 0.2)[seed // 2 % 4]
    wave = share * np.sin(2 * np.pi * depth / period + rng.uniform(0, 2 * np.pi))
    force = load(name, depth) + top * (wave + 0.01 * rng.normal(size=depth.size))
    return Curve(depth, force), medium(START), tip, free


def empty(kind: str, seed: int) -> Curve:
    """A record without contact: the force of a tip in air or liquid."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(200, 1500))
    along = np.linspace(0, 1, count)
    force = {
        "noise": 0 * along,
        "tilt": rng.uniform(-30, 30) * along,
        "drift": np.cumsum(rng.normal(size=count)) / np.sqrt(count) * 10,
        "waves": 10 * np.sin(2 * np.pi * (along * rng.uniform(0.7, 4) + rng.uniform())),
        "steps": 10.0 * (along > rng.uniform(0.1, 0.9)) - 6.0 * (along > rng.uniform(0.1, 0.9)),
    }[kind]
    return Curve(2e-6 * along, 1e-11 * (force + rng.normal(size=count)))
