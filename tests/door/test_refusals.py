"""Refusals come within seconds, name the contact that was asked for in a readable unit, and stop where nothing converges."""

import time
import warnings
from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.bem import NotConverged
from flatpunch.compliances import compliance
from flatpunch.contact.refined.refinement import Refinement, refinement


def thin(poisson, thickness, young=1e4):
    return fp.Medium([fp.Layer(young, poisson, thickness)], fp.RigidBase())


STIFF = fp.Medium([fp.Layer(4.6e11, 0.5, 2.3e-6), fp.Layer(135.0, -0.9, 2.9e-5, bonded=False)], fp.RigidBase())
SLENDER = fp.EllipticParaboloid(189437, 358.69)

NEARLY_FLAT = fp.Superellipse(1e-6, 2e-6, 1e-6, power=3, exponent=0.06)
"""Its contact is as narrow as the depth to the power of 16."""

REFUSED = {
    "cells of a contact of no width": (
        lambda: fp.indent(fp.HalfSpace(1e4, 0.3), NEARLY_FLAT, depth=1e-9, method="bem"),
        r"depth = 1 nm: the contact would be 2e-56 m wide.*Check the shape of the tip",
    ),
    "adhesion of an ellipse on a thin layer": (
        lambda: fp.indent(thin(0.3, 1e-8), fp.EllipticParaboloid(1e2, 2e2), depth=1e-9, work_of_adhesion=1.0),
        r"work_of_adhesion = 1 J/m\^2: .* radii above 2.5\d+ µm",
    ),
    "adhesion of a blunt pyramid": (
        lambda: fp.pull_off(thin(0.5, 2.7e-7, 3.5e10), fp.Pyramid(4, 1e-9), work_of_adhesion=1.8e-6),
        r"work_of_adhesion = 1.8e-06 J/m\^2: .* µm",
    ),
    "pull-off of a nearly flat tip": (
        lambda: fp.pull_off(thin(0.3, 1e-6), fp.Paraboloid(1e50), work_of_adhesion=0.05),
        r"work_of_adhesion = 0.05 J/m\^2: .* µm",
    ),
    "cells a million times wider than the layer": (
        lambda: fp.pressure(thin(0.5, 1e-6), fp.Pyramid(4, 0.3), 0.0, 0.0, force=1.0),
        r"force = 1 N: boundary elements do not converge",
    ),
    "a film 3e9 times stiffer, by radius": (
        lambda: fp.indent(STIFF, SLENDER, radius=4.43e-7),
        r"radius up to 443 nm: depth = 3\d\d.\d+ µm: boundary elements do not converge",
    ),
    "a cut-off pyramid by a radius of 10 000 layers": (
        lambda: fp.indent(thin(0.5, 1e-6), fp.Truncated(fp.Pyramid(4, 0.3), height_removed=1e-7), radius=1e-2),
        r"radius up to 10 mm: depth = [\d.]+ mm",
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", REFUSED)
def test_refused_soon_and_by_name(name):
    call, message = REFUSED[name]
    begun = time.process_time()
    with pytest.raises(ValueError, match=message):
        call()
    # 0.2 to 1 s on a quiet core, 3 to 180 s before; a loaded machine may take some times as long
    assert time.process_time() - begun < 5


def test_a_refusal_leaves_nothing_behind():
    """A depth that has no round contact is not the end of the tip for the calls that follow."""
    body, method = fp.HalfSpace(1e4, 0.3), fp.Refined(cells=32)
    with pytest.raises(ValueError, match="depth = 1 nm is too small"):
        fp.indent(body, NEARLY_FLAT, depth=1e-9, method=method)
    found = fp.indent(body, NEARLY_FLAT, force=1e-9, method=method)
    assert float(found["force"][0]) == pytest.approx(1e-9)


BODY = fp.Medium([fp.Layer(10e9, 0.3, 1e-6)], fp.HalfSpace(1e9, 0.3))
TIP = fp.Truncated(fp.Pyramid(4, 0.3), height_removed=1e-7)


def not_converging(monkeypatch, above):
    """Let solutions above a depth [m] count as not converged; returns the list of depths solved."""
    depths = []
    solve = Refinement.solve

    def marked(self, positions):
        solve(self, positions)
        for x, sample in self.samples.items():
            if x > np.log(above) and sample.converged:
                self.samples[x] = replace(sample, force_error=np.inf, shape_error=np.inf, notes=("not converged",))
                depths.append(float(np.exp(x)))

    monkeypatch.setattr(Refinement, "solve", marked)
    refinement.cache_clear()
    return depths


def test_search_for_a_radius_ends_at_the_first_solution_that_does_not_converge(monkeypatch):
    lost = not_converging(monkeypatch, 1e-30)
    with pytest.raises(NotConverged, match=r"radius up to 2 µm: boundary elements do not converge at a depth of"):
        fp.indent(BODY, TIP, radius=2e-6, method=fp.Refined(cells=32))
    assert 1 <= len(lost) <= 2
    refinement.cache_clear()


@pytest.mark.long
def test_steps_beside_a_solution_that_does_not_converge_are_not_valid(monkeypatch):
    limit = 3e-7
    lost = not_converging(monkeypatch, limit)
    depth = np.geomspace(5e-8, 8e-7, 30)
    curve = fp.indent(BODY, TIP, depth=depth, method=fp.Refined(cells=32))
    # gaps beside such a solution are not halved for it, so that one gap below the limit is lost as well
    solutions = refinement(compliance(BODY), TIP, 360, 32, None)
    last = max(float(np.exp(x)) for x, sample in solutions.samples.items() if sample.converged)
    assert lost
    np.testing.assert_array_equal(curve.valid.values, depth <= last)
    assert curve.valid.values[:5].all()
    assert not curve.valid.values[depth > limit].any()
    assert "not converged" in curve.attrs["notes"]
    refinement.cache_clear()


@pytest.mark.long
def test_cells_a_million_times_wider_than_the_layer_by_depth_give_no_valid_result():
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        curve = fp.indent(thin(0.5, 1e-6), fp.Pyramid(4, 0.3), depth=1.0, method="bem")
    assert any("not converged after" in str(each.message) for each in found)
    assert not curve.valid.any()
