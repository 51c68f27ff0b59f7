"""Fits of synthetic curves: values, intervals, what cannot be told, and what is refused."""

import dataclasses

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.fits import Curve, CurveError, Free, fit
from flatpunch.indenters import Cone, Paraboloid, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from support.synthetic_curves import synthetic

H = 1e-6
GEL = Medium([Layer(5e3, 0.5, H)], RigidBase())
START = Medium([Layer(1e3, 0.5, H)], RigidBase())
YOUNG = "layers[0].young"


@pytest.mark.parametrize(
    "tip", [Sphere(3e-6), Cone(0.6), Pyramid(4, 0.6), Pyramid(3, 0.4)], ids=lambda t: type(t).__name__
)
def test_exact_data_give_exact_parameters(tip):
    """Without noise only the tables' 1e-6 of the force is left."""
    curve = synthetic(GEL, tip, 0.4e-6, noise=0, contact=-7e-8, baseline=0.1)
    result = fit(curve, START, tip, [YOUNG])
    assert result[YOUNG] == pytest.approx(5e3, rel=1e-5)
    assert result["contact"] == pytest.approx(-7e-8, abs=1e-5 * 0.4e-6)
    assert result.model_error() < 1e-6


def test_two_parameters_that_scale():
    """Modulus and thickness together: a curve that reaches deep into the layer determines both."""
    curve = synthetic(GEL, Paraboloid(3e-6), 0.5e-6, noise=0, contact=2e-8)
    start = Medium([Layer(3e3, 0.5, 1.4 * H)], RigidBase())
    result = fit(curve, start, Paraboloid(3e-6), [YOUNG, "layers[0].thickness"])
    # they nearly trade off, so that the tables' 1e-6 of the force may show a hundredfold
    assert result[YOUNG] == pytest.approx(5e3, rel=1e-4)
    assert result["layers[0].thickness"] == pytest.approx(H, rel=1e-4)


@pytest.mark.long
def test_three_parameters_of_two_combinations():
    """On one layer F = (E h^3/R) phi(d R/h^2): modulus, thickness and radius together cannot be told, whatever the curve."""
    curve = synthetic(GEL, Paraboloid(3e-6), 0.5e-6, contact=2e-8)
    result = fit(curve, GEL, Paraboloid(2e-6), [YOUNG, "layers[0].thickness", "indenter.radius"])
    assert any("only a combination of layers[0].young and layers[0].thickness and" in note for note in result.notes)


def test_quick_fits_and_lmfit_agree():
    """One minimum: within a hundredth of the standard error; covariances to 1e-3, the error of lmfit's difference quotients."""
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6, contact=3e-8, baseline=0.05)
    one = fit(curve, START, Sphere(3e-6), [YOUNG], baseline="linear")
    two = fit(curve, START, Sphere(3e-6), [YOUNG], baseline="linear", quick=True)
    for name, estimate in one.estimates.items():
        assert two[name] == pytest.approx(estimate.value, abs=0.01 * estimate.stderr)
        assert two.estimates[name].stderr == pytest.approx(estimate.stderr, rel=1e-3)
    found = one.to_lmfit().leastsq().params["log_layers_0_young"]
    assert np.exp(found.value) == pytest.approx(one[YOUNG], abs=0.01 * one.estimates[YOUNG].stderr)
    assert found.stderr * one[YOUNG] == pytest.approx(one.estimates[YOUNG].stderr, rel=1e-3)


def test_profile_agrees_with_covariance_where_it_should():
    """One parameter, one layer: nearly quadratic, the profile's interval is the covariance's within 5 % of its width."""
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6, contact=3e-8)
    result = fit(curve, START, Sphere(3e-6), [YOUNG], baseline="constant")
    estimate, profile = result.estimates[YOUNG], result.profile(YOUNG)
    width = estimate.high - estimate.low
    assert profile.low == pytest.approx(estimate.low, abs=0.05 * width)
    assert profile.high == pytest.approx(estimate.high, abs=0.05 * width)
    assert (np.diff(profile.signed_root) > 0).all()


