"""Posteriors of fits: against the covariance and closed forms, priors, messages, and simulation-based calibration."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, chisquare

import flatpunch as fp
from flatpunch.contact import indent
from flatpunch.fits import Curve, LogNormal, Normal, Uniform, fit, fit_together
from flatpunch.fits.fitting import model_of, setup_of
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.settings import Settings, as_free
from flatpunch.fits.report import sampling
from flatpunch.fits.report.log_posterior import Quadratic, residuals_of_many
from flatpunch.indenters import Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from support.synthetic_curves import synthetic

YOUNG, THICK, RADIUS = "layers[0].young", "layers[0].thickness", "indenter.radius"
GEL, BEAD = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase()), Sphere(3e-6)
CURVE = synthetic(GEL, BEAD, 0.4e-6, points=400)


@pytest.fixture(scope="module")
def fitted():
    return fit(CURVE, GEL, BEAD, [YOUNG], baseline="constant")


@pytest.fixture
def short(monkeypatch):
    """Chains of ten autocorrelation times: enough for medians and standard deviations to some per cent."""
    monkeypatch.setattr(sampling, "_CHAINS", replace(sampling._CHAINS, shortest=10.0, length=10.0, block=100))


@pytest.mark.long
def test_without_priors_it_is_the_covariance(fitted):
    """1 % noise: the parabola holds; 3000 effective draws know a standard deviation to 1.3 %, the rest is four of that."""
    found = fitted.posterior(draws=4000, seed=1)
    assert found.effective.min() > 2000
    for name in fitted.names:
        estimate = fitted.estimates[name]
        assert np.std(found[name]) == pytest.approx(estimate.stderr, rel=0.05)
        assert np.mean(found[name]) == pytest.approx(estimate.value, abs=0.1 * estimate.stderr)
    near = np.abs(found.correlation - fitted.correlation).max()
    assert near < 0.05


@pytest.mark.parametrize(("spring", "rtol"), [(None, 1e-13), (0.05, 1e-5)])
@pytest.mark.parametrize("baseline", ["linear", "constant"])
def test_residuals_of_many_vectors_are_those_of_each(spring, rtol, baseline):
    """To the tolerance of Newton's method behind a cantilever, to rounding without."""
    curve = replace(CURVE, spring_constant=spring)
    free = [YOUNG, THICK] if baseline == "linear" else [YOUNG]
    wanted = as_free(free)
    model = model_of(Sample(GEL, BEAD), wanted, "auto")
    # beside where a search starts: the identity needs no minimum, and no intervals
    setup = setup_of(curve, model, model.bounds(wanted), Settings(baseline=baseline, quick=True))
    start = setup.start()
    x = start + 0.02 * np.random.default_rng(3).normal(size=(7, start.size))
    one = np.ones(7)
    many = residuals_of_many(setup.objective, x, one, one)
    each = np.array([setup.objective.evaluate(row)[0] for row in x])
    np.testing.assert_allclose(many, each, atol=rtol * np.abs(each).max(), rtol=0)


def test_residuals_with_another_calibration_are_those_of_the_other_curve():
    """Forces 1.1 x 0.95 times, deflections 0.95 times as large: the curve that the true constants would have given."""
    spring, more, less = 0.05, 1.1, 0.95
    result = fit(replace(CURVE, spring_constant=spring), GEL, BEAD, [YOUNG], quick=True)
    objective, x = result.objective, result.minimum.x + 0.03
    found = residuals_of_many(objective, x[None], np.array([more]), np.array([less]))[0]
    gain = more * less
    depth = objective.position - less * objective.force / spring
    other = replace(objective, depth=depth, force=gain * objective.force, spring=more * spring, _before={})
    frame = objective.frame
    y = x.copy()
    y[objective.names.index("baseline")] = (gain * (frame.level + frame.span * x[-1]) - frame.level) / frame.span
    np.testing.assert_allclose(gain * found, other.evaluate(y)[0], atol=1e-5)


def test_a_prior_of_the_spring_constant_widens_the_modulus(short):
    """F = k delta: a relative error of k is one of E of a half-space, and adds to its variance; a tip moved by delta stays."""
    body = HalfSpace(5e3, 0.5)
    curve = replace(synthetic(body, BEAD, 0.4e-6, points=300), spring_constant=1.0)
    result = fit(curve, body, BEAD, ["base.young"])
    found = result.posterior(4000, {"spring_constant": LogNormal(1.0, 0.1)})
    error = np.hypot(0.1, result.estimates["base.young"].stderr / result["base.young"])
    assert np.std(np.log(found["base.young"])) == pytest.approx(error, rel=0.1)
    assert np.corrcoef(np.log(found["base.young"]), np.log(found["spring_constant"]))[0, 1] > 0.9


