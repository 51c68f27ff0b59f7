"""Second order under non-round tips: exact ellipses, the round limit, the limit without adhesion, energy, refusals."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.case import adhesive_case
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import stability, steady_radius
from support.adhesive_ellipse import adhesive_ellipse, force_and_energy, unit_of

UNIT = fp.HalfSpace(1.0, 0.0)
GRADED = fp.PowerLawHalfSpace(1.0, 0.5, 0.4, 0.3)
LAYER = fp.Medium([fp.Layer(1.0, 0.45, 0.8)], base=fp.RigidBase())


def test_the_judge_is_right_for_hertz():
    # d = 1, f = r^2/2 on a circle of radius 1 has no edge singularity: F = (4/3) a^3/R
    force, _ = force_and_energy(1.0, 1 + 1e-9, 1.0, 0.5, 0.5)
    assert force == pytest.approx(4 / 3, rel=1e-8)


@pytest.mark.parametrize("radius", [0.55, 0.9, 1.3, 2.0])
def test_order_of_the_error_against_exact_ellipses(radius):
    # radii below and above both instabilities (0.49 and 1.02)
    work = 0.3
    errors = []
    for asymmetry in (0.2, 0.1):
        tip = fp.EllipticParaboloid(0.5 * (1 - asymmetry), 0.5 * (1 + asymmetry))
        branch = PerturbedBranch(compliance(UNIT), tip, work)
        at = np.array([radius])
        contact = branch.at(at)
        outline, _, area = branch.shape(at, np.array([0, np.pi / 2]))
        force, axes = adhesive_ellipse(float(contact.depth[0]), tip.A, tip.B, work, radius)
        elongation = np.log(outline[0, 0] / outline[0, 1]) - np.log(axes[0] / axes[1])
        errors.append(np.abs([contact.force[0] - force, elongation, area[0] / (np.pi * axes.prod()) - 1]))
    # what is left out is of fourth, third (elongations are odd) and fourth order; constants read off: 0.13, 0.025, 0.08
    assert np.all(errors[1] < [0.15e-4, 0.03e-3, 0.1e-4])
    assert np.all(errors[0] < [0.15 * 0.2**4, 0.03 * 0.2**3, 0.1 * 0.2**4])


@pytest.mark.long
@pytest.mark.parametrize("exponent", [-0.3, 0.4, 0.7])
@pytest.mark.parametrize("radius", [0.6, 1.5])
def test_order_of_the_error_on_power_law_half_spaces(exponent, radius):
    medium, work = fp.PowerLawHalfSpace(1.0, 1.0, exponent, 0.0), 0.3
    unit = unit_of(fp.flat_punch(medium, 1.0).stiffness, exponent)
    errors = []
    for asymmetry in (0.2, 0.1):
        tip = fp.EllipticParaboloid(0.5 * (1 - asymmetry), 0.5 * (1 + asymmetry))
        branch = PerturbedBranch(compliance(medium), tip, work)
        at = np.array([radius])
        contact = branch.at(at)
        _, _, area = branch.shape(at, np.zeros(1))
        force, axes = adhesive_ellipse(float(contact.depth[0]), tip.A, tip.B, work, radius, exponent, unit)
        errors.append(np.abs([contact.force[0] - force, area[0] / (np.pi * axes.prod()) - 1]))
    # of fourth order in the asymmetry, and what sixth order adds; the constants are those of the half-space
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 4, atol=0.25)
    assert np.all(errors[1] < [0.15e-4, 0.1e-4])


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Pyramid(4, 0.3), fp.PowerLaw(2.5, lambda phi: 2 + 0.3 * np.cos(3 * phi))])
def test_power_law_half_spaces_go_over_into_the_homogeneous_one(tip):
    plain, *graded = (
        fp.pull_off(medium, tip, work_of_adhesion=0.1)
        for medium in (fp.HalfSpace(1.0, 0.3), *(fp.PowerLawHalfSpace(1.0, 1.0, k, 0.3) for k in (1e-3, 1e-6)))
    )
    off = [abs(g.force / plain.force - 1) for g in graded]
    # in proportion to the exponent
    assert off[1] == pytest.approx(1e-3 * off[0], rel=1e-2, abs=1e-9)
    assert off[1] < 1e-5


@pytest.mark.parametrize("medium", [UNIT, LAYER, GRADED], ids=["half-space", "layer", "graded"])
def test_round_limit(medium):
    tip = fp.PowerLaw(2.0, lambda phi: 0.5 * (1 + 1e-7 * np.cos(3 * phi)))
    near, exact = (fp.pull_off(medium, shape, work_of_adhesion=0.3) for shape in (tip, fp.Paraboloid(1.0)))
    # second order in 1e-7 is nothing
    assert near.force == pytest.approx(exact.force, rel=1e-11)
    assert near.depth_minimum.depth == pytest.approx(exact.depth_minimum.depth, rel=1e-11)


@pytest.mark.long
@pytest.mark.parametrize("medium", [UNIT, LAYER, GRADED], ids=["half-space", "layer", "graded"])
@pytest.mark.parametrize("tip", [fp.EllipticParaboloid(0.3, 0.7), fp.Pyramid(4, 0.5)], ids=["ellipse", "pyramid"])
def test_no_adhesion_is_the_second_order_method(medium, tip):
    depth = np.linspace(0.5, 2, 4)
    plain = fp.indent(medium, tip, depth=depth, method="second-order")
    apart = {}
    for work in (1e-8, 1e-12):
        sticky = fp.indent(medium, tip, depth=depth, work_of_adhesion=work, method="second-order")
        apart[work] = [
            float(np.abs(sticky[name] / plain[name] - 1).max()) for name in ("force", "radius", "area", "contour")
        ]
    # at given depth the force is stationary in the radius: in proportion to the work; the radius to its root
    assert np.all(apart[1e-12] < np.array([1e-8, 2e-5, 4e-5, 3e-4]))
    assert apart[1e-12][0] < 1e-2 * apart[1e-8][0] + 1e-9
    # cusps at the edges of pyramids add a factor that grows like the logarithm
    assert apart[1e-12][1] < 1.3e-2 * apart[1e-8][1]


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.EllipticParaboloid(0.3, 0.7), fp.Pyramid(3, 0.3)], ids=["ellipse", "pyramid"])
def test_curves_and_loop(tip):
    point = fp.pull_off(LAYER, tip, work_of_adhesion=0.1)
    depth = np.linspace(point.depth_minimum.depth * 0.99, 0.75, 12)
    curve = fp.indent(LAYER, tip, depth=depth, work_of_adhesion=0.1, method="second-order")
    back = fp.indent(LAYER, tip, radius=curve.radius.values, work_of_adhesion=0.1, method="second-order")
    # mean radii are inverted to 1e-12; beside the depth minimum that is stretched by its inverse distance
    assert np.allclose(back.depth, depth, rtol=0, atol=1e-9)
    assert (curve.force > point.force * (1 + 1e-9)).all()
    assert curve.valid.all()
    assert (curve.force_error < 0.1).all()
    loop = fp.adhesion_loop(LAYER, tip, work_of_adhesion=0.1, depth=0.5, points=800)
    # trapezoids beside the square root at pull-off: 800^-1.5
    assert loop.attrs["energy_lost"] == pytest.approx(float(np.trapezoid(loop.force, loop.depth)), rel=5e-5)


def test_refusals():
    with pytest.raises(ValueError, match="second-order"):
        fp.indent(UNIT, fp.Pyramid(4, 0.3), depth=0.1, work_of_adhesion=0.1, method="fourth-order")
    with pytest.raises(ValueError, match="round indenters only"):
        fp.pressure(UNIT, fp.Pyramid(4, 0.3), 0.0, 0.0, depth=0.1, work_of_adhesion=0.1, method="second-order")


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.EllipticParaboloid(0.1, 3.0), fp.Pyramid(3, 0.3)], ids=["ellipse", "pyramid"])
def test_pull_off_and_loop_know_the_mean_radius_and_the_error_of_curves(tip):
    lost = fp.pull_off(LAYER, tip, work_of_adhesion=0.1).force_minimum
    curve = fp.indent(LAYER, tip, force=lost.force * (1 - 1e-12), work_of_adhesion=0.1)
    # beside the minimum the radius goes like the root of the force: 1e-12 of it are 1e-6 of the radius and more
    assert lost.radius == pytest.approx(float(curve.radius[0]), rel=1e-4)
    loop = fp.adhesion_loop(LAYER, tip, work_of_adhesion=0.1, force=0.1, points=4)
    assert loop.attrs["pull_off_radius"] == pytest.approx(lost.radius, rel=1e-6)
    assert float(loop.radius[-1]) == pytest.approx(lost.radius, rel=1e-6)
    assert float(loop.area[-1]) == pytest.approx(float(curve.area[0]), rel=1e-3)
    # the estimate of curves refers to both terms of the force, which cancel in part
    assert lost.force_error > float(curve.force_error[0]) > 1e-3
    assert fp.pull_off(LAYER, fp.Paraboloid(1.0), work_of_adhesion=0.1).force_minimum.force_error == 0


def test_corrections_are_not_searched_where_the_round_contact_is_held_firmly():
    film = fp.Medium([fp.Layer(3.15e10, 0.49999, 1.47e-7)], base=fp.HalfSpace(1.75e5, 0.3))
    tip = fp.Superellipse(1.865e-6, 1.266e-7, 1.266e-7, power=8)
    case = adhesive_case(compliance(film), tip, 0.021)
    mean = stability(case.branch.base, case.branch.profile, tip.reach)
    firm = steady_radius(case.branch.base, mean)
    # the round branch is searched over the distance in which the soft base could turn it, three hundred times as wide
    assert mean.force[0].start < firm < mean.searched / 50
    # the first look reaches half a decade beyond the pull-off
    assert firm < case.stability.searched < 5 * firm
    assert case.stability.force[0].start == pytest.approx(mean.force[0].start, rel=0.5)


@pytest.mark.long
def test_unstable_outlines_have_no_estimate_and_are_marked():
    film = fp.Medium([fp.Layer(68.45e6, 0.5, 38.89e-6)], base=fp.HalfSpace(13.84e3, 0.3))
    tip, work = fp.EllipticParaboloid(2988.79, 33146.7), 0.03342262975391665
    lost = fp.pull_off(film, tip, work_of_adhesion=work).force_minimum
    branch = PerturbedBranch(compliance(film), tip, work)
    assert lost.radius > 0
    assert np.isfinite(lost.force_error) == bool(branch.weakest(branch.base_radius(np.array([lost.radius])))[0] > 0)
    curve = fp.indent(film, tip, radius=np.geomspace(0.02, 1, 12) * 38.89e-6, work_of_adhesion=work)
    assert (curve.area > 0).all()
    assert not curve.valid.values[np.isinf(curve.force_error.values)].any()