def test_profile_is_lmfits():
    """lmfit's own conf_interval on the same problem; it stops at 0.01 of the probability, about 2 % of the half width."""
    from lmfit import Minimizer, conf_interval

    result = fit(synthetic(GEL, Sphere(3e-6), 0.4e-6, contact=3e-8), START, Sphere(3e-6), [YOUNG], baseline="none")
    objective = result.objective
    names = list(result.to_lmfit().params)

    def residual(p):
        return objective.evaluate(np.array([p[n].value for n in names]))[0]

    parameters = result.to_lmfit().params.copy()
    for p in parameters.values():
        p.set(min=-np.inf, max=np.inf)
    problem = Minimizer(residual, parameters)
    interval = conf_interval(problem, problem.leastsq(), p_names=["log_layers_0_young"], sigmas=[0.95])
    low, _, high = (np.exp(v) for _, v in interval["log_layers_0_young"])
    profile = result.profile(YOUNG)
    width = high - low
    assert profile.low == pytest.approx(low, abs=0.03 * width)
    assert profile.high == pytest.approx(high, abs=0.03 * width)


@pytest.mark.long
def test_film_and_substrate_from_a_shallow_curve_cannot_be_told_apart():
    film = Medium([Layer(5e3, 0.4, H)], HalfSpace(5e4, 0.3))
    curve = synthetic(film, Sphere(3e-6), 0.03e-6, points=1000)
    result = fit(curve, film, Sphere(3e-6), {YOUNG: None, "base.young": (1e4, 5e5)})
    assert any(
        "hardly distinguish layers[0].young and base.young" in note and "Fix one" in note for note in result.notes
    )
    correlation = result.correlations().sel(parameter=YOUNG).sel({"with": "base.young"})
    assert correlation < -0.98
    profile = result.profile(YOUNG, points=9)
    # along the valley the base gets softer while the film gets stiffer, until it meets its limit
    line = profile.others["base.young"]
    assert (np.diff(line) <= 0).all()
    assert line[-1] < 0.5 * line[0]
    assert np.abs(profile.signed_root).min() < 1


def test_modulus_and_radius_on_a_half_space_are_one_combination():
    body = HalfSpace(5e3, 0.5)
    result = fit(synthetic(body, Paraboloid(3e-6), 1e-7), body, Paraboloid(3e-6), ["base.young", "indenter.radius"])
    assert any("only a combination of base.young and indenter.radius" in note for note in result.notes)
    # E sqrt(R) is determined all the same
    assert result["base.young"] * result["indenter.radius"] ** 0.5 == pytest.approx(5e3 * 3e-6**0.5, rel=0.02)


def test_a_value_on_its_limit_is_held_in_lmfit():
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6)
    result = fit(curve, START, Sphere(3e-6), {YOUNG: Free(1e3, 500.0, 4e3)})
    params = result.to_lmfit().leastsq().params
    assert not params["log_layers_0_young"].vary
    assert np.exp(params["log_layers_0_young"].value) == pytest.approx(4e3)
    assert params["contact"].value == pytest.approx(result.minimum.x[1], abs=1e-6)


def test_limits_hold_and_are_named():
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6)
    result = fit(curve, START, Sphere(3e-6), {YOUNG: Free(1e3, 500.0, 4e3)})
    assert result[YOUNG] == pytest.approx(4e3)
    assert result.estimates[YOUNG].at_bound
    assert any("sits on its limit" in note for note in result.notes)
    with pytest.raises(ValueError, match="must lie between"):
        fit(curve, START, Sphere(3e-6), {YOUNG: (2e3, 4e3)})


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
def test_outliers_do_not_move_a_robust_fit(loss):
    """5 % of the points are off by a fifth of the largest force: those that jump away are left out, whatever the loss."""
    clean = synthetic(GEL, Sphere(3e-6), 0.4e-6, points=2000)
    force = clean.force.copy()
    force[1000::20] += 0.2 * force.max()
    dirty = Curve(clean.depth, force)
    robust = fit(dirty, START, Sphere(3e-6), [YOUNG], loss=loss)
    plain = fit(dirty, START, Sphere(3e-6), [YOUNG])
    assert abs(robust[YOUNG] / 5e3 - 1) < 0.02
    assert abs(plain[YOUNG] / 5e3 - 1) < 0.02
    assert any("jump away and back: left out" in note for note in plain.notes)
    fast = fit(dirty, START, Sphere(3e-6), [YOUNG], loss=loss, quick=True)
    # both stop at 1e-8 of the cost, a hundredth of a standard error or so
    assert fast[YOUNG] == pytest.approx(robust[YOUNG], abs=0.05 * robust.estimates[YOUNG].stderr)


