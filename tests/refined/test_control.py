"""Prescribed forces and radii: where boundary elements are solved, and what comes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.refined import refinement as refinement_module
from flatpunch.indenters import Rounded, Truncated
from flatpunch.indenters.geometry.features import flat_radius

FILM_10 = fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
FILM_50 = fp.Medium([fp.Layer(50.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
COARSE = {"method": fp.Refined(cells=64, rtol=4.99e-4)}


def solutions_of(monkeypatch: pytest.MonkeyPatch, **control: Any) -> tuple[Any, int]:
    """A curve, and how many boundary element solutions it took."""
    count, solve = [0], refinement_module.shared_out

    def counted(function: Any, case: Any, places: Any, **options: Any) -> Any:
        count[0] += len(places)
        return solve(function, case, places, **options)

    monkeypatch.setattr(refinement_module, "shared_out", counted)
    result = fp.indent(**control, **COARSE)
    monkeypatch.undo()
    return result, count[0]


def film(modulus: float) -> fp.Medium:
    """Stiff film of which nothing is known yet."""
    return fp.Medium([fp.Layer(modulus, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


@pytest.mark.long
@pytest.mark.parametrize("name", ["force", "radius"])
def test_other_controls_take_about_as_many_solutions(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tip, depth = fp.Pyramid(4, 0.3), np.geomspace(0.02, 5.0, 50)
    # media that differ by a millionth share no solutions
    by_depth, usual = solutions_of(monkeypatch, medium=film(50.0), indenter=tip, depth=depth)
    values = by_depth[name].values
    again, taken = solutions_of(monkeypatch, medium=film(50.00005), indenter=tip, **{name: values})
    np.testing.assert_allclose(again[name], values, rtol=1e-9)
    assert taken <= usual + 3
    # and none for what is known
    later, more = solutions_of(monkeypatch, medium=film(50.00005), indenter=tip, **{name: values[5:-5] * 1.001})
    assert more == 0
    np.testing.assert_allclose(later[name], values[5:-5] * 1.001, rtol=1e-9)


@pytest.mark.parametrize("name", ["force", "radius"])
def test_one_value_takes_few_solutions(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    result, taken = solutions_of(monkeypatch, medium=FILM_10, indenter=fp.Pyramid(4, 0.31), **{name: 0.7})
    assert float(result[name][0]) == pytest.approx(0.7, rel=1e-9)
    assert taken <= 5
    # of so few cells
    assert float(result.force_error[0]) < 3e-3


@pytest.mark.long
@pytest.mark.parametrize("name", ["force", "radius"])
def test_a_few_values_far_apart_have_solutions_of_their_own(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    medium = fp.Medium([fp.Layer(1.0, 0.3, 1.0), fp.Layer(3.1, 0.3, 0.5)], base=fp.HalfSpace(1.0, 0.3))
    tip, values = fp.AfmPyramid(0.3, 0.4, 0.5, tip_radius=0.1), np.array([0.01, 0.3, 5.0])
    result, taken = solutions_of(monkeypatch, medium=medium, indenter=tip, **{name: values})
    np.testing.assert_allclose(result[name], values, rtol=1e-9)
    assert taken <= 40
    # depths in between, to the error of so few cells, and estimates that know of no neighbours far away
    direct = fp.indent(medium, tip, depth=result.depth, method=fp.BoundaryElements(grid=128))
    np.testing.assert_allclose(direct.force, result.force, rtol=1e-3)
    assert np.all(result.force_error < 2e-3)


@pytest.mark.long
def test_ends_close_in_on_a_contact_that_is_about_to_come_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    # ln a0 bends there, so that where it is expected moves on with every solution
    tip = Truncated(fp.Pyramid(4, 0.3), 0.1)
    result, taken = solutions_of(monkeypatch, medium=film(50.0001), indenter=tip, radius=1.0)
    assert float(result.radius[0]) == pytest.approx(1.0, rel=1e-9)
    assert taken <= 20


@pytest.mark.long
def test_radii_of_a_flat_end_have_no_depth() -> None:
    tip = Truncated(fp.Pyramid(4, 0.3), 0.1)
    # the second lies between the sides and the corners of the flat
    radius = np.array([0.05, 0.35, 0.5, 1.0])
    result = fp.indent(FILM_50, tip, radius=radius, **COARSE)
    np.testing.assert_allclose(result.radius, radius, rtol=1e-9)
    assert not result.depth[:2].any()
    assert not result.force[:2].any()
    np.testing.assert_allclose(result.area[:2], np.pi * radius[:2] ** 2)
    again = fp.indent(FILM_50, tip, depth=result.depth, **COARSE)
    np.testing.assert_allclose(again.radius[2:], radius[2:], rtol=2e-2)


def test_radius_of_a_flat_end() -> None:
    assert flat_radius(fp.Pyramid(4, 0.3)) == 0
    assert flat_radius(Rounded(fp.Pyramid(4, 0.3), 0.1, true_sphere=False)) == 0
    # the mean distance of a square's sides from its centre over half their length, by integrating 1/cos
    square = 0.1 / np.tan(0.3) * 4 / np.pi * np.log(1 + np.sqrt(2))
    assert flat_radius(Truncated(fp.Pyramid(4, 0.3), 0.1)) == pytest.approx(square, rel=1e-5)
    assert not fp.pressure(FILM_50, Truncated(fp.Pyramid(4, 0.3), 0.1), 0.1, 0.0, radius=0.35, **COARSE)


@pytest.mark.long
@pytest.mark.parametrize("name", ["radius", "force", "depth"])
def test_nothing_and_two_values_far_apart(name: str) -> None:
    values = np.array([0.0, 0.05, 5.0])
    result = fp.indent(FILM_50, fp.Pyramid(4, 0.3), **{name: values}, **COARSE)
    np.testing.assert_allclose(result[name], values, rtol=1e-9)
    assert [float(result[other][0]) for other in ("depth", "force", "radius")] == [0, 0, 0]


def test_force_beyond_a_tip_that_ends() -> None:
    x = np.linspace(-1.0, 1.0, 61)
    tip = fp.HeightMap(x, x, 0.3 * x**2 + 0.4 * x[:, None] ** 2)
    with pytest.raises(ValueError, match=r"force = .* is beyond this indenter"):
        fp.indent(FILM_10, tip, force=[0.01, 1e3], **COARSE)


def test_tips_far_smaller_than_the_layer_under_force() -> None:
    # where the layer looks like a half-space one solution serves all
    tip = fp.Pyramid(5, 0.3)
    depth = np.array([1e-8, 1e-7])
    force = fp.indent(FILM_10, tip, depth=depth, **COARSE).force.values
    for value, expected in zip(force, depth, strict=True):
        assert float(fp.indent(film(10.0000001), tip, force=value, **COARSE).depth[0]) == pytest.approx(
            expected, rel=1e-5
        )
