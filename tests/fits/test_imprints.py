"""Imprints are judged on the whole load cycle: the share of the depth left, whatever else the record and the fit contain."""

import numpy as np
import pytest

from flatpunch.fits import Curve, CurveError, fit
from flatpunch.fits.measured.cycles import imprint
from flatpunch.indenters import Cone, Cylinder, Sphere
from flatpunch.media import HalfSpace

DEEP, LOAD = 300e-9, 2e-3
TIPS = {"sphere": (Sphere(3e-6), 1.5), "cone": (Cone(np.radians(20)), 2.0), "flat end": (Cylinder(1e-6), 1.0)}


def record(
    left,
    *,
    power=2.0,
    m=1.5,
    count=400,
    air=0.2,
    hold=0.0,
    creep=0.0,
    dip=0.0,
    cycles=1,
    down_to=0.0,
    drift=0.0,
    noise=1e-3,
    seed=0,
):
    """Depth over DEEP and force over LOAD: P ~ h^power, unloading P ~ (h - left)^m down to a share of the load.

    `hold` is its length over that of the loading, `creep` the depth gained in it, `drift` the depth gained over the record.
    """
    depth, force = [np.linspace(-0.5, 0, int(air * count))], [np.zeros(int(air * count))]
    for number in range(1, cycles + 1):
        size, before = number / cycles, (number - 1) / cycles
        level = np.linspace(size**power * (down_to if number > 1 else 0), size**power, count)
        first = level ** (1 / power)
        again = before * (left + (1 - left) * np.minimum(level / max(before, 1e-9) ** power, 1) ** (1 / m))
        depth.append(np.where(level < before**power, again, first))
        force.append(level)
        if number == cycles and hold:
            held = np.ones(int(hold * count))
            held[1:4] -= dip
            depth.append(1 + creep * np.linspace(0, 1, held.size))
            force.append(held)
        back = np.linspace(1, down_to ** (1 / m), count)
        depth.append(size * (left + (1 - left) * back) + (creep if number == cycles and hold else 0))
        force.append(size**power * back**m)
    if not down_to and air:
        depth.append(np.linspace(depth[-1][-1], -0.5, int(air * count)))
        force.append(np.zeros(int(air * count)))
    h, p, rng = np.concatenate(depth), np.concatenate(force), np.random.default_rng(seed)
    h = h + drift * np.arange(h.size) / h.size
    return DEEP * h, LOAD * (p + noise * rng.normal(size=p.size))


VARIANTS = [
    {},
    {"hold": 0.1},
    {"hold": 2.0},
    {"hold": 1.0, "dip": 5e-5, "noise": 0.0},
    {"hold": 1.0, "creep": 0.15},
    {"cycles": 3},
    {"cycles": 3, "down_to": 0.2},
    {"down_to": 0.3},
    {"air": 0.0},
    {"count": 40},
    {"count": 3000, "noise": 0.02},
    {"m": 1.1},
    {"m": 2.0},
]


@pytest.mark.parametrize("change", VARIANTS, ids=str)
@pytest.mark.parametrize("left", [0.4, 0.85])
def test_the_share_is_that_of_the_record(left, change):
    found = imprint(Curve(*record(left, **change)))
    # 40 levels and steps of .1 of the exponent: .03 without noise
    assert found.share == pytest.approx(left, abs=0.03 + 2 * found.error)
    assert found.error < 0.1
    assert found.seen


@pytest.mark.parametrize("change", VARIANTS[:-2], ids=str)
@pytest.mark.parametrize("spring", [None, 5e3])
def test_all_repeats_of_a_test_of_a_stiff_body_are_refused(change, spring):
    """Holds, creep, dips, cycles, ends of the unloading, air, cantilevers: one answer."""
    depth, force = record(0.6, **change)
    curve = Curve(depth, force) if spring is None else Curve.from_piezo(depth + force / spring, force, spring)
    with pytest.raises(CurveError, match=r"the unloading ends [56].% of the depth short of .*the loading was plastic"):
        fit(curve, HalfSpace(1e9, 0.3), Cone(np.radians(20)), ["base.young"])


@pytest.mark.parametrize("part", [{"depth_to": 0.4 * DEEP}, {"force_to": 0.5 * LOAD}, {"baseline": "none"}], ids=str)
def test_the_part_that_is_fitted_does_not_matter(part):
    with pytest.raises(CurveError, match=r"ends (59|60|61)% of the depth short"):
        fit(Curve(*record(0.6)), HalfSpace(1e9, 0.3), Cone(np.radians(20)), ["base.young"], **part)


@pytest.mark.parametrize("tip", TIPS)
@pytest.mark.parametrize("change", [{}, {"hold": 1.0}, {"cycles": 3}, {"down_to": 0.3}, {"air": 0.0}], ids=str)
@pytest.mark.parametrize(("noise", "drift"), [(1e-4, 0.05), (0.01, -0.05), (0.03, 0.0)])
def test_elastic_bodies_give_everything_back(tip, change, noise, drift):
    power = TIPS[tip][1]
    found = imprint(Curve(*record(0.0, power=power, m=power, noise=noise, drift=drift, **change)))
    # the drift, noise that moves readings to other levels, and two standard errors
    assert abs(found.share) < abs(drift) + 0.03 + 2 * noise + 2 * found.error
    assert not found.seen


@pytest.mark.parametrize("tip", TIPS)
def test_an_elastic_ceramic_is_fitted(tip):
    shape, power = TIPS[tip]
    star, tall = 300e9 / (1 - 0.25**2), 10e-9 / DEEP
    depth, force = record(0.0, power=power, m=power, noise=0.01, drift=0.03, hold=0.5)
    law = {
        "sphere": 4 / 3 * np.sqrt(3e-6),
        "cone": 2 / np.pi / np.tan(np.radians(20)),
        "flat end": 2e-6,
    }[tip]
    curve = Curve(depth * tall, force / LOAD * law * star * (DEEP * tall) ** power)
    found = fit(curve, HalfSpace(100e9, 0.25), shape, ["base.young"])
    # 3 % of drift over the depth
    assert found["base.young"] == pytest.approx(300e9, rel=0.15)
    assert not any("short of where" in note for note in found.notes)


def test_without_an_unloading_nothing_is_judged():
    depth, force = record(0.6)
    end = int(np.argmax(force))
    assert imprint(Curve(depth[:end], force[:end])) is None


@pytest.mark.parametrize("seed", range(5))
def test_a_viscous_gel_is_noted_at_most(seed):
    """A standard linear solid that keeps a third of its stiffness, at random speeds."""
    rng = np.random.default_rng(seed)
    way = np.concatenate([np.linspace(-0.5, 1, 600), np.linspace(1, -0.5, 600)])
    pressed, keeps = np.maximum(way, 0) ** 1.5, np.exp(-1 / (1200 * 10 ** rng.uniform(-2, 0)))
    memory = np.zeros(way.size)
    for i in range(1, way.size):
        memory[i] = keeps * memory[i - 1] + pressed[i] - pressed[i - 1]
    force = np.maximum(pressed / 3 + 2 / 3 * memory, 0) * (way > 0) + 1e-3 * rng.normal(size=way.size)
    fit(Curve(1e-6 * way, 1e-8 * force), HalfSpace(1e4, 0.5), Sphere(5e-6), ["base.young"])
