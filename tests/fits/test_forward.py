"""The tabulated forward model against `indent`, and its derivatives against differences."""

import numpy as np
import pytest

from flatpunch.fits import ForwardModel, parameter_names
from flatpunch.fits.elastic.table import Table
from flatpunch.fits.parameters.scaling import scaling
from flatpunch.indenters import Cone, Cylinder, EllipticParaboloid, Paraboloid, Pyramid, RadialProfile, Sphere
from flatpunch.media import GradedLayer, HalfSpace, Layer, LinearModulus, Medium, RigidBase, TwoBodies
from flatpunch.sensitivities import sensitivity

H = 1e-6
GEL = Medium([Layer(5e3, 0.45, H)], RigidBase())
FILM = Medium([Layer(5e3, 0.45, H)], HalfSpace(1e4, 0.3))
TWO = Medium([Layer(5e3, 0.45, H), Layer(8e3, 0.3, 0.3 * H, bonded=False)], HalfSpace(1e4, 0.3))
GRADED = Medium([GradedLayer(LinearModulus(5e3, 9e3, H), 0.4, H)], HalfSpace(1e4, 0.3))
PROFILE = RadialProfile(np.linspace(0, 3e-6, 30), np.linspace(0, 3e-6, 30) ** 2 / 4e-6)

CASES = [
    (GEL, Paraboloid(2e-6), ("layers[0].young", "layers[0].thickness", "indenter.radius")),
    (GEL, Sphere(2e-6), ("layers[0].young", "indenter.radius")),
    (GEL, Pyramid(4, 0.6), ("layers[0].young", "indenter.inclination")),
    (GEL, Cone(0.5), ("layers[0].young", "layers[0].poisson")),
    (FILM, Cone(0.6), ("layers[0].young", "layers[0].thickness")),
    (FILM, Paraboloid(3e-6), ("layers[0].young", "base.young")),
    (FILM, Cylinder(1e-6), ("base.young", "indenter.radius")),
    (FILM, PROFILE, ("layers[0].young", "layers[0].thickness")),
    (TWO, EllipticParaboloid(1e5, 2e5), ("layers[1].young",)),
    (GRADED, Paraboloid(3e-6), ("base.young",)),
    (HalfSpace(1e4, 0.3), Sphere(1e-6), ("base.young", "indenter.radius")),
    (HalfSpace(1e4, 0.3), Pyramid(3, 0.4), ("base.young", "base.poisson", "indenter.inclination")),
]


def _shifted(model):
    """Parameters away from the start and from every knot of the tables."""
    return model.start() + np.array([0.0 if name.endswith("poisson") else 0.13 for name in model.free])


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "indenter", "free"), CASES, ids=lambda v: type(v).__name__ if not isinstance(v, tuple) else v[-1]
)
def test_force_is_that_of_indent(medium, indenter, free):
    """1e-6 of the largest force is what the tables promise: splines 5e-7 (pyramids), knots about 1e-7."""
    model = ForwardModel(medium, indenter, free)
    theta = _shifted(model)
    depth = np.geomspace(1e-11, 0.4e-6, 60)
    exact = model.exact(depth, model.externals(theta))[0]
    np.testing.assert_allclose(model.evaluate(depth, theta)[0], exact, rtol=0, atol=1e-6 * exact.max())


@pytest.mark.parametrize(
    ("medium", "indenter", "free"), CASES, ids=lambda v: type(v).__name__ if not isinstance(v, tuple) else v[-1]
)
def test_derivatives(medium, indenter, free):
    """Central differences with step 1e-5 leave 1e-9 of smooth functions; 1e-6 beside a joint of the piecewise polynomials."""
    model = ForwardModel(medium, indenter, free)
    theta, depth, step = _shifted(model), np.geomspace(1e-9, 0.4e-6, 40), 1e-5
    _, stiffness, by_theta = model.evaluate(depth, theta)
    for j in range(theta.size):
        ends = []
        for sign in (1, -1):
            moved = theta.copy()
            moved[j] += sign * step
            ends.append(model.evaluate(depth, moved)[0])
        difference = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(by_theta[j], difference, rtol=0, atol=1e-6 * np.abs(difference).max())
    ends = [model.evaluate(depth * (1 + sign * step), theta)[0] for sign in (1, -1)]
    np.testing.assert_allclose(stiffness, (ends[0] - ends[1]) / (2 * step * depth), rtol=1e-5)


def test_what_scales_needs_no_table():
    """Modulus, thickness and radius of one layer on a rigid base are exponents alone; a ratio of moduli is one coordinate."""
    assert not scaling(GEL, Paraboloid(1e-6), CASES[0][2]).coordinates
    assert len(scaling(FILM, Paraboloid(1e-6), ("layers[0].young",)).coordinates) == 1
    assert len(scaling(TWO, Paraboloid(1e-6), ("layers[0].young",)).coordinates) == 1
    assert len(scaling(TWO, Paraboloid(1e-6), ("layers[0].young", "layers[1].young", "base.young")).coordinates) == 2


