"""Two elastic bodies in contact: their compliances add, whatever they are made of."""

import numpy as np
import pytest

import flatpunch as fp

LAYER = fp.Medium([fp.Layer(1.0, 0.45, 0.4)], base=fp.RigidBase())
COATED = fp.Medium([fp.Layer(3.0, 0.3, 0.2), fp.Layer(0.5, 0.2, 0.5, bonded=False)], base=fp.HalfSpace(2.0, 0.3))
GRADED = fp.Medium([fp.GradedLayer(fp.ExponentialModulus(1.0, 4.0, 0.6), 0.35, 0.6)], base=fp.HalfSpace(4.0, 0.35))
BODIES = {"layer": LAYER, "coated": COATED, "graded": GRADED, "half-space": fp.HalfSpace(2.0, 0.3)}
TIP = fp.EllipticParaboloid(0.4, 0.6)
RADII = np.array([0.1, 0.5, 1.5])
VARIABLES = ("depth", "force", "area", "stiffness", "contour")


def solve(medium, method="second-order"):
    return fp.indent(medium, TIP, radius=RADII, method=method, angles=24)


def agree(one, other, rtol):
    for name in VARIABLES:
        np.testing.assert_allclose(one[name], other[name], rtol=rtol, err_msg=name)


@pytest.mark.parametrize("method", ["first-order", "second-order"])
def test_two_equal_half_spaces_are_one_of_half_the_modulus(method):
    one = fp.HalfSpace(2.0, 0.3)
    agree(solve(fp.TwoBodies(one, one), method), solve(fp.HalfSpace(1.0, 0.3), method), 1e-13)


@pytest.mark.long
@pytest.mark.parametrize("name", BODIES)
def test_two_equal_bodies_are_one_of_half_the_force(name):
    one, pair = solve(BODIES[name]), solve(fp.TwoBodies(BODIES[name], BODIES[name]))
    for variable in VARIABLES:
        share = 0.5 if variable in ("force", "stiffness") else 1.0
        # Chebyshev panels are those of one kernel; graded pairs know their responses to 1e-10
        np.testing.assert_allclose(pair[variable], share * one[variable], rtol=1e-9, err_msg=variable)


@pytest.mark.long
@pytest.mark.parametrize(("one", "other"), [("layer", "coated"), ("layer", "graded"), ("graded", "half-space")])
def test_order_does_not_matter(one, other):
    # the pairs have different lengths of their own, so panels lie elsewhere: 1e-9 under graded surfaces
    agree(solve(fp.TwoBodies(BODIES[one], BODIES[other])), solve(fp.TwoBodies(BODIES[other], BODIES[one])), 1e-8)


@pytest.mark.long
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("method", ["first-order", "fourth-order"])
def test_one_rigid_body_returns_the_other(name, method):
    for pair in (fp.TwoBodies(BODIES[name], fp.RigidBase()), fp.TwoBodies(fp.RigidBase(), BODIES[name])):
        agree(solve(pair, method), solve(BODIES[name], method), 1e-15)


def test_a_body_far_stiffer_is_rigid():
    hard = fp.HalfSpace(1e9, 0.3)
    # 1e-9 is the share of its modulus
    agree(solve(fp.TwoBodies(GRADED, hard)), solve(GRADED), 1e-8)


def test_layer_against_layer_of_the_same_kind_and_thickness():
    """Two sliding layers of one thickness differ by their moduli only, which add like springs in series."""
    soft, stiff = (
        fp.Medium([fp.Layer(e, nu, 0.4, bonded=False)], base=fp.RigidBase()) for e, nu in ((1.0, 0.3), (3.0, 0.45))
    )
    pair = fp.TwoBodies(soft, stiff)
    together = fp.Medium([fp.Layer(pair.surface_modulus, 0.0, 0.4, bonded=False)], base=fp.RigidBase())
    # L of a sliding layer on a rigid base does not depend on nu
    agree(solve(pair), solve(together), 1e-11)


def test_power_law_bodies_of_one_exponent():
    one, other = fp.PowerLawHalfSpace(1.0, 1.0, 0.3, 0.3), fp.PowerLawHalfSpace(5.0, 0.2, 0.3, 0.45)
    pair = solve(fp.TwoBodies(one, other))
    # compliances of one shape add like springs in series
    np.testing.assert_allclose(
        1 / pair["stiffness"], 1 / solve(one)["stiffness"] + 1 / solve(other)["stiffness"], rtol=1e-12
    )
    agree(pair, solve(fp.TwoBodies(other, one)), 1e-12)
    agree(solve(fp.TwoBodies(one, fp.RigidBase())), solve(one), 1e-15)


@pytest.mark.parametrize("pair", [(LAYER, COATED), (GRADED, LAYER)])
def test_boundary_elements_press_pairs_as_well(pair):
    medium = fp.TwoBodies(*pair)
    fast = fp.indent(medium, TIP, depth=0.3, method="fourth-order", angles=24)
    rigorous = fp.indent(medium, TIP, depth=0.3, method=fp.BoundaryElements(grid=64), angles=24)
    # 64 cells leave a few 1e-3 in force
    np.testing.assert_allclose(rigorous["force"], fast["force"], rtol=5e-3)
