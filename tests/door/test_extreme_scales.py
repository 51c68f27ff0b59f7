"""Random calls with extreme scales give finite numbers, mark them, or are refused in the package's own words."""

from __future__ import annotations

import traceback

import numpy as np
import pytest

import flatpunch as fp

DOORS = ("indent", "pressure", "flat_punch", "fields", "pull_off", "history")


def size(rng: np.random.Generator, extreme: float = 150.0) -> float:
    """A number in SI, as in a laboratory or anywhere."""
    low, high = ((-9.0, -3.0), (-49.0, 49.0), (-extreme, extreme))[int(rng.choice([0, 0, 0, 1, 1, 2]))]
    return float(10.0 ** rng.uniform(low, high))


def body(rng: np.random.Generator) -> object:
    modulus = float(10.0 ** rng.uniform(*((3, 11), (-49, 49), (-300, 300))[int(rng.choice([0, 0, 0, 1, 2]))]))
    nu = float(rng.choice([0.0, 0.3, 0.5, -0.9]))
    kind = int(rng.integers(4))
    if kind == 0:
        return fp.HalfSpace(modulus, nu)
    if kind == 1:
        return fp.Medium([fp.Layer(modulus, nu, size(rng))], base=fp.RigidBase())
    if kind == 2:
        stiffer = modulus * float(10.0 ** rng.uniform(-3, 3))
        return fp.Medium([fp.Layer(modulus, nu, size(rng))], base=fp.HalfSpace(stiffer, 0.3))
    return fp.PowerLawHalfSpace(modulus=modulus, depth=size(rng), exponent=float(rng.uniform(-0.45, 0.95)), poisson=nu)


def tip(rng: np.random.Generator) -> fp.Indenter:
    kind, angle = int(rng.integers(6)), float(10.0 ** rng.uniform(-12, 0.19))
    if kind == 0:
        return fp.Paraboloid(size(rng))
    if kind == 1:
        return fp.Sphere(size(rng))
    if kind == 2:
        return fp.Cone(angle)
    if kind == 3:
        return fp.PowerLaw(float(rng.uniform(0.3, 8)), float(10.0 ** rng.uniform(-100, 100)))
    if kind == 4:
        return fp.Truncated(fp.Cone(0.3), height_removed=size(rng))
    return fp.Cylinder(size(rng))


def finite(door: str, rng: np.random.Generator) -> bool:
    """Make a random call of a door; whether all numbers that it gives without a mark are finite."""
    medium, shape, value = body(rng), tip(rng), size(rng)
    what = {str(rng.choice(["depth", "force", "radius"])): value}
    if door == "indent":
        work = float(10.0 ** rng.uniform(-3, 0)) if rng.integers(2) else None
        result = fp.indent(medium, shape, **what, work_of_adhesion=work, angles=8)
        numbers = [float(result[name][0]) for name in ("depth", "force", "radius", "area")]
        return not bool(result.valid[0]) or bool(np.isfinite(numbers).all())
    if door == "pressure":
        return not np.isnan(fp.pressure(medium, shape, [0.0, value], 0.0, **what)).any()
    if door == "flat_punch":
        return 0 < fp.flat_punch(medium, value).stiffness < np.inf
    if door == "fields":
        return bool(np.isfinite(fp.fields(medium, shape, [0.0, value], 0.0, 0.1 * value, **what).von_mises).all())
    if door == "pull_off":
        found = fp.pull_off(medium, shape, work_of_adhesion=float(10.0 ** rng.uniform(-300, 300)))
        return bool(np.isfinite([found.force, found.depth]).all())
    start = float(10.0 ** rng.uniform(-100, 100))
    relaxation = fp.Prony([0.5, 0.2], [start, 100 * start])
    times, depths = start * np.arange(4.0), value * np.array([0.0, 1.0, 0.4, 0.4])
    result = fp.indent(medium, shape, depth=depths, time=times, relaxation=relaxation, angles=8)
    return bool(np.isfinite(result.force.values[result.valid.values]).all())


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
@pytest.mark.parametrize("door", DOORS)
def test_extreme_scales_are_solved_marked_or_refused(door):
    solved = 0
    for number in range(40):
        try:
            assert finite(door, np.random.default_rng([7, DOORS.index(door), number])), number
            solved += 1
        except (ValueError, TypeError) as error:
            # a refusal of the package, and none of NumPy or SciPy that it ran into
            if "flatpunch" not in traceback.extract_tb(error.__traceback__)[-1].filename:
                pytest.fail(f"call {number}: {error}")
    # some have sizes that can be computed
    assert solved >= 1