def test_given_contact_point_and_no_baseline():
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6, contact=1e-7)
    result = fit(curve, START, Sphere(3e-6), [YOUNG], contact=1e-7, baseline="none")
    assert result.names == (YOUNG,)
    assert result[YOUNG] == pytest.approx(5e3, abs=4 * result.estimates[YOUNG].stderr)


@pytest.mark.long
def test_noise_behind_a_soft_cantilever():
    """Force noise moves the tip as well; the estimate stays unbiased where the sample is twenty times as stiff as the spring."""
    body, tip, k = HalfSpace(5e5, 0.5), Paraboloid(3e-6), 0.05
    exact = synthetic(body, tip, 2e-7, noise=0, points=2000)
    ratios = []
    for seed in range(20):
        noise = 0.003 * exact.force.max() * np.random.default_rng(seed).normal(size=exact.force.size)
        curve = Curve.from_piezo(exact.depth + exact.force / k, exact.force + noise, k)
        result = fit(curve, body, tip, ["base.young"], quick=True, baseline="constant")
        ratios.append((result["base.young"] - 5e5) / result.estimates["base.young"].stderr)
    # mean of 20 standard normal numbers: 0.22 standard deviation; 4 of them
    assert abs(np.mean(ratios)) < 0.9
    assert 0.6 < np.std(ratios) < 1.5


def test_model_and_data_that_disagree_show():
    """A half-space fitted to a thin layer: correlated residuals are reported, and the modulus is wrong."""
    curve = synthetic(GEL, Sphere(3e-6), 0.6e-6, noise=0.002)
    result = fit(curve, HalfSpace(1e3, 0.5), Sphere(3e-6), ["base.young"])
    assert any("Neighbouring residuals are correlated" in note for note in result.notes)
    assert result["base.young"] > 1.5 * 5e3


def test_recovered_modulus_does_not_depend_on_the_depth_range():
    """That is what a right thin-layer model means; the half-space model drifts by tens of per cent over the same ranges."""
    curve = synthetic(GEL, Sphere(3e-6), 0.6e-6, noise=0.002, points=3000)
    thin, bulk = [], []
    for share in (0.25, 0.5, 1.0):
        limit = {"depth_to": share * 0.6e-6}
        result = fit(curve, START, Sphere(3e-6), [YOUNG], **limit)
        estimate = result.estimates[YOUNG]
        thin.append(abs(estimate.value - 5e3) / estimate.stderr)
        bulk.append(fit(curve, HalfSpace(1e3, 0.5), Sphere(3e-6), ["base.young"], **limit)["base.young"])
    assert max(thin) < 4
    assert bulk[-1] / bulk[0] > 1.3


def _broken(**change):
    return dataclasses.replace(synthetic(GEL, Sphere(3e-6), 0.4e-6, points=600), **change)


def _cycle():
    up = synthetic(GEL, Sphere(3e-6), 0.4e-6, points=600)
    return Curve(np.concatenate([up.depth, up.depth[::-1]]), np.concatenate([up.force, up.force[::-1]]))


def test_approach_is_found_in_a_whole_cycle():
    result = fit(_cycle(), START, Sphere(3e-6), [YOUNG])
    # cut where the moving average is largest: within its window of 12 points
    assert abs(result.curve.depth.size - 600) <= 12
    assert result[YOUNG] == pytest.approx(5e3, abs=4 * result.estimates[YOUNG].stderr)


def test_what_cannot_be_evaluated_is_refused_with_the_reason():
    whole, tip = _cycle(), Sphere(3e-6)
    base = synthetic(GEL, tip, 0.4e-6, points=600)
    cases = {
        "is a retract": whole.taken(slice(600, None)),
        "no contact is to be seen": Curve(base.depth, np.random.default_rng(3).normal(size=600)),
        "at every point": Curve(base.depth, np.ones(600)),
    }
    for message, curve in cases.items():
        with pytest.raises(CurveError, match=message):
            fit(curve, START, tip, [YOUNG])
    with pytest.raises(CurveError, match=r"2 of 600 values of force are no finite numbers \(rows 5, 7"):
        Curve(base.depth, np.where(np.isin(np.arange(600), (5, 7)), np.nan, base.force))
    with pytest.raises(CurveError, match="needs 12 or more"):
        Curve(np.arange(5.0), np.arange(5.0))
    flat = fit(Curve(base.depth, np.minimum(base.force, 0.6 * base.force.max())), START, tip, [YOUNG])
    assert flat.estimates[YOUNG].low < 5e3 < flat.estimates[YOUNG].high
    assert any("usually a saturated detector" in note for note in flat.notes)


