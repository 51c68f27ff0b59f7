"""Speed targets, measured: `make benchmarks`. Each one asserts its target and so fails when the package gets slow.

Cold: the medium has never been seen. Solutions are kept by the medium they belong to, so every round gets a thickness that
differs in the tenth digit. Warm: the same call again. The minimum over the rounds counts: other processes only add to it.
"""

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


def test_pyramid_curve_of_1000_depths_cold(benchmark):
    result = benchmark.pedantic(fp.indent, setup=lambda: ((new_medium(), PYRAMID), {"depth": DEPTHS}), rounds=20)
    assert result["valid"].all()
    report(benchmark, 30e-3)


def test_pyramid_curve_of_1000_depths_warm(benchmark):
    medium = new_medium()
    fp.indent(medium, PYRAMID, depth=DEPTHS)
    result = benchmark.pedantic(fp.indent, args=(medium, PYRAMID), kwargs={"depth": DEPTHS}, rounds=50)
    assert result.sizes["step"] == 1000
    report(benchmark, 5e-3)
