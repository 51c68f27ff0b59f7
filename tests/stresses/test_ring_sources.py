"""The transform of a round pressure, and the size of the sums over it."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.numerics.gauss import gauss
from flatpunch.stresses.axisymmetric.contact_load import contact_load
from flatpunch.stresses.axisymmetric.ring_sources import RingSources


@pytest.mark.parametrize("terms", [1, 2, 3, 16])
@pytest.mark.parametrize("last", [1e-2, 1.0, 30.0, 300.0])
@pytest.mark.parametrize("count", [1, 7, 600])
def test_transform_is_the_integral_of_the_cosine(terms, last, count):
    """Few and many wavenumbers, few and many oscillations on a panel: each against a fine Gauss rule."""
    rng = np.random.default_rng([terms, int(100 * last), count])
    breaks = np.concatenate([[0.0], np.sort(rng.random(4)), [1.0]])
    series = rng.normal(size=(5, terms))
    k = np.concatenate([[0.0], last * rng.random(count - 1)]) if count > 1 else np.array([last])
    x, w = gauss(200)
    direct = np.zeros_like(k)
    for low, high, own in zip(breaks[:-1], breaks[1:], series, strict=True):
        t = (low + high) / 2 + (high - low) / 2 * x
        direct += np.cos(np.outer(k, t)) @ (chebyshev.chebval(x, own) * w) * (high - low) / 2
    # about 1e-13 is lost in the recurrence of the spherical Bessel functions near their number of terms
    np.testing.assert_allclose(RingSources(breaks, series, np.zeros(5, dtype=bool)).transform(k), direct, atol=1e-12)


@pytest.mark.long
def test_energy_of_very_wide_contacts_is_refused_before_the_sums():
    gel = fp.Medium([fp.Layer(5e3, 0.45, 2e-6)], fp.RigidBase())
    with pytest.raises(ValueError, match="a radius of 36 mm, is too wide for the energy in layers this thin"):
        fp.energy_by_depth(gel, fp.Cone(0.3), radius=36e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "radius", "moduli"),
    [
        (fp.Sphere(5.8), 0.03, (86e9, 1.8e3)),
        (fp.Cone(0.1), 0.001, (86e9, 1e7)),
        (fp.SpheroCone(0.3, 1e-3), 5e-4, (1e8, 3e10)),
        (fp.Truncated(fp.Cone(0.1), 1e-6), 1e-3, (2e8, 1e7)),
    ],
    ids=["sphere", "cone", "rounded", "truncated"],
)
def test_sources_carry_the_force_under_very_stiff_films(tip, radius, moduli):
    """The half-space's sources are up to a million times what is left of them; kinks need more terms than the stiffness."""
    layers = [fp.Layer(moduli[0], 0.2, 54e-6), fp.Layer(moduli[1], 0.2, 63e-6), fp.Layer(1e6, 0.5, 55e-6)]
    body = fp.Medium(layers, base=fp.HalfSpace(1e9, 0.3))
    contact = fp.indent(body, tip, radius=radius).isel(step=0)
    load = contact_load(compliance(body), tip, radius, float(contact.depth), edge=False)
    assert load.breaks.size < 100
    # the interpolated contact itself is known to 1e-9
    assert load.force == pytest.approx(float(contact.force), rel=1e-8)
