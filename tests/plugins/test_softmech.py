"""The force model for SoftMech, on a stand-in of its interface: a base class with typed parameters and a registry of modules.

SoftMech is in no package index; the stand-in has the names, signatures and units that its plug-ins are written against.
"""

import importlib
import sys
from types import ModuleType

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.fits import ForwardModel
from flatpunch.plugins.force_models import write_softmech_model

GEL = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], fp.RigidBase())
FILM = fp.Medium([fp.Layer(5e3, 0.4, 2e-6)], fp.HalfSpace(2e4, 0.22))


class _ForceModel:
    """Parameters are annotated class variables; the region of the fit is in nm, indentations in m."""

    min_indentation_depth: float = 0.0
    max_indentation_depth: float = float("inf")

    def _get_fitting_region(self, x, y):
        inside = (x * 1e9 >= self.min_indentation_depth) & (x * 1e9 <= self.max_indentation_depth)
        return x[inside], y[inside]


@pytest.fixture
def load(monkeypatch, tmp_path):
    for name in ("softmech", "softmech.core", "softmech.core.plugins"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["softmech.core.plugins"].ForceModel = _ForceModel
    monkeypatch.syspath_prepend(tmp_path)

    def written(name, *case, **options):
        write_softmech_model(tmp_path / f"{name}.py", *case, **options)
        monkeypatch.delitem(sys.modules, name, raising=False)
        module = importlib.import_module(name)
        assert isinstance(module.NAME, str)
        assert issubclass(module.ForceModel, _ForceModel)
        return module.ForceModel()

    return written


@pytest.mark.parametrize(
    ("name", "medium", "tip"),
    [
        ("gel_sphere", GEL, fp.Sphere(5e-6)),
        ("film_cone", FILM, fp.Cone(0.5)),
        ("body", fp.HalfSpace(5e3, 0.5), fp.Pyramid(4, 0.5)),
    ],
)
def test_theory_and_fit(load, name, medium, tip):
    model = load(name, medium, tip, title='A "test"')
    x = np.linspace(-1e-7, 4e-7, 60)
    top = "base.young" if isinstance(medium, fp.HalfSpace) else "layers[0].young"
    force = ForwardModel(medium, tip, (top,)).force(x, {top: 5e3})
    # two tables with different units of length
    np.testing.assert_allclose(model.theory(x, 5e3, curve=None), force, rtol=0, atol=2e-6 * force.max())
    (young,) = model.calculate(x, model.theory(x, 8e3))
    assert young == pytest.approx(8e3, rel=1e-6)


def test_region_and_held_parameters(load):
    model = load("thick_gel", GEL, fp.Sphere(5e-6))
    x = np.linspace(0, 4e-7, 60)
    force = model.theory(x, 5e3)
    model.max_indentation_depth = 100.0
    assert model.calculate(x, np.where(x > 1e-7, 0.0, force))[0] == pytest.approx(5e3, rel=1e-6)
    assert model.layer_thickness_nm == 2000
    model.layer_thickness_nm = 4000.0
    thicker = fp.indent(fp.Medium([fp.Layer(5e3, 0.5, 4e-6)], fp.RigidBase()), fp.Sphere(5e-6), depth=4e-7)
    assert model.theory(x, 5e3)[-1] == pytest.approx(float(thicker.force[0]), rel=1e-5)
    assert model.calculate(x[:0], force[:0]) is False
