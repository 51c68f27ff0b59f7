"""Speed targets, measured: `make benchmarks`. Each one asserts its target and so fails when the package gets slow.

Cold: the medium has never been seen. Solutions are kept by the medium they belong to, so every round gets a thickness that
differs in the tenth digit. Warm: the same call again. The minimum over the rounds counts: other processes only add to it.
"""

import subprocess
import sys
from itertools import count

import numpy as np
import pytest

import flatpunch as fp

NUMBER = count(1)
PYRAMID = fp.Pyramid(sides=4, inclination=0.9)
DEPTHS = np.linspace(1e-9, 1.5e-6, 1000)


def new_medium():
    """Layer on a softer or stiffer half-space, each time another one."""
    thickness = 1e-6 * (1 + 1e-10 * next(NUMBER))
    return fp.Medium(
        [fp.Layer(young=2e9, poisson=0.4, thickness=thickness)], base=fp.HalfSpace(young=70e9, poisson=0.22)
    )


def report(benchmark, target):
    """Compare the fastest round with the target [s]; without timing (`make test`) there is nothing to compare."""
    if benchmark.enabled:
        fastest = benchmark.stats.stats.min
        benchmark.extra_info["target_ms"] = target * 1e3
        assert fastest < target, f"{fastest * 1e3:.2f} ms, the target is {target * 1e3:g} ms"


@pytest.fixture(autouse=True)
def imported_and_warm():
    """Imports, BLAS start-up and first-call costs belong to no target."""
    fp.flat_punch(new_medium(), 1e-6)
    fp.indent(new_medium(), PYRAMID, depth=DEPTHS[:10])


def test_flat_punch_one_layer(benchmark):
    benchmark.pedantic(fp.flat_punch, setup=lambda: ((new_medium(), 1e-6), {}), rounds=50)
    report(benchmark, 2e-3)


CURVES = [("first-order", 30e-3, 5e-3), ("second-order", 200e-3, 10e-3), ("fourth-order", 200e-3, 10e-3)]


@pytest.mark.parametrize(("method", "target"), [(method, cold) for method, cold, _ in CURVES])
def test_pyramid_curve_of_1000_depths_cold(benchmark, method, target):
    arguments = {"depth": DEPTHS, "method": method}
    result = benchmark.pedantic(fp.indent, setup=lambda: ((new_medium(), PYRAMID), arguments), rounds=20)
    assert result["valid"].all()
    report(benchmark, target)


@pytest.mark.parametrize(("method", "target"), [(method, warm) for method, _, warm in CURVES])
def test_pyramid_curve_of_1000_depths_warm(benchmark, method, target):
    medium, arguments = new_medium(), {"depth": DEPTHS, "method": method}
    fp.indent(medium, PYRAMID, **arguments)
    result = benchmark.pedantic(fp.indent, args=(medium, PYRAMID), kwargs=arguments, rounds=50)
    assert result.sizes["step"] == 1000
    report(benchmark, target)


def test_atlas_values(benchmark):
    """100 000 values of Kbar and kappa_1, one medium."""
    table, beta = fp.atlas.table("bonded-layer"), np.geomspace(1e-3, 100, 100_000)
    benchmark.pedantic(
        table.stiffness_and_moments, args=(beta, (1,)), kwargs={"poisson": 0.45}, rounds=20, warmup_rounds=1
    )
    report(benchmark, 50e-3)


def test_atlas_values_of_many_media(benchmark):
    """The same, each of another medium."""
    table, beta = fp.atlas.table("bonded-layer"), np.geomspace(1e-3, 100, 100_000)
    poisson = np.random.default_rng(1).uniform(0, 0.5, beta.size)
    benchmark.pedantic(
        table.stiffness_and_moments, args=(beta, (1,)), kwargs={"poisson": poisson}, rounds=20, warmup_rounds=1
    )
    report(benchmark, 50e-3)


def test_atlas_against_direct_solution(benchmark):
    """A value of a table costs less than a hundredth of a direct solution."""
    from time import perf_counter

    table = fp.atlas.table("bonded-layer")
    poisson = np.random.default_rng(2).uniform(0, 0.5, 1000)
    benchmark.pedantic(
        table.stiffness_and_moments, args=(np.ones(1000), (1,)), kwargs={"poisson": poisson}, rounds=20, warmup_rounds=1
    )
    start = perf_counter()
    for nu in poisson[:20]:
        fp.flat_punch(fp.Medium([fp.Layer(1.0, float(nu), 1.0)], base=fp.RigidBase()), 1.0).moment(1)
    direct = (perf_counter() - start) / 20
    report(benchmark, direct * 1000 / 100)


def test_atlas_curve_of_1000_depths(benchmark):
    """First-order curve on a medium that has its punches from the atlas."""
    gel = fp.Medium([fp.Layer(young=5e3, poisson=0.48, thickness=2e-6)], base=fp.RigidBase())
    medium = fp.atlas.tabulated(gel)
    depths = np.linspace(1e-9, 1e-6, 1000)
    benchmark.pedantic(
        fp.indent, args=(medium, PYRAMID), kwargs={"depth": depths, "method": "first-order"}, rounds=50, warmup_rounds=1
    )
    report(benchmark, 5e-3)


