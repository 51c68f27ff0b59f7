"""What is refused of adhesive contacts."""

import numpy as np
import pytest

import flatpunch as fp

GEL = fp.HalfSpace(young=1e6, poisson=0.5)


@pytest.mark.parametrize(
    ("indenter", "message"),
    [(fp.PowerLaw(0.4, 1e-3), "square root")],
)
def test_refused_indenters(indenter, message):
    with pytest.raises(ValueError, match=message):
        fp.pull_off(GEL, indenter, work_of_adhesion=0.05)


@pytest.mark.parametrize("work", [0.0, -1.0, np.nan])
def test_refused_work_of_adhesion(work):
    with pytest.raises(ValueError, match="work_of_adhesion"):
        fp.indent(GEL, fp.Paraboloid(1e-6), depth=0.0, work_of_adhesion=work)


def test_other_bad_input():
    with pytest.raises(ValueError, match="exactly one"):
        fp.indent(GEL, fp.Paraboloid(1e-6), depth=0.0, force=0.0, work_of_adhesion=0.05)
    with pytest.raises(ValueError, match="radius"):
        fp.indent(GEL, fp.Paraboloid(1e-6), radius=0.0, work_of_adhesion=0.05)
    with pytest.raises(ValueError, match="exactly one"):
        fp.adhesion_loop(GEL, fp.Paraboloid(1e-6), work_of_adhesion=0.05)
    with pytest.raises(ValueError, match="range_of_action"):
        fp.pull_off(GEL, fp.Paraboloid(1e-6), work_of_adhesion=0.05, range_of_action=0.0)
    with pytest.raises(ValueError, match="no stable contact"):
        fp.pull_off(GEL, fp.Sphere(1e-9), work_of_adhesion=10.0)
    with pytest.raises(ValueError, match="needs a contact radius"):
        fp.indent(GEL, fp.Sphere(1e-6), depth=1e-5, work_of_adhesion=0.001)


@pytest.mark.parametrize(
    ("medium", "tip", "work", "message"),
    [
        (fp.HalfSpace(1e6, 0.3), fp.EllipticParaboloid(1e5, 2e5), 1e-300, "work_of_adhesion = "),
        (fp.HalfSpace(1e40, 0.3), fp.Cone(0.3), 0.05, "far below the size of an atom"),
    ],
)
def test_extreme_scales_are_refused(medium, tip, work, message):
    with pytest.raises(ValueError, match=message):
        fp.pull_off(medium, tip, work_of_adhesion=work)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fp.HalfSpace(1e300, 0.3), r"HalfSpace\.young = 1e\+300 .*must"),
        (lambda: fp.Paraboloid(1e-150), r"Paraboloid\.radius = 1e-150 .*must"),
        (lambda: fp.Sphere(1e-150), r"Sphere\.radius = 1e-150 .*must"),
    ],
    ids=["modulus", "paraboloid", "sphere"],
)
def test_constructors_refuse_extreme_scales(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("more", [{}, {"range_of_action": 1e-9}])
def test_a_thin_film_that_sinks_with_its_soft_base_holds(more):
    """At no force adhesion draws the tip in by more than four times the thickness of a film, which is not pressed through."""
    gel = fp.Medium([fp.Layer(5e4, 0.5, 5e-9)], fp.HalfSpace(5e3, 0.5))
    found = fp.indent(gel, fp.Paraboloid(5e-6), force=[-1e-10, 0.0, 1e-10], work_of_adhesion=1e-5, **more)
    assert (found.depth > 20e-9).all()
    assert found.valid.all()
    assert "pressed through" not in found.notes
