"""Results under round tips are exact, and say so, whatever made them."""

import numpy as np
import pytest

import flatpunch as fp

GEL = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
SPRING = fp.StandardLinearSolid(0.5, 1.0)


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Sphere(5e-6), fp.Truncated(fp.Cone(0.3), 2e-8)], ids=["sphere", "flat"])
def test_round_tips_are_exact_everywhere(tip):
    depth = np.linspace(-1e-7, 2e-7, 200)
    force = np.zeros(200)
    force[depth > 0] = fp.indent(GEL, tip, depth=depth[depth > 0]).force
    curve = fp.Curve(depth, force + 1e-12 * np.random.default_rng(0).normal(size=200))
    made = {
        "contact": fp.indent(GEL, tip, depth=1e-7),
        "by the name of the paper's method": fp.indent(GEL, tip, depth=1e-7, method="first-order"),
        "adhesive contact": fp.indent(GEL, tip, depth=1e-7, work_of_adhesion=1e-5),
        "history": fp.indent(GEL, tip, depth=[1e-8, 1e-7], time=[0.0, 1.0], relaxation=SPRING),
        "sensitivity": fp.sensitivity(GEL, tip, depth=1e-7),
        "fields": fp.fields(GEL, tip, 0.0, 0.0, 1e-7, depth=1e-7),
        "fit": fp.fit(curve, GEL, tip, ["layers[0].young"]).dataset(),
    }
    assert {name: each.attrs["method"] for name, each in made.items()} == dict.fromkeys(made, "exact")
