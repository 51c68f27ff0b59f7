"""What a fit says of pull-off, and of the difference between a sphere and a paraboloid."""

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.fits import Curve, fit
from flatpunch.indenters import Paraboloid, Sphere
from flatpunch.media import HalfSpace


def test_pull_off_force_is_that_of_jkr():
    """F = 3/2 pi w R on a half-space, whatever its modulus, with the relative error of w."""
    body, tip, work = HalfSpace(3e4, 0.5), Paraboloid(4e-6), 2e-3
    depth = np.linspace(-9e-7, 4e-7, 800)
    found = indent(body, tip, depth=depth, work_of_adhesion=work, angles=8)["force"].values
    force = np.where(np.isfinite(found), found, 0.0)
    force = force + 1e-10 * np.random.default_rng(3).normal(size=force.size)
    # pressed and withdrawn along the same branch
    curve = Curve(np.concatenate([depth, depth[::-1]]), np.concatenate([force, force[::-1]]))
    result = fit(curve, body, tip, ["base.young", "work_of_adhesion"], work_of_adhesion=1e-3)
    pull, fitted = result.pull_off, result.estimates["work_of_adhesion"]
    # the tables of adhesive contacts are made to 1e-5
    assert pull.value == pytest.approx(1.5 * np.pi * fitted.value * tip.radius, rel=1e-4)
    assert pull.stderr / pull.value == pytest.approx(fitted.stderr / fitted.value, rel=1e-2)
    assert "pull-off force" in result.summary()
    assert result.row()["pull-off force"] == pull.value


@pytest.mark.parametrize(("depth", "words"), [(0.05, None), (0.15, "1.5 % less"), (0.4, "4.0 % less")])
def test_a_sphere_that_is_fitted_as_a_paraboloid_is_noted(depth, words):
    """By a sphere's own force, F_sphere/F_paraboloid = 1 - d/(10 R) + ... on a half-space."""
    radius = 5e-6
    x = np.linspace(-0.5, 1, 400) * depth * radius
    bent = [
        indent(HalfSpace(1e4, 0.5), tip, depth=[depth * radius], angles=8)["force"].values[0]
        for tip in (Sphere(radius), Paraboloid(radius))
    ]
    assert 1 - bent[0] / bent[1] == pytest.approx(depth / 10, rel=0.05)
    force = indent(HalfSpace(1e4, 0.5), Paraboloid(radius), depth=np.maximum(x, 0), angles=8)["force"].values
    for tip in (Paraboloid(radius), Sphere(radius)):
        notes = [
            note
            for note in fit(Curve(x, force), HalfSpace(1e3, 0.5), tip, ["base.young"]).notes
            if "paraboloid:" in note
        ]
        expected = words is not None and isinstance(tip, Paraboloid)
        assert bool(notes) == expected
        if expected:
            assert words in notes[0]
