"""The corrections of standard tips on one layer that come with the package."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact import default_choice, default_method
from flatpunch.contact.boundary_elements.outlines import traced
from flatpunch.contact.refined.table import FORCE_ERROR, layer, tabulated_rows
from flatpunch.media import TwoBodies

CASES = [
    (fp.Pyramid(4, 0.3), 0.5, 0.7),
    (fp.Pyramid(4, 0.9), 0.48, 0.15),
    (fp.Pyramid(4, 0.3), 0.1, 4.0),
    (fp.Pyramid(3, 0.5), 0.45, 0.4),
    (fp.Pyramid(3, 0.5), None, 2.0),
    (fp.Pyramid(6, 0.3), 0.3, 1.3),
    (fp.EllipticParaboloid(0.12, 1.0), 0.49, 0.6),
    (fp.EllipticParaboloid(1.0, 0.2), 0.35, 3.0),
    (fp.EllipticParaboloid(0.5, 1.0), None, 0.2),
]


def _medium(poisson: float | None, thickness: float = 2.0, modulus: float = 3.0) -> fp.Medium:
    bonded = poisson is not None
    return fp.Medium([fp.Layer(modulus, poisson if bonded else 0.4, thickness, bonded)], base=fp.RigidBase())


@pytest.mark.long
@pytest.mark.parametrize(("tip", "poisson", "beta"), CASES)
def test_against_fresh_boundary_elements(
    tip: object, poisson: float | None, beta: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    medium = _medium(poisson)
    depth = float(fp.indent(medium, tip, radius=2.0 * beta, method="second-order").depth[0])
    kernel = compliance(medium)
    truth = bem.solve(kernel, tip, depths=depth, grid=256, tolerance=1e-6)[0]
    trace = traced(kernel, tip, truth, 360)

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("the table was not used")

    monkeypatch.setattr("flatpunch.bem.solve", refuse)
    # the table is what answers by default
    result = fp.indent(medium, tip, depth=depth)
    assert result.attrs["method"] == "refined"
    assert float(result.force[0]) == pytest.approx(truth.force, rel=FORCE_ERROR)
    # areas of contacts wider than the layer are known to some 0.3 % from 256 cells
    assert float(result.area[0]) == pytest.approx(trace.area, rel=4e-3)
    off = np.abs(result.contour.values[0] - trace.contour).max() / trace.radius
    assert off < float(result.contour_error[0]) + trace.error


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "poisson"),
    [(fp.EllipticParaboloid(0.2, 1.0), 0.5), (fp.EllipticParaboloid(0.12, 1.0), 0.0), (fp.Pyramid(3, 0.3), 0.4)],
    ids=["ellipse incompressible", "ellipse compressible", "three sides"],
)
def test_area_of_contacts_ten_times_wider_than_the_layer(tip: object, poisson: float) -> None:
    """Beside the rim few cells lie in the thickness: those of 256 and 320 cells were 0.3 % too large."""
    medium = _medium(poisson, thickness=1.0)
    result = fp.indent(medium, tip, radius=9.0)
    kernel = compliance(medium)
    truth = bem.solve(kernel, tip, depths=result.depth.values, grid=640, tolerance=1e-6)[0]
    trace = traced(kernel, tip, truth, 360)
    assert result.attrs["method"] == "refined"
    assert float(result.area[0]) == pytest.approx(trace.area, rel=2.5e-3)
    assert np.abs(result.contour.values[0] - trace.contour).max() < 0.01 * trace.radius


@pytest.mark.parametrize("steps", [{"depth": 1e-6}, {"force": 1e-10}, {"radius": 1e-6}])
def test_default_is_the_table_where_it_reaches(steps: dict[str, float]) -> None:
    medium = fp.Medium([fp.Layer(1e3, 0.49, 1e-6)], base=fp.RigidBase())
    tip = fp.Pyramid(4, 0.3)
    assert default_method(tip, medium, **steps) == "refined"
    far = {name: float(fp.indent(medium, tip, radius=8e-5, method="first-order")[name][0]) for name in steps}
    assert default_choice(tip, medium, **steps).quick
    # elsewhere the outline of a series is far off
    assert not default_choice(tip, medium, **far).quick
    assert not default_choice(tip, fp.HalfSpace(1e3, 0.49), **steps).quick
    assert not default_choice(fp.Pyramid(5, 0.3), medium, **steps).quick
    # without a medium only the fast methods are judged
    assert default_method(tip) == "fourth-order"


@pytest.mark.parametrize("poisson", [0.0, 0.123, 0.3, 0.4999, 0.5, None])
def test_layers_are_recognised_by_their_response(poisson: float | None) -> None:
    rows = tabulated_rows(compliance(_medium(poisson)), fp.Pyramid(4, 0.3))
    assert rows is not None
    assert np.all(np.isfinite(rows.rows))


@pytest.mark.parametrize(
    "medium",
    [
        fp.HalfSpace(1.0, 0.3),
        fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.HalfSpace(200.0, 0.3)),
        fp.Medium([fp.Layer(1.0, -0.2, 1.0)], base=fp.RigidBase()),
        TwoBodies(fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()), fp.HalfSpace(50.0, 0.3)),
    ],
    ids=["half-space", "stiff base", "auxetic", "two bodies"],
)
def test_other_media_are_not(medium: object) -> None:
    assert tabulated_rows(compliance(medium), fp.Pyramid(4, 0.3)) is None


def test_other_tips_are_not() -> None:
    kernel = compliance(layer(0.0))
    assert tabulated_rows(kernel, fp.Pyramid(5, 0.3)) is None
    assert tabulated_rows(kernel, fp.EllipticParaboloid(0.01, 1.0)) is None
    assert tabulated_rows(kernel, fp.PowerLaw(2, lambda phi: 1 + 0.1 * np.cos(2 * phi))) is None


def test_turned_ellipse_has_the_turned_outline() -> None:
    medium = _medium(0.5)
    along = fp.indent(medium, fp.EllipticParaboloid(0.2, 1.0), depth=1.0, method="refined")
    across = fp.indent(medium, fp.EllipticParaboloid(1.0, 0.2), depth=1.0, method="refined")
    np.testing.assert_allclose(np.roll(along.contour[0], 90), across.contour[0], rtol=1e-9)


def test_table_is_small() -> None:
    assert len((files("flatpunch.contact.refined") / "data" / "corrections.npz").read_bytes()) < 500_000


def test_thousand_depths_cost_no_boundary_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flatpunch.bem.solve", None)
    curve = fp.indent(_medium(0.45), fp.Pyramid(4, 0.6), depth=np.linspace(0.01, 4.0, 1000), method="refined")
    assert np.all(np.diff(curve.force) > 0)