@pytest.mark.long
def test_calibration_of_the_curve_enters(short):
    """A spring constant as in the covariance of the fit, which repeats it with one standard deviation more.

    The sensitivity also bends the curve, so that the curve determines it in part: here to better than its prior.
    """
    truth = {name: prior.centre for name, prior in PRIORS.items()}
    curve = _measured(truth, np.random.default_rng(1))
    result = fit(replace(curve, meta={"calibration": {"spring_constant": 0.05}}), GEL, BEAD, [YOUNG])
    found = result.posterior(4000)
    assert found.names[-1] == "spring_constant"
    assert np.std(found[YOUNG]) == pytest.approx(result.estimates[YOUNG].stderr, rel=0.1)
    both = {"calibration": {"spring_constant": 0.05, "sensitivity": 0.03}}
    found = fit(replace(curve, meta=both), GEL, BEAD, [YOUNG]).posterior(4000)
    assert found.names[-2:] == ("spring_constant", "sensitivity")
    assert np.std(found["sensitivity"]) < 0.02


@pytest.mark.long
def test_what_was_held_is_drawn_with_its_prior(short, tmp_path):
    """A thickness from ellipsometry: ln E moves with it as in a fit with another thickness."""
    result = fit(CURVE, GEL, BEAD, [YOUNG])
    found = result.posterior(4000, {THICK: Normal(1e-6, 3e-8), RADIUS: Uniform(2.9e-6, 3.1e-6)}, seed=2)
    assert found.names[:3] == (YOUNG, THICK, RADIUS)
    assert found[RADIUS].min() >= 2.9e-6
    assert found[RADIUS].max() <= 3.1e-6
    assert np.std(found[THICK]) < 3.2e-8
    assert np.std(found[YOUNG]) > 1.5 * result.estimates[YOUNG].stderr
    assert any("adds little" in note for note in found.notes)
    assert "prior 1 µm ± 30 nm" in found.summary()
    assert "effective draws" in str(found)
    data = found.dataset()
    assert data["draws"].shape == (4000, 5)
    assert found.save(tmp_path / "draws.nc").stat().st_size > 0
    np.testing.assert_array_equal(fp.load(tmp_path / "draws.nc")["draws"].values, found.draws)


@pytest.mark.long
def test_quadratic_models_of_slow_fits(short, monkeypatch):
    """A relaxing sample: draws from residuals of second degree, and from the model itself, have the same spread."""
    time = np.linspace(0, 3, 240)
    depth = np.interp(time, [0, 1, 3], [-1e-7, 4e-7, 4e-7])
    law = fp.StandardLinearSolid(equilibrium=0.4, time=0.5)
    body = HalfSpace(5e3, 0.5)
    force = np.zeros(240)
    inside = depth > 0
    t, d = time[inside] - time[inside][0], depth[inside]
    force[inside] = indent(body, BEAD, time=t, depth=d, relaxation=law)["force"]
    noise = 0.01 * force.max() * np.random.default_rng(5).normal(size=240)
    result = fit(
        Curve(depth, force + noise, time=time), body, BEAD, ["base.young", "relaxation.equilibrium"], relaxation=law
    )
    made = []
    monkeypatch.setattr(
        Quadratic, "of", classmethod(lambda cls, *a, of=Quadratic.of.__func__: made.append(of(cls, *a)) or made[-1])
    )
    found = result.posterior(2000)
    assert made
    x = result.minimum.x + np.sqrt(np.diag(result.covariance)) * np.random.default_rng(0).normal(
        size=(5, result.minimum.x.size)
    )
    exact = np.array([result.objective.residuals(row) for row in x])
    # a tenth of the noise at most, beside the contact point, where the second derivative of the force jumps
    np.testing.assert_allclose(made[0].residuals(x), exact, atol=0.1 * np.std(exact), rtol=0)
    assert np.std(found["base.young"]) == pytest.approx(result.estimates["base.young"].stderr, rel=0.1)


def test_joint_fits(short):
    curves = [replace(synthetic(GEL, BEAD, 0.4e-6, points=200, seed=s), name=f"curve {s}") for s in (1, 2)]
    result = fit_together(curves, GEL, BEAD, [YOUNG])
    found = result.posterior(2000, {YOUNG: LogNormal(5e3, 0.5)})
    assert found.names == result.names
    assert np.std(found[YOUNG]) == pytest.approx(result.estimates[YOUNG].stderr, rel=0.1)
    with pytest.raises(ValueError, match=r"'layers\[0\]\.thickness' was not fitted"):
        result.posterior(10, {THICK: Normal(1e-6, 1e-8)})


@pytest.mark.long
def test_same_seed_same_draws(fitted, short):
    first, second, other = (fitted.posterior(100, seed=s).draws for s in (4, 4, 5))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)
    assert first.shape == (100, 3)


