"""Random bodies, tips and targets, one in six of them of an absurd size: a finite result, or one refusal, and no warning."""

import linecache
import random
import traceback

import numpy as np
import pytest

import flatpunch as fp


class Drawn:
    """Random arguments from one seed."""

    def __init__(self, seed):
        self.rng = random.Random(seed)

    def size(self, low, high):
        chance = self.rng.random()
        if chance < 0.85:
            return 10 ** self.rng.uniform(np.log10(low), np.log10(high))
        if chance < 0.95:
            return 10 ** self.rng.uniform(-60, 60)
        return self.rng.choice([0.0, -1.0, 5e-324, 1e300, 1e50, 1e-50, 1.0])

    def poisson(self):
        return self.rng.choice([0.3, 0.5, 0.0, -0.9, 0.49999, 0.1, 1e-20, 0.5 + 1e-12])

    def layer(self):
        young, thickness = self.size(1e2, 1e12), self.size(1e-8, 1e-3)
        return fp.Layer(young, self.poisson(), thickness, self.rng.random() < 0.8)

    def medium(self):
        kind = self.rng.randrange(6)
        if kind == 0:
            return fp.HalfSpace(self.size(1e2, 1e12), self.poisson())
        if kind == 1:
            return fp.TwoBodies(
                fp.HalfSpace(self.size(1e2, 1e12), self.poisson()), fp.Medium([self.layer()], fp.RigidBase())
            )
        base = self.rng.choice([fp.RigidBase(), fp.HalfSpace(1e9, 0.3)])
        return fp.Medium([self.layer() for _ in range(self.rng.choice([1, 1, 2]))], base)

    def tip(self):
        kinds = [
            lambda: fp.Paraboloid(self.size(1e-8, 1e-2)),
            lambda: fp.Sphere(self.size(1e-8, 1e-2)),
            lambda: fp.Cone(self.rng.choice([self.rng.uniform(0.01, 1.5), 1e-12, 1.5707])),
            lambda: fp.Pyramid(self.rng.choice([3, 4, 10**9]), self.rng.choice([0.3, 1e-9, 1.57])),
            lambda: fp.Cylinder(self.size(1e-8, 1e-3)),
            lambda: fp.EllipticParaboloid(self.size(1e2, 1e8), self.size(1e2, 1e8)),
            lambda: fp.PowerLaw(self.rng.choice([0.5, 1, 2, 3.3, 20, 1e3, 1e-3]), self.size(1e-3, 1e9)),
            lambda: fp.Ellipsoid(self.size(1e-8, 1e-3), self.size(1e-8, 1e-3), self.size(1e-8, 1e-3)),
            lambda: fp.AreaFunction((24.5, self.size(1, 1e3)), limit=self.size(1e-8, 1e-5), unit=1e-9),
        ]
        return self.rng.choice(kinds)()

    def call(self):
        """A call with everything drawn."""
        medium, tip = self.medium(), self.tip()
        target = self.rng.choice(["depth", "force", "radius"])
        value = self.size(*{"depth": (1e-10, 1e-6), "force": (1e-13, 1e-4), "radius": (1e-9, 1e-6)}[target])
        kind = self.rng.randrange(5)
        if kind < 3:
            found = fp.indent(medium, tip, **{target: value}, angles=16)
            numbers = [found[name].values for name in ("depth", "force", "radius", "area")]
            assert all(np.isfinite(n[found.valid.values]).all() for n in numbers)
        elif kind == 3:
            fp.flat_punch(medium, value)
        else:
            fp.pull_off(medium, tip, work_of_adhesion=self.size(1e-6, 1))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
@pytest.mark.parametrize("count", [120, pytest.param(3000, marks=pytest.mark.slow)])
def test_finite_or_refused(count):
    drawn, refused = Drawn(count), 0
    for _ in range(count):
        try:
            drawn.call()
        except (ValueError, TypeError) as error:
            refused += 1
            last = traceback.extract_tb(error.__traceback__)[-1]
            ours = "flatpunch" in last.filename and "raise" in linecache.getline(last.filename, last.lineno or 0)
            message = str(error)
        else:
            ours, message = True, ""
        assert ours, message
        assert len(message) < 700
    assert count / 10 < refused < 0.8 * count


@pytest.mark.parametrize(
    "make",
    [
        lambda: fp.Medium([fp.Layer(1e3, 0.3, 1e-6), fp.Layer(1e40, 0.3, 1e-6)], fp.RigidBase()),
        lambda: fp.Medium([fp.Layer(1e3, 0.3, 1e-30), fp.Layer(1e3, 0.3, 1.0)], fp.RigidBase()),
        lambda: fp.Medium([fp.Layer(1e-20, 0.3, 1e-6)], fp.HalfSpace(1e10, 0.3)),
        lambda: fp.GradedLayer(fp.ExponentialModulus(1e-15, 1e15, 1e-6), 0.3, 1e-6),
        lambda: fp.TwoBodies(fp.HalfSpace(1e-20, 0.3), fp.HalfSpace(1e10, 0.3)),
        lambda: fp.EllipticParaboloid(1.0, 1e8),
        lambda: fp.Ellipsoid(1.0, 1e-8, 1.0),
        lambda: fp.Superellipse(1.0, 1e-8, 1.0),
        lambda: fp.Superellipse(1.0, 1.0, 1.0, power=1e5),
        lambda: fp.PowerLaw(1e3, 1.0),
    ],
)
def test_what_differs_by_more_than_can_be_computed(make):
    with pytest.raises(ValueError, match=r"differ by|must not differ|must lie between|must be 1000"):
        make()
