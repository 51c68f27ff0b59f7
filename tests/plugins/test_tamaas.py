"""The operator in Tamaas's contact solver: its own half-space, and contacts of this package."""

import gc

import numpy as np
import pytest

import flatpunch as fp

tamaas = pytest.importorskip("tamaas", reason="Tamaas is installed in environments of its own only")
plugin = pytest.importorskip("flatpunch.plugins.tamaas")

BODY = fp.HalfSpace(1.0, 0.3)
LAYER = fp.Medium([fp.Layer(1.0, 0.45, 0.2)], fp.RigidBase())
FILM = fp.Medium([fp.Layer(1.0, 0.3, 0.2)], fp.HalfSpace(10.0, 0.2))


@pytest.fixture(autouse=True)
def _quiet():
    tamaas.set_log_level(tamaas.LogLevel.error)


def _bowl(shape):
    x = [(np.arange(n) + 0.5) / n - 0.5 for n in shape]
    return -sum(axis**2 for axis in np.ix_(*x)) / 2


def _model(kind, shape):
    return tamaas.Model(kind, [1.0] * len(shape), list(shape))


# on odd numbers of points Tamaas's own kernel is not symmetric
@pytest.mark.parametrize("shape", [(64, 64), (48, 64), (64,)])
def test_periodic_half_space_is_the_hosts(shape):
    kind = tamaas.model_type.basic_2d if len(shape) == 2 else tamaas.model_type.basic_1d
    own, theirs = _model(kind, shape), _model(kind, shape)
    theirs.E, theirs.nu = 1.0, 0.3
    solvers = [
        plugin.ContactSolver(own, _bowl(shape), 1e-12, BODY),
        tamaas.PolonskyKeerRey(theirs, _bowl(shape), 1e-12),
    ]
    gc.collect()
    for solver in solvers:
        solver.solve(0.02)
    np.testing.assert_allclose(own.traction, theirs.traction, rtol=0, atol=1e-12)
    np.testing.assert_allclose(own.displacement, theirs.displacement, rtol=0, atol=1e-12)


def test_surfaces_of_this_package_are_taken_as_they_are():
    """Heights of a random surface in Tamaas's own solver: the pressures of `rough_contact` on a half-space."""
    rough = fp.self_affine(64, 1 / 64, rms_slope=0.1, cut_off=1 / 8)
    before = rough.heights.copy()
    model = _model(tamaas.model_type.basic_2d, rough.shape)
    model.E, model.nu = 1.0, 0.3
    tamaas.PolonskyKeerRey(model, rough.heights, 1e-12).solve(0.01)
    np.testing.assert_array_equal(rough.heights, before)
    ours = fp.rough_contact(BODY, rough, pressure=0.01, fields=True).pressure.values[0]
    # both solve the same discrete problem, to 1e-7 of the gap here
    np.testing.assert_allclose(ours, model.traction, rtol=0, atol=1e-5 * ours.max())


@pytest.mark.parametrize("medium", [BODY, LAYER, FILM], ids=["half-space", "layer", "film"])
def test_contact_on_a_layer(medium):
    """A paraboloid, pressed in without repetition: depth to 1e-3."""
    n = 64
    curve = fp.indent(medium, fp.Paraboloid(1.0), depth=0.08)
    model, surface = _model(tamaas.model_type.basic_2d, (n, n)), _bowl((n, n))
    solver = plugin.ContactSolver(model, surface, 1e-10, medium, periodic=False)
    solver.solve(float(curve.force[0]))
    sinks = np.zeros_like(model.traction)
    solver.operator.apply(model.traction, sinks)
    contact = model.traction > 0
    assert float((sinks - surface)[contact].mean()) == pytest.approx(0.08, rel=1e-3)


def test_what_the_operator_cannot_do_is_refused():
    with pytest.raises(ValueError, match="basic_1d or basic_2d"):
        plugin.MediumOperator(tamaas.Model(tamaas.model_type.surface_2d, [1.0, 1.0], [8, 8]), BODY)
    with pytest.raises(ValueError, match="two dimensions and squares"):
        plugin.MediumOperator(tamaas.Model(tamaas.model_type.basic_2d, [1.0, 2.0], [8, 8]), BODY, periodic=False)
