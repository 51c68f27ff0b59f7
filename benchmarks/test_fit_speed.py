"""Speed target of fits: 2000 curves of 4000 points a second and core, modulus and contact point, once the tables are made.

nanite fits a half-space to the same curves beside it, where it is installed.
"""

import numpy as np
import pytest

import flatpunch as fp

GEL = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
TIPS = {"sphere": fp.Sphere(radius=3e-6), "pyramid": fp.Pyramid(sides=4, inclination=0.6)}
CURVES = 50


def curves(tip, spring):
    """Noisy curves of different moduli and contact points; behind a cantilever the noise moves the tip as well."""
    z = np.linspace(-0.2e-6, 0.4e-6, 4000)
    force = np.zeros(4000)
    force[z > 0] = fp.indent(GEL, tip, depth=z[z > 0], angles=8)["force"].values
    rng = np.random.default_rng(1)
    noise = 0.01 * force.max() * rng.normal(size=(CURVES, 4000))
    return [
        fp.Curve(z + shift - (row / spring if spring else 0), scale * force + row, spring_constant=spring)
        for shift, scale, row in zip(rng.uniform(-1e-7, 1e-7, CURVES), rng.uniform(0.5, 2, CURVES), noise, strict=True)
    ]


@pytest.mark.parametrize("spring", [None, 0.05])
@pytest.mark.parametrize("shape", TIPS)
def test_curves_a_second(benchmark, shape, spring):
    tip = TIPS[shape]
    measured = curves(tip, spring)
    free = ["layers[0].young"]
    fp.fit_batch(measured[:1], GEL, tip, free, workers=1, baseline="none")
    batch = benchmark.pedantic(fp.fit_batch, (measured, GEL, tip, free), {"workers": 1, "baseline": "none"}, rounds=8)
    assert not batch.failed
    if benchmark.enabled:
        rate = CURVES / benchmark.stats.stats.min
        benchmark.extra_info["curves_per_second"] = rate
        assert rate > 2000, f"{rate:.0f} curves a second, the target is 2000"


def test_nanite_on_the_same_curves(benchmark):
    """Its parabolic half-space model with one descent from a good start, contact point and offset free."""
    nanite = pytest.importorskip("nanite")
    lmfit = pytest.importorskip("lmfit")
    model = nanite.model.models_available["hertz_para"]
    measured = curves(TIPS["sphere"], None)[:10]

    def all_curves():
        found = []
        for curve in measured:
            parameters = model.get_parameter_defaults()
            parameters["R"].value, parameters["nu"].value = 3e-6, 0.5
            parameters["E"].value = 5e3
            fitted = lmfit.minimize(model.residual, parameters, args=(-curve.depth, curve.force))
            found.append(fitted.params["E"].value)
        return found

    found = benchmark.pedantic(all_curves, rounds=3)
    assert np.all(np.isfinite(found))
    if benchmark.enabled:
        benchmark.extra_info["curves_per_second"] = len(measured) / benchmark.stats.stats.min


def test_map_with_intervals(benchmark):
    """64 x 64 curves of 4000 points on two processes, in under five seconds."""
    tip = TIPS["sphere"]
    measured = curves(tip, None)
    many = [measured[i % len(measured)] for i in range(64 * 64)]
    free = ["layers[0].young"]
    fp.fit_batch(measured[:1], GEL, tip, free, workers=1)
    batch = benchmark.pedantic(fp.fit_batch, (many, GEL, tip, free), {"workers": 2}, rounds=1)
    assert not batch.failed
    if benchmark.enabled:
        assert benchmark.stats.stats.min < 5


def test_joint_fit_of_three_numbers(benchmark):
    """Two beads on a film: modulus, thickness and Poisson ratio, which are solved without tables; target 60 s."""
    film = fp.Medium([fp.Layer(young=5e3, poisson=0.45, thickness=1e-6)], base=fp.HalfSpace(young=5e4, poisson=0.5))
    start = fp.Medium([fp.Layer(young=4e3, poisson=0.45, thickness=1.2e-6)], base=fp.HalfSpace(young=5e4, poisson=0.5))
    measured = []
    for i, radius in enumerate((1e-6, 5e-6)):
        z, tip = np.linspace(-1.25e-7, 2.5e-7, 1000), fp.Sphere(radius=radius)
        force = np.zeros(1000)
        force[z > 0] = fp.indent(film, tip, depth=z[z > 0]).force
        noise = 0.02 * force.max() * np.random.default_rng(i).normal(size=1000)
        measured.append(fp.Measured(fp.Curve(z, force + noise, name=f"bead {i}"), indenter=tip))
    names = [f"layers[0].{name}" for name in ("young", "thickness", "poisson")]
    found = benchmark.pedantic(fp.fit_together, (measured, start, fp.Sphere(radius=1e-6), names), rounds=1)
    assert found.agreement > 1e-3
    if benchmark.enabled:
        assert benchmark.stats.stats.min < 60


def test_ten_thousand_draws(benchmark):
    """Modulus and thickness from 4000 points; target 10 s."""
    depth = np.linspace(-4e-7, 4e-7, 4000)
    force = np.zeros(4000)
    force[depth > 0] = fp.indent(GEL, TIPS["sphere"], depth=depth[depth > 0]).force
    force += 0.01 * force.max() * np.random.default_rng(0).normal(size=4000)
    result = fp.fit(fp.Curve(depth=depth, force=force), GEL, TIPS["sphere"], ["layers[0].young", "layers[0].thickness"])
    benchmark.pedantic(result.posterior, (10_000,), rounds=1)
    if benchmark.enabled:
        assert benchmark.stats.stats.min < 10
