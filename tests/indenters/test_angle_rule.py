"""The rule over the polar angle of outlines that vary by orders of magnitude."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.indenters.geometry import angles


@pytest.mark.long
def test_few_trials_lead_to_many_angles(monkeypatch):
    """A height coefficient of 1e-8 in one direction: thousands of angles, in steps that grow with their number."""
    made = []
    monkeypatch.setattr(angles, "gauss", lambda nodes, rule=angles.gauss: made.append(nodes) or rule(nodes))
    around = np.radians([0.0, 90.0, 180.0, 270.0])
    tip = fp.PowerLaw(2.5, (around, [1.013e-1, 1.2e7, 1.0e7, 1.2e7]), corners=[0.0])
    phi, weights = angles.angular_rule(tip)
    assert phi.size > 4000
    assert len(made) < 50
    assert abs(weights.sum() - 1) < 1e-13