def test_a_broad_dip_is_adhesion():
    base = synthetic(GEL, Sphere(3e-6), 0.4e-6, points=600)
    sticky = base.force - 0.2 * base.force.max() * np.exp(-(((base.depth + 5e-8) / 2e-8) ** 2))
    with pytest.raises(CurveError, match="tip is pulled in"):
        fit(Curve(base.depth, sticky), START, Sphere(3e-6), [YOUNG])


def test_bad_settings_are_refused():
    curve = synthetic(GEL, Sphere(3e-6), 0.4e-6)
    with pytest.raises(ValueError, match="baseline = 'cubic' is unknown"):
        fit(curve, START, Sphere(3e-6), [YOUNG], baseline="cubic")
    with pytest.raises(TypeError, match="must be a list of names"):
        fit(curve, START, Sphere(3e-6), YOUNG)
    with pytest.raises(TypeError, match="must be a Curve"):
        fit([1, 2], START, Sphere(3e-6), [YOUNG])


def test_result_as_table_words_and_dataset():
    result = fit(synthetic(GEL, Sphere(3e-6), 0.4e-6), START, Sphere(3e-6), [YOUNG])
    row = result.row()
    assert row["ok"]
    assert row[f"{YOUNG} low"] < row[YOUNG] < row[f"{YOUNG} high"]
    assert "kPa" in result.summary()
    dataset = result.dataset()
    np.testing.assert_allclose(dataset["force"] - dataset["fitted"], result.residual)
    medium, _ = result.case
    assert medium.layers[0].young == result[YOUNG]


@pytest.mark.long
def test_limits_of_the_theory_are_passed_on():
    """Under a cone on a film 100 times stiffer the pressure turns negative inside: the fit says so."""
    film = Medium([Layer(1e11, 0.3, H)], HalfSpace(1e9, 0.3))
    tip = Cone(0.3)
    curve = synthetic(film, tip, 3.2e-6, points=200)
    assert any("pressure is negative" in note for note in fit(curve, film, tip, [YOUNG]).notes)


def test_curve_that_begins_in_contact():
    """No baseline in the data: the contact point lies before the first point and is still found, with its wide interval."""
    whole = synthetic(GEL, Sphere(3e-6), 0.4e-6, noise=0.002, points=1000)
    part = whole.taken(whole.depth > 0.05e-6)
    result = fit(part, START, Sphere(3e-6), [YOUNG], baseline="none")
    for name, truth in ((YOUNG, 5e3), ("contact", 0.0)):
        estimate = result.estimates[name]
        assert abs(estimate.value - truth) < 4 * estimate.stderr


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Sphere(5e-6), fp.Paraboloid(2e-6)], ids=["sphere", "paraboloid"])
@pytest.mark.parametrize("baseline", ["constant", "linear"])
@pytest.mark.parametrize("free", [["layers[0].young"], ["layers[0].young", "layers[0].thickness"]], ids=["E", "E, h"])
def test_curves_without_noise_find_their_minimum(tip, baseline, free):
    rng = np.random.default_rng(len(free))
    for _ in range(3):
        young, thickness = 10 ** rng.uniform(2.5, 5), 10 ** rng.uniform(-6.3, -5)
        true = fp.Medium([fp.Layer(young, 0.45, thickness)], base=fp.RigidBase())
        depth = np.linspace(-0.3, 0.3, 200) * thickness
        force = np.zeros(200)
        force[depth > 0] = fp.indent(true, tip, depth=depth[depth > 0]).force
        start = fp.Medium([fp.Layer(1.7 * young, 0.45, thickness * (1.2 if len(free) > 1 else 1))], base=fp.RigidBase())
        result = fp.fit(fp.Curve(depth=depth + 1e-7, force=force), start, tip, free, baseline=baseline)
        # the tables of fits are good to 1e-8 in force; along the valley of two parameters that is a thousand times as much
        bound = 1e-6 if len(free) == 1 else 1e-4
        assert result.estimates["layers[0].young"].value == pytest.approx(young, rel=bound)
