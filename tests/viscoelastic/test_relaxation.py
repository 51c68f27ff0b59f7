"""Relaxation functions: values, integrals, moduli under oscillation, series of exponentials, refusals."""

import numpy as np
import pytest
from scipy.integrate import quad

import flatpunch as fp
from flatpunch.contact.viscoelastic.series import exponential_series, moments

LAWS = [
    fp.Prony([0.3, 0.2], [0.1, 3.0]),
    fp.Prony([2.0], [0.5], equilibrium=1.0),
    fp.StandardLinearSolid(0.25, 0.5),
    fp.PowerLawRelaxation(0.3, 2.0),
]


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_integral(law):
    for t in (0.01, 1.0, 30.0):
        # t' = u^4 takes the singularity of the power law out; quad's own bound
        value = quad(lambda u: float(law(np.array(u**4))) * 4 * u**3, 0, t**0.25, epsrel=1e-12)[0]
        assert float(law.integral(np.array(t))) == pytest.approx(value, rel=1e-10)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_dynamic_modulus(law):
    omega = 3.0
    # psi* = i omega int psi exp(-i omega t) dt = psi(T) + int over the part that decays; on t = y exp(-i pi/4) the integrand
    # no longer oscillates: i omega t = omega y exp(i pi/4)
    turn = np.exp(-0.25j * np.pi)

    def integrand(u):
        t = u**4 * turn
        return 1j * omega * _continued(law, t) * np.exp(-1j * omega * t) * turn * 4 * u**3

    real = quad(lambda u: integrand(u).real, 0, np.inf, epsrel=1e-11, limit=200)[0]
    imaginary = quad(lambda u: integrand(u).imag, 0, np.inf, epsrel=1e-11, limit=200)[0]
    value = complex(law.dynamic(np.array(omega)))
    # quad's bound on the sum of both
    assert value == pytest.approx(real + 1j * imaginary, rel=1e-9)


def _continued(law, t):
    """psi at complex times."""
    if isinstance(law, fp.PowerLawRelaxation):
        return (t / law.time) ** -law.exponent
    prony = getattr(law, "prony", law)
    return prony.equilibrium + sum(g * np.exp(-t / tau) for g, tau in zip(prony.weights, prony.times, strict=True))


@pytest.mark.parametrize("alpha", [0.05, 0.2, 0.5, 0.8])
def test_power_law_as_a_series(alpha):
    law = fp.PowerLawRelaxation(alpha, 3.0)
    series = exponential_series(law, 1e-3, 1e2)
    t = np.geomspace(1e-3, 1e2, 300)
    # trapezoidal rule with |Gamma(alpha + 16.5 i)| = 1e-11 over Gamma(alpha); rates cut at 1e-8 of the inverse duration
    assert np.allclose(series(t), law(t), rtol=1e-9)
    # the integral from zero holds what is faster than a step
    integral = series.constant * 1e-3 + -np.expm1(-1e-3 * series.rates) @ (series.weights / series.rates)
    assert integral == pytest.approx(float(law.integral(np.array(1e-3))), rel=1e-9)


def test_moments_of_the_exponential():
    z = np.geomspace(1e-6, 1e3, 200)
    t, v = np.polynomial.legendre.leggauss(60)
    # the integrand lives within 40/z of x = 1
    width = np.minimum(1, 40 / z)[:, None]
    x = 1 - width * (1 - t) / 2
    for p, values in enumerate(moments(z)):
        direct = np.sum(x**p * np.exp(-z[:, None] * (1 - x)) * v, axis=1) * width[:, 0] / 2
        # recursions divide by z >= 0.5 twice: 8 digits of rounding at most lost to 1e-14
        assert np.allclose(values, direct, rtol=1e-13)


def test_prony_is_normalised_by_the_instantaneous_modulus():
    law = fp.Prony([0.3, 0.2], [0.1, 3.0])
    assert law.equilibrium == pytest.approx(0.5, rel=1e-15)
    assert float(law(np.zeros(1))[0]) == pytest.approx(1.0, rel=1e-15)
    solid = fp.StandardLinearSolid(0.4, 2.0)
    t = np.linspace(0, 5, 7)
    assert np.allclose(solid(t), 0.4 + 0.6 * np.exp(-t / 2.0), rtol=1e-15)


@pytest.mark.long
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fp.Prony([0.7, 0.6], [1, 2]), "add up to 1.3"),
        (lambda: fp.Prony([0.7], [1, 2]), "one time per weight"),
        (lambda: fp.Prony([-0.1], [1]), r"weights\[0\]"),
        (lambda: fp.Prony([0.1], [0.0]), r"times\[0\]"),
        (lambda: fp.StandardLinearSolid(1.0, 1.0), "below 1"),
        (lambda: fp.StandardLinearSolid(0.5, -1.0), "time"),
        (lambda: fp.PowerLawRelaxation(1.0, 1.0), "between 0"),
        (lambda: fp.PowerLawRelaxation(0.5, 0.0), "time"),
    ],
)
def test_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
