"""Kernels as objects: handed over to another process they say the same."""

import pickle

import numpy as np
import pytest

import flatpunch as fp


@pytest.mark.parametrize(
    "medium",
    [
        fp.HalfSpace(1.0, 0.3),
        fp.Medium([fp.Layer(10.0, 0.3, 1.0), fp.Layer(0.1, 0.45, 2.0)], base=fp.HalfSpace(1.0, 0.3)),
        fp.Medium([fp.GradedLayer(fp.LinearModulus(1.0, 3.0, 1.0), 0.3, 1.0)], base=fp.RigidBase()),
        fp.Medium(
            [fp.Layer(1.0, 0.3, 0.5), fp.GradedLayer(fp.LinearModulus(1.0, 3.0, 1.0), 0.3, 1.0)], base=fp.RigidBase()
        ),
        fp.PowerLawHalfSpace(1.0, 1.0, 0.4, 0.3),
        fp.TwoBodies(fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()), fp.HalfSpace(4.0, 0.3)),
        fp.TwoBodies(fp.PowerLawHalfSpace(1.0, 1.0, 0.4, 0.3), fp.PowerLawHalfSpace(2.0, 1.0, 0.4, 0.2)),
    ],
    ids=["half-space", "layers", "graded", "graded-below", "power-law", "two-bodies", "two-power-laws"],
)
def test_kernels_can_be_handed_to_other_processes(medium):
    """Without the flat punches that were solved for them."""
    kernel = fp.compliance(medium)
    fp.indent(medium, fp.Pyramid(4, 0.3), depth=[0.1, 0.2], method="second-order")
    packed = pickle.dumps(kernel)
    assert len(packed) < 50_000
    again = pickle.loads(packed)
    k = np.geomspace(1e-3, 1e3, 50)
    assert np.array_equal(again(k), kernel(k))
