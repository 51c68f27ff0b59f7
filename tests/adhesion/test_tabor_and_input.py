"""Range of validity, and what is refused."""

import warnings

import numpy as np
import pytest

import flatpunch as fp

GEL = fp.HalfSpace(young=1e6, poisson=0.5)
SILICA = fp.HalfSpace(young=70e9, poisson=0.17)


def test_tabor_parameter_on_a_half_space():
    z0, w, radius = 0.5e-9, 0.05, 1e-6
    tabor = fp.pull_off(GEL, fp.Paraboloid(radius), work_of_adhesion=w, range_of_action=z0).tabor
    # its definition (Tabor 1977); 1e-11 is the accuracy of the pull-off radius
    assert tabor.parameter == pytest.approx((radius * w**2 / (GEL.surface_modulus**2 * z0**3)) ** (1 / 3), rel=1e-10)
    assert tabor.regime == "JKR"
    assert tabor.dmt_force == pytest.approx(-2 * np.pi * w * radius, rel=1e-12)


@pytest.mark.parametrize(("radius", "regime"), [(2e-8, "transition"), (1e-11, "DMT")])
def test_transition_and_dmt_warn(radius, regime):
    with pytest.warns(fp.FlatpunchWarning, match="Tabor"):
        point = fp.pull_off(SILICA, fp.Paraboloid(radius), work_of_adhesion=0.1, range_of_action=0.3e-9)
    assert point.tabor.regime == regime
    curve = fp.indent(SILICA, fp.Paraboloid(radius), force=0.0, work_of_adhesion=0.1, range_of_action=0.3e-9)
    assert "Tabor" in curve.attrs["notes"]


def test_a_thin_layer_lowers_the_parameter():
    # the layer can be stretched by sqrt(2 w h/M) only, whatever the tip
    young, h, w, z0 = 1e6, 1e-9, 0.05, 1e-9
    confined = young * 0.7 / (1.3 * 0.4)
    thin = fp.Medium([fp.Layer(young, 0.3, h)], base=fp.RigidBase())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        tabor = fp.pull_off(thin, fp.Paraboloid(1e-6), work_of_adhesion=w, range_of_action=z0).tabor
    thick = fp.pull_off(fp.HalfSpace(young, 0.3), fp.Paraboloid(1e-6), work_of_adhesion=w, range_of_action=z0).tabor
    assert tabor.parameter < 0.1 * thick.parameter
    # thin limit of the retraction; corrections h/a of a few per cent
    assert tabor.parameter * 3.0937 * z0 == pytest.approx(np.sqrt(2 * w * h / confined), rel=0.05)


def test_rigid_value_of_a_sphere_cut_short():
    # range of action 1 % of the radius: f(r0) = z0 on the true sphere is r0^2 = 2 R z0 - z0^2
    point = fp.pull_off(GEL, fp.Sphere(1e-6), work_of_adhesion=0.5, range_of_action=1e-8)
    assert point.tabor.dmt_force == pytest.approx(-0.5 / 1e-8 * np.pi * (2e-14 - 1e-16), rel=1e-12)


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