def test_zero_outside_contact():
    force = ForwardModel(GEL, Paraboloid(1e-6)).force(np.array([-1e-7, 0.0, 1e-7]))
    assert force[0] == force[1] == 0 < force[2]


def test_a_trial_without_contact_tabulates_nothing(monkeypatch):
    """The scaled depth has no largest value there: a table to a depth of 1 m took 40 s under a worn pyramid."""
    model = ForwardModel(HalfSpace(1e3, 0.5), Pyramid(4, 0.3), ("base.young",))
    monkeypatch.setattr(Table, "at", lambda *_: pytest.fail("a table was made"))
    force, stiffness, derivatives = model.evaluate(np.zeros(0), model.start())
    assert (force.shape, stiffness.shape, derivatives.shape) == ((0,), (0,), (1, 0))


def test_beyond_the_tip_the_curve_goes_on():
    """A trial step of a fit may ask for more than a ball has; the model answers, so that the fit can turn back."""
    force = ForwardModel(HalfSpace(1e4, 0.3), Sphere(1e-6), ("base.young",)).force(np.array([0.5e-6, 3e-6]))
    assert np.isfinite(force).all()
    assert force[1] > force[0]


@pytest.mark.long
def test_trial_steps_to_layers_too_thin_do_not_end_a_fit():
    """A step to a layer a thousandth as thick as the contact is wide: the curve goes on, and models that share the table live."""
    tip = Paraboloid(1.7e-6)
    free = ("layers[0].young", "layers[0].thickness")
    model, other = ForwardModel(GEL, tip, free), ForwardModel(GEL, tip, free)
    depth = np.geomspace(1e-9, 4e-7, 40)
    thin = model.internals({"layers[0].thickness": 1e-3 * H})
    force, stiffness, by_theta = model.evaluate(depth, thin)
    assert np.isfinite(by_theta).all()
    assert (np.diff(force) > 0).all()
    assert (stiffness > 0).all()
    usual = other.start()
    exact = other.exact(depth, other.externals(usual))[0]
    np.testing.assert_allclose(other.evaluate(depth, usual)[0], exact, rtol=0, atol=1e-6 * exact.max())


def test_a_table_outlives_what_cannot_be_solved():
    def solve(q, delta):
        if delta.max() > 1e3:
            raise ValueError("too deep")
        return delta**1.5

    table = Table(solve, (), lambda q: np.inf)
    depth = np.log(np.array([1e-3, 0.5]))
    before = table.at((), 0.0).at(depth)[0]
    with pytest.raises(ValueError, match="too deep"):
        table.at((), np.log(1e5))
    np.testing.assert_allclose(table.at((), 0.0).at(depth)[0], before, rtol=1e-14)
    np.testing.assert_allclose(before, 1.5 * depth, rtol=1e-12)


def test_unknown_parameter_is_named():
    with pytest.raises(ValueError, match=r"'layers\[1\].young' is not part of this case; it has layers\[0\].young"):
        ForwardModel(GEL, Paraboloid(1e-6), ("layers[1].young",))
    assert parameter_names(GEL, Cone(0.3))[-1] == "indenter.inclination"


def test_notes_have_the_error_of_the_force():
    """Of tips that are not round; outlines, which are less well known, are no part of a fit."""
    depth = np.array([1e-7, 3e-7])
    for tip, said in ((Pyramid(4, 0.9), "fourth-order method, which expects to be within"), (Cone(0.9), "")):
        notes = ForwardModel(GEL, tip).exact(depth, {})[1]
        assert said in notes
        assert "outline" not in notes
        assert bool(said) == ("Forces are those of" in notes)


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "indenter"),
    [
        (GEL, Sphere(2e-6)),
        (FILM, Cone(0.6)),
        (TwoBodies(FILM, HalfSpace(2e4, 0.2)), Paraboloid(3e-6)),
    ],
    ids=["gel", "film", "two bodies"],
)
def test_derivatives_are_the_sensitivities(medium, indenter):
    """Every modulus, Poisson ratio, thickness and the tip, one by one: 1e-5 of the force against the exact derivatives.

    Six knots of a Poisson ratio leave 1e-7 of the force, and some 1e-6 of its derivative.
    """
    depth = H * np.array([0.05, 0.2, 0.4])
    exact = sensitivity(medium, indenter, depth=depth).force
    for name in parameter_names(medium, indenter):
        model = ForwardModel(medium, indenter, (name,))
        force, _, derivatives = model.evaluate(depth, model.start())
        found = derivatives[0] / force / model.scales[name].slope(model.start()[0]) * model.numbers[name].value
        np.testing.assert_allclose(found, exact.sel(parameter=name).values, atol=1e-5, err_msg=name)
