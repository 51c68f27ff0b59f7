"""Layers that relax each in its own way: limits with a solution of their own, the Laplace plane, and the estimated error."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.exact import punch_stiffness
from flatpunch.contact.viscoelastic import layered

PSI, FASTER = fp.Prony([0.3, 0.4], [0.1, 2.0]), fp.StandardLinearSolid(0.5, 0.3)
GEL = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], fp.RigidBase())
FILM = fp.Medium([fp.Layer(5e3, 0.4, 2e-6)], fp.HalfSpace(20e3, 0.3))
TIP = fp.Sphere(10e-6)
TIME = np.linspace(0, 5, 26)
DEPTH = np.interp(TIME, [0, 1, 2, 3, 4, 5], [0, 2e-7, 2e-7, 0.5e-7, 1.8e-7, 0])


@pytest.mark.long
@pytest.mark.parametrize("tip", [TIP, fp.Cone(0.4), fp.Cylinder(1e-6)], ids=lambda tip: type(tip).__name__)
def test_one_relaxation_of_all(tip):
    """On a rigid base it is the exact row of springs: loading, hold, unloading, loading again, loss of contact."""
    ours = fp.indent(GEL, tip, depth=DEPTH, time=TIME, relaxation=[PSI])
    theirs = fp.indent(GEL, tip, depth=DEPTH, time=TIME, relaxation=PSI)
    largest = float(theirs.force.max())
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=5e-4 * largest)
    touching = theirs.force.values > 0.02 * largest
    np.testing.assert_allclose(ours.radius[touching], theirs.radius[touching], rtol=5e-3)
    assert ours.attrs["method"] == "exact"
    assert "equilibrium" in ours.attrs["relaxation"]


@pytest.mark.long
def test_springs_of_interfaces():
    """Elastic in a list, relaxing under one relaxation of the whole, which a note reports."""
    time, depth = [0.0, 1e-9, 1e9], np.full(3, 1e-7)
    face = fp.Interface(normal=1e9, shear=1e9)

    def film(factor, springs):
        bonded = fp.Interface(springs * face.normal, springs * face.shear)
        return fp.Medium([fp.Layer(factor * 5e3, 0.5, 2e-6, bonded=bonded)], fp.RigidBase())

    found = {
        springs: fp.indent(film(1.0, 1.0), TIP, depth=depth, time=time, relaxation=relaxation)
        for springs, relaxation in ((0.3, PSI), (1.0, [PSI]))
    }
    for springs, curve in found.items():
        elastic = fp.indent(film(0.3, springs), TIP, depth=depth[-1:])
        assert float(curve.force[-1]) == pytest.approx(float(elastic.force[0]), rel=1e-3)
    assert "springs and membranes of the interfaces relax" in found[0.3].attrs["notes"]
    assert "springs" not in found[1.0].attrs["notes"]
    assert "springs" not in fp.indent(GEL, TIP, depth=depth, time=time, relaxation=PSI).attrs["notes"]


@pytest.mark.long
def test_prescribed_force():
    force = np.interp(TIME, [0, 1, 5], [0, 1e-9, 1e-9])
    ours = fp.indent(GEL, TIP, force=force, time=TIME, relaxation=[PSI])
    theirs = fp.indent(GEL, TIP, force=force, time=TIME, relaxation=PSI)
    np.testing.assert_allclose(ours.depth[3:], theirs.depth[3:], rtol=5e-4)
    np.testing.assert_allclose(ours.force, force, rtol=1e-9, atol=1e-20)


@pytest.mark.long
def test_equal_layers_are_a_half_space():
    """The base relaxes as well."""
    body = fp.HalfSpace(5e3, 0.4)
    stack = fp.Medium([fp.Layer(5e3, 0.4, 1e-6)], body)
    ours = fp.indent(stack, TIP, depth=DEPTH, time=TIME, relaxation=[PSI, PSI])
    theirs = fp.indent(body, TIP, depth=DEPTH, time=TIME, relaxation=PSI)
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=5e-4 * float(theirs.force.max()))


@pytest.mark.long
def test_first_and_last_moments():
    """A film on an elastic base: a sudden step is elastic with the first moduli, a long hold with the last ones."""
    time, depth = np.array([0.0, 1.0, 10.0, 400.0]), np.full(4, 2e-7)
    found = fp.indent(FILM, TIP, depth=depth, time=time, relaxation=[PSI, None])
    for step, factor in ((0, 1.0), (-1, 0.3)):
        elastic = fp.indent(layered.with_moduli(FILM, [factor, 1.0]), TIP, depth=2e-7)
        assert float(found.force[step]) == pytest.approx(float(elastic.force[0]), rel=5e-4)
        assert float(found.radius[step]) == pytest.approx(float(elastic.radius[0]), rel=2e-3)


@pytest.mark.long
def test_flat_punch_in_the_laplace_plane():
    """s times the transform of the force under a sudden depth is the elastic stiffness with the moduli s psi(s): 0.01 %."""
    medium = fp.Medium([fp.Layer(5e3, 0.4, 2e-6), fp.Layer(50e3, 0.3, 1e-6)], fp.HalfSpace(20e3, 0.3))
    given, psi = [PSI, None, FASTER], [PSI, None, FASTER.prony]
    punch, depth = fp.Cylinder(3e-6), 1e-8
    time = np.concatenate([[0.0], np.geomspace(1e-3, 300, 120)])
    force = fp.indent(medium, punch, depth=np.full(time.size, depth), time=time, relaxation=given).force.values
    x, w = np.polynomial.legendre.leggauss(400)
    low, high = np.log(time[1]), np.log(time[-1])
    t = np.exp(low + (high - low) * (1 + x) / 2)
    from scipy.interpolate import CubicSpline

    values = CubicSpline(np.log(time[1:]), force[1:])(np.log(t))
    for s in (0.05, 0.3, 1.0, 5.0, 20.0):
        inner = (high - low) / 2 * (w @ (values * np.exp(-s * t) * t * s))
        transform = inner + force[0] * -np.expm1(-s * time[1]) + force[-1] * np.exp(-s * time[-1])
        body = layered.with_moduli(medium, [layered._operational(each, s) for each in psi])
        assert transform == pytest.approx(depth * punch_stiffness(compliance(body), np.array([3e-6]))[0], rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("more", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_estimated_error(monkeypatch, more):
    """With twice or three times the rings and steps, and more retardation times, forces change by less than the estimate."""
    medium = fp.Medium([fp.Layer(5e3, 0.5, 1e-6)], fp.HalfSpace(50e3, 0.3))
    rough = fp.indent(medium, TIP, depth=DEPTH, time=TIME, relaxation=[PSI, FASTER])
    for name, value in (("_RINGS", 160 * more), ("_STEPS", 400 * more), ("_PER_DECADE", 8)):
        monkeypatch.setattr(layered, name, value)
    fine = fp.indent(medium, TIP, depth=DEPTH, time=TIME, relaxation=[PSI, FASTER])
    largest = float(fine.force.max())
    some = fine.force.values > 0.05 * largest
    off = np.abs(rough.force / fine.force - 1).values[some]
    assert float(off.max()) < 1e-3
    assert np.all(off <= 1.5 * rough.force_error.values[some] + 2e-5)


def test_bad_input():
    with pytest.raises(ValueError, match="relaxation has 1 entries for 1 layers and an elastic base; give 2"):
        fp.indent(FILM, TIP, depth=DEPTH, time=TIME, relaxation=[PSI])
    with pytest.raises(ValueError, match="no entry but None"):
        fp.indent(FILM, TIP, depth=DEPTH, time=TIME, relaxation=[None, None])
    with pytest.raises(TypeError, match=r"relaxation\[0\] = .*PowerLawRelaxation"):
        fp.indent(FILM, TIP, depth=DEPTH, time=TIME, relaxation=[fp.PowerLawRelaxation(0.2, 1.0), None])
    with pytest.raises(TypeError, match="goes with a Medium"):
        fp.indent(fp.HalfSpace(1e3, 0.3), TIP, depth=DEPTH, time=TIME, relaxation=[PSI])
    with pytest.raises(ValueError, match=r"indenter = .* is not round"):
        fp.indent(FILM, fp.Vickers(), depth=DEPTH, time=TIME, relaxation=[PSI, None])
    with pytest.raises(ValueError, match="method is not chosen"):
        fp.indent(FILM, TIP, depth=DEPTH, time=TIME, relaxation=[PSI, None], method="second-order")
    with pytest.raises(ValueError, match=r"time\[1\]"):
        fp.indent(FILM, TIP, depth=[1e-8, 1e-8], time=[1.0, 0.0], relaxation=[PSI, None])


@pytest.mark.long
@pytest.mark.parametrize(("tip", "deepest"), [(fp.Sphere(5e-6), 1e-6), (fp.Cone(1.2), 3e-7)], ids=["sphere", "cone"])
def test_estimated_error_at_every_step(monkeypatch, tip, deepest):
    """It holds at single steps too, where both solutions may agree by chance."""
    medium = fp.Medium([fp.Layer(1e4, 0.5, 0.5e-6), fp.Layer(1e3, 0.45, 1e-6)], fp.HalfSpace(1e6, 0.3))
    time, depth = np.linspace(0, 10, 11), deepest * np.array([0, 0.2, 0.5, 0.8, 1, 0.8, 0.6, 0.4, 0.2, 0.1, 0])

    def solved():
        return fp.indent(medium, tip, depth=depth, time=time, relaxation=[None, fp.Prony([0.9], [1.0]), None])

    found = solved()
    monkeypatch.setattr(layered, "_RINGS", 320)
    monkeypatch.setattr(layered, "_STEPS", 1200)
    better = solved()
    some = better.force.values > 0
    off = np.abs(found.force.values[some] / better.force.values[some] - 1)
    assert np.all(off <= found.force_error.values[some])


@pytest.mark.long
def test_rings_that_do_not_resolve_a_thin_incompressible_layer_are_not_valid():
    """A contact a hundred times wider than the layer: both solutions are wrong alike, and the elastic one tells."""
    layer = fp.Medium([fp.Layer(1e4, 0.5, 1e-6)], base=fp.RigidBase())
    time, depth = np.linspace(0, 1, 9), np.linspace(0, 3e-7, 9)
    found = fp.indent(layer, fp.Paraboloid(1e-2), depth=depth, time=time, relaxation=[fp.Prony((0.5,), (0.3,))])
    assert (found.force_error.values[1:] >= 1).all()
    assert not found.valid.values[1:].any()
