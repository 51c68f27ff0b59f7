"""Single points by the finite elements that make the tables."""

import numpy as np
import pytest

import flatpunch as fp
from support.large_strain import LAW, cone, large


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of scikit-fem
def test_a_point_by_finite_elements():
    pytest.importorskip("skfem")
    from finite_strain.laws import Law
    from finite_strain.point import point
    from finite_strain.tips import Ball

    found, table = point(Law(0.4999), Ball(2.0), 1.0, 0.37, 6), large(0.5, [0.37])
    assert found.linear == pytest.approx(1.0, abs=2e-3)
    assert found.ratio == pytest.approx(float(table.strain_factor[0]), abs=float(table.force_error[0]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of scikit-fem
def test_points_under_cones_by_finite_elements():
    """At the table's angles, and at one degree, where the force is that of linear theory within 0.2 %."""
    pytest.importorskip("skfem")
    from finite_strain.laws import Law
    from finite_strain.point import cone_point
    from finite_strain.tips import RoundedCone

    for angle, thickness in ((23.0, 1.0), (41.0, 2.0)):
        found = cone_point(Law(0.4999), RoundedCone(angle), thickness, 0.4, 4)
        gel = fp.Medium([fp.Layer(1.0, 0.4999, thickness)], base=fp.RigidBase())
        table = fp.indent(gel, cone(angle), depth=0.4 * found.depth, finite_strain=LAW)
        assert found.linear == pytest.approx(1.0, abs=2e-3)
        assert found.ratio == pytest.approx(float(table.strain_factor[0]), abs=float(table.force_error[0]))
    assert cone_point(Law(0.4999), RoundedCone(1.0), np.inf, 1e-3, 4).ratio == pytest.approx(1.0, abs=2e-3)