@pytest.mark.long
def test_what_the_curve_does_not_determine_is_noted(short):
    """A layer on a base of its own material: the thickness changes nothing, its draws fill the limits."""
    same = Medium([Layer(5e3, 0.5, 1e-6)], HalfSpace(5e3, 0.5))
    result = fit(synthetic(same, BEAD, 0.2e-6, points=150), same, BEAD, {THICK: (5e-7, 2e-6)})
    found = result.posterior(2000)
    assert any("thickness is not determined by the curve" in note for note in found.notes)
    # ln h is uniform between the limits
    assert np.std(np.log(found[THICK])) == pytest.approx(np.log(4) / np.sqrt(12), rel=0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"draws": 0}, "draws = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"priors": {YOUNG: 5e3}}, r"priors\['layers\[0\]\.young'\] = 5000\.0 must be Normal"),
        (
            {"priors": {"layers[1].young": Normal(1, 1)}},
            r"no parameter of this fit; it has layers\[0\]\.young, contact",
        ),
        ({"priors": {"spring_constant": Normal(1, 1)}}, "the curve has no spring constant"),
        ({"priors": {YOUNG: Uniform(-2, -1)}}, "allows no value between the limits"),
    ],
)
def test_messages(fitted, arguments, message):
    with pytest.raises((ValueError, TypeError), match=message):
        fitted.posterior(**arguments)


def test_priors_check_themselves():
    with pytest.raises(ValueError, match="must be below"):
        Uniform(2, 1)
    with pytest.raises(ValueError, match=r"Normal\.std = 0"):
        Normal(1, 0)
    with pytest.raises(ValueError, match=r"LogNormal\.median = -1"):
        LogNormal(-1, 0.1)


def test_robust_losses_have_none(fitted):
    with pytest.raises(ValueError, match="no posterior: it is no likelihood"):
        replace(fitted, settings=replace(fitted.settings, loss="huber")).posterior()


PRIORS = {
    YOUNG: LogNormal(5e3, 0.3),
    THICK: Normal(1e-6, 1e-7),
    RADIUS: LogNormal(3e-6, 0.05),
    "contact": Uniform(-4e-8, 4e-8),
    "baseline": Normal(0.0, 2e-11),
    "spring_constant": LogNormal(0.05, 0.1),
}


def _drawn(rng):
    """Numbers from the priors."""
    values = {}
    for name, prior in PRIORS.items():
        if isinstance(prior, Normal):
            values[name] = rng.normal(prior.mean, prior.std)
        elif isinstance(prior, LogNormal):
            values[name] = prior.median * np.exp(prior.relative * rng.normal())
        else:
            values[name] = rng.uniform(prior.low, prior.high)
    return values


def _measured(truth, rng):
    """A curve behind a cantilever whose assumed spring constant is the median of its prior."""
    assumed = PRIORS["spring_constant"].median
    depth = np.linspace(-2e-7, 4e-7, 150)
    force = np.zeros(150)
    body = Medium([Layer(truth[YOUNG], 0.5, truth[THICK])], RigidBase())
    force[depth > 0] = indent(body, Sphere(truth[RADIUS]), depth=depth[depth > 0])["force"]
    read = force * assumed / truth["spring_constant"] + truth["baseline"] + 3e-11 * rng.normal(size=150)
    # the contact point is that on the axis of depths, which a constant of the force moves
    position = depth + truth["contact"] + (force * assumed / truth["spring_constant"] + truth["baseline"]) / assumed
    return Curve(position - read / assumed, read, spring_constant=assumed)


def _ranks(count, seed, draws=99):
    """Rank of the truth among the draws, for each data set and parameter."""
    rng = np.random.default_rng(seed)
    ranks = np.empty((count, len(PRIORS)), dtype=int)
    for i in range(count):
        truth = _drawn(rng)
        result = fit(_measured(truth, rng), GEL, BEAD, [YOUNG, THICK], quick=True)
        found = result.posterior(draws, PRIORS, seed=int(rng.integers(2**31)))
        ranks[i] = [int(np.sum(found[name] < truth[name])) for name in PRIORS]
    return ranks


def _flat(ranks, bins, draws=99):
    """Rank histograms flat within 99 % bounds: all counts together, and each histogram by chi squared."""
    count, parameters = ranks.shape
    low, high = binom.interval(1 - 0.01 / (bins * parameters), count, 1 / bins)
    for name, column in zip(PRIORS, ranks.T, strict=True):
        counts = np.bincount(column * bins // (draws + 1), minlength=bins)
        assert low <= counts.min(), (name, counts)
        assert counts.max() <= high, (name, counts)
        assert chisquare(counts).pvalue > 0.01 / parameters, (name, counts)


@pytest.mark.long
def test_simulation_based_calibration_of_a_few(monkeypatch):
    """Talts et al. (2018): with the truth drawn from the priors its rank among the draws is uniform. Four bins of four."""
    monkeypatch.setattr(sampling, "_CHAINS", replace(sampling._CHAINS, shortest=5.0, block=50, walkers=40))
    _flat(_ranks(16, 11), 4)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_simulation_based_calibration(monkeypatch, seed):
    """200 data sets, ten bins of twenty; the 99 draws come from 40 chains of 20 autocorrelation times each."""
    monkeypatch.setattr(sampling, "_CHAINS", replace(sampling._CHAINS, walkers=40))
    _flat(_ranks(200, seed), 10)


@pytest.mark.slow
def test_ten_thousand_draws_of_four_thousand_points_are_worth_two_thousand():
    curve = synthetic(GEL, BEAD, 0.4e-6, points=4000)
    assert fit(curve, GEL, BEAD, [YOUNG, THICK]).posterior(10_000).effective.min() > 2000