def many_layers(layers):
    """Equal thicknesses, moduli that alternate; each time another stack."""
    thickness = 1e-6 * (1 + 1e-10 * next(NUMBER))
    stack = [fp.Layer(young=(2e9, 6e9)[i % 2], poisson=0.3, thickness=thickness) for i in range(layers)]
    return fp.Medium(stack, base=fp.HalfSpace(young=70e9, poisson=0.22))


@pytest.mark.parametrize(("layers", "target"), [(1, 2e-3), (10, 10e-3), (100, 25e-3)])
def test_flat_punch_as_wide_as_the_stack(benchmark, layers, target):
    benchmark.pedantic(fp.flat_punch, setup=lambda: ((many_layers(layers), layers * 1e-6), {}), rounds=5)
    report(benchmark, target)


@pytest.mark.parametrize(("layers", "target"), [(1, 30e-3), (10, 60e-3), (100, 0.3)])
def test_round_curve_as_wide_as_the_stack(benchmark, layers, target):
    depths = np.linspace(1e-3, 0.2, 1000) * layers * 1e-6
    benchmark.pedantic(fp.indent, setup=lambda: ((many_layers(layers), fp.Cone(0.2)), {"depth": depths}), rounds=3)
    report(benchmark, target)


@pytest.mark.parametrize("order", ["second-order", "fourth-order"])
@pytest.mark.parametrize(("layers", "target"), [(1, 0.2), (10, 0.25), (30, 0.4), (100, 1.0)])
def test_pyramid_curve_as_wide_as_the_stack(benchmark, layers, target, order):
    depths = np.linspace(1e-3, 0.2, 1000) * layers * 1e-6
    pyramid = fp.Pyramid(sides=4, inclination=0.2)
    benchmark.pedantic(
        fp.indent, setup=lambda: ((many_layers(layers), pyramid), {"depth": depths, "method": order}), rounds=2
    )
    report(benchmark, target)


@pytest.mark.parametrize(("layers", "target"), [(400, 0.3), (2000, 2.0)])
def test_sphere_on_layers_of_five_nanometres(benchmark, layers, target):
    def setup():
        thickness = 5e-9 * (1 + 1e-10 * next(NUMBER))
        stack = [fp.Layer(young=(450e9, 360e9)[i % 2], poisson=0.25, thickness=thickness) for i in range(layers)]
        return (fp.Medium(stack, base=fp.HalfSpace(young=210e9, poisson=0.3)), fp.Sphere(10e-6)), {"force": 50e-3}

    benchmark.pedantic(fp.indent, setup=setup, rounds=2)
    report(benchmark, target)


@pytest.mark.parametrize("call", ["fp.flat_punch(body, 10e-6)", "fp.indent(body, fp.Cone(0.2), radius=radii)"])
def test_memory_of_2000_layers(call):
    """Less than 500 MB for the whole process, by its own account."""
    script = f"""
import resource, numpy as np, flatpunch as fp
layers = [fp.Layer(young=(450e9, 360e9)[i % 2], poisson=0.25, thickness=5e-9) for i in range(2000)]
body, radii = fp.Medium(layers, base=fp.HalfSpace(young=210e9, poisson=0.3)), np.linspace(1e-7, 1e-5, 1000)
{call}
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    # Linux counts in kB, macOS in bytes
    assert int(found.stdout) / (1e3 if sys.platform.startswith("linux") else 1e6) < 500


@pytest.mark.parametrize(("shape", "target"), [((100_000,), 1.0), ((300, 300), 0.5)], ids=["points", "plane"])
def test_fields_of_a_known_contact(benchmark, shape, target):
    rng = np.random.default_rng(0)
    film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    if len(shape) == 1:
        x, y = rng.uniform(-1e-5, 1e-5, (2, *shape))
        z = rng.uniform(0, 1e-5, shape)
    else:
        x, y, z = np.linspace(-1e-5, 1e-5, shape[0]), 0.0, np.linspace(0, 1e-5, shape[1])[:, None]
    benchmark.pedantic(fp.fields, (film, fp.Sphere(50e-6), x, y, z), {"force": 0.5}, rounds=3, warmup_rounds=1)
    report(benchmark, target)


def test_sensitivities_of_fifty_layers(benchmark):
    rng = np.random.default_rng(1)

    def setup():
        layers = [fp.Layer(10 ** rng.uniform(-1, 1), 0.3, 0.1) for _ in range(50)]
        return (fp.Medium(layers, base=fp.HalfSpace(5.0, 0.25)), fp.Paraboloid(10.0)), {"radius": 1.0}

    benchmark.pedantic(fp.sensitivity, setup=setup, rounds=5)
    # the evaluation itself, and less than two more for 153 derivatives
    report(benchmark, 1.0)
